"""One gateway over so many robots, in a process of its own; says what it saw on its output.

Started by `rosic.bench.scaling` as ``python -m rosic.bench.scaling_process PLAN``. Robots
report and people command over sockets, from processes of their own.
"""

from __future__ import annotations

import asyncio
import gc
import os
import sys
import tempfile
from contextlib import asynccontextmanager
from itertools import count, islice
from pathlib import Path
from time import perf_counter, perf_counter_ns, process_time, process_time_ns
from typing import TYPE_CHECKING

import msgspec

from rosic.app import runtime
from rosic.app.gateway import Gateway, GatewaySettings
from rosic.app.people import ConfiguredPerson
from rosic.bench.load_generator import SendFigures, robot_name
from rosic.bench.paired_runs import COMMANDS, SETTLING_S, STOPS, take_turns
from rosic.bench.reporting_robots import FrameProtocol, ReportDelivery, ReportingRobot, read_wish
from rosic.bench.senders import BenchMessenger
from rosic.bench.sites import CLOCK, parts_of
from rosic.contracts.background_tasks import BackgroundTasks
from rosic.core.identity import Address
from rosic.core.message import Chat, Inbound
from rosic.core.rate_limit import RateLimit
from rosic.core.robot.alert_config import AlertConfig
from rosic.core.robot.profile import Busy, Link, Profile, Telemetry
from rosic.core.robot.skill import Parameter, Skill
from rosic.stores.memory import MemoryStore

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Callable, Iterable

    from rosic.contracts.messenger import Receive
    from rosic.core.message import Outbound
    from rosic.core.robot.profile import RobotId

IDS = count(1)
SAID = count()
STARTING_S = 60.0
TOGETHER = 50
SKILLS = 10
STRETCHES = 10
LOOK_S = 0.1


class ScalingPlan(msgspec.Struct, frozen=True):
    """What one process is to see.

    Attributes:
        people: In turns: so many command, each for ``commanding_s``.
        per_s: Commands of all people together.
        quiet_s, fed_s, commanding_s: How long nothing happens; robots report; people command.
        flat_out: How many commands are given as fast as they can be.
    """

    robots: int
    people: tuple[int, ...]
    per_s: int
    quiet_s: float
    fed_s: float
    commanding_s: int
    flat_out: int


class CommandFigures(msgspec.Struct, frozen=True):
    """What was seen while so many people commanded.

    Attributes:
        latencies_ns: From somebody's sending until the end was told, one second after another.
        own_ns: Of that, what the gateway itself was at work, on this and on all else.
        refused: How many were not told an end, because somebody else was faster.
        cpu_s: Of the gateway, what robots said included.
        seconds: For how long.
    """

    people: int
    latencies_ns: list[list[int]]
    own_ns: list[list[int]]
    refused: int
    cpu_s: float
    seconds: float


class ProcessFigures(msgspec.Struct, frozen=True):
    """What one process saw.

    Attributes:
        start_s: How long the gateway took to open.
        rss_bytes: Of the whole process, at the end.
        quiet: Share of a processor while nothing happened.
        fed_cpu_s, fed_s, fed: While robots reported and nobody commanded: processor time, time,
            messages.
        commanded: While people commanded, as many as the plan says, one number after another.
        flat_out: While as much was commanded as could be, in each turn.
        robots_sent, people_sent: What the other processes say of themselves.
        stops_ns: From the receipt of a stop until the last adapter had it, in each turn.
        each_ns: What one message costs when many wait, in each turn; see `rosic.bench.paired_runs`.
    """

    robots: int
    start_s: float
    rss_bytes: int
    quiet: float
    fed_cpu_s: float
    fed_s: float
    fed: int
    commanded: tuple[CommandFigures, ...]
    robots_sent: SendFigures
    people_sent: tuple[SendFigures, ...]
    flat_out: list[CommandFigures] = []
    each_ns: list[float] = []
    stops_ns: list[int] = []


class SocketMessenger(BenchMessenger):
    """Listens for ever; what people say comes over a line of its own."""

    async def send(self, outbound: Outbound) -> str:
        """Take a message; one that says done at once ends the wait."""
        await self.edit(outbound.reply_to, outbound)
        return outbound.reply_to

    async def run(self, receive: Receive) -> None:  # noqa: ARG002 - the contract
        """Wait until cancelled."""
        await asyncio.Event().wait()


class CpuInterval:
    """A stretch of time, and the processor time spent in it."""

    def __init__(self) -> None:
        self._began_s, self._cpu_s = perf_counter(), process_time()

    def end(self) -> tuple[float, float]:
        """Return processor time and time since its beginning, in s."""
        return process_time() - self._cpu_s, perf_counter() - self._began_s


