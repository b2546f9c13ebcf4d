"""A cancel ends what its author has under way, all of it, and latches nothing."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

import pytest
from msgspec.structs import replace

from rosic.core.message import ChatKind, MessageValidity
from rosic.core.records import Claimed
from rosic.core.robot.profile import Busy, Presence
from rosic.errors import RecordUnavailable
from rosic.robots.memory import MemoryRobot
from tests.gateway.place import BO, VI, Place, SlowStore, profile

if TYPE_CHECKING:
    from rosic.core.records import Record

LONG_S = 10_000.0
SWARM = tuple(profile(f"cf{number}", groups=("swarm",)) for number in range(1, 41))
"""So many that others have their turn while a line to all of them is worked out."""


def _latched(place: Place) -> list[str]:
    return [name for name, robot in place.gateway.robots.items() if robot.gate.latched]


def _works(place: Place) -> list[str]:
    linker = place.gateway.rooms.linker
    return [name for name in place.gateway.robots if linker.current(name) is not None]


async def _at_work(place: Place) -> None:
    """Let Ada drive omni and wave with kuka1, and Bo drive cf1."""
    for name in ("omni", "kuka1", "cf1"):
        place.robot(name).work_s = LONG_S
    await place.say("omni move 1 m")
    await place.say("kuka1 wave")
    await place.say("cf1 move 1 m", account=BO, chat="2")
    assert _works(place) == ["omni", "kuka1", "cf1"]


@pytest.mark.parametrize(
    "word",
    ["cancel", "Cancel!", "/cancel", "abort", "cancle", "abbrechen", "取消", "отмена"],
)
async def test_it_ends_what_its_author_has_under_way_and_nobody_elses(word: str) -> None:
    async with Place().open() as place:
        await _at_work(place)
        told = await place.say(word)
        assert "Cancelled. omni is at rest (0.00 s). kuka1 is at rest (0.00 s)." in told
        assert "stopped before it ended 12:00:00: as Ada asked" in told
        assert _works(place) == ["cf1"]
        assert _latched(place) == []
        place.robot("omni").work_s = 0.0
        await place.say("omni move 1 m")
        assert place.acted("omni") == 2, "the robot is free for the next order at once"


async def test_a_name_leaves_the_others_at_work() -> None:
    async with Place().open() as place:
        await _at_work(place)
        await place.say("omni cancel")
        assert _works(place) == ["kuka1", "cf1"]
        await place.say("cancel kuka")
        assert _works(place) == ["cf1"], "a name that means nobody leaves nothing at work"


async def test_in_reply_to_an_order_it_ends_that_one() -> None:
    async with Place().open() as place:
        place.robot("omni").work_s = place.robot("kuka1").work_s = LONG_S
        await place.say("omni move 1 m")
        omni = place.last()[0]
        await place.say("kuka1 wave")
        await place.say("cancel", answers=omni)
        assert _works(place) == ["kuka1"]


async def test_what_waits_for_a_busy_robot_is_not_done() -> None:
    async with Place().open() as place:
        place.robot("kuka1").work_s = LONG_S
        await place.say("kuka1 wave")
        await place.say("kuka1 move 1 m")
        await place.say("kuka1 move 2 m")
        told = await place.say("cancel")
        assert "2 commands that waited are not done." in told
        assert "You cancelled this before it could begin. Nothing was done." in told
        assert place.acted("kuka1") == 1
        assert place.gateway.rooms.linker.waiting("kuka1") == 0


async def test_it_leaves_what_others_have_waiting() -> None:
    async with Place(fleet=(profile("kuka1", busy=Busy.QUEUE),)).open() as place:
        place.robot("kuka1").work_s = LONG_S
        await place.say("kuka1 wave")
        await place.say("kuka1 look", account=VI, chat="3")
        await place.say("cancel")
        assert place.acted("kuka1") == 2


async def test_an_order_on_its_way_to_the_disk_does_not_begin() -> None:
    store = SlowStore(Claimed)
    async with Place(store).open() as place:
        place.chat.say("omni move 1 m")
        await place.quiet()
        await place.clock.advance(0.001)
        place.chat.say("cancel")
        await place.quiet()
        store.ready.set()
        await place.quiet()
        assert place.acted() == 0
        await place.say("omni move 1 m")
        assert place.acted() == 1


class SecondSlow(SlowStore):
    """Its disk takes its time with the second record of its kind, and with none before."""

    def __init__(self, slow: type) -> None:
        super().__init__(slow)
        self.ready.set()
        self._count = 0

    async def write(self, *records: Record) -> None:
        """Let go of ``ready`` when the second comes."""
        self._count += any(isinstance(record, self._slow) for record in records)
        if self._count == 2:
            self._count += 1
            self.ready.clear()
        await super().write(*records)


async def test_nobody_of_a_broadcast_begins_that_waits_for_the_disk_of_one() -> None:
    store = SecondSlow(Claimed)
    place = Place(store, fleet=SWARM)
    async with place.open():
        place.chat.say("/broadcast swarm move 1 m")
        await place.quiet()
        assert not store.ready.is_set()
        await place.clock.advance(0.001)
        place.chat.say("cancel")
        await place.quiet()
        store.ready.set()
        await place.quiet()
        await place.clock.advance(1.0)
        assert sum(map(place.acted, place.gateway.robots)) == 0
        assert "2 of 40 robots are asked" in place.last()[1].text
        assert "You cancelled this before it could begin" in place.last()[1].text
        await place.say("/broadcast swarm move 1 m")
        assert sum(map(place.acted, place.gateway.robots)) == 40


@pytest.mark.parametrize("turns", [12, 20])
@pytest.mark.parametrize("line", ["/together swarm move 1 m", "/broadcast swarm move 1 m"])
async def test_many_that_are_looked_at_when_a_cancel_comes_do_not_begin(
    line: str, turns: int
) -> None:
    place = Place(fleet=SWARM)
    async with place.open():
        await _cancelled_after(turns, line, place)
        assert sum(map(place.acted, place.gateway.robots)) == 0


@pytest.mark.parametrize("turns", [2, 3, 4, 5])
async def test_a_task_that_is_worked_out_when_a_cancel_comes_is_not_given(turns: int) -> None:
    place = Place(fleet=SWARM)
    async with place.open():
        await _cancelled_after(turns, "/task swarm move 1 m then move 2 m then wave", place)
        assert sum(map(place.acted, place.gateway.robots)) == 0
        assert await place.say("/tasks") == "No task is open."


async def test_what_a_cancel_of_others_leaves_is_given() -> None:
    place = Place(fleet=SWARM)
    async with place.open():
        await _cancelled_after(3, "/task swarm move 1 m then wave", place, "cancel cf1")
        assert sum(map(place.acted, place.gateway.robots)) == 1


async def _cancelled_after(turns: int, line: str, place: Place, cancel: str = "cancel") -> None:
    """Say a line, and let a cancel come so many turns of the event loop later."""
    for robot in place.gateway.robots:
        place.robot(robot).work_s = LONG_S
    await place.clock.advance(0.001)
    place.chat.say(line)
    for _ in range(turns):
        await asyncio.sleep(0)
    assert sum(map(place.acted, place.gateway.robots)) == 0
    place.chat.say(cancel)
    await place.quiet()
    for _ in range(4):
        await place.clock.advance(0.5)


async def test_what_was_received_before_and_is_read_after_it_is_void() -> None:
    async with Place().open() as place:
        before = place.chat.say("status", chat="elsewhere")
        await place.clock.advance(0.001)
        await place.say("cancel")
        late = replace(before, text="omni move 1 m", message="late")
        place.chat.deliver(late)
        await place.quiet()
        assert place.acted() == 0
        assert "You cancelled this before" in place.last()[1].text
        await place.say("omni move 1 m", chat="elsewhere")
        assert place.acted() == 1


async def test_nothing_else_of_its_message_is_done() -> None:
    async with Place().open() as place:
        await _at_work(place)
        told = await place.say("cf2 move 1 m\ncancel")
        assert "Nothing else of that message was done." in told
        assert place.acted("cf2") == 0
        assert _works(place) == ["cf1"]


async def test_all_of_a_common_start_end() -> None:
    async with Place().open() as place:
        place.robot("cf1").work_s = place.robot("cf2").work_s = LONG_S
        await place.say("/together swarm move 1 m")
        assert _works(place) == ["cf1", "cf2"]
        await place.say("cancel")
        assert _works(place) == []
        assert _latched(place) == []


async def test_tasks_end_and_nobody_else_takes_them() -> None:
    async with Place().open() as place:
        place.robot("cf1").work_s = place.robot("cf2").work_s = LONG_S
        await place.say("/task swarm move 1 m")
        await place.say("/task swarm move 2 m")
        await place.say("/task swarm move 3 m")
        await place.clock.advance(1.0)
        assert _works(place) == ["cf1", "cf2"]
        told = await place.say("cancel")
        for _ in range(10):
            await place.clock.advance(0.5)
        assert "3 tasks are cancelled" in told
        assert _works(place) == []
        assert (place.acted("cf1"), place.acted("cf2")) == (1, 1)
        assert await place.say("/tasks") == "No task is open."


async def test_a_question_that_waits_for_an_answer_is_void() -> None:
    async with Place().open() as place:
        await place.say("omni move 1 m")
        await place.say("again")
        do_it, under = place.button("Do it")
        await place.say("cancel")
        told = await place.tap(do_it, under)
        assert "no longer good" in told or told == ""
        assert place.acted() == 1


async def test_with_nothing_under_way_it_says_who_is_at_work() -> None:
    async with Place().open() as place:
        await _at_work(place)
        told = await place.say("cancel", account=VI, chat="3")
        assert told.startswith("Nothing of yours is under way.\ncf1 is at work for Bo;")
        assert _works(place) == ["omni", "kuka1", "cf1"]
        stop, under = place.button("STOP cf1")
        await place.tap(stop, under, account=VI)
        assert _latched(place) == ["cf1"]


async def test_an_edited_message_may_cancel_and_a_stranger_may_not() -> None:
    async with Place().open() as place:
        await _at_work(place)
        await place.say("cancel", account="99", chat="99")
        assert _works(place) == ["omni", "kuka1", "cf1"]
        await place.say("cancel", standing=MessageValidity.EDITED)
        assert _works(place) == ["cf1"]


async def test_in_a_group_it_is_whoever_says_it() -> None:
    async with Place().open() as place:
        await _at_work(place)
        await place.say("cancel", account=BO, chat="g", kind=ChatKind.GROUP)
        assert _works(place) == ["omni", "kuka1"]


class Restless(MemoryRobot):
    """Says that it moves on, whatever is cancelled; a stop brings it to rest."""

    def presence(self) -> Presence:
        moves = bool(self.acted) and not self.gate.latched
        return replace(super().presence(), at_rest=not moves)


class RestlessPlace(Place):
    kind = Restless


async def test_what_does_not_come_to_rest_is_stopped() -> None:
    async with RestlessPlace().open() as place:
        place.robot("omni").work_s = LONG_S
        await place.say("omni move 1 m", account=BO, chat="2")
        place.chat.say("cancel", account=BO, chat="2")
        for _ in range(200):
            await place.clock.advance(0.05)
        await place.quiet()
        assert _latched(place) == ["omni"]
        texts = [told.outbound.text for told in place.chat.told]
        assert any("omni has not come to rest by it. It is stopped now" in text for text in texts)


async def test_it_needs_no_disk() -> None:
    store = SlowStore(Claimed)
    store.ready.set()
    async with Place(store).open() as place:
        await _at_work(place)
        store.ready.clear()
        await place.say("cancel")
        assert _works(place) == ["cf1"]
        store.ready.set()


async def test_a_cancel_does_not_wait_for_its_chat() -> None:
    store = SlowStore(Claimed)
    async with Place(store).open() as place:
        store.ready.set()
        await _at_work(place)
        store.ready.clear()
        place.chat.say("cf2 wave")
        await place.quiet()
        await place.clock.advance(0.001)
        place.chat.say("cancel")
        await place.quiet()
        assert _works(place) == ["cf1"], "though the message before it is not settled"
        store.ready.set()
        await place.quiet()
        assert place.acted("cf2") == 0


async def test_an_order_that_came_with_the_cancel_is_void() -> None:
    """A poll brings both at one moment, and the cancel is obeyed before the order is read."""
    async with Place().open() as place:
        await _at_work(place)
        place.chat.say("cancel")
        place.chat.say("cf2 wave")
        await place.quiet()
        assert place.acted("cf2") == 0
        assert _works(place) == ["cf1"]


async def test_pause_holds_tasks_and_says_what_cannot_be_held() -> None:
    async with Place().open() as place:
        await _at_work(place)
        place.robot("cf2").work_s = LONG_S
        await place.say("/task cf2 move 1 m")
        await place.clock.advance(1.0)
        told = await place.say("pause")
        assert "Task 1 is paused; its robot is brought to rest." in told
        assert "omni cannot hold that half way. Cancel it, or stop it." in told
        assert _works(place) == ["omni", "kuka1", "cf1"]
        assert place.button("Continue")
        assert place.button("STOP omni")
        cancel, under = place.button("Cancel omni")
        await place.tap(cancel, under)
        assert _works(place) == ["kuka1", "cf1"]
        place.robot("cf2").work_s = 0.0
        assert "Task 1 goes on." in await place.say("continue")
        await place.clock.advance(1.0)
        assert place.acted("cf2") == 2
        assert await place.say("continue") == "Nothing of yours is paused."


@pytest.mark.parametrize("after_s", [0.0, 0.01, 0.06, 1.0])
@pytest.mark.parametrize("word", ["cancel", "cancel cf2", "button"])
async def test_what_was_paused_is_cancelled_too(word: str, after_s: float) -> None:
    async with Place().open() as place:
        place.robot("cf2").work_s = LONG_S
        await place.say("/task cf2 move 1 m")
        await place.clock.advance(1.0)
        await place.say("pause")
        await place.clock.advance(after_s)
        if word == "button":
            await place.tap(*place.button("Cancel"))
        else:
            await place.say(word)
        await place.clock.advance(1.0)
        assert await place.say("/tasks") == "No task is open."
        assert await place.say("continue") == "Nothing of yours is paused."


async def test_what_was_paused_stays_so_where_another_robot_is_named() -> None:
    async with Place().open() as place:
        place.robot("cf2").work_s = LONG_S
        await place.say("/task cf2 move 1 m")
        await place.clock.advance(1.0)
        await place.say("pause")
        await place.clock.advance(1.0)
        before = await place.say("/tasks")
        assert "paused" in before
        await place.say("cancel omni")
        assert await place.say("/tasks") == before


async def test_cancel_booking_is_about_bookings_whatever_moves() -> None:
    async with Place().open() as place:
        await _at_work(place)
        assert await place.say("cancel booking") == "You have no times booked."
        await place.say("/task cf2 move 1 m")
        assert "Task 1" in await place.say("cancel task 1")
        assert _works(place) == ["omni", "kuka1", "cf1"]


@pytest.mark.parametrize(
    ("raised", "told"),
    [
        (RuntimeError("a fault of ours"), "Something else of yours could not be ended."),
        (asyncio.CancelledError(), "Something else of yours could not be ended."),
        (RecordUnavailable("It could not be written."), "It could not be written."),
    ],
)
async def test_what_else_cannot_be_ended_does_not_take_the_answer_with_it(
    raised: BaseException, told: str
) -> None:
    async def fail(_who: object, _robots: object) -> str:
        raise raised

    async with Place().open() as place:
        place.gateway.pipeline.cancels.also(fail)
        await _at_work(place)
        await place.say("/task cf2 move 1 m")
        answer = await place.say("cancel")
        assert "Cancelled. omni is at rest (0.00 s). kuka1 is at rest (0.00 s). " in answer
        assert told in answer
