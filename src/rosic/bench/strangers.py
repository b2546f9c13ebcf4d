"""How soon a stop takes effect behind the worst that strangers and a viewer send (L2, I15)."""

from __future__ import annotations

import asyncio
import gc
import tempfile
from contextlib import asynccontextmanager, contextmanager
from pathlib import Path
from time import perf_counter, perf_counter_ns, thread_time_ns
from typing import TYPE_CHECKING, Final, NamedTuple

import msgspec

from rosic.app import runtime
from rosic.app.gateway import Gateway, GatewaySettings
from rosic.app.people import ConfiguredPerson
from rosic.bench.bot_api_process import TOKEN, stand_in
from rosic.bench.recorder import pace_of_machine
from rosic.bench.report import BenchReport, case_of, machine, quantile
from rosic.bench.sites import CLOCK, parts_of
from rosic.core.identity import Address
from rosic.core.robot.profile import Link, Profile
from rosic.core.robot.skill import Skill
from rosic.messengers.telegram.messenger import TelegramMessenger
from rosic.messengers.telegram.rate_limiter import PUBLISHED
from rosic.messengers.telegram.settings import read_settings
from rosic.robots.memory import MemoryRobot
from rosic.stores.database import DatabaseStore
from rosic.stores.stop_latch import FileLatch

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Callable, Iterator, Sequence
    from contextvars import Context

    from rosic.bench.recorder import BenchRecorder
    from rosic.bench.report import BenchCase
    from rosic.contracts.clock import Clock
    from rosic.core.order import RestReport, Stop
    from rosic.core.order_gate import OrderGate
    from rosic.testing.telegram import Control


# ---- steps ----

# How much of the processor each step of an event loop takes, and what the step was.
#
# Nothing else happens between two steps: a stop that arrives during one waits for its end. Time
# on the processor is counted, not time that passed: others who use the machine lengthen no step.


class LoopStep(NamedTuple):
    """One step of the loop.

    Attributes:
        cpu_ns: Time on the processor.
        what: The callback that ran, for a report.
    """

    cpu_ns: int
    what: str


class MeteredLoop(asyncio.SelectorEventLoop):
    """An event loop that remembers its longest step.

    Attributes:
        longest: Since `reset`.
    """

    def __init__(self) -> None:
        self.longest = LoopStep(0, "")
        super().__init__()

    def reset(self) -> None:
        """Begin anew."""
        self.longest = LoopStep(0, "")

    def call_soon(
        self, callback: Callable[..., object], *args: object, context: Context | None = None
    ) -> asyncio.Handle:
        """Metered."""
        return super().call_soon(self._metered, callback, *args, context=context)

    def call_soon_threadsafe(
        self, callback: Callable[..., object], *args: object, context: Context | None = None
    ) -> asyncio.Handle:
        """Metered."""
        return super().call_soon_threadsafe(self._metered, callback, *args, context=context)

    def call_at(
        self,
        when: float,
        callback: Callable[..., object],
        *args: object,
        context: Context | None = None,
    ) -> asyncio.TimerHandle:
        """Metered."""
        return super().call_at(when, self._metered, callback, *args, context=context)

    def _add_reader(
        self, fd: int, callback: Callable[..., object], *args: object
    ) -> asyncio.Handle:
        """Metered: what comes in over a connection is read and taken apart here."""
        return super()._add_reader(fd, self._metered, callback, *args)  # type: ignore[misc, no-any-return]

    def _metered(self, callback: Callable[..., object], *args: object) -> None:
        began_ns = thread_time_ns()
        try:
            callback(*args)
        finally:
            took_ns = thread_time_ns() - began_ns
            if took_ns > self.longest.cpu_ns:
                self.longest = LoopStep(took_ns, _named(callback))


def _named(callback: Callable[..., object]) -> str:
    owner = getattr(callback, "__self__", None)
    if isinstance(owner, asyncio.Task):
        return getattr(owner.get_coro(), "__qualname__", "a task")
    return getattr(callback, "__qualname__", repr(callback))


@contextmanager
def undisturbed() -> Iterator[None]:
    """Leave what was made before alone while inside: looking for garbage in it is no step's own."""
    gc.collect()
    gc.freeze()
    try:
        yield
    finally:
        gc.unfreeze()


# ---- strangers ----