class RemoteSenders:
    """The people: has the gateway receive what they send, and notes when its end was told."""

    def __init__(self, gateway: Gateway, messenger: BenchMessenger) -> None:
        self.latencies_ns: list[int] = []
        self.own_ns: list[int] = []
        self._gateway, self._messenger = gateway, messenger
        self._waiting: BackgroundTasks[None] = BackgroundTasks()

    def take(self, words: bytes) -> None:
        """Take one message."""
        wish = read_wish(words)
        inbound = inbound_of(str(wish.person), text_of(wish.robot, next(SAID)))
        self._waiting.begin(self._follow(inbound, wish.sent_ns, wish.spent_ns))

    def begin_anew(self) -> None:
        """Note what is told from now on in rows of its own."""
        self.latencies_ns, self.own_ns = [], []

    async def command(self, times: int, robots: int, people: int) -> None:
        """Have robots commanded in turns, as fast as it goes, some at a time."""
        numbers = islice(SAID, times)

        async def lane() -> None:
            for number in numbers:
                robot = number % robots
                text = text_of(robot_name(robot), number)
                inbound = inbound_of(str(robot % people), text)
                await self._follow(inbound, perf_counter_ns(), process_time_ns())

        async with asyncio.timeout(STARTING_S):
            await asyncio.gather(*(lane() for _ in range(TOGETHER)))

    async def _follow(self, inbound: Inbound, sent_ns: int, spent_ns: int) -> None:
        ended = asyncio.get_running_loop().create_future()
        self._messenger.ended[inbound.message] = ended
        await self._gateway.pipeline.receive(self._messenger, inbound)
        await ended
        self.latencies_ns.append(perf_counter_ns() - sent_ns)
        self.own_ns.append(process_time_ns() - spent_ns)

    async def told(self) -> int:
        """Wait until everybody was told; return how many were not."""
        if self._waiting:
            await asyncio.wait(self._waiting, timeout=SETTLING_S)
        left = tuple(self._waiting)
        for task in left:
            task.cancel()
        await asyncio.gather(*left, return_exceptions=True)
        return len(left)


def text_of(robot: RobotId, number: int) -> str:
    """Return what somebody says to a robot: never the same twice in a run."""
    return f"{robot} skill{number % SKILLS} {0.01 + number % 49_900 / 10_000:g} m"


def inbound_of(person: str, text: str) -> Inbound:
    """Return what somebody says now."""
    now_ns = CLOCK.wall_ns()
    return Inbound(
        sender=Address("bench", person),
        chat=Chat("bench", person),
        message=str(next(IDS)),
        text=text,
        sent_ns=now_ns,
        received_ns=now_ns,
    )


@asynccontextmanager
async def line(
    who: str, numbers: tuple[int, ...], take: Callable[[bytes], None], ended: list[SendFigures]
) -> AsyncIterator[None]:
    """Let a process of its own send while inside; afterwards it has said what it did."""
    with tempfile.TemporaryDirectory(prefix="rosic-bench-") as folder:
        path = f"{folder}/line"
        frames = FrameProtocol(take)
        server = await asyncio.get_running_loop().create_unix_server(lambda: frames, path)
        process = await asyncio.create_subprocess_exec(
            sys.executable,
            "-m",
            "rosic.bench.load_generator",
            who,
            path,
            *map(str, numbers),
            stdout=asyncio.subprocess.PIPE,
        )
        try:
            await asyncio.wait_for(frames.connected.wait(), STARTING_S)
            frames.transport.write(b"!")
            yield
            frames.transport.abort()
            said, _ = await asyncio.wait_for(process.communicate(), STARTING_S)
            ended.append(msgspec.json.decode(said, type=SendFigures))
        finally:
            server.close()
            if process.returncode is None:
                process.kill()
                await process.wait()


async def see(plan: ScalingPlan) -> None:
    """See what a gateway does with so many robots, and say it; then take turns."""
    feed = ReportDelivery(map(robot_name, range(plan.robots)))
    messenger, began_s = SocketMessenger(), perf_counter()
    gateway = gateway_over(plan.robots, max(plan.people), messenger)
    await gateway.open()
    start_s = perf_counter() - began_s
    running = asyncio.create_task(gateway.run())
    runtime.settle()
    try:
        robots = {
            n: robot for n, robot in gateway.robots.items() if isinstance(robot, ReportingRobot)
        }
        feed.join(robots)
        seen = await _see(plan, gateway, messenger, feed, start_s)
        sys.stdout.write(msgspec.json.encode(seen).decode() + "\n")
        sys.stdout.flush()
        ways = {
            COMMANDS: lambda: _flat_out(plan, RemoteSenders(gateway, messenger)),
            STOPS: lambda: _stop(gateway, messenger, robots.values()),
        }
        await take_turns(feed, plan.robots, ways)
    finally:
        running.cancel()
        await asyncio.gather(running, return_exceptions=True)
        await gateway.close()
        gc.unfreeze()


