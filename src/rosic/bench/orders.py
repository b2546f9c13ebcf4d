"""One case of the bench of the pipeline: a whole gateway in memory, and people who give it orders.

Nothing is left out but the messenger's and the robot's own work: the message is understood, its
author authenticated and admitted, the lease taken, the order claimed, relayed, acted on once at a
robot, concluded and told.
"""

from __future__ import annotations

import gc
import sys
import tempfile
from contextlib import AsyncExitStack, asynccontextmanager
from itertools import count, cycle
from pathlib import Path
from time import perf_counter, process_time
from typing import TYPE_CHECKING, NamedTuple

import msgspec

from rosic import __version__
from rosic.app import runtime
from rosic.app.gateway import Gateway, GatewaySettings
from rosic.app.people import ConfiguredPerson
from rosic.bench import sites
from rosic.bench.senders import BenchMessenger, OrderSending, RobotLane, lanes_of
from rosic.bench.sites import ACTS_AT_MOST, CLOCK, parts_of
from rosic.core.identity import Address
from rosic.core.rate_limit import RateLimit
from rosic.core.robot.profile import Busy, Link, Profile
from rosic.core.robot.skill import Parameter, Skill
from rosic.robots.memory import MemoryRobot
from rosic.stores.database import DatabaseStore
from rosic.stores.memory import MemoryStore
from rosic.stores.stop_latch import MemoryLatch
from rosic.system import SystemClock

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Iterator

    from rosic.contracts.store import StopLatch, Store

ROBOTS = 50
SLICES = 20


class OrderLoad(msgspec.Struct, frozen=True, kw_only=True):
    """How much one case of the bench asks for.

    Attributes:
        skills: Shared out among the robots.
        roles: Of the place's own, dealt out to people in turn; 0: all are operators.
        slots: In the calendar, from the next hour on: looked at for each order, in nobody's way.
    """

    name: str
    orders: int
    skills: int = 500
    people: int = 1_000
    robots: int = ROBOTS
    in_flight: int = 256
    durable: bool = False
    new_texts: bool = False
    roles: int = 0
    slots: int = 0


class OrderRun(NamedTuple):
    """What was seen of one case in one run.

    Attributes:
        times_ns: How long each order took.
        slices: How many orders ended in each turn, and in how many seconds.
    """

    times_ns: list[int]
    slices: list[tuple[int, float]]

    @property
    def rate_per_s(self) -> float:
        """Orders a second."""
        return len(self.times_ns) / sum(seconds for _, seconds in self.slices)

    @property
    def each_s(self) -> list[float]:
        """What one order cost, in each turn."""
        return [seconds / orders for orders, seconds in self.slices]