LONGEST: Final = 4_096
CROWD: Final = 40
HANDED_WITHIN_S: Final = 60.0
DRAINED_WITHIN_S: Final = 60.0
ABOVE_QUIET_S: Final = 0.100
STEP_S: Final = 0.020
SIGNS: Final = (
    "\ufdfa\n",
    "\ufdfa",
    "\u3316\n",
    "stop \ufdfa",
    "@x a\n",
    "\U0001f6d1x\n",
    "/start A-B\n",
)
"""What a message of a flood is made of, over and over, in turns."""
NAMED: Final = "\n".join(f"@b{number}bot " + "\u3316 " * 12 + str(number) for number in range(300))
"""Each line is to another bot and unlike all others, and of signs that are six letters each."""
MARKED: Final = "a" + "\u0301" * (LONGEST // 2 - 1) + "\u0316" * (LONGEST // 2)
"""One letter with marks that canonical order moves past very many others."""
TEXTS: Final = (*((sign * LONGEST)[:LONGEST] for sign in SIGNS), NAMED[:LONGEST], MARKED)
TASK: Final = "/task go"
KINDS: Final = 4
CHANNELS: Final = 10
STOPS: Final = ("a stop, quiet", "a stop behind a flood", "a stop behind everybody's")
UNFINISHED: Final = "Stops of an admin, quiet and right behind floods, until it was interrupted."
METHOD: Final = (
    "A gateway with its record and its latch on disk receives from a stand-in for the Bot API in a "
    "process of its own, through the real listener. {samples} stops of an admin, and in turns as "
    "many right behind a flood of {flood} messages of {longest} characters ({worst}, or each line "
    "to another bot, or thousands of accents on one letter): of one account that nobody knows, of "
    "many, in channels of theirs, or of all three at once with as many {task} of somebody known "
    "here, and as many accents of theirs. Times "
    "run from the moment the admin's message is given to the "
    "stand-in until the robot's adapter is told to stop. The floods are sent by the same process. "
    "Event loop: {loop}. A step is what the event loop does without a pause, in time on the "
    "processor; {metered} stops of each kind on a loop of asyncio that meters each step."
)


class StrangerLoad(msgspec.Struct, frozen=True, kw_only=True):
    """How much is asked for.

    Attributes:
        samples: Stops without a flood, and as many behind one.
        metered: The same once more, for the longest step alone: the meter takes its time.
        flood: Messages in each.
    """

    samples: int
    metered: int
    flood: int = 30


FULL: Final = StrangerLoad(samples=2_000, metered=200)
QUICK: Final = StrangerLoad(samples=12, metered=7)


class StrangerFigures(NamedTuple):
    """What was measured, in nanoseconds, and the longest step of it all."""

    quiet: list[int]
    flooded: list[int]
    mixed: list[int]
    longest: LoopStep
    took_s: float


class StopWatcher(MemoryRobot):
    """Notes when its adapter was told to stop."""

    def __init__(self, profile: Profile, gate: OrderGate, clock: Clock) -> None:
        super().__init__(profile, gate, clock)
        self._handed: asyncio.Future[int] | None = None

    def expect_stop(self) -> asyncio.Future[int]:
        """Return what is done, with the time in ns, when the next stop is handed over."""
        self._handed = asyncio.get_running_loop().create_future()
        return self._handed

    async def stop(self, stop: Stop) -> RestReport:
        """Note the time before anything else."""
        if self._handed is not None and not self._handed.done():
            self._handed.set_result(perf_counter_ns())
        return await super().stop(stop)


def measure(recorder: BenchRecorder) -> BenchReport:
    """Stop a robot without strangers and behind their floods, in turns."""
    load = QUICK if recorder.quick else FULL
    with recorder.turn("a stop"):
        found = runtime.run(_run(load, recorder))
    with undisturbed(), asyncio.Runner(loop_factory=MeteredLoop) as runner:
        longest = runner.run(_run(msgspec.structs.replace(load, samples=load.metered))).longest
    above_s, with_known_s = (
        (quantile(behind, 0.99) - quantile(found.quiet, 0.99)) / 1e9
        for behind in (found.flooded, found.mixed)
    )
    step_s, pace = longest.cpu_ns / 1e9, pace_of_machine()
    promised = f"ms above quiet (promised: {ABOVE_QUIET_S * 1e3:.0f})"
    step = f"{step_s * 1e3:.1f} ms (promised: {STEP_S * 1e3:.0f}, here times {pace:.2f})"
    findings = (
        f"A stop behind a flood: p99 {above_s * 1e3:.1f} {promised}.",
        f"A stop behind floods of everybody: p99 {with_known_s * 1e3:.1f} {promised}.",
        f"The longest step of the event loop: {step}; it was {longest.what or 'none'}.",
    )
    kept = (above_s <= ABOVE_QUIET_S, with_known_s <= ABOVE_QUIET_S, step_s <= STEP_S * pace)
    rate = load.samples / found.took_s
    worst = ", ".join(ascii(sign) for sign in SIGNS)
    return BenchReport(
        machine=machine(),
        method=METHOD.format(
            samples=load.samples,
            flood=load.flood,
            longest=LONGEST,
            worst=worst,
            task=TASK,
            metered=load.metered,
            loop=runtime.name(),
        ),
        cases=tuple(_cases(rate, found.quiet, found.flooded, found.mixed)),
        findings=findings,
        failures=tuple(finding for finding, held in zip(findings, kept, strict=True) if not held),
    )


def _so_far(*stops_ns: Sequence[int]) -> BenchReport:
    """Return what was seen of stops until now, one after another."""
    rate = len(stops_ns[0]) / (sum(map(sum, stops_ns)) / 1e9) if stops_ns[0] else 0.0
    return BenchReport(machine=machine(), method=UNFINISHED, cases=tuple(_cases(rate, *stops_ns)))


def _cases(rate: float, *stops_ns: Sequence[int]) -> Iterator[BenchCase]:
    for name, times in zip(STOPS, stops_ns, strict=True):
        if times:
            yield case_of(name, [(rate, times)])


async def _run(load: StrangerLoad, recorder: BenchRecorder | None = None) -> StrangerFigures:
    with tempfile.TemporaryDirectory(prefix="rosic-bench-") as folder:
        async with stand_in() as control:
            await control.call("set_limits", limits=None)
            admin = await control.create_user("Ada")
            viewer = await control.create_user("Bo")
            crowd = [await control.create_user(f"S{number}") for number in range(CROWD)]
            channels = [
                await control.create_chat("channel", "C", members=[who], bot="administrator")
                for who in crowd[:CHANNELS]
            ]
            async with _gateway(Path(folder), control, admin, viewer) as robot:
                bench = _Bench(control, robot, (admin, viewer), crowd, channels)
                await bench.stop()  # what is made once is made
                return await _samples(bench, load, recorder)


async def _samples(
    bench: _Bench, load: StrangerLoad, recorder: BenchRecorder | None
) -> StrangerFigures:
    here = asyncio.get_running_loop()
    meter = here if isinstance(here, MeteredLoop) else None
    quiet: list[int] = []
    flooded: list[int] = []
    mixed: list[int] = []
    began_s = perf_counter()
    if recorder is not None:
        recorder.report_by(lambda: _so_far(quiet, flooded, mixed))
    if meter is not None:
        meter.reset()
    for number in range(load.samples):
        quiet.append(await bench.stop())
        await bench.flood(number, load.flood)
        (mixed if number % KINDS == KINDS - 1 else flooded).append(await bench.stop())
    longest = LoopStep(0, "") if meter is None else meter.longest
    return StrangerFigures(quiet, flooded, mixed, longest, perf_counter() - began_s)


class _Bench:
    """Says stop as an admin, and whatever strangers and a viewer say."""

    def __init__(
        self,
        control: Control,
        robot: StopWatcher,
        known: tuple[int, int],
        crowd: list[int],
        channels: list[int],
    ) -> None:
        self._control = control
        self._robot = robot
        self._admin, self._viewer = known
        self._crowd = crowd
        self._channels = channels

    async def stop(self) -> int:
        """Return how long a stop took to reach the adapter, in nanoseconds; then wait for quiet."""
        handed = self._robot.expect_stop()
        began_ns = perf_counter_ns()
        await self._control.say(self._admin, self._admin, "stop")
        handed_ns = await asyncio.wait_for(handed, HANDED_WITHIN_S)
        async with asyncio.timeout(DRAINED_WITHIN_S):
            while await self._control.pending():  # noqa: ASYNC110 - another process
                await asyncio.sleep(0.002)
        return handed_ns - began_ns

    async def flood(self, number: int, messages: int) -> None:
        """Send what takes longest: from one stranger, many, nobody in channels, or all with Bo."""
        kind, text = number % KINDS, TEXTS[number % len(TEXTS)]
        senders = (self._crowd[:1], self._crowd[:messages], self._channels)
        for some in senders if kind == len(senders) else (senders[kind],):
            for chat in some:
                who = None if some is self._channels else chat
                await self._control.backlog(chat, who, text, max(1, messages // len(some)))
        if kind == len(senders):
            for said in (TASK, MARKED):
                await self._control.backlog(self._viewer, self._viewer, said, messages)


@asynccontextmanager
async def _gateway(
    folder: Path, control: Control, admin: int, viewer: int
) -> AsyncIterator[StopWatcher]:
    settings = read_settings("bench", {"token": TOKEN, "api_base": control.api_base})
    messenger = TelegramMessenger("bench", settings, CLOCK, rates=PUBLISHED.times(1_000))
    latch = FileLatch(folder / "stops")
    profile = Profile(id="omni", link=Link(kind="memory"), skills={"go": Skill(id="go")})
    people = (
        ConfiguredPerson("Ada", (Address("telegram", str(admin)),), ("admin",)),
        ConfiguredPerson("Bo", (Address("telegram", str(viewer)),), ("viewer",)),
    )
    store = DatabaseStore(folder, clock=CLOCK)
    gateway = Gateway(
        GatewaySettings(profiles=(profile,), people=people),
        parts_of(store, messenger, robot=StopWatcher, latch=latch),
    )
    try:
        await gateway.open()
        running = asyncio.create_task(gateway.run())
        try:
            while messenger.catching_up():  # noqa: ASYNC110 - nobody is told
                await asyncio.sleep(0.01)
            (robot,) = (one for one in gateway.robots.values() if isinstance(one, StopWatcher))
            yield robot
        finally:
            running.cancel()
            await asyncio.wait([running])
            await gateway.close()
    finally:
        await latch.close()
