"""A robot that nobody knows yet, and a place to which it is added."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

import pytest

from rosic.core.identity import OPERATOR
from rosic.core.records import Decided
from rosic.errors import ConfigurationError, Refusal
from rosic.features.alerts import AlertFeature
from rosic.features.robot_to_robot import RobotToRobotFeature
from rosic.gateway.robot_registry import ProfileDraft, owner_may
from rosic.robots.memory import MemoryRobot
from tests.gateway.place import Place, SlowStore

if TYPE_CHECKING:
    from collections.abc import Awaitable

    from rosic.app.gateway import Gateway
    from rosic.contracts.robot import Say
    from rosic.core.order import RestReport, Stop
    from rosic.core.records import Record

ROVER = """\
id: rover
title: Rover 3
words: [buggy]
groups: [swarm]
link: { kind: memory, namespace: /rover }
stop: { cancel_only: true }
skills:
  wiggle:
    title: Wiggle
    parameters:
      times: { min: 1, max: 9, integer: true, default: 3 }
  scan: { class: observe }
telemetry:
  battery: { unit: "%" }
alerts:
  - { name: battery_low, when: battery < 20 %, for: 1 s }
"""
CAN = "Rover 3 can:\n  wiggle: times 1 to 9, else 3\n  scan"


def draft(text: str = ROVER, **changes: str) -> ProfileDraft:
    """Return the rover's profile, with some words replaced."""
    for old, new in changes.items():
        assert old in text
        text = text.replace(old, new)
    return ProfileDraft(text=text, name="rover.yaml")


async def add(place: Place, some: ProfileDraft | None = None) -> str:
    """Add a robot as the operator does, and return what was said."""
    return await place.gateway.robot_adder.add(some or draft(), OPERATOR, owner_may)


class Reluctant(MemoryRobot):
    """Takes its time to be opened, or cannot be, where its id says so."""

    closed: list[str]
    opening: asyncio.Event
    goes_on: asyncio.Event
    stops: list[int]

    async def open(self, say: Say) -> None:
        await super().open(say)
        if self.profile.id.startswith("bad"):
            raise ConfigurationError("There is nobody there.")
        if self.profile.id.startswith("odd"):
            raise ZeroDivisionError
        if self.profile.id.startswith("late"):
            raise TimeoutError
        if self.profile.id.startswith("slow"):
            type(self).opening.set()
            await type(self).goes_on.wait()

    async def close(self) -> None:
        type(self).closed.append(self.profile.id)

    async def stop(self, stop: Stop) -> RestReport:
        type(self).stops.append(stop.generation)
        return await super().stop(stop)


class HoldingStore(SlowStore):
    """Holds a robot back that is being written down, until ``ready``.

    Attributes:
        reached: It is.
    """

    def __init__(self) -> None:
        super().__init__(Decided)
        self.reached = asyncio.Event()

    async def write(self, *records: Record) -> None:
        if any(isinstance(record, Decided) for record in records):
            self.reached.set()
        await super().write(*records)


class Lab(Place):
    kind = Reluctant

    def __init__(self, *arguments: object, **how: object) -> None:
        super().__init__(*arguments, **how)  # type: ignore[arg-type]
        Reluctant.closed, Reluctant.stops = [], []
        Reluctant.opening, Reluctant.goes_on = asyncio.Event(), asyncio.Event()


async def refused(doing: Awaitable[str]) -> str:
    with pytest.raises(Refusal) as why:
        await doing
    return why.value.sentence


def snapshot(gateway: Gateway) -> tuple[object, ...]:
    """Return everything that knows robots."""
    rooms = gateway.rooms
    return (
        dict(gateway.robots),
        dict(rooms.profiles),
        tuple(rooms.stops),
        rooms.vocabulary.names,
        gateway.authority.rights.epoch,
        dict(gateway.features.get(AlertFeature).alerting.following),
        dict(gateway.features.get(RobotToRobotFeature).messaging.inboxes),
        tuple(gateway._opened),
    )
