"""Fifty robots that never run out of work: every queue is kept full."""

from __future__ import annotations

import asyncio
from itertools import count, cycle
from time import perf_counter_ns
from typing import TYPE_CHECKING

from rosic.app.gateway import Gateway, GatewaySettings
from rosic.app.people import ConfiguredPerson
from rosic.bench.senders import BenchMessenger
from rosic.bench.sites import ACTS_AT_MOST, CLOCK, parts_of
from rosic.core.identity import Address
from rosic.core.message import Chat, Inbound
from rosic.core.rate_limit import RateLimit
from rosic.core.robot.profile import Busy, Link, Profile
from rosic.core.robot.skill import Parameter, Skill
from rosic.core.time_units import HOUR_S
from rosic.robots.memory import MemoryRobot

if TYPE_CHECKING:
    from rosic.contracts.clock import Clock
    from rosic.contracts.messenger import Messenger
    from rosic.contracts.robot import Tell
    from rosic.contracts.store import StopLatch, Store
    from rosic.core.message import Outbound
    from rosic.core.order import Order, Outcome, RestReport, Stop
    from rosic.core.order_gate import OrderGate
    from rosic.core.robot.profile import RobotId

ROBOTS = 50
EVERYTHING = "fleet"
WORK_S = 0.05
# A queue is kept a little fuller than is asked for: one order is always just being taken out.
SPARE = 10
CHATS = 16
LIVES_S = float(HOUR_S)
FILLED_WITHIN_S = 30.0
LOOK_S = 0.002
REFUSED_S = 0.1
"""Fifty who ask again at once leave no time to write down what a stop of everything has ended."""
WATCHER = "watcher"


class BusyRobot(MemoryRobot):
    """Works on each order for a moment, and notes when it was told to stop.

    Attributes:
        handed_ns: When ``stop`` was last called, on the clock of ``perf_counter_ns``.
        acted_before: How many orders had acted then.
        hungry: Set whenever an order ends.
    """

    def __init__(self, profile: Profile, gate: OrderGate, clock: Clock) -> None:
        super().__init__(profile, gate, clock)
        self.work_s = WORK_S
        self.handed_ns = 0
        self.acted_before = 0
        self.remember(ACTS_AT_MOST)
        self.hungry = asyncio.Event()

    async def execute(self, order: Order, tell: Tell) -> Outcome:
        """Act once, and ask for more."""
        try:
            return await super().execute(order, tell)
        finally:
            self.hungry.set()

    async def stop(self, stop: Stop) -> RestReport:
        """Note the time before anything else."""
        self.handed_ns = perf_counter_ns()
        self.acted_before = len(self.acted)
        return await super().stop(stop)

    async def resume(self, generation: int) -> None:
        """Ask for more again."""
        await super().resume(generation)
        self.hungry.set()


class TimedLatch:
    """Notes when a stop was kept by the latch it stands before.

    Attributes:
        kept_ns: Per robot, when its last stop was kept.
    """

    def __init__(self, latch: StopLatch) -> None:
        self.kept_ns: dict[RobotId, int] = {}
        self._latch = latch

    def read(self) -> dict[RobotId, tuple[int, bool]]:
        """Return what the latch says."""
        return dict(self._latch.read())

    async def write(self, robot: RobotId, generation: int, *, latched: bool) -> None:
        """Keep it, then note the time."""
        await self._latch.write(robot, generation, latched=latched)
        if latched:
            self.kept_ns[robot] = perf_counter_ns()


class WatchedMessenger(BenchMessenger):
    """A messenger that reads only what the watcher is told."""

    def __init__(self) -> None:
        super().__init__()
        self._told: asyncio.Future[tuple[int, str]] | None = None
        self._ids = count(1)

    def expect_stop(self) -> asyncio.Future[tuple[int, str]]:
        """Return what is done, with the time and the text, when the next stop is answered."""
        self._told = asyncio.get_running_loop().create_future()
        return self._told

    async def send(self, outbound: Outbound) -> str:
        """Take a message."""
        self._read(outbound)
        return str(next(self._ids))

    async def edit(self, message: str, outbound: Outbound) -> None:  # noqa: ARG002 - a contract
        """Take an edit."""
        self._read(outbound)

    def _read(self, outbound: Outbound) -> None:
        if self._told is None or outbound.chat.id != WATCHER:
            return
        if outbound.text.startswith("STOP: ") and not self._told.done():
            self._told.set_result((perf_counter_ns(), outbound.text))


