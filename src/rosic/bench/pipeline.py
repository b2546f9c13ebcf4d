"""How many orders a second pass the whole way, and how long one takes.

Nothing is left out but the messenger's and the robot's own work: the message is understood, its
author authenticated and admitted, the lease taken, the order claimed, relayed, acted on once at a
robot, concluded and told.
"""

from __future__ import annotations

import gc
import tempfile
from itertools import count, cycle
from pathlib import Path
from typing import TYPE_CHECKING

import msgspec

from rosic.app import heap, loop
from rosic.app.face import face_of
from rosic.app.gateway import Gateway, Parts, Settings
from rosic.app.placing.people import Seed
from rosic.app.units import compile_units
from rosic.bench import deciding, places, weighing
from rosic.bench.lanes import TURN_MESSAGES, BenchMessenger, Lane, Sending, lanes_of
from rosic.bench.report import Case, Report, case_of, machine
from rosic.core.identity import Address
from rosic.core.rate import RateLimit
from rosic.core.robot import Busy, Link, Profile
from rosic.core.skill import Parameter, Skill
from rosic.robots.memory import MemoryRobot
from rosic.stores.database import DatabaseStore
from rosic.stores.latch import MemoryLatch
from rosic.stores.memory import MemoryStore
from rosic.system import SystemClock, SystemEntropy

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rosic.contracts.adapter import RobotFactory
    from rosic.contracts.store import Latch, Store

ROBOTS = 50
METHOD = (
    "Orders that ended done at a robot with a distinct number, each counted once its author was "
    "told. People take turns: one sends {turn} messages on each of the slots in flight at a robot, "
    "then the lease passes to the next. {robots} robots in memory, {runs} runs, median. A skill is "
    "asked for in the same words each time, once before the clock starts, and what was read before "
    "is remembered, but for the case that says otherwise. "
    "The sending side runs in the same process and thread and is part of the time. Event loop: "
    "{loop}."
)


class Load(msgspec.Struct, frozen=True, kw_only=True):
    """One case.

    Attributes:
        roles: Of the place's own, dealt out to people in turn; 0: all are operators.
        slots: In the calendar, from the next hour on: looked at for each order, in nobody's way.
    """

    name: str
    orders: int
    skills: int = 500
    people: int = 1_000
    in_flight: int = 256
    durable: bool = False
    new_texts: bool = False
    roles: int = 0
    slots: int = 0


CASES = (
    Load(name="memory, 256 in flight", orders=40_000),
    Load(name="memory, 1 in flight", orders=5_000, in_flight=1),
    Load(name="memory, 5 skills", orders=40_000, skills=5),
    Load(name="memory, 5000 skills", orders=40_000, skills=5_000),
    Load(name="memory, 10 people", orders=40_000, people=10),
    Load(name="memory, 10000 people", orders=40_000, people=10_000),
    Load(
        name="memory, 10000 people, 100 roles, 50000 slots",
        orders=40_000,
        people=10_000,
        roles=100,
        slots=50_000,
    ),
    Load(name="memory, every text new", orders=40_000, new_texts=True),
    Load(name="durable, 256 in flight", orders=20_000, durable=True),
    Load(name="durable, 1 in flight", orders=1_000, in_flight=1, durable=True),
)


