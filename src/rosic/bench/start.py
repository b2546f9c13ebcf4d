"""How far apart robots begin to move that were told to begin together.

Robots as ROS 2 nodes in two processes of their own, and a gateway's side for each of them in
this one. Each order carries one moment to begin at. When a robot's motors are first told to move it
takes down the time itself, so what comes late to this process does not count.
"""

from __future__ import annotations

import asyncio
import os
import sys
from concurrent.futures import ThreadPoolExecutor
from contextlib import AsyncExitStack, asynccontextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter
from typing import TYPE_CHECKING, NamedTuple, cast

import msgspec
from msgspec.structs import replace

from rosic.bench.report import BenchCase, BenchReport, machine, quantile
from rosic.config.profiles import load_profile, shipped_profiles
from rosic.core.order import OrderEnding
from rosic.core.order_gate import OrderGate
from rosic.core.synchronised_start import TOGETHER_NS, TOO_LATE_NS, misses_start
from rosic.core.time_units import SECOND_NS
from rosic.errors import OrderVoid
from rosic.robots.ros2.client.executor_thread import ahead_ns
from rosic.robots.ros2.robot import Ros2Robot
from rosic.system import SystemClock
from rosic.testing.factories import OrderBook
from rosic.testing.ros2.graph import RosGraph
from rosic_sim.ros2.waiting_clock import RealtimePriority

if TYPE_CHECKING:
    from asyncio.subprocess import Process
    from collections.abc import AsyncIterator, Iterator, Sequence

    from rosic.bench.recorder import BenchRecorder
    from rosic.core.robot.profile import Profile
    from rosic.core.robot.skill import Argument


ROBOTS, QUICK_ROBOTS, PROCESSES = 20, 4, 2
ROUNDS, QUICK_ROUNDS = 50, 3
SIMULATION = "rosic_sim.ros2.simulation"
STEP_M = 0.05
THERE_WITHIN_S = 60.0
# A machine that others keep busy loses some rounds; one that loses most measures nothing.
TRIES = 2

# Later than this a plain process shows that the machine itself was late.
PROMISED_NS = 20_000_000

METHOD = (
    "{robots} robots as ROS 2 nodes in {processes} processes, told {rounds} times to begin "
    "together {together:.1f} s later. Times: from the first whose motors moved to the last, as "
    "taken down at the robots; and from the agreed moment to each robot's beginning. "
    "Rate: robots started a second. Beside them {processes} plain processes that do nothing but "
    "sleep until the same moments. Punctual: the robots' processes ask for real-time priority just "
    "before, as controllers of robots do; granted here: {granted}."
)
FIRST = (
    "{name}: the first start, while links were still opening, {first_ms:.1f} ms apart; not counted."
)
FEW = "{name}: only {seen} of {tried} starts were seen whole."
WITHIN = (
    "{name}: {robots} of {rounds} starts within {promised_ms:.0f} ms; the plain processes woke "
    "within it {sleepers} times, and when they did the robots began within it {both} times."
)


class StartRound(NamedTuple):
    """One common start.

    Attributes:
        robots_ns, sleepers_ns: How long after the agreed moment each robot began, and each plain
            process woke up.
    """

    robots_ns: Sequence[int]
    sleepers_ns: Sequence[int]


def spread_ns(moments_ns: Sequence[int]) -> int:
    """Return how long from the first to the last."""
    return max(moments_ns) - min(moments_ns)


