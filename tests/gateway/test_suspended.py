"""I2: the machine sleeps, is paused, or stands still, wherever an order is between taken and done.

Suspend: the event loop's clock stands still, the machine's own run on. A virtual machine that is
paused: only the wall clock jumps, once it goes on. A process that is held (SIGSTOP): all run on.
"""

from __future__ import annotations

import asyncio
import signal
import sys
from asyncio.subprocess import PIPE
from functools import partial
from typing import TYPE_CHECKING, Final

import pytest
from msgspec.structs import replace

from rosic.core.order import Order, OrderStage
from rosic.core.order_gate import OrderGate
from rosic.core.robot.profile import Busy
from rosic.core.stop_registry import StopRegistry, not_known_yet
from rosic.core.synchronised_start import TOO_LATE_NS, begins_ns
from rosic.errors import OrderVoid
from rosic.linker.linker import Linker
from rosic.robots.memory import MemoryRobot
from rosic.stores.stop_latch import MemoryLatch
from rosic.testing.clock import ManualClock
from rosic.testing.factories import OrderBook
from tests.gateway.held import LIVES_S
from tests.gateway.place import FLEET, Place, WritingStore, profile
from tests.linker.policy import Policy
from tests.pace import patience

if TYPE_CHECKING:
    from collections.abc import Callable

    from rosic.contracts.clock import Clock
    from rosic.contracts.robot import Tell
    from rosic.core.order import Outcome, StageReport
    from rosic.core.records import Record
    from rosic.core.robot.profile import Profile

NIGHT_S = 8 * 3600.0
TURNS = 40
"""More than any order here takes from its message to its robot; that is asserted."""
OPENS = 3


def suspend(clock: ManualClock) -> None:
    clock.suspend(NIGHT_S)


def pause(clock: ManualClock) -> None:
    clock.jump_wall(NIGHT_S)


PAUSES: Final = (suspend, pause)


class Slow(MemoryRobot):
    """Looks for its nodes before it begins, keeps common starts, and notes when it began.

    Attributes:
        late_ns: By how much an order had expired when it was sent, by the clock that says more.
    """

    def __init__(self, profile: Profile, gate: OrderGate, clock: Clock) -> None:
        super().__init__(profile, gate, clock)
        self.late_ns: list[int] = []

    async def execute(self, order: Order, tell: Tell) -> Outcome:
        for _ in range(OPENS):
            await asyncio.sleep(0)

        def told(report: StageReport) -> None:
            if report.stage is OrderStage.SENT:
                self.late_ns.append(self._late_ns(order))
            tell(report)

        return await super().execute(order, told)

    def _late_ns(self, order: Order) -> int:
        clock, now_ns = self._clock, self._clock.monotonic_ns()
        late_ns = max(now_ns - order.deadline_ns, clock.wall_ns() - order.expires_ns)
        start_ns = begins_ns(order, now_ns)
        if start_ns is None:
            return late_ns
        ahead_ns = order.expires_ns - order.deadline_ns
        missed_ns = max(now_ns, clock.wall_ns() - ahead_ns) - start_ns - TOO_LATE_NS
        return max(late_ns, missed_ns)


class Together(Slow):
    """Passes its gate as what keeps a common start does."""

    def __init__(self, profile: Profile, gate: OrderGate, clock: Clock) -> None:
        super().__init__(profile, _KeepsStarts.new(gate.robot), clock)


class _KeepsStarts(OrderGate):
    __slots__ = ()

    def pass_order(
        self,
        order: Order,
        now_ns: int,
        wall_ns: int,
        *,
        together: bool = False,  # noqa: ARG002
    ) -> None:
        super().pass_order(order, now_ns, wall_ns, together=True)


class TakesTurns(WritingStore):
    """Its disk takes some turns of the event loop."""

    async def write(self, *records: Record) -> None:
        for _ in range(OPENS):
            await asyncio.sleep(0)
        await super().write(*records)


class SlowPlace(Place):
    kind = Slow


class TogetherPlace(Place):
    kind = Together


async def _turns(number: int) -> None:
    for _ in range(number):
        await asyncio.sleep(0)


async def _interrupted(
    place: Place,
    say: Callable[[], object],
    names: tuple[str, ...],
    after: int,
    interrupt: Callable[[ManualClock], None],
) -> tuple[int, int]:
    """Say something, let the machine sleep some turns later; return who acted before and in all."""
    robots = [place.robot(name) for name in names]
    assert all(isinstance(robot, Slow) for robot in robots)
    say()
    await _turns(after)
    before = sum(len(robot.acted) for robot in robots)
    interrupt(place.clock)
    await place.quiet()
    await place.clock.advance(1.0)
    await place.quiet()
    for robot in robots:
        assert isinstance(robot, Slow)
        assert all(late_ns <= 0 for late_ns in robot.late_ns), f"it began late, at turn {after}"
    return before, sum(len(robot.acted) for robot in robots)


@pytest.mark.parametrize("interrupt", PAUSES)
async def test_wherever_it_waits_nothing_moves_after_a_pause(
    interrupt: Callable[[ManualClock], None],
) -> None:
    waited = acted = 0
    for after in range(TURNS):
        async with SlowPlace(TakesTurns()).open() as place:
            before, in_all = await _interrupted(
                place, partial(place.chat.say, "omni wave"), ("omni",), after, interrupt
            )
            assert before == in_all, f"it moved after the pause, {after} turns in"
            waited += not in_all
            acted += in_all
    assert waited > 2 * OPENS, "the pause came at no time that matters"
    assert acted, "it never came after the robot had moved"


