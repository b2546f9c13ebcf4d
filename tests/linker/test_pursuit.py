"""A stop that was not confirmed goes on until rest is measured; then people are told."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

import pytest

from rosic.core.order import RestReport, Stop
from rosic.core.order_gate import OrderGate
from rosic.core.robot.profile import Link, Presence, Profile
from rosic.core.robot.skill import Skill
from rosic.core.stop_registry import StopRegistry, not_known_yet
from rosic.errors import RobotUnreachable
from rosic.linker.linker import Linker
from rosic.linker.pursuit import EVERY_S
from rosic.robots.memory import MemoryRobot
from rosic.stores.stop_latch import MemoryLatch
from rosic.testing.clock import ManualClock, settle
from tests.linker.policy import Policy
from tests.linker.test_linker import SlowLatch

if TYPE_CHECKING:
    from rosic.contracts.store import StopLatch

PROFILE = Profile(id="omni", link=Link(kind="memory"), skills={"move": Skill(id="move")})


class Coasting(MemoryRobot):
    """It comes to rest when it is told so for the last of so many times; None: never."""

    times: int | None = 3
    at_rest: bool | None = False
    fails = False

    def __init__(self, clock: ManualClock) -> None:
        super().__init__(PROFILE, OrderGate.new("omni"), clock)
        self.told: list[int] = []

    async def stop(self, stop: Stop) -> RestReport:
        await super().stop(stop)
        self.told.append(stop.generation)
        if self.fails:
            raise ZeroDivisionError
        if self.online and len(self.told) == self.times:
            self.at_rest = True
        return RestReport(stop.robot, confirmed=self.at_rest is True, seconds=0.1)

    def presence(self) -> Presence:
        return Presence(online=self.online, at_rest=self.at_rest if self.online else None)


class Place:
    def __init__(
        self, found: dict[str, tuple[int, bool]] | None = None, latch: StopLatch | None = None
    ) -> None:
        self.clock = ManualClock()
        self.robot = Coasting(self.clock)
        self.stops = StopRegistry(["omni"], found or {}, not_known_yet())
        self.latch = MemoryLatch() if latch is None else latch
        self.linker = Linker(
            {"omni": self.robot}, self.stops, self.latch, self.clock, self.clock.wall_ns, Policy(0)
        )

    @property
    def told(self) -> int:
        return len(self.robot.told)

    async def pass_s(self, seconds: float) -> None:
        await self.clock.advance(seconds)


@pytest.fixture
def place() -> Place:
    return Place()


async def test_what_is_not_there_and_was_never_seen_at_rest_stays_stopped(place: Place) -> None:
    rest = await stopped(place)
    assert not rest.confirmed
    place.robot.online = False
    with pytest.raises(RobotUnreachable, match="omni is not there; its stop was never confirmed"):
        await place.linker.resume("omni", 1)
    assert place.stops["omni"].latched

    place.robot.online = True
    await place.pass_s(5 * EVERY_S)
    assert place.robot.at_rest
    place.robot.online = False  # it went away at rest, as it was seen
    assert await place.linker.resume("omni", 1)
    assert not place.stops["omni"].latched


async def test_what_an_earlier_run_stopped_may_be_resumed_while_it_is_away() -> None:
    place = Place({"omni": (4, True)})
    place.robot.online = False
    place.linker.watch_stopped()
    await place.pass_s(2 * EVERY_S)
    assert await place.linker.resume("omni", 4)


async def stopped(place: Place) -> RestReport:
    halting = place.linker.stop(["omni"], "p1")
    await halting.latched
    return await halting.rests["omni"]


async def test_a_stop_is_applied_once_a_second_until_rest_is_measured(place: Place) -> None:
    assert not (await stopped(place)).confirmed
    assert place.told == 1
    await place.pass_s(EVERY_S)
    assert place.told == 2
    assert "omni" in place.linker.pursuit
    await place.pass_s(EVERY_S)
    assert place.told == 3
    await place.pass_s(60)
    assert place.told == 3
    assert "omni" not in place.linker.pursuit
    assert set(place.robot.told) == {1}


async def test_a_stop_that_was_confirmed_is_not_applied_again(place: Place) -> None:
    place.robot.times = 1
    assert (await stopped(place)).confirmed
    await place.pass_s(60)
    assert place.told == 1


async def test_a_fault_of_the_adapter_does_not_end_it(place: Place) -> None:
    place.robot.fails = True
    with pytest.raises(ZeroDivisionError):
        await stopped(place)
    await place.pass_s(EVERY_S)
    place.robot.fails = False
    await place.pass_s(EVERY_S)
    assert place.told == 3
    assert place.robot.at_rest


async def test_what_is_not_there_is_stopped_once_it_is_back(place: Place) -> None:
    place.robot.online = False
    await stopped(place)
    await place.pass_s(60)
    assert place.told == 1
    place.robot.online, place.robot.times = True, 2
    await place.pass_s(EVERY_S)
    assert place.told == 2
    assert "omni" not in place.linker.pursuit


async def test_where_rest_is_not_measured_it_is_told_again_only_when_it_comes_back(
    place: Place,
) -> None:
    place.robot.at_rest, place.robot.times = None, None
    await stopped(place)
    await place.pass_s(60)
    assert place.told == 1
    for times in (2, 3):
        place.robot.online = False
        await place.pass_s(EVERY_S)
        place.robot.online = True
        await place.pass_s(60)
        assert place.told == times


async def test_a_later_stop_takes_over(place: Place) -> None:
    place.robot.times = 4
    await stopped(place)
    await stopped(place)
    assert "omni" in place.linker.pursuit, "the end of the earlier one is not that of this one"
    await place.pass_s(60)
    assert place.robot.told == [1, 2, 2, 2]


async def test_whoever_waits_for_an_earlier_stop_hears_what_came_of_the_later_one(
    place: Place,
) -> None:
    place.robot.times = 4
    await stopped(place)
    first = asyncio.create_task(place.linker.pursuit.rested("omni", 1))
    await settle()
    await stopped(place)
    second = asyncio.create_task(place.linker.pursuit.rested("omni", 2))
    await settle()
    assert not first.done()
    assert not second.done()
    await place.pass_s(2 * EVERY_S)
    for waiting in (first, second):
        rest = await waiting
        assert rest is not None
        assert rest.confirmed


async def test_whoever_asks_after_it_was_confirmed_is_told_of_this_stop_and_of_no_earlier_one(
    place: Place,
) -> None:
    place.robot.times = 2
    await stopped(place)
    await place.pass_s(EVERY_S)
    rest = await place.linker.pursuit.rested("omni", 1)
    assert rest is not None
    assert rest.confirmed
    place.robot.at_rest = False
    await stopped(place)
    waiting = asyncio.create_task(place.linker.pursuit.rested("omni", 2))
    await settle()
    place.linker.pursuit.end("omni")
    assert await waiting is None, "what was measured then is nothing that is so now"


async def test_what_came_of_a_stop_stays_known_when_a_later_one_is_undone(place: Place) -> None:
    place.robot.times = 2
    await stopped(place)
    await place.pass_s(EVERY_S)
    rest = await place.linker.pursuit.rested("omni", 1)
    assert rest is not None
    place.robot.at_rest = False
    await stopped(place)
    place.stops.resume("omni", 2)
    await place.pass_s(2 * EVERY_S)
    assert "omni" not in place.linker.pursuit
    assert await place.linker.pursuit.rested("omni", 1) == rest


async def test_a_stop_that_stands_no_more_is_not_applied_again(place: Place) -> None:
    await stopped(place)
    place.stops.resume("omni", 1)  # whoever keeps the stops need not tell the pursuit
    await place.pass_s(60)
    assert place.robot.told == [1]
    assert "omni" not in place.linker.pursuit


async def test_a_stop_that_is_not_the_last_one_is_not_applied_again(place: Place) -> None:
    await stopped(place)
    place.stops.stop("omni", "p2", 0)
    await place.pass_s(60)
    assert place.robot.told == [1]


async def test_a_stop_that_comes_while_an_earlier_one_is_undone_stands() -> None:
    latch = SlowLatch()
    latch.ready.set()
    place = Place(latch=latch)
    await stopped(place)
    place.robot.at_rest = True
    latch.ready.clear()
    resuming = asyncio.create_task(place.linker.resume("omni", 1))
    await settle()
    place.robot.at_rest = False
    place.linker.stop(["omni"], "p2")
    latch.ready.set()
    assert await resuming is False
    assert place.stops["omni"].latched
    assert "omni" in place.linker.pursuit


async def test_nobody_waits_for_what_is_not_pursued(place: Place) -> None:
    assert await place.linker.pursuit.rested("omni", 1) is None


async def test_what_moves_is_not_resumed_and_stays_stopped_on_disk_too(place: Place) -> None:
    place.robot.times = None
    await stopped(place)
    with pytest.raises(RobotUnreachable, match="omni still moves: its stop is not confirmed yet"):
        await place.linker.resume("omni", 1)
    assert place.stops["omni"].latched
    assert place.robot.gate.latched
    assert place.latch.read() == {"omni": (1, True)}
    place.robot.times = 2
    await place.pass_s(EVERY_S)
    assert await place.linker.resume("omni", 1)


async def test_one_that_this_run_brings_to_rest_is_not_resumed_while_it_is_not_there() -> None:
    place = Place({"omni": (1, True)})
    place.robot.times = None
    place.linker.watch_stopped()
    await place.pass_s(EVERY_S)
    assert place.told == 1
    place.robot.online = False
    with pytest.raises(RobotUnreachable):
        await place.linker.resume("omni", 1)
    assert place.stops["omni"].latched


async def test_a_resume_ends_it(place: Place) -> None:
    place.robot.at_rest = place.robot.times = None
    await stopped(place)
    assert await place.linker.resume("omni", 1)
    assert "omni" not in place.linker.pursuit
    place.robot.at_rest = False  # its new order moves it
    await place.pass_s(60)
    assert place.told == 1


async def test_one_whose_last_order_is_in_doubt_is_brought_to_rest_and_held(place: Place) -> None:
    assert place.linker.halt("omni") == 1
    assert place.robot.gate.latched
    await settle()
    assert place.told == 1
    await place.pass_s(60)
    assert place.told == 3
    assert place.robot.at_rest


async def test_a_stop_of_this_run_that_is_under_way_is_not_taken_for_an_earlier_runs() -> None:
    place = Place({"omni": (7, True)})
    place.robot.online, place.robot.at_rest = False, None
    await stopped(place)
    place.linker.watch_stopped()
    with pytest.raises(RobotUnreachable):
        await place.linker.resume("omni", 8)
    place.robot.online = True  # it has not heard the stop, and measures nothing
    await place.pass_s(EVERY_S)
    assert place.robot.told == [8, 8]


async def test_one_that_was_stopped_before_a_restart_is_stopped_again_only_where_it_moves() -> None:
    for moves, times in ((True, 1), (False, 0)):
        place = Place({"omni": (7, True)})
        place.robot.gate.apply_stop(Stop("omni", 7))
        place.robot.at_rest, place.robot.times = None, 1
        place.linker.watch_stopped()
        await place.pass_s(5)
        assert place.told == 0  # nothing is measured yet
        place.robot.at_rest = not moves
        await place.pass_s(60)
        assert place.robot.told == [7] * times
        assert "omni" not in place.linker.pursuit


async def test_whoever_waits_is_told_what_came_of_it(place: Place) -> None:
    await stopped(place)
    waiting = asyncio.create_task(place.linker.pursuit.rested("omni", 1))
    await settle()
    await place.pass_s(EVERY_S * 2)
    rest = await waiting
    assert rest is not None
    assert rest.confirmed
    place.robot.at_rest = place.robot.times = None
    await stopped(place)
    waiting = asyncio.create_task(place.linker.pursuit.rested("omni", 2))
    await settle()
    place.linker.pursuit.close()
    assert await waiting is None