async def run(*loads: OrderLoad) -> list[OrderRun]:
    """Run a case once, or several in turns: a slow moment of the machine hits them alike.

    Raises:
        AssertionError: An order was not done, or not by one act: there is no result.
    """
    turns = SLICES if len(loads) > 1 else 1
    found = [OrderRun([], []) for _ in loads]
    async with AsyncExitStack() as stack:
        opened = [await stack.enter_async_context(_opened(load)) for load in loads]
        runtime.settle()
        stack.callback(gc.unfreeze)
        for load, (gateway, sending, lanes, _) in zip(loads, opened, strict=True):
            await sending.send(lanes, load.skills)
            for robot in _robots(gateway):
                robot.remember(ACTS_AT_MOST)
        for _ in range(turns):
            for load, (_, sending, lanes, _), ran in zip(loads, opened, found, strict=True):
                times_ns, seconds = await sending.send(lanes, load.orders // turns)
                ran.times_ns.extend(times_ns)
                ran.slices.append((len(times_ns), seconds))
        for (gateway, *_), ran in zip(opened, found, strict=True):
            distinct = sum(len(set(robot.acted)) for robot in _robots(gateway))
            if distinct != len(ran.times_ns):
                raise AssertionError(f"{len(ran.times_ns)} told done, {distinct} acted")
    return found


@asynccontextmanager
async def _opened(
    load: OrderLoad,
) -> AsyncIterator[tuple[Gateway, OrderSending, list[RobotLane], Store]]:
    with tempfile.TemporaryDirectory(prefix="rosic-bench-") as folder:
        messenger = BenchMessenger()
        store: Store = (
            DatabaseStore(Path(folder), clock=SystemClock()) if load.durable else MemoryStore()
        )
        gateway = _gateway(load, messenger, store, MemoryLatch())
        await gateway.open()
        try:
            _book(gateway, load)
            hands = load.in_flight if load.durable else 1
            sending = OrderSending(gateway.pipeline, messenger, load.people, CLOCK.wall_ns, hands)
            yield gateway, sending, _lanes(load, sending), store
        finally:
            await gateway.close()


def _book(gateway: Gateway, load: OrderLoad) -> None:
    people = [person.id for person in gateway.rooms.authoriser.directory.people()]
    size = sites.SiteSize(load.people, load.roles, load.robots, load.slots)
    calendar = gateway.rooms.organiser.calendar
    for slot in sites.slots_of(size, CLOCK.wall_ns(), people.__getitem__):
        calendar.apply(slot.fact())


def _robots(gateway: Gateway) -> Iterator[MemoryRobot]:
    for robot in gateway.robots.values():
        if isinstance(robot, MemoryRobot):
            yield robot


def _lanes(load: OrderLoad, sending: OrderSending) -> list[RobotLane]:
    """Share what is in flight out among the robots."""
    robots = min(load.robots, load.skills, load.in_flight)
    return lanes_of(load.in_flight, [_texts(robot, load) for robot in range(robots)], sending)


def _texts(robot: int, load: OrderLoad) -> Iterator[str]:
    """Return what a robot is asked for, without end."""
    skills = [f"robot{robot} skill{n}" for n in range(max(1, load.skills // load.robots))]
    if load.new_texts:
        far = (0.01 + n % 4_990 / 1_000 for n in count())
        return (f"{skill} {m:g} m forward" for skill, m in zip(cycle(skills), far, strict=False))
    return cycle([f"{skill} 0.5 m forward" for skill in skills])


def _gateway(load: OrderLoad, messenger: BenchMessenger, store: Store, latch: StopLatch) -> Gateway:
    settings = GatewaySettings(
        profiles=tuple(_profile(robot, load) for robot in range(load.robots)),
        people=tuple(
            ConfiguredPerson(f"person {n}", (Address("bench", str(n)),), (_role(n, load),))
            for n in range(load.people)
        ),
        rulebook=sites.rulebook_of(load.roles, sites.FREE),
        limit=RateLimit(burst=1e9, per_s=1e9),
        lease_idle_s=0.0,
    )
    return Gateway(settings, parts_of(store, messenger, latch=latch))


def _role(person: int, load: OrderLoad) -> str:
    return f"role{person % load.roles}" if load.roles else "operator"


def _profile(robot: int, load: OrderLoad) -> Profile:
    share = max(1, load.skills // load.robots)
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


# ---- in a process of its own ----


class OrderTurn(msgspec.Struct, frozen=True, kw_only=True, omit_defaults=True):
    """What one turn of a process came to.

    Attributes:
        times_ns: How long each message took.
        seconds: All of them.
        processor_s: What the process used of processors meanwhile.
        commits: How many groups went to the disk; 0 where there is none.
    """

    times_ns: list[int]
    seconds: float
    processor_s: float
    commits: int = 0


async def take_turns(load: OrderLoad) -> None:
    """Print a version, then what a turn came to for each line: how many orders, and in flight.

    Between two turns it blocks, on purpose: nothing of this gateway runs meanwhile.
    """
    async with _opened(load) as (_, sending, lanes, store):
        runtime.settle()
        await sending.send(lanes, load.skills)
        _print(__version__)
        kept: dict[int, list[RobotLane]] = {}  # so that a turn goes on where one ended
        for line in sys.stdin:
            orders, in_flight = map(int, line.split())
            if in_flight not in kept:
                wanted = msgspec.structs.replace(load, in_flight=in_flight)
                kept[in_flight] = _lanes(wanted, sending)
            asked = kept[in_flight]
            before, began, began_processor = _commits(store), perf_counter(), process_time()
            times_ns, _ = await sending.send(asked, orders)
            seen = OrderTurn(
                times_ns=times_ns,
                seconds=perf_counter() - began,
                processor_s=process_time() - began_processor,
                commits=_commits(store) - before,
            )
            _print(seen)


def _commits(store: Store) -> int:
    return store.commits if isinstance(store, DatabaseStore) else 0


def _print(said: object) -> None:
    sys.stdout.write(msgspec.json.encode(said).decode() + "\n")
    sys.stdout.flush()


if __name__ == "__main__":
    runtime.run(take_turns(msgspec.json.decode(sys.argv[1], type=OrderLoad)))