def measure(recorder: BenchRecorder, *, robots: int = 0, rounds: int = 0) -> BenchReport:
    """Let robots begin together, again and again."""
    robots = robots or (QUICK_ROBOTS if recorder.quick else ROBOTS)
    rounds = rounds or (QUICK_ROUNDS if recorder.quick else ROUNDS)
    granted = _granted()
    cases: list[BenchCase] = []
    findings: list[str] = []
    failures: list[str] = []
    for name, options in (("ordinary", ()), ("punctual", ("--punctual",))):
        if options and not granted:
            continue
        begun = perf_counter()
        with recorder.turn(name):
            seen = _seen(robots, rounds + 1, options)
        rate = robots * len(seen) / (perf_counter() - begun)
        if len(seen) <= rounds:
            failures.append(FEW.format(name=name, seen=len(seen), tried=TRIES * (rounds + 1)))
        if seen:
            first_ms = spread_ns(seen[0].robots_ns) / 1e6
            findings.append(FIRST.format(name=name, first_ms=first_ms))
        if counted := seen[1:]:
            cases += recorder.see(_cases(name, counted, rate))
            findings.append(_within(name, counted))
    method = METHOD.format(
        robots=robots,
        processes=PROCESSES,
        together=TOGETHER_NS / SECOND_NS,
        rounds=rounds,
        granted="yes" if granted else "no",
    )
    return BenchReport(
        machine=machine(),
        method=method,
        cases=tuple(cases),
        findings=tuple(findings),
        failures=tuple(failures),
    )


def _granted() -> bool:
    """Tell whether this machine grants real-time priority, to a thread that ends at once."""

    def ask() -> bool:
        urgency = RealtimePriority(wanted=True)
        urgency.be(True)
        return urgency.wanted

    with ThreadPoolExecutor(1) as pool:
        return pool.submit(ask).result()


def _seen(robots: int, rounds: int, options: Sequence[str]) -> list[StartRound]:
    """Return so many common starts of so many robots."""
    with TemporaryDirectory(prefix="rosic-start-") as folder, RosGraph(Path(folder)) as graph:
        names = [f"omni{number}" for number in range(1, robots + 1)]
        file = Path(folder) / "starts"
        for first in range(PROCESSES):
            mine = names[first::PROCESSES]
            graph.start(
                *("-m", SIMULATION, "--starts", str(file), *options, *mine),
                timeout_s=120.0,
                ends_with_input=False,
            )
        return asyncio.run(_measure(file, names, rounds))


def _cases(name: str, seen: Sequence[StartRound], rate: float) -> Iterator[BenchCase]:
    """Yield what robots and plain processes made of the same moments."""
    for who, rows in (
        ("robots", [one.robots_ns for one in seen]),
        ("plain processes", [one.sleepers_ns for one in seen]),
    ):
        yield _case(f"{name}: {who}, first to last", [spread_ns(row) for row in rows], rate)
        yield _case(f"{name}: {who}, agreed to begun", [ns for row in rows for ns in row], rate)


def _within(name: str, seen: Sequence[StartRound]) -> str:
    """Return in a sentence how often all was as promised, and how often the machine let it be."""
    robots = {at for at, one in enumerate(seen) if spread_ns(one.robots_ns) < PROMISED_NS}
    sleepers = {at for at, one in enumerate(seen) if max(one.sleepers_ns) < PROMISED_NS}
    return WITHIN.format(
        name=name,
        robots=len(robots),
        rounds=len(seen),
        promised_ms=PROMISED_NS / 1e6,
        sleepers=len(sleepers),
        both=len(robots & sleepers),
    )


def _case(name: str, taken_ns: Sequence[int], rate: float) -> BenchCase:
    return BenchCase(
        name=name,
        rate_per_s=rate,
        p50_us=quantile(taken_ns, 0.5) / 1e3,
        p99_us=quantile(taken_ns, 0.99) / 1e3,
    )


