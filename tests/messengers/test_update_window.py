"""What is confirmed, and in which order things are handed over."""

from __future__ import annotations

import asyncio
from collections import Counter
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING

import pytest

from rosic.core.identity import Address
from rosic.core.message import Chat, Inbound
from rosic.messengers.telegram.update_window import (
    ATTEMPTS,
    OVERDUE_AT_MOST,
    AdmittedUpdate,
    UpdateWindow,
)
from rosic.testing.clock import ManualClock, settle

if TYPE_CHECKING:
    from collections.abc import AsyncIterator


def news(number: int, chat: str = "1", *, stop: bool = False) -> AdmittedUpdate:
    inbound = Inbound(
        sender=Address("t", chat),
        chat=Chat("t", chat),
        message=str(number),
        text="stop" if stop else "move",
        sent_ns=0,
        received_ns=0,
    )
    return AdmittedUpdate(number, inbound, stop)


def take(window: UpdateWindow, poll: list[AdmittedUpdate]) -> int:
    """Take what one poll brought; return how many were new."""
    fresh = sum(window.admit(one) for one in poll)
    window.release()
    return fresh


class Table:
    """Receives only what it is told to receive."""

    def __init__(self, window: UpdateWindow, clock: ManualClock, heard: list[str]) -> None:
        self.window = window
        self.clock = clock
        self.heard = heard
        self.held: dict[str, asyncio.Event] = {}
        self.broken: Counter[str] = Counter()

    def hold(self, *messages: int) -> None:
        for message in messages:
            self.held[str(message)] = asyncio.Event()

    async def receive(self, inbound: Inbound) -> None:
        self.heard.append(inbound.message)
        if self.broken[inbound.message] > 0:
            self.broken[inbound.message] -= 1
            raise ValueError("a bug")
        if inbound.message in self.held:
            await self.held[inbound.message].wait()


@pytest.fixture
async def table() -> AsyncIterator[Table]:
    async with laid() as table:
        yield table


@asynccontextmanager
async def laid() -> AsyncIterator[Table]:
    clock = ManualClock()
    counts: Counter[str] = Counter()
    async with asyncio.TaskGroup() as group:

        async def receive(inbound: Inbound) -> None:
            await laid_out.receive(inbound)

        laid_out = Table(UpdateWindow(group, receive, clock, counts), clock, [])
        yield laid_out
        for event in laid_out.held.values():
            event.set()


async def test_nothing_is_confirmed_while_it_is_being_received(table: Table) -> None:
    table.hold(10)
    take(table.window, [news(10), news(11, "2")])
    await settle()
    assert table.window.busy
    assert table.window.offset is None
    table.held["10"].set()
    await settle()
    assert table.window.offset == 12


async def test_what_is_before_the_first_unfinished_one_is_confirmed(table: Table) -> None:
    table.hold(12)
    take(table.window, [news(10), news(11), news(12), news(13, "2")])
    await settle()
    assert table.window.offset == 12
    table.window.confirmed(12)
    assert table.window.offset is None
    table.held["12"].set()
    await settle()
    assert table.window.offset == 14


async def test_an_offset_is_not_repeated(table: Table) -> None:
    take(table.window, [news(10)])
    await settle()
    assert table.window.offset == 11
    table.window.confirmed(11)
    assert table.window.offset is None
    take(table.window, [news(3)])  # after a quiet week Telegram goes on with lower numbers
    await settle()
    assert table.heard == ["10", "3"]
    assert table.window.offset == 4


async def test_what_is_given_out_again_is_not_handed_over_again(table: Table) -> None:
    table.hold(10)
    assert take(table.window, [news(10), news(11, "2"), news(11, "2")]) == 2
    await settle()
    assert take(table.window, [news(10), news(11, "2"), news(12, "2")]) == 1
    await settle()
    assert table.heard == ["10", "11", "12"]


