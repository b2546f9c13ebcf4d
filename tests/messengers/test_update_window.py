"""What is confirmed, and in which order things are handed over."""

from __future__ import annotations

import asyncio
from collections import Counter
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING

import pytest
from msgspec import structs

from rosic.core.identity import Address
from rosic.core.message import Chat, Inbound, MessageValidity
from rosic.core.time_units import SECOND_NS
from rosic.messengers.telegram.update_window import (
    ATTEMPTS,
    FIRST_WAIT_S,
    HELD_NS,
    OVERDUE_AT_MOST,
    WAITING_AT_MOST,
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

    def __init__(
        self, window: UpdateWindow, clock: ManualClock, heard: list[str], roomy: list[int]
    ) -> None:
        self.window = window
        self.roomy = roomy
        self.clock = clock
        self.heard = heard
        self.held: dict[str, asyncio.Event] = {}
        self.broken: Counter[str] = Counter()
        self.told: list[str] = []

    def hold(self, *messages: int) -> None:
        for message in messages:
            self.held[str(message)] = asyncio.Event()

    async def receive(self, inbound: Inbound) -> None:
        self.heard.append(inbound.message)
        if self.broken[inbound.message] > 0:
            self.broken[inbound.message] -= 1
            raise ValueError("a bug")
        if inbound.standing is MessageValidity.DROPPED:
            self.told.append(inbound.message)
            return
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

        def room() -> None:
            laid_out.roomy.append(laid_out.window._waiting)

        laid_out = Table(UpdateWindow(group, receive, clock, counts, room), clock, [], [])
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


async def test_what_is_received_while_a_poll_confirms_what_is_before_it_stays_known(
    table: Table,
) -> None:
    """Telegram gives it out once more: the offset that it took was the number itself."""
    table.hold(11)
    take(table.window, [news(10), news(11)])
    await settle()
    assert table.window.offset == 11
    table.held["11"].set()
    await settle()
    table.window.confirmed(11)
    assert not table.window.knows(10)
    assert take(table.window, [news(11)]) == 0
    await settle()
    assert table.heard == ["10", "11"]
    assert table.window.offset == 12


async def test_whose_message_it_is_is_asked_anew_where_a_number_comes_again(table: Table) -> None:
    """A stranger's may be confirmed before it is received; that of somebody known may not."""
    table.window.expect(10, light=True)
    take(table.window, [news(10, "stranger")])
    await settle()
    table.window.confirmed(11)
    table.hold(10)
    take(table.window, [news(10)])
    await settle()
    assert table.heard == ["10", "10"]
    table.window.clear_the_way()
    assert table.window.offset is None


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


async def test_what_is_given_up_is_given_up_with_the_last_attempt(table: Table) -> None:
    """What is behind it waits no longer for something that is not tried again."""
    table.broken["10"] = ATTEMPTS
    take(table.window, [news(10), news(11)])
    waits = [FIRST_WAIT_S * 2**n for n in range(ATTEMPTS - 1)]
    await table.clock.advance(sum(waits) - FIRST_WAIT_S / 2)
    assert table.heard == ["10"] * (ATTEMPTS - 1)
    await table.clock.advance(FIRST_WAIT_S / 2)
    assert table.heard == ["10"] * ATTEMPTS + ["11"]
    assert table.window.offset == 12


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


async def test_what_is_held_up_is_confirmed_where_it_is_in_the_way_and_followed_all_the_same(
    table: Table,
) -> None:
    table.hold(10)
    take(table.window, [news(10), news(11), news(12, "2")])
    await settle()
    assert table.window.offset is None
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
    table.window.relieve()
    assert table.window.offset == 11
    table.window.relieve()
    assert table.window.offset == 11
    table.window.release(11)
    await settle()
    assert table.heard == ["10"]
    table.window.release()
    await settle()
    assert table.heard == ["10", "11"]
    assert table.window.offset == 12


async def settled() -> None:
    """Let more than a thousand be handed over."""
    for _ in range(60):
        await settle()


async def held_up(table: Table, count: int, chats: int = 1) -> None:
    """Have so many handed over and confirmed, of which nothing ends."""
    for first in range(0, count, 100):
        numbers = range(first, min(first + 100, count))
        take(table.window, [news(n, str(n % chats)) for n in numbers])
        await settled()
        table.window.relieve()
        table.window.confirmed(table.window.offset)


async def test_of_too_much_that_is_held_up_what_waited_for_long_is_given_up(
    table: Table, caplog: pytest.LogCaptureFixture
) -> None:
    table.hold(0)
    await held_up(table, OVERDUE_AT_MOST)
    await table.clock.advance(HELD_NS / SECOND_NS)
    late, first = OVERDUE_AT_MOST - 1, OVERDUE_AT_MOST
    take(table.window, [news(first, "0"), news(first + 1, "0")])
    await settled()
    table.window.relieve()
    assert table.window.offset == first + 2
    assert table.window._counts["given-up"] == late, "all but what was begun and what came now"
    assert caplog.messages == [
        f"messages were given up because they cannot be followed: {late}",
    ]
    await settled()
    assert table.told == [str(n) for n in range(1, OVERDUE_AT_MOST)], "and whoever sent it is told"
    table.held["0"].set()
    await settled()
    assert table.heard[-2:] == [str(first), str(first + 1)]
    assert table.window._counts["received"] == 3
    assert not table.window._overdue
    assert table.window.has_room, "what was given up waits no longer"


async def test_of_too_much_that_is_held_up_nothing_is_given_up_or_confirmed_at_once(
    table: Table, caplog: pytest.LogCaptureFixture
) -> None:
    """What is handed over may still be followed: only what waited for long is not."""
    table.hold(0)
    await held_up(table, OVERDUE_AT_MOST)
    await table.clock.advance(HELD_NS / SECOND_NS / 2)
    take(table.window, [news(OVERDUE_AT_MOST, "0")])
    await settled()
    table.window.relieve()
    assert table.window.offset is None
    assert not table.window._counts["given-up"]
    assert not caplog.messages
    table.held["0"].set()
    await settled()
    assert table.window.offset == OVERDUE_AT_MOST + 1
    assert table.window._counts["received"] == OVERDUE_AT_MOST + 1
    assert table.told == []


async def test_of_as_much_as_may_be_held_up_nothing_is_given_up_however_long_it_waits(
    table: Table,
) -> None:
    table.hold(0)
    await held_up(table, OVERDUE_AT_MOST - 1)
    await table.clock.advance(2 * HELD_NS / SECOND_NS)
    take(table.window, [news(OVERDUE_AT_MOST - 1, "0")])
    await settled()
    table.window.relieve()
    assert table.window.offset == OVERDUE_AT_MOST
    assert not table.window._counts["given-up"]


async def test_as_much_as_may_be_held_up_is_confirmed_once_the_rest_is_given_up(
    table: Table,
) -> None:
    """Each chat has one under way, the first of them another that waited for long."""
    last = OVERDUE_AT_MOST
    table.hold(*range(last + 1))
    await held_up(table, last, chats=last - 1)
    assert len(table.window._overdue) == OVERDUE_AT_MOST, "so many may be"
    await table.clock.advance(HELD_NS / SECOND_NS)
    take(table.window, [news(last, "another")])
    await settled()
    table.window.relieve()
    assert table.window._counts["given-up"] == 1
    assert table.window.offset == last + 1


async def test_where_some_is_given_up_what_is_still_to_be_read_is_not_confirmed(
    table: Table,
) -> None:
    """Nor is anything of what was given up looked after any longer."""
    table.hold(0)
    await held_up(table, OVERDUE_AT_MOST)
    late, unread = OVERDUE_AT_MOST, OVERDUE_AT_MOST + 1
    take(table.window, [news(late, "0")])
    await settled()
    await table.clock.advance(HELD_NS / SECOND_NS)
    table.window.expect(unread)
    table.window.relieve()
    assert table.window._counts["given-up"] == late, "all but what was begun"
    assert table.window.offset == unread
    assert table.window.knows(unread)
    assert table.window._overdue == {0}


async def test_what_cannot_be_followed_at_all_is_told_of_in_its_own_way(table: Table) -> None:
    """What was changed or forwarded is followed in no case; one that breaks stops no other."""
    table.hold(0, 1)
    await held_up(table, OVERDUE_AT_MOST, chats=2)
    lane = table.window._lanes["1"]
    edited = structs.replace(lane[1].inbound, standing=MessageValidity.EDITED)
    lane[1] = lane[1]._replace(inbound=edited)
    table.broken["5"] = 1
    await table.clock.advance(HELD_NS / SECOND_NS)
    take(table.window, [news(OVERDUE_AT_MOST, "0")])
    await settled()
    table.window.relieve()
    await settled()
    assert set(table.told) == {str(n) for n in range(2, OVERDUE_AT_MOST)} - {edited.message, "5"}


async def test_while_too_much_waits_there_is_no_room_and_then_it_is_told(table: Table) -> None:
    table.hold(0)
    take(table.window, [news(n) for n in range(WAITING_AT_MOST + 1)])
    await settled()
    assert not table.window.has_room
    table.held["0"].set()
    await settled()
    assert table.window.has_room
    assert table.roomy[0] == WAITING_AT_MOST - 1
    assert table.roomy[-1] == 0