class OrderSenders:
    """One person for each robot, who sends it another order whenever one has left its queue."""

    def __init__(self, gateway: Gateway, messenger: Messenger, queued: int) -> None:
        self.robots = {
            name: robot for name, robot in gateway.robots.items() if isinstance(robot, BusyRobot)
        }
        self._gateway = gateway
        self._messenger = messenger
        self._queued = queued
        self._depth = queued // ROBOTS + SPARE
        self._ids = count(1)
        self._feeding: list[asyncio.Task[None]] = []

    def open(self) -> None:
        """Begin to send."""
        self._feeding = [
            asyncio.create_task(self._feed(number, name)) for number, name in enumerate(self.robots)
        ]

    async def close(self) -> None:
        """Send no more.

        Raises:
            BaseException: Whatever ended somebody's sending before this.
        """
        for task in self._feeding:
            task.cancel()
        found = await asyncio.gather(*self._feeding, return_exceptions=True)
        for error in found:
            if isinstance(error, Exception):
                raise error

    @property
    def queued(self) -> int:
        """How many orders wait in all queues together."""
        return sum(map(self._gateway.rooms.linker.waiting, self.robots))

    @property
    def acted(self) -> int:
        """How many orders acted so far, at all robots."""
        return sum(len(robot.acted) for robot in self.robots.values())

    async def filled(self) -> None:
        """Wait until a few more orders wait than were asked for.

        Raises:
            TimeoutError: The robots are faster than orders can be accepted here.
        """
        async with asyncio.timeout(FILLED_WITHIN_S):
            while self.queued < self._queued + ROBOTS:  # noqa: ASYNC110 - a length tells nobody
                await asyncio.sleep(LOOK_S)

    async def say(self, who: str, chat: str, text: str) -> None:
        """Have somebody say something, now."""
        now_ns = CLOCK.wall_ns()
        inbound = Inbound(
            sender=Address("bench", who),
            chat=Chat("bench", chat),
            message=str(next(self._ids)),
            text=text,
            sent_ns=now_ns,
            received_ns=now_ns,
        )
        await self._gateway.pipeline.receive(self._messenger, inbound)

    async def _feed(self, number: int, name: RobotId) -> None:
        robot, waiting = self.robots[name], self._gateway.rooms.linker.waiting
        chats = cycle(f"{number}.{chat}" for chat in range(CHATS))
        text = f"{name} go 0.5 m"
        while True:
            if robot.gate.latched:  # it is told to go on before its gate is open
                await asyncio.sleep(LOOK_S)
                continue
            missing = self._depth - waiting(name)
            if missing <= 0:
                robot.hungry.clear()
                await robot.hungry.wait()
                continue
            together, before = min(missing, CHATS), waiting(name)
            await asyncio.gather(
                *(self.say(str(number), next(chats), text) for _ in range(together))
            )
            # What was accepted enters its queue; who is refused waits before asking again.
            await asyncio.sleep(0 if waiting(name) > before else REFUSED_S)


def crowded_gateway(messenger: Messenger, store: Store, latch: StopLatch, queued: int) -> Gateway:
    """Return a gateway for the crowd; nothing is opened."""
    people = [
        ConfiguredPerson(f"person {n}", (Address("bench", str(n)),), ("operator",))
        for n in range(ROBOTS)
    ]
    people.append(ConfiguredPerson("the watcher", (Address("bench", WATCHER),), ("operator",)))
    settings = GatewaySettings(
        profiles=tuple(_profile(f"robot{number}", queued) for number in range(ROBOTS)),
        people=tuple(people),
        limit=RateLimit(burst=1e9, per_s=1e9),
    )
    return Gateway(settings, parts_of(store, messenger, robot=BusyRobot, latch=latch))


def _profile(name: RobotId, queued: int) -> Profile:
    distance = Parameter(unit="m", min=0.01, max=5.0)
    return Profile(
        id=name,
        groups=(EVERYTHING,),
        link=Link(kind="memory"),
        busy=Busy.QUEUE,
        queue_length=queued // ROBOTS + SPARE + CHATS,
        skills={"go": Skill(id="go", lifetime_s=LIVES_S, parameters={"distance": distance})},
    )
