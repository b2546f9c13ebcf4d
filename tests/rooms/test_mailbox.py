"""A robot's orders: one at a time, in order, bounded, by the profile's busy policy."""

from __future__ import annotations

import asyncio

import pytest
from msgspec.structs import replace

from rosic.core.gate import Gate
from rosic.core.order import Order, Report, Stage, Stop
from rosic.core.robot import Busy, Link, Profile
from rosic.core.skill import Skill
from rosic.core.stopboard import StopBoard
from rosic.errors import OrderVoid, RobotBusy
from rosic.linker.linker import Linker, PolicyMoved
from rosic.linker.mailbox import Mailbox
from rosic.robots.memory import MemoryRobot
from rosic.stores.latch import MemoryLatch
from rosic.testing.clock import ManualClock, settle
from rosic.testing.orders import OrderBook


def ignore(_report: Report) -> None:
    """The reports do not matter here."""


class Bench:
    """A mailbox, its robot and orders for it."""

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
        self.robot = MemoryRobot(self.profile, Gate("r"), self.clock)
        self.mailbox = Mailbox(self.robot, self.clock)
        self.book = OrderBook(self.profile, self.clock)

    def order(self) -> Order:
        return self.book.order("go")


async def test_a_busy_robot_refuses_and_says_what_it_does() -> None:
    bench = Bench(Busy.REFUSE)
    await bench.mailbox.turn(bench.order(), ignore)
    with pytest.raises(RobotBusy, match="Robot R is busy: go"):
        await bench.mailbox.turn(bench.order(), ignore)


async def test_a_queue_keeps_the_order_and_says_so() -> None:
    bench, passed, said = Bench(Busy.QUEUE), list[int](), list[Stage]()
    await bench.mailbox.turn(bench.order(), ignore)

    async def wait(order: Order) -> None:
        await bench.mailbox.turn(order, lambda report: said.append(report.stage))
        passed.append(order.n)
        bench.mailbox.leave()

    tasks = [asyncio.create_task(wait(bench.order())) for _ in range(2)]
    await settle()
    assert said == [Stage.QUEUED, Stage.QUEUED]
    bench.mailbox.leave()
    await asyncio.gather(*tasks)
    assert passed == [2, 3]


async def test_a_full_queue_refuses() -> None:
    bench = Bench(Busy.QUEUE, queue_length=1)
    await bench.mailbox.turn(bench.order(), ignore)
    waiting = asyncio.create_task(bench.mailbox.turn(bench.order(), ignore))
    await settle()
    with pytest.raises(RobotBusy, match="1 commands waiting"):
        await bench.mailbox.turn(bench.order(), ignore)
    waiting.cancel()


async def test_a_later_line_of_the_same_message_waits_whatever_the_policy() -> None:
    bench = Bench(Busy.REFUSE)
    await bench.mailbox.turn(bench.order(), ignore)
    waiting = asyncio.create_task(bench.mailbox.turn(replace(bench.order(), sequel=True), ignore))
    await settle()
    bench.mailbox.leave()
    await asyncio.wait_for(waiting, 1)


async def test_what_waits_too_long_is_told_when_it_happens() -> None:
    bench = Bench(Busy.QUEUE)
    await bench.mailbox.turn(bench.order(), ignore)
    waiting = asyncio.create_task(bench.mailbox.turn(bench.order(), ignore))
    await bench.clock.advance(4.9)
    assert not waiting.done()
    await bench.clock.advance(0.2)
    with pytest.raises(OrderVoid, match="Robot R was busy for too long"):
        await waiting


async def test_a_stop_voids_what_waits() -> None:
    bench = Bench(Busy.QUEUE)
    await bench.mailbox.turn(bench.order(), ignore)
    waiting = asyncio.create_task(bench.mailbox.turn(bench.order(), ignore))
    await settle()
    bench.mailbox.clear()
    with pytest.raises(OrderVoid, match="Robot R was stopped"):
        await waiting


async def test_a_waiting_order_that_is_cancelled_gives_its_turn_on() -> None:
    bench = Bench(Busy.QUEUE)
    await bench.mailbox.turn(bench.order(), ignore)
    first = asyncio.create_task(bench.mailbox.turn(bench.order(), ignore))
    second = asyncio.create_task(bench.mailbox.turn(bench.order(), ignore))
    await settle()
    bench.mailbox.leave()
    first.cancel()
    await asyncio.wait_for(second, 1)


class LinkerBench(Bench):
    """A linker with one robot."""

    def __init__(self, busy: Busy) -> None:
        super().__init__(busy)
        self.board = StopBoard(["r"], {})
        self.latch = MemoryLatch()
        self.linker = Linker({"r": self.robot}, self.board, self.latch, self.clock)
        self.linker.epoch = 1


async def test_an_order_admitted_under_another_policy_is_not_relayed() -> None:
    bench = LinkerBench(Busy.REFUSE)
    bench.linker.epoch = 2
    with pytest.raises(PolicyMoved):
        await bench.linker.dispatch(bench.order(), ignore)
    assert not bench.robot.acted


async def test_a_replacing_order_ends_the_one_under_way() -> None:
    bench = LinkerBench(Busy.REPLACE)
    bench.robot.work_s = 60.0

    async def live(order: Order) -> None:
        await bench.linker.turn(order, ignore)
        try:
            await bench.linker.dispatch(order, ignore)
        finally:
            bench.linker.leave(order)

    first = asyncio.create_task(live(bench.order()))
    await settle()
    second = asyncio.create_task(live(bench.order()))
    await settle()
    assert first.done()
    assert bench.robot.acted[-1] == 2
    await bench.robot.stop(Stop("r", 1))
    await asyncio.wait_for(second, 1)


async def test_a_stop_is_handed_over_before_it_is_written() -> None:
    bench = LinkerBench(Busy.QUEUE)
    bench.robot.work_s = 60.0
    running = asyncio.create_task(bench.linker.dispatch(bench.order(), ignore))
    await settle()
    halting = bench.linker.stop(["r"], "p")
    assert bench.robot.gate.latched
    assert bench.board["r"].latched
    assert (await asyncio.wait_for(halting.rests["r"], 1)).confirmed
    assert await asyncio.wait_for(halting.latched, 1)
    assert bench.latch.read() == {"r": (1, True)}
    await asyncio.wait_for(running, 1)


async def test_a_resume_of_an_older_stop_changes_nothing() -> None:
    bench = LinkerBench(Busy.QUEUE)
    bench.linker.stop(["r"], "p")
    bench.linker.stop(["r"], "p")
    await bench.linker.resume("r", 1)
    assert bench.board["r"].latched
    await bench.linker.resume("r", 2)
    assert not bench.board["r"].latched
    await settle()
    assert bench.latch.read() == {"r": (2, False)}
