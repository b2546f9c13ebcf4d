"""I2 and I5: a call that waits for its turn asks the gate when it leaves, not before."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

import pytest

from rosic.core.traffic import TrafficCounter
from rosic.errors import OrderVoid
from rosic.robots.ros2.client.services import MAX_CALLS, ServiceLink
from rosic.testing.clock import settle

if TYPE_CHECKING:
    from collections.abc import Callable


class Answering:
    """Stands for the ROS thread: sends at once, and answers when it is let."""

    alive = True

    def __init__(self) -> None:
        self.thread = self
        self.sent = 0
        self.traffic = TrafficCounter()
        self.may_answer = asyncio.Event()

    async def ask(self, send: Callable[[], object], _what: str, *, timeout_s: float) -> object:
        send()
        self.sent += 1
        await asyncio.wait_for(self.may_answer.wait(), timeout_s)
        return object()


class Handle:
    """Stands for rclpy's client."""

    def service_is_ready(self) -> bool:
        return True

    def call_async(self, request: object) -> object:
        return request


class Empty:
    """Stands for a service whose request has no fields."""

    class Request:
        SLOT_TYPES = ()

        @staticmethod
        def get_fields_and_field_types() -> dict[str, str]:
            return {}


async def test_the_gate_is_asked_when_there_is_a_place_among_the_calls() -> None:
    runtime, asked = Answering(), []
    link = ServiceLink(runtime, "/do", Empty, Handle(), Handle)  # type: ignore[arg-type]

    def refuses() -> None:
        asked.append(runtime.sent)
        raise OrderVoid("too late")

    first = [asyncio.create_task(link.call({}, timeout_s=60.0)) for _ in range(MAX_CALLS)]
    await settle()
    last = asyncio.create_task(link.call({}, timeout_s=60.0, leave=refuses))
    await settle()
    assert runtime.sent == MAX_CALLS
    assert not asked, "it passed the gate, and went on waiting"
    runtime.may_answer.set()
    await asyncio.gather(*first)
    with pytest.raises(OrderVoid):
        await last
    assert runtime.sent == MAX_CALLS, "it was sent all the same"