async def _measure(file: Path, names: Sequence[str], rounds: int) -> list[StartRound]:
    """Return so many rounds that were seen whole; fewer where too many were not."""
    clock = SystemClock()
    seen: list[StartRound] = []
    async with AsyncExitStack() as stack:
        sleepers = [await stack.enter_async_context(sleeping()) for _ in range(PROCESSES)]
        sides = [_Side(one_more(name), clock) for name in names]
        for side in sides:
            await side.robot.open(lambda _text: None)
            stack.push_async_callback(side.robot.close)
        async with asyncio.timeout(THERE_WITHIN_S):
            while not all(side.there for side in sides):  # noqa: ASYNC110 - tells nobody
                await asyncio.sleep(0.05)
        for number in range(1, TRIES * rounds + 1):
            if len(seen) == rounds:
                break
            before = _size(file)
            start_ns = clock.monotonic_ns() + TOGETHER_NS
            agreed_ns = start_ns + ahead_ns(clock.wall_ns, clock.monotonic_ns)
            way = "forward" if number % 2 == 0 else "back"
            waking = asyncio.gather(*(sleeper.sleep(start_ns) for sleeper in sleepers))
            done = await asyncio.gather(*(side.go(way, start_ns) for side in sides))
            woke = await waking
            moments = began(file, before)
            if any(side.late for side in sides):  # no start together: it counts as one so far apart
                seen.append(StartRound([0, TOO_LATE_NS], [woke_ns - start_ns for woke_ns in woke]))
                continue
            if not all(done) or set(moments) != set(names):
                continue  # one held, as it did not hear of us for a second: a round of fewer
            robots = [moment_ns - agreed_ns for moment_ns in moments.values()]
            seen.append(StartRound(robots, [woke_ns - start_ns for woke_ns in woke]))
    return seen


class _Sleeper:
    """A plain process that sleeps until a moment."""

    def __init__(self, process: Process) -> None:
        self._to = cast("asyncio.StreamWriter", process.stdin)  # both are pipes
        self._from = cast("asyncio.StreamReader", process.stdout)

    async def sleep(self, until_ns: int) -> int:
        """Let it sleep until then; return when it woke up."""
        self._to.write(b"%d\n" % until_ns)
        return int(await self._from.readline())


@asynccontextmanager
async def sleeping() -> AsyncIterator[_Sleeper]:
    """Run a plain process while inside."""
    process = await asyncio.create_subprocess_exec(
        sys.executable,
        "-m",
        "rosic.bench.timer_baseline",
        stdin=asyncio.subprocess.PIPE,
        stdout=asyncio.subprocess.PIPE,
    )
    try:
        yield _Sleeper(process)
    finally:
        process.kill()
        await process.wait()


def _size(file: Path) -> int:
    return file.stat().st_size if file.exists() else 0


def began(file: Path, since: int = 0) -> dict[str, int]:
    """Return when each robot began to move, wall clock, from so many bytes of the file on."""
    lines = file.read_bytes()[since:].decode().splitlines()
    return {robot: int(moment_ns) for robot, moment_ns in map(str.split, lines)}


class _Side:
    """The gateway's side of one robot.

    Attributes:
        late: It was told to go too late to begin with the others.
    """

    def __init__(self, profile: Profile, clock: SystemClock) -> None:
        self.name = profile.id
        self.late = False
        self.robot = Ros2Robot(profile, OrderGate.new(profile.id), clock)
        self._book = OrderBook(profile, clock)
        self._clock = clock

    @property
    def there(self) -> bool:
        """Whether it was heard."""
        return self.robot.presence().online is True

    async def go(self, way: str, start_ns: int) -> bool:
        """Go a little, beginning when all do; tell whether it was done."""
        arguments: dict[str, Argument] = {"direction": way, "distance": STEP_M, "speed": 0.5}
        order = replace(self._book.order("move", arguments), start_ns=start_ns, cid=os.urandom(16))
        self.late = False
        try:
            outcome = await self.robot.execute(order, lambda _report: None)
        except OrderVoid:
            self.late = misses_start(order, self._clock.monotonic_ns(), self._clock.wall_ns())
            return False
        return outcome.ending is OrderEnding.DONE


def one_more(name: str) -> Profile:
    """Return the profile of one more omni."""
    path = shipped_profiles()["omni"]
    text = msgspec.json.encode(load_profile(path)).decode()
    described = msgspec.json.decode(
        text.replace("/omni/", f"/{name}/").replace('"/omni"', f'"/{name}"')
    )
    return msgspec.convert(described | {"id": name, "title": name}, type(load_profile(path)))
