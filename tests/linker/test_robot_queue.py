"""A robot's orders: one at a time, in order, bounded, by the profile's busy policy."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

import pytest
from msgspec.structs import replace

from rosic.core.order import Order, OrderEnding, OrderStage, Outcome, StageReport
from rosic.core.order_gate import OrderGate
from rosic.core.robot.profile import Busy, Link, Profile
from rosic.core.robot.skill import Skill
from rosic.core.stop_registry import StopRegistry, not_known_yet
from rosic.errors import OrderVoid, RobotBusy
from rosic.linker.linker import Linker, PolicyMoved
from rosic.linker.robot_queue import RobotQueue
from rosic.robots.memory import MemoryRobot
from rosic.stores.stop_latch import MemoryLatch
from rosic.testing.clock import ManualClock, settle
from rosic.testing.factories import OrderBook
from tests.linker.policy import Policy
from tests.pace import pace

if TYPE_CHECKING:
    from rosic.contracts.robot import Tell


GO = Skill(id="go")
LAND = Skill(id="land", to_safety=True)


def ignore(_report: StageReport) -> None:
    """The reports do not matter here."""


class Entry:
    """An order, and what it was told."""

    def __init__(self, order: Order) -> None:
        self.order = order
        self.said: list[OrderStage] = []
        self.voided = ""

    def tell(self, report: StageReport) -> None:
        self.said.append(report.stage)

    def void(self, refusal: OrderVoid) -> None:
        self.voided = str(refusal)


class Bench:
    """A queue, its robot and orders for it."""

    def __init__(self, busy: Busy, queue_length: int = 2) -> None:
        self.clock = ManualClock()
        self.profile = Profile(
            id="r",
            title="Robot R",
            link=Link(kind="memory"),
            busy=busy,
            queue_length=queue_length,
            skills={"go": Skill(id="go")},
        )
        self.robot = MemoryRobot(self.profile, OrderGate.new("r"), self.clock)
        self.queue = RobotQueue(self.robot, self.clock)
        self.book = OrderBook(self.profile, self.clock)

    def entry(self) -> Entry:
        return Entry(self.book.order("go"))

    def busy(self) -> Entry:
        """Give the robot something to do."""
        first = self.entry()
        assert self.queue.put(first)
        return first


def test_a_busy_robot_refuses_and_says_what_it_does() -> None:
    bench = Bench(Busy.REFUSE)
    bench.busy()
    with pytest.raises(RobotBusy, match="Robot R is busy: go"):
        bench.queue.put(bench.entry())


async def test_a_queue_keeps_the_order_and_says_so() -> None:
    bench = Bench(Busy.QUEUE)
    first = bench.busy()
    waiting = [bench.entry(), bench.entry()]
    assert [bench.queue.put(entry) for entry in waiting] == [False, False]
    assert [entry.said for entry in (first, *waiting)] == [
        [],
        [OrderStage.QUEUED],
        [OrderStage.QUEUED],
    ]
    assert [bench.queue.next() for _ in range(3)] == [*waiting, None]
    assert bench.queue.put(bench.entry()), "a robot that is done is free"


async def test_a_full_queue_refuses() -> None:
    bench = Bench(Busy.QUEUE, queue_length=1)
    bench.busy()
    bench.queue.put(bench.entry())
    with pytest.raises(RobotBusy, match="1 commands waiting"):
        bench.queue.put(bench.entry())


async def test_a_later_line_of_the_same_message_waits_whatever_the_policy() -> None:
    bench = Bench(Busy.REFUSE)
    bench.busy()
    later = bench.entry()
    later.order = replace(later.order, sequel=True)
    bench.queue.put(later)
    assert bench.queue.next() is later


async def test_what_waits_too_long_is_told_when_it_happens() -> None:
    bench = Bench(Busy.QUEUE)
    bench.busy()
    waiting = bench.entry()
    bench.queue.put(waiting)
    await bench.clock.advance(4.9)
    early = waiting.voided
    await bench.clock.advance(0.2)
    late = waiting.voided
    assert (early, late) == ("", "Robot R was busy for too long. This was not done.")
    assert bench.queue.next() is None


async def test_an_order_is_good_until_its_last_moment_and_every_later_one_is_watched_too() -> None:
    bench = Bench(Busy.QUEUE)
    bench.busy()
    for _ in range(3):
        waiting = bench.entry()
        bench.queue.put(waiting)
        left_s = (waiting.order.deadline_ns - bench.clock.monotonic_ns()) / 1e9
        await bench.clock.advance(left_s)
        assert waiting.voided == "", "this is the moment until which it is good"
        await bench.clock.advance(0.02)
        assert waiting.voided
        assert len(bench.queue) == 0


def watches() -> int:
    return sum(
        getattr(task.get_coro(), "__qualname__", "") == "RobotQueue._expire"
        for task in asyncio.all_tasks()
    )


class Patient(ManualClock):
    """Counts how often somebody goes to sleep."""

    sleeps = 0

    async def sleep(self, seconds: float) -> None:
        self.sleeps += 1
        await super().sleep(seconds)


async def test_who_watches_what_waits_is_one_and_is_woken_for_a_reason_only() -> None:
    bench = Bench(Busy.QUEUE, queue_length=10)
    bench.clock = clock = Patient()
    bench.queue = RobotQueue(bench.robot, clock)
    bench.busy()
    now_ns, wall_ns = clock.monotonic_ns(), clock.wall_ns()
    waiting = [bench.entry() for _ in range(5)]
    for number, entry in enumerate(waiting):
        lasts_ns = (5 - number) * 100_000_000_000
        entry.order = replace(
            entry.order, deadline_ns=now_ns + lasts_ns, expires_ns=wall_ns + lasts_ns
        )
        bench.queue.put(entry)
    await settle()
    assert watches() == 1
    await clock.advance(100.02)
    assert [bool(entry.voided) for entry in waiting] == [False, False, False, False, True]
    before = clock.sleeps
    await clock.advance(99.0)
    assert clock.sleeps == before, "the next order is good for another second"
    await clock.advance(400.0)
    assert all(entry.voided for entry in waiting)
    assert watches() == 0


def test_only_a_robot_that_refuses_and_is_at_work_is_not_free() -> None:
    free = Bench(Busy.REFUSE)
    free.queue.check_free()
    queues = Bench(Busy.QUEUE)
    queues.busy()
    queues.queue.check_free()
    refuses = Bench(Busy.REFUSE)
    refuses.busy()
    with pytest.raises(RobotBusy):
        refuses.queue.check_free()


async def test_what_is_under_way_is_replaced_once() -> None:
    bench = Bench(Busy.REPLACE)
    assert not bench.queue.replace()
    bench.robot.work_s = 60.0
    relayed = asyncio.create_task(bench.queue.relay(bench.entry().order, ignore))
    await settle()
    running = bench.queue.running
    assert running is not None
    assert bench.queue.replace()
    assert not bench.queue.replace(), "its coming to rest is not cut short"
    await asyncio.wait((running, relayed))
    assert running.cancelled()


async def test_a_stop_voids_what_waits_and_nothing_that_came_later() -> None:
    bench = Bench(Busy.QUEUE)
    bench.busy()
    before, later = bench.entry(), bench.entry()
    later.order = replace(later.order, permit=replace(later.order.permit, stop_generation=1))
    bench.queue.put(before)
    bench.queue.put(later)
    bench.queue.clear(1)
    assert (before.voided, later.voided) == ("Robot R was stopped before this could begin.", "")
    assert bench.queue.next() is later


async def test_of_orders_that_replace_each_other_only_the_newest_waits() -> None:
    bench = Bench(Busy.REPLACE)
    bench.busy()
    second, third = bench.entry(), bench.entry()
    bench.queue.put(second)
    bench.queue.put(third)
    assert second.voided == "A later command took its place. This was not done."
    assert bench.queue.next() is third


@pytest.mark.parametrize("busy", list(Busy))
async def test_what_brings_to_safety_takes_the_place_of_all_that_waits_however_much_that_is(
    busy: Busy,
) -> None:
    """A drone may always land."""
    bench = Bench(busy, queue_length=1)
    bench.busy()
    waiting = bench.entry()
    waiting.order = replace(waiting.order, sequel=True)
    bench.queue.put(waiting)
    lands = bench.entry()
    lands.order = replace(lands.order, skill=replace(lands.order.skill, to_safety=True))
    assert not bench.queue.put(lands)
    assert waiting.voided == "A later command took its place. This was not done."
    assert bench.queue.next() is lands
    assert bench.queue.next() is None


async def test_however_few_may_wait_the_newest_takes_the_place_of_the_one_before() -> None:
    bench = Bench(Busy.REPLACE, queue_length=1)
    bench.busy()
    entries = [bench.entry() for _ in range(3)]
    for entry in entries:
        bench.queue.put(entry)
    assert bench.queue.next() is entries[-1]


def of(bench: Bench, principal: str) -> Entry:
    """Return an order that somebody gave."""
    order = bench.book.order("go")
    return Entry(replace(order, permit=replace(order.permit, principal=principal)))


async def test_what_one_person_has_waiting_is_taken_out_and_nobody_elses() -> None:
    bench = Bench(Busy.QUEUE, queue_length=3)
    bench.busy()
    first, others, last = of(bench, "p1"), of(bench, "p2"), of(bench, "p1")
    for entry in (first, others, last):
        assert not bench.queue.put(entry)
    assert bench.queue.take_out("nobody") == []
    assert bench.queue.take_out("p1") == [first, last]
    assert bench.queue.take_out("p1") == []
    assert [entry.voided for entry in (first, others, last)] == [""] * 3
    assert bench.queue.next() is others
    assert bench.queue.next() is None


class LinkerBench(Bench):
    """A linker with one robot."""

    def __init__(self, busy: Busy) -> None:
        super().__init__(busy)
        self.stops = StopRegistry(["r"], {}, not_known_yet())
        self.latch, self.policy = MemoryLatch(), Policy(1)
        self.linker = Linker(
            {"r": self.robot}, self.stops, self.latch, self.clock, self.clock.wall_ns, self.policy
        )

    def order(self) -> Order:
        return self.book.order("go")


async def test_an_order_admitted_under_another_policy_is_not_relayed() -> None:
    bench = LinkerBench(Busy.REFUSE)
    bench.policy.epoch = 2
    with pytest.raises(PolicyMoved):
        await bench.linker.dispatch(bench.order(), ignore)
    assert not bench.robot.acted


async def test_a_replacing_order_ends_the_one_under_way() -> None:
    bench = LinkerBench(Busy.REPLACE)
    bench.robot.work_s = 60.0
    first, second = bench.entry(), bench.entry()
    assert bench.linker.put(first)
    running = asyncio.create_task(bench.linker.dispatch(first.order, ignore))
    await settle()
    assert not bench.linker.put(second)
    outcome = await asyncio.wait_for(running, 60 * pace())
    assert (outcome.ending, outcome.note) == (
        OrderEnding.CANCELLED,
        "a later command took its place",
    )
    assert bench.linker.next("r") is second


@pytest.mark.parametrize("busy", list(Busy))
async def test_what_is_replaced_before_it_was_relayed_never_begins(busy: Busy) -> None:
    """Both come in one turn of the event loop: the second finds nothing that it could cancel."""
    bench = LinkerBench(Busy.REPLACE)
    bench.profile = replace(bench.profile, busy=busy, skills={"go": GO, "land": LAND})
    bench.robot.profile = bench.profile
    bench.linker = Linker(
        {"r": bench.robot}, bench.stops, bench.latch, bench.clock, bench.clock.wall_ns, bench.policy
    )
    first, lands, after = bench.entry(), bench.entry(), bench.entry()
    lands.order = replace(lands.order, skill=LAND)
    assert bench.linker.put(first)
    assert not bench.linker.put(lands)
    with pytest.raises(OrderVoid, match="A later command took its place"):
        await bench.linker.dispatch(first.order, ignore)
    assert not bench.robot.acted
    assert bench.linker.next("r") is lands
    outcome = await asyncio.wait_for(bench.linker.dispatch(lands.order, ignore), 60 * pace())
    assert outcome.ending is OrderEnding.DONE
    assert list(bench.robot.acted) == [lands.order.n]
    assert bench.linker.next("r") is None
    assert bench.linker.put(after), "nothing gives way to an order that is over"
    outcome = await asyncio.wait_for(bench.linker.dispatch(after.order, ignore), 60 * pace())
    assert outcome.ending is OrderEnding.DONE


async def test_a_replaceable_order_that_nothing_replaces_ends_as_any_other() -> None:
    bench = LinkerBench(Busy.REPLACE)
    first = bench.entry()
    assert bench.linker.put(first)
    outcome = await asyncio.wait_for(bench.linker.dispatch(first.order, ignore), 60 * pace())
    assert outcome.ending is OrderEnding.DONE


class ComesToRestSlowly(MemoryRobot):
    """Counts how often its coming to rest was cut short."""

    cut_short = 0

    async def execute(self, order: Order, tell: Tell) -> Outcome:
        del order, tell
        try:
            await asyncio.Event().wait()
        except asyncio.CancelledError:
            try:
                await self._clock.sleep(1.0)
            except asyncio.CancelledError:
                self.cut_short += 1
            raise
        raise AssertionError("nothing ever happens")


async def test_what_was_replaced_comes_to_rest_though_the_gateway_closes() -> None:
    bench = LinkerBench(Busy.REPLACE)
    robot = ComesToRestSlowly(bench.profile, OrderGate.new("r"), bench.clock)
    linker = Linker(
        {"r": robot}, bench.stops, bench.latch, bench.clock, bench.clock.wall_ns, Policy(1)
    )
    first = bench.entry()
    linker.put(first)
    running = asyncio.create_task(linker.dispatch(first.order, ignore))
    await settle()
    linker.put(bench.entry())
    await settle()
    running.cancel()
    await settle()
    assert not running.done(), "it is not at rest yet"
    await bench.clock.advance(1.0)
    with pytest.raises(asyncio.CancelledError):
        await asyncio.wait_for(running, 60 * pace())
    assert robot.cut_short == 0


async def test_a_stop_is_handed_over_before_it_is_written() -> None:
    bench = LinkerBench(Busy.QUEUE)
    bench.robot.work_s = 60.0
    running = asyncio.create_task(bench.linker.dispatch(bench.order(), ignore))
    await settle()
    halting = bench.linker.stop(["r"], "p")
    assert bench.robot.gate.latched
    assert bench.stops["r"].latched
    assert (await asyncio.wait_for(halting.rests["r"], 60 * pace())).confirmed
    assert await asyncio.wait_for(halting.latched, 60 * pace())
    assert bench.latch.read() == {"r": (1, True)}
    await asyncio.wait_for(running, 60 * pace())


async def test_a_resume_of_an_older_stop_changes_nothing() -> None:
    bench = LinkerBench(Busy.QUEUE)
    bench.linker.stop(["r"], "p")
    bench.linker.stop(["r"], "p")
    await bench.linker.resume("r", 1)
    assert bench.stops["r"].latched
    await bench.linker.resume("r", 2)
    assert not bench.stops["r"].latched
    await settle()
    assert bench.latch.read() == {"r": (2, False)}


async def test_whether_a_robot_would_begin_at_once_can_be_asked_of_the_linker() -> None:
    bench = LinkerBench(Busy.REFUSE)
    bench.linker.check_free("r")
    bench.linker.put(bench.entry())
    with pytest.raises(RobotBusy):
        bench.linker.check_free("r")


async def test_one_that_nobody_steers_is_void_where_orders_replace_one_another() -> None:
    bench = Bench(Busy.REPLACE)
    live = replace(bench.entry().order, live=True)
    with pytest.raises(OrderVoid, match="cannot be driven live over its link"):
        await bench.queue.relay(live, ignore)