@pytest.mark.parametrize("interrupt", PAUSES)
async def test_wherever_a_tap_waits_nothing_moves_after_a_pause(
    interrupt: Callable[[ManualClock], None],
) -> None:
    acted = 0
    for after in range(TURNS):
        async with SlowPlace(TakesTurns()).open() as place:
            await place.say("robots")
            await place.tap(*place.button("omni"))
            await place.tap(*place.button("Wave"))
            button, under = place.button("Do it")
            before, in_all = await _interrupted(
                place,
                partial(place.chat.tap, button, under=under),
                ("omni",),
                after,
                interrupt,
            )
            assert before == in_all, f"it moved after the pause, {after} turns in"
            acted += in_all
    assert acted, "it never came after the robot had moved"


@pytest.mark.parametrize("interrupt", PAUSES)
async def test_none_of_a_group_begins_after_a_pause(
    interrupt: Callable[[ManualClock], None],
) -> None:
    for after in range(TURNS):
        async with TogetherPlace(TakesTurns()).open() as place:
            before, in_all = await _interrupted(
                place,
                partial(place.chat.say, "swarm wave"),
                ("cf1", "cf2"),
                after,
                interrupt,
            )
            assert before == in_all, f"it moved after the pause, {after} turns in"


@pytest.mark.parametrize("interrupt", PAUSES)
async def test_what_waits_for_a_busy_robot_does_not_outlive_a_night(
    interrupt: Callable[[ManualClock], None],
) -> None:
    fleet = (profile("kuka1", busy=Busy.QUEUE), *FLEET[2:])
    async with SlowPlace(fleet=fleet).open() as place:
        robot = place.robot("kuka1")
        robot.work_s = 3600.0
        await place.say("kuka1 wave")
        await place.say("kuka1 wave")
        assert place.acted("kuka1") == 1
        interrupt(place.clock)
        robot.finish()
        await place.quiet()
        assert place.acted("kuka1") == 1, "it waited for a night, and moved in the morning"
        assert "too late" in place.last()[1].text


@pytest.mark.parametrize("interrupt", PAUSES)
async def test_a_button_does_not_outlive_a_pause(interrupt: Callable[[ManualClock], None]) -> None:
    async with Place().open() as place:
        await place.say("robots")
        await place.tap(*place.button("omni"))
        await place.tap(*place.button("Wave"))
        button, under = place.button("Do it")
        interrupt(place.clock)
        await place.tap(button, under)
        assert place.acted() == 0
        assert place.chat.answers[-1][1] == "This button is too old. Nothing was done."


@pytest.mark.parametrize("interrupt", PAUSES)
async def test_a_lease_does_not_outlive_a_pause(interrupt: Callable[[ManualClock], None]) -> None:
    async with Place().open() as place:
        await place.say("omni wave")
        organiser = place.gateway.rooms.organiser
        assert organiser.holder("omni") is not None
        interrupt(place.clock)
        assert organiser.holder("omni") is None


async def test_a_small_step_of_the_wall_clock_ends_nothing() -> None:
    """Clocks are set right all the time, by a second when they have just been found wrong."""
    async with SlowPlace(TakesTurns()).open() as place:
        place.chat.say("omni wave")
        await _turns(4)
        place.clock.jump_wall(1.0)
        await place.quiet()
        assert place.acted() == 1


@pytest.mark.parametrize("clock_of", ["deadline_ns", "expires_ns"])
async def test_what_is_late_is_not_handed_to_the_robot(clock_of: str) -> None:
    class Recording(MemoryRobot):
        asked = 0

        async def execute(self, order: Order, tell: Tell) -> Outcome:
            self.asked += 1
            return await super().execute(order, tell)

    clock, kind = ManualClock(), FLEET[0]
    robot = Recording(kind, OrderGate.new(kind.id), clock)
    stops = StopRegistry((kind.id,), {}, not_known_yet())
    linker = Linker({kind.id: robot}, stops, MemoryLatch(), clock, clock.wall_ns, Policy(0))
    order = OrderBook(kind, clock).order("wave")
    order = replace(order, permit=replace(order.permit, epoch=linker.epoch))
    late = replace(order, **{clock_of: getattr(order, clock_of) - 6 * 10**9})
    with pytest.raises(OrderVoid, match="too late"):
        await linker.dispatch(late, lambda _report: None)
    assert robot.asked == 0


async def test_a_process_that_was_held_moves_nothing_that_is_too_old() -> None:
    process = await asyncio.create_subprocess_exec(
        sys.executable, "-m", "tests.gateway.held", stdin=PIPE, stdout=PIPE
    )
    assert process.stdin is not None
    assert process.stdout is not None
    try:
        ready = await asyncio.wait_for(process.stdout.readline(), 60 * patience())
        assert ready == b"waiting 1\n"
        process.send_signal(signal.SIGSTOP)
        await asyncio.sleep(LIVES_S + 0.5)  # what passes while it is held is what this is about
        process.stdin.write(b"\n")
        await process.stdin.drain()
        process.send_signal(signal.SIGCONT)
        said = (await asyncio.wait_for(process.stdout.readline(), 60 * patience())).decode()
        assert said.startswith("acted 1 "), said
    finally:
        if process.returncode is None:
            process.kill()
        await process.wait()
