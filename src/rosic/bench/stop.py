"""How soon a stop is latched and handed to the robot while 10,000 orders are queued (L2)."""

from __future__ import annotations

import asyncio
import gc
import tempfile
from pathlib import Path
from time import perf_counter_ns
from typing import TYPE_CHECKING

import msgspec

from rosic.app import runtime
from rosic.bench.busy_robots import (
    EVERYTHING,
    ROBOTS,
    WATCHER,
    WORK_S,
    OrderSenders,
    TimedLatch,
    WatchedMessenger,
    crowded_gateway,
)
from rosic.bench.report import BenchReport, case_of, machine
from rosic.stores.database import DatabaseStore
from rosic.stores.memory import MemoryStore
from rosic.stores.stop_latch import FileLatch, MemoryLatch
from rosic.system import SystemClock

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence
    from concurrent.futures import Future

    from rosic.bench.recorder import BenchRecorder
    from rosic.bench.report import BenchCase
    from rosic.contracts.store import Store
    from rosic.core.robot.profile import RobotId


TOLD_WITHIN_S = 30.0
RESUMED_WITHIN_S = 60.0
AGAIN_S = 0.01
METHOD = (
    "Stops, sent as messages while at least {queued} orders wait in the queues of {robots} "
    "robots that work {work_ms:.0f} ms on each, and whose people send another for each that "
    "ends. Times run from the moment the message is handed over: until the robot's adapter is "
    "told to stop, until the stop is kept by the latch, until its author is told of confirmed "
    "rest; the robots are in memory and rest at once, so a real one's own way to rest comes on "
    "top. 'Before it is handed over' is how long it waited for that since it came in from another "
    "thread, as from a network. One robot: {alone} stops; all robots: {together} stops, each "
    "counted at each robot. After each, resumed and filled again; no order acted in between. "
    "Rate: the orders that acted meanwhile. The sending side runs in the same process and thread "
    "and is part of the time. Event loop: {loop}."
)


class StopLoad(msgspec.Struct, frozen=True, kw_only=True):
    """How much is asked for.

    Attributes:
        alone: Stops of one robot.
        together: Stops of all robots at once.
    """

    queued: int
    alone: int
    together: int


FULL = StopLoad(queued=10_000, alone=200, together=4)
QUICK = StopLoad(queued=1_000, alone=10, together=1)


class StopFigures(msgspec.Struct):
    """What was measured of the stops of one case, in nanoseconds.

    Attributes:
        wrong: Stops that were not as they must be; each a sentence. Their times do not count.
    """

    waited: list[int] = msgspec.field(default_factory=list)
    handed: list[int] = msgspec.field(default_factory=list)
    latched: list[int] = msgspec.field(default_factory=list)
    told: list[int] = msgspec.field(default_factory=list)
    wrong: list[str] = msgspec.field(default_factory=list)


def measure(recorder: BenchRecorder) -> BenchReport:
    """Stop robots with the record in memory, then with the record and the latch on disk."""
    load = QUICK if recorder.quick else FULL
    cases: list[BenchCase] = []
    failures: list[str] = []
    for name in ("memory", "durable"):
        with recorder.turn(name):
            rate, found = runtime.run(_run(load, durable=name == "durable"))
        for which, seen in found.items():
            cases += recorder.see(_cases(f"{name}, {which}", rate, seen))
            failures += [f"{name}, {which}: {one}" for one in seen.wrong]
    method = METHOD.format(
        queued=load.queued,
        robots=ROBOTS,
        work_ms=WORK_S * 1e3,
        alone=load.alone,
        together=load.together,
        loop=runtime.name(),
    )
    return BenchReport(
        machine=machine(), method=method, cases=tuple(cases), failures=tuple(failures)
    )


def _cases(name: str, rate: float, seen: StopFigures) -> Iterator[BenchCase]:
    for what, times in (
        ("handed to the adapter", seen.handed),
        ("kept by the latch", seen.latched),
        ("rest told", seen.told),
        ("before it is handed over", seen.waited),
    ):
        if times:
            yield case_of(f"{name}: {what}", [(rate, times)])