def measure(*, quick: bool = False) -> Report:
    """Run every case in turns, so that a slow moment of the machine hits all alike."""
    runs = 1 if quick else 5
    seen: dict[str, list[tuple[float, list[int]]]] = {load.name: [] for load in CASES}
    for _ in range(runs):
        for load in CASES:
            if quick:
                load = msgspec.structs.replace(load, orders=max(500, load.orders // 10))  # noqa: PLW2901
            seen[load.name].append(loop.run(run(load)))
    orders: tuple[Case, ...] = tuple(case_of(name, found) for name, found in seen.items())
    method = METHOD.format(turn=TURN_MESSAGES, robots=ROBOTS, runs=runs, loop=loop.name())
    how, asked = deciding.measure(quick=quick)
    how_weighed, weighed = weighing.measure()
    return Report(
        machine=machine(), method=f"{method} {how} {how_weighed}", cases=(*orders, *asked, weighed)
    )


async def run(load: Load) -> tuple[float, list[int]]:
    """Run one case once.

    Returns:
        Orders a second, and how long each took, in ns.

    Raises:
        AssertionError: An order was not done, or not by one act: there is no result.
    """
    with tempfile.TemporaryDirectory(prefix="rosic-bench-") as folder:
        messenger = BenchMessenger()
        store: Store = (
            DatabaseStore(Path(folder), clock=SystemClock()) if load.durable else MemoryStore()
        )
        gateway = _gateway(load, messenger, store, MemoryLatch())
        await gateway.open()
        try:
            _book(gateway, load)
            heap.settle()
            sending = Sending(gateway.pipeline, messenger, load.people, CLOCK.wall_ns)
            lanes = _lanes(load)
            await sending.send(lanes, load.skills)
            for robot in _robots(gateway):
                robot.acted.clear()
            times, seconds = await sending.send(lanes, load.orders)
            distinct = sum(len(set(robot.acted)) for robot in _robots(gateway))
            if distinct != len(times):
                raise AssertionError(f"{len(times)} told done, {distinct} acted")
        finally:
            await gateway.close()
            gc.unfreeze()
    return len(times) / seconds, times


def _book(gateway: Gateway, load: Load) -> None:
    people = [person.id for person in gateway.rooms.authoriser.directory.people()]
    size = places.Size(load.people, load.roles, ROBOTS, load.slots)
    calendar = gateway.rooms.organiser.calendar
    for slot in places.slots_of(size, CLOCK.wall_ns(), people.__getitem__):
        calendar.apply(slot.fact())


def _robots(gateway: Gateway) -> Iterator[MemoryRobot]:
    for robot in gateway.robots.values():
        if isinstance(robot, MemoryRobot):
            yield robot


def _lanes(load: Load) -> list[Lane]:
    """Share what is in flight out among the robots."""
    robots = min(ROBOTS, load.skills, load.in_flight)
    return lanes_of(load.in_flight, [_texts(robot, load) for robot in range(robots)])


def _texts(robot: int, load: Load) -> Iterator[str]:
    """Return what a robot is asked for, without end."""
    skills = [f"robot{robot} skill{n}" for n in range(max(1, load.skills // ROBOTS))]
    if load.new_texts:
        far = (0.01 + n % 4_990 / 1_000 for n in count())
        return (f"{skill} {m:g} m forward" for skill, m in zip(cycle(skills), far, strict=False))
    return cycle([f"{skill} 0.5 m forward" for skill in skills])


CLOCK = SystemClock()


def _gateway(load: Load, messenger: BenchMessenger, store: Store, latch: Latch) -> Gateway:
    def factory(_kind: str) -> RobotFactory:
        return MemoryRobot

    settings = Settings(
        profiles=tuple(_profile(robot, load) for robot in range(ROBOTS)),
        people=tuple(
            Seed(f"person {n}", (Address("bench", str(n)),), (_role(n, load),))
            for n in range(load.people)
        ),
        rulebook=places.rulebook_of(load.roles, places.FREE),
        limit=RateLimit(burst=1e9, per_s=1e9),
        lease_idle_s=0.0,
    )
    parts = Parts(
        messengers=(messenger,),
        robot_factory=factory,
        store=store,
        latch=latch,
        clock=CLOCK,
        entropy=SystemEntropy(),
        units=compile_units(),
        face=face_of(),
    )
    return Gateway(settings, parts)


def _role(person: int, load: Load) -> str:
    return f"role{person % load.roles}" if load.roles else "operator"


def _profile(robot: int, load: Load) -> Profile:
    share = max(1, load.skills // ROBOTS)
    return Profile(
        id=f"robot{robot}",
        link=Link(kind="memory"),
        busy=Busy.QUEUE,
        queue_length=64,
        skills={
            f"skill{n}": Skill(
                id=f"skill{n}",
                parameters={
                    "direction": Parameter(choices={"forward": (), "back": ()}, default="forward"),
                    "distance": Parameter(unit="m", min=0.01, max=5.0),
                },
            )
            for n in range(share)
        },
    )