async def test_stops_first_then_each_chat_in_order(table: Table) -> None:
    table.hold(10)
    batch = [news(13, stop=True), news(11), news(10), news(12, "2"), news(14, "2")]
    take(table.window, batch)
    await settle()
    assert table.heard == ["13", "10", "12", "14"]
    table.held["10"].set()
    await settle()
    assert table.heard == ["13", "10", "12", "14", "11"]


async def test_a_stop_does_not_wait_for_its_own_chat(table: Table) -> None:
    table.hold(10)
    take(table.window, [news(10), news(11)])
    await settle()
    take(table.window, [news(12, stop=True)])
    await settle()
    assert table.heard == ["10", "12"]


async def test_what_breaks_is_tried_again_and_given_up_in_the_end(table: Table) -> None:
    table.broken.update({"10": 1, "11": ATTEMPTS})
    take(table.window, [news(10), news(11, "2"), news(12, "2")])
    await settle()
    assert table.window.offset is None
    await table.clock.advance(10)
    assert table.heard.count("10") == 2
    assert table.heard.count("11") == ATTEMPTS
    assert table.heard[-1] == "12"
    assert table.window.offset == 13
    assert table.window._counts == {"received": 2, "given-up": 1}


async def test_waiting_for_it_ends_as_soon_as_everything_is_received(table: Table) -> None:
    table.hold(10)
    take(table.window, [news(10)])
    waiting = asyncio.create_task(table.window.idle(0.25))
    await settle()
    assert not waiting.done()
    table.held["10"].set()
    await settle()
    assert waiting.done()


async def test_waiting_for_it_ends_so_that_a_stop_is_seen(table: Table) -> None:
    table.hold(10)
    take(table.window, [news(10)])
    waiting = asyncio.create_task(table.window.idle(0.25))
    await table.clock.advance(0.3)
    assert waiting.done()
    assert table.window.busy


async def test_what_is_held_up_is_confirmed_after_a_while_and_followed_all_the_same(
    table: Table,
) -> None:
    table.hold(10)
    take(table.window, [news(10), news(11), news(12, "2")])
    await settle()
    await table.clock.advance(0.9)
    table.window.relieve()
    assert table.window.offset is None
    await table.clock.advance(0.2)
    table.window.relieve()
    assert table.window.offset == 13
    assert not table.window.busy
    table.window.confirmed(13)
    table.held["10"].set()
    await settle()
    assert table.heard == ["10", "12", "11"]
    assert table.window.offset is None, "an offset is not repeated"
    assert table.window._counts["received"] == 3


async def test_what_waits_for_something_to_be_read_is_never_confirmed(table: Table) -> None:
    """It was handed to nobody: if this process ended now, nobody would be told of it."""
    table.hold(10)
    take(table.window, [news(10)])
    table.window.admit(news(11, "2"))
    await settle()
    await table.clock.advance(1.1)
    table.window.relieve()
    assert table.window.offset == 11
    await table.clock.advance(1.1)
    table.window.relieve()
    assert table.window.offset == 11
    table.window.release(11)
    await settle()
    assert table.heard == ["10"]
    table.window.release()
    await settle()
    assert table.heard == ["10", "11"]
    assert table.window.offset == 12


async def test_whatever_ends_shows_that_nothing_is_held_up(table: Table) -> None:
    table.hold(10, 11)
    take(table.window, [news(10), news(11, "2")])
    await settle()
    await table.clock.advance(0.9)
    table.held["11"].set()
    await settle()
    await table.clock.advance(0.9)
    table.window.relieve()
    assert table.window.offset is None


async def test_of_too_much_that_is_held_up_what_was_not_begun_is_given_up(table: Table) -> None:
    table.hold(0)
    for number in range(0, OVERDUE_AT_MOST + 1, 91):
        take(table.window, [news(n) for n in range(number, number + 91)])
        await settle()
        await table.clock.advance(1.0)
        table.window.relieve()
        table.window.confirmed(table.window.offset)
    assert table.window._counts["given-up"] == OVERDUE_AT_MOST, "all but what was begun, each once"
    table.held["0"].set()
    await settle()
    assert table.heard == ["0"]
    assert not table.window._overdue