async def _run(load: StopLoad, *, durable: bool) -> tuple[float, dict[str, StopFigures]]:
    """Return how many orders a second acted, and what was seen of the stops."""
    with tempfile.TemporaryDirectory(prefix="rosic-bench-") as folder:
        store: Store = (
            DatabaseStore(Path(folder), clock=SystemClock()) if durable else MemoryStore()
        )
        file = FileLatch(Path(folder) / "stops") if durable else None
        latch, messenger = TimedLatch(file or MemoryLatch()), WatchedMessenger()
        gateway = crowded_gateway(messenger, store, latch, load.queued)
        try:
            await gateway.open()
            runtime.settle()
            try:
                crowd = OrderSenders(gateway, messenger, load.queued)
                return await _stops(_Bench(crowd, messenger, latch, load.queued), load)
            finally:
                await gateway.close()
                gc.unfreeze()
        finally:
            if file is not None:
                await file.close()


async def _stops(bench: _Bench, load: StopLoad) -> tuple[float, dict[str, StopFigures]]:
    crowd = bench.crowd
    names = list(crowd.robots)
    alone, together = StopFigures(), StopFigures()
    crowd.open()
    try:
        await crowd.filled()
        began_ns, acted = perf_counter_ns(), crowd.acted
        for number in range(load.alone):
            name = names[number % ROBOTS]
            await bench.stop(name, [name], alone)
        for _ in range(load.together):
            await bench.stop(EVERYTHING, names, together)
        rate = (crowd.acted - acted) / ((perf_counter_ns() - began_ns) / 1e9)
    finally:
        await crowd.close()
    return rate, {"one robot": alone, "all robots": together}


class _Bench:
    """Stops robots, and looks at everybody's watches."""

    def __init__(
        self, crowd: OrderSenders, messenger: WatchedMessenger, latch: TimedLatch, queued: int
    ) -> None:
        self.crowd = crowd
        self._messenger = messenger
        self._latch = latch
        self._queued = queued

    async def stop(self, said: str, names: Sequence[RobotId], seen: StopFigures) -> None:
        """Stop robots in the middle of their work, see them at rest, then let all go on.

        Args:
            said: What to stop, as a person says it.
            names: The robots meant.
            seen: Takes what was measured, or what was not as it must be: too little was queued, a
                robot was not stopped, or an order acted after its stop.
        """
        robots = [self.crowd.robots[name] for name in names]
        await self.crowd.filled()
        told = self._messenger.expect_stop()
        came_ns, began_ns, queued = await self._come_in(f"stop {said}")
        told_ns, text = await asyncio.wait_for(told, TOLD_WITHIN_S)
        handed = [robot.handed_ns - began_ns for robot in robots]
        latched = [self._latch.kept_ns.get(name, 0) - began_ns for name in names]
        wrong = []
        if queued < self._queued:
            wrong.append(f"only {queued} orders were queued")
        if min(*handed, *latched, 0) < 0 or text.count("at rest") != len(names):
            wrong.append(f"{said} was not stopped: {text}")
        if any(len(robot.acted) != robot.acted_before for robot in robots):
            wrong.append(f"an order acted after the stop of {said}")
        seen.wrong += wrong
        if not wrong:
            seen.waited.append(began_ns - came_ns)
            seen.handed += handed
            seen.latched += latched
            seen.told += [told_ns - began_ns] * len(names)
        await self._resume(said, names)

    async def _resume(self, said: str, names: Sequence[RobotId]) -> None:
        """Ask until it is done: while the record is full of what a stop ended, it is refused."""
        async with asyncio.timeout(RESUMED_WITHIN_S):
            while any(self.crowd.robots[name].gate.latched for name in names):
                await self.crowd.say(WATCHER, WATCHER, f"resume {said}")
                await asyncio.sleep(AGAIN_S)

    async def _come_in(self, text: str) -> tuple[int, int, int]:
        """Have the watcher's words come in from another thread.

        Returns:
            When they came in, when they were handed over, and how many orders waited then.
        """
        here = asyncio.get_running_loop()

        async def taken() -> tuple[int, int]:
            queued, began_ns = self.crowd.queued, perf_counter_ns()
            await self.crowd.say(WATCHER, WATCHER, text)
            return began_ns, queued

        def come_in() -> tuple[int, Future[tuple[int, int]]]:
            came_ns = perf_counter_ns()
            return came_ns, asyncio.run_coroutine_threadsafe(taken(), here)

        came_ns, future = await asyncio.to_thread(come_in)
        began_ns, queued = await asyncio.wrap_future(future)
        return came_ns, began_ns, queued
