"""How far apart robots begin to move that were told to begin together.

Twenty robots as ROS 2 nodes in two processes of their own, and a gateway's side for each of them in
this one. Each order carries one moment to begin at. When a robot's motors are first told to move it
takes down the time itself, so what comes late to this process does not count.
"""

from __future__ import annotations

import asyncio
import os
from contextlib import AsyncExitStack
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter
from typing import TYPE_CHECKING

import msgspec
from msgspec.structs import replace

from rosic.app.profiles import load_profile, shipped_profiles
from rosic.bench.report import Case, Report, machine
from rosic.core.gate import Gate
from rosic.core.order import Ending
from rosic.pipeline.way import TOGETHER_NS
from rosic.robots.ros2.robot import Ros2Robot
from rosic.system import SystemClock
from rosic.testing.orders import OrderBook
from rosic.testing.ros2.graph import RosGraph

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rosic.core.robot import Profile
    from rosic.core.skill import Argument

ROBOTS, PROCESSES = 20, 2
ROUNDS, QUICK_ROUNDS = 50, 3
SIMULATION = "rosic.robots.ros2.simulation"
STEP_M = 0.05
THERE_WITHIN_S = 60.0
# A machine that others keep busy loses some rounds; one that loses most measures nothing.
TRIES = 2
NS = 1_000_000_000

METHOD = (
    "{robots} robots as ROS 2 nodes in {processes} processes, told {rounds} times to begin "
    "together {together:.1f} s later. Times: from the first whose motors moved to the last, as "
    "taken down at the robots; and from the agreed moment to each robot's beginning. "
    "Rate: robots started a second."
)


def measure(*, quick: bool, robots: int = ROBOTS, rounds: int = 0) -> Report:
    """Let robots begin together, again and again."""
    rounds = rounds or (QUICK_ROUNDS if quick else ROUNDS)
    with TemporaryDirectory(prefix="rosic-start-") as folder, RosGraph(Path(folder)) as graph:
        names = [f"omni{number}" for number in range(1, robots + 1)]
        file = Path(folder) / "starts"
        for first in range(PROCESSES):
            mine = names[first::PROCESSES]
            graph.start("-m", SIMULATION, "--starts", file, *mine, timeout_s=120.0)
        begun = perf_counter()
        spreads, lates = asyncio.run(_measure(file, names, rounds))
        took_s = perf_counter() - begun
    method = METHOD.format(
        robots=robots, processes=PROCESSES, together=TOGETHER_NS / NS, rounds=rounds
    )
    rate = robots * len(spreads) / took_s
    found = (("first to last", spreads), ("agreed to begun", lates))
    cases = tuple(_case(name, taken_ns, rate) for name, taken_ns in found if taken_ns)
    few = f"Only {len(spreads)} of {TRIES * rounds} rounds were seen whole."
    return Report(
        machine=machine(), method=method, cases=cases,
        failures=(few,) if len(spreads) < rounds else (),
    )  # fmt: skip


def _case(name: str, taken_ns: Sequence[int], rate: float) -> Case:
    row = sorted(taken_ns)
    return Case(
        name=name,
        rate_per_s=rate,
        p50_us=row[len(row) // 2] / 1e3,
        p99_us=row[min(len(row) - 1, int(len(row) * 0.99))] / 1e3,
    )


async def _measure(file: Path, names: Sequence[str], rounds: int) -> tuple[list[int], list[int]]:
    """Return, in nanoseconds, each round's spread, and every robot's lateness of all rounds.

    They are fewer than asked for where too many rounds were not seen whole.
    """
    clock = SystemClock()
    spreads: list[int] = []
    lates: list[int] = []
    async with AsyncExitStack() as stack:
        sides = [_Side(one_more(name), clock) for name in names]
        for side in sides:
            await side.robot.open(lambda _text: None)
            stack.push_async_callback(side.robot.close)
        async with asyncio.timeout(THERE_WITHIN_S):
            while not all(side.there for side in sides):  # noqa: ASYNC110 - tells nobody
                await asyncio.sleep(0.05)
        for number in range(1, TRIES * rounds + 1):
            if len(spreads) == rounds:
                break
            before = _size(file)
            start_ns, agreed_ns = clock.monotonic_ns() + TOGETHER_NS, clock.wall_ns() + TOGETHER_NS
            way = "forward" if number % 2 == 0 else "back"
            done = await asyncio.gather(*(side.go(way, start_ns) for side in sides))
            moments = began(file, before)
            if not all(done) or set(moments) != set(names):
                continue  # one held, as it did not hear of us for a second: a round of fewer
            spreads.append(max(moments.values()) - min(moments.values()))
            lates += [moment - agreed_ns for moment in moments.values()]
    return spreads, lates


def _size(file: Path) -> int:
    return file.stat().st_size if file.exists() else 0


def began(file: Path, since: int = 0) -> dict[str, int]:
    """Return when each robot began to move, wall clock, from so many bytes of the file on."""
    lines = file.read_bytes()[since:].decode().splitlines()
    return {robot: int(moment_ns) for robot, moment_ns in map(str.split, lines)}


class _Side:
    """The gateway's side of one robot."""

    def __init__(self, profile: Profile, clock: SystemClock) -> None:
        self.name = profile.id
        self.robot = Ros2Robot(profile, Gate(profile.id), clock)
        self._book = OrderBook(profile, clock)

    @property
    def there(self) -> bool:
        """Whether it was heard."""
        return self.robot.presence().online is True

    async def go(self, way: str, start_ns: int) -> bool:
        """Go a little, beginning when all do; tell whether it was done."""
        arguments: dict[str, Argument] = {"direction": way, "distance": STEP_M, "speed": 0.5}
        order = replace(self._book.order("move", arguments), start_ns=start_ns, cid=os.urandom(16))
        outcome = await self.robot.execute(order, lambda _report: None)
        return outcome.ending is Ending.DONE


def one_more(name: str) -> Profile:
    """Return the profile of one more omni."""
    path = shipped_profiles()["omni"]
    text = msgspec.json.encode(load_profile(path)).decode()
    described = msgspec.json.decode(
        text.replace("/omni/", f"/{name}/").replace('"/omni"', f'"/{name}"')
    )
    return msgspec.convert(described | {"id": name, "title": name}, type(load_profile(path)))