async def _see(
    plan: ScalingPlan,
    gateway: Gateway,
    messenger: BenchMessenger,
    feed: ReportDelivery,
    start_s: float,
) -> ProcessFigures:
    stretch = CpuInterval()
    await asyncio.sleep(plan.quiet_s)
    quiet_cpu_s, quiet_s = stretch.end()
    robots_sent: list[SendFigures] = []
    people_sent: list[SendFigures] = []
    async with line("robots", (plan.robots,), feed.take, robots_sent):
        await _all_heard(feed)
        before, stretch = feed.messages, CpuInterval()
        await asyncio.sleep(plan.fed_s)
        fed_cpu_s, fed_s = stretch.end()
        fed = feed.messages - before
        people = min(max(plan.people), plan.robots)
        await RemoteSenders(gateway, messenger).command(plan.robots, plan.robots, people)
        commanded = [
            await _command(plan, people, RemoteSenders(gateway, messenger), people_sent)
            for people in plan.people
        ]
    rss = rss_bytes()
    return ProcessFigures(
        plan.robots,
        start_s,
        rss,
        quiet_cpu_s / quiet_s,
        fed_cpu_s,
        fed_s,
        fed,
        tuple(commanded),
        robots_sent[0],
        tuple(people_sent),
    )


async def _all_heard(feed: ReportDelivery) -> None:
    async with asyncio.timeout(STARTING_S):
        while not feed.all_have_reported():  # noqa: ASYNC110 - they tell nobody
            await asyncio.sleep(LOOK_S)


async def _command(
    plan: ScalingPlan, people: int, crowd: RemoteSenders, ended: list[SendFigures]
) -> CommandFigures:
    async with line("people", (people, plan.robots, plan.per_s, os.getpid()), crowd.take, ended):
        await asyncio.sleep(SETTLING_S)  # what is said the first time is read once
        found: list[list[int]] = []
        own: list[list[int]] = []
        stretch = CpuInterval()
        for _ in range(plan.commanding_s):
            crowd.begin_anew()
            await asyncio.sleep(1.0)
            found.append(crowd.latencies_ns)
            own.append(crowd.own_ns)
        cpu_s, seconds = stretch.end()
    return CommandFigures(people, found, own, await crowd.told(), cpu_s, seconds)


async def _flat_out(plan: ScalingPlan, crowd: RemoteSenders) -> CommandFigures:
    people = min(max(plan.people), plan.robots)  # each robot has one person: nobody is in the way
    stretch = CpuInterval()
    await crowd.command(plan.flat_out // STRETCHES, plan.robots, people)
    cpu_s, seconds = stretch.end()
    return CommandFigures(people, [crowd.latencies_ns], [crowd.own_ns], 0, cpu_s, seconds)


async def _stop(
    gateway: Gateway, messenger: BenchMessenger, robots: Iterable[ReportingRobot]
) -> int:
    """Stop everybody; return how long it took until the last one was told, in ns."""
    began_ns = perf_counter_ns()
    await gateway.pipeline.receive(messenger, inbound_of("0", "stop"))
    return max(robot.handed_ns for robot in robots) - began_ns


def rss_bytes() -> int:
    """Return how much memory this process has now."""
    pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[1])
    return pages * 4096


def gateway_over(robots: int, people: int, messenger: BenchMessenger) -> Gateway:
    """Return a gateway; nothing is opened."""
    settings = GatewaySettings(
        profiles=tuple(profile_of(number) for number in range(robots)),
        people=tuple(
            ConfiguredPerson(f"person {n}", (Address("bench", str(n)),), ("operator",))
            for n in range(people)
        ),
        limit=RateLimit(burst=1e9, per_s=1e9),
        lease_idle_s=0.0,
    )
    return Gateway(settings, parts_of(MemoryStore(), messenger, robot=ReportingRobot))


def profile_of(number: int) -> Profile:
    """Return a robot with ten skills, a battery, a place and a rule about its battery."""
    distance = Parameter(unit="m", min=0.01, max=5.0)
    name = robot_name(number)
    return Profile(
        id=name,
        title=f"Robot {number}",
        groups=("everywhere", f"aisle{number // 50}"),
        link=Link(kind="memory"),
        busy=Busy.QUEUE,
        queue_length=64,
        telemetry={"battery": Telemetry(unit="%")},
        alerts=(AlertConfig(name="low", when="battery < 20 %"),),
        skills={
            f"skill{n}": Skill(id=f"skill{n}", parameters={"distance": distance})
            for n in range(SKILLS)
        },
    )


def main(text: str) -> None:
    """See what a plan asks for, say it, and take turns."""
    runtime.run(see(msgspec.json.decode(text, type=ScalingPlan)))


if __name__ == "__main__":
    main(sys.argv[1])
