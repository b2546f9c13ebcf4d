"""A gateway whose clock is read wherever an order passes, between a server and a robot."""

from __future__ import annotations

import asyncio
import tempfile
import time
from contextlib import AsyncExitStack, asynccontextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, TypeVar

from rosic.app.gateway import Gateway, GatewaySettings
from rosic.app.people import ConfiguredPerson
from rosic.bench.bot_api_process import TOKEN
from rosic.bench.sites import CLOCK, parts_of
from rosic.config.plugins import robot_factory
from rosic.config.profiles import load_profile, shipped_profiles
from rosic.core.identity import Address
from rosic.core.order import OrderStage
from rosic.core.rate_limit import RateLimit
from rosic.core.records import Claimed
from rosic.messengers.telegram.bot_client import BotClient
from rosic.messengers.telegram.messenger import TelegramMessenger
from rosic.messengers.telegram.rate_limiter import PUBLISHED
from rosic.messengers.telegram.settings import read_settings
from rosic.stores.database import DatabaseStore
from rosic.stores.stop_latch import FileLatch

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Awaitable, Callable, Sequence

    from rosic.core.order import Order, Outcome, StageReport
    from rosic.core.records import Record
    from rosic.core.robot.profile import Profile
    from rosic.testing.telegram import Control

T = TypeVar("T")

PAPER_BITS_PER_S: Final = 26e6
PAPER_ROUND_TRIP_S: Final = 0.06
"""The network of the paper (section 4): 26 Mbit/s; 10 messages took 63.2 ms each."""
LISTENS_WITHIN_S: Final = 60.0
ENDS_WITHIN_S: Final = 30.0
LOOK_S: Final = 0.005
DRIVEN: Final = ("omni move forward 1 cm", "omni move back 1 cm")
SEEN_KINDS: Final = ("sent", "edited", "delivered", "said")
HOPS: Final = (
    "person to server",
    "server to gateway",
    "decided",
    "on disk",
    "robot received",
    "robot acknowledged",
    "answer sent",
    "person sees",
)
"""In the order of the way; each lasts from the end of the one before it that was seen."""


class OrderClock:
    """Notes, in Unix time, when the order that is under way passes; it is one at a time."""

    def __init__(self) -> None:
        self.seen_ns: dict[str, int] = {}

    def begin(self) -> None:
        """Forget the order before."""
        self.seen_ns = {}

    def note(self, hop: str) -> None:
        """Note that it passes here now; the first time counts."""
        self.seen_ns.setdefault(hop, time.time_ns())

    # ---- as an observer of orders ----

    def accepted(self, _order: Order) -> None:
        """It is on disk, and handed on."""

    def reported(self, _order: Order, report: StageReport) -> None:
        """The robot's side says that it has it."""
        if report.stage is OrderStage.RECEIVED:
            self.note("robot acknowledged")

    def ended(self, _order: Order, _outcome: Outcome) -> None:
        """It is over."""
        self.note("ended")


class ClockedStore(DatabaseStore):
    """A record on disk that notes when an order goes in, and when it is safe."""

    def __init__(self, folder: Path, clock: OrderClock) -> None:
        super().__init__(folder, clock=CLOCK)
        self._passage = clock

    async def write(self, *records: Record) -> None:
        """Write, and look at the clock before and after."""
        claims = any(isinstance(record, Claimed) for record in records)
        if claims:
            self._passage.note("decided")
        await super().write(*records)
        if claims:
            self._passage.note("on disk")


class ClockedClient(BotClient):
    """A line to the Bot API that notes when updates come, and when the first answer goes."""

    def __init__(self, settings: Any, clock: OrderClock) -> None:  # noqa: ANN401
        super().__init__(settings)
        self._passage = clock

    async def updates(
        self, offset: int | None, timeout_s: int, kinds: Sequence[str], limit: int
    ) -> list[Any]:
        """Ask for updates, and note when some have come."""
        found = await super().updates(offset, timeout_s, kinds, limit)
        if found:
            self._passage.note("server to gateway")
        return found

    async def ask(self, act: Callable[[Any], Awaitable[T]], *, within_s: float = 0.0) -> T:
        """Note when something is said, once an order is decided."""
        if "decided" in self._passage.seen_ns:
            self._passage.note("answer sent")
        return await super().ask(act, within_s=within_s)


class HopSite:
    """One gateway with one robot, one person and their chat; orders pass it one at a time.

    Attributes:
        person: Their id at the server; also that of the chat.
    """

    def __init__(
        self, control: Control, person: int, clock: OrderClock, lines: Sequence[str]
    ) -> None:
        self.person = person
        self._control = control
        self._clock = clock
        self._lines = lines
        self._turn = 0

    async def order(self) -> dict[str, int]:
        """Say an order, wait until it is over and told; return when it passed where, in ns.

        Raises:
            TimeoutError: It was not told in time.
        """
        self._clock.begin()
        line = self._lines[self._turn % len(self._lines)]
        self._turn += 1
        first = await self._control.seq()
        begun_ns = time.time_ns()
        message = await self._control.say(self.person, self.person, line)
        async with asyncio.timeout(ENDS_WITHIN_S):
            shown = await self._answer(message, first)
            while "ended" not in self._clock.seen_ns:  # noqa: ASYNC110 - a clock tells nobody
                await asyncio.sleep(LOOK_S)
        said = await self._control.message(self.person, message)
        return {
            "begun": begun_ns,
            "person to server": _ns(said["versions"][0]["received_s"]),
            **self._clock.seen_ns,
            "person sees": _ns(shown["versions"][0]["received_s"]),
        }

    def robot_took(self, at_ns: int) -> None:
        """Hear that the robot took a goal, by its own clock; one of an order before is none."""
        if at_ns > self._clock.seen_ns.get("decided", at_ns):
            self._clock.seen_ns.setdefault("robot received", at_ns)

    async def _answer(self, message: int, first: int) -> dict[str, Any]:
        """Return the first message of the bot in reply to one."""
        seq = first
        while True:
            # Of those after it alone: a chat grows, and reading all of it is no time of an order.
            found = await self._control.messages(self.person, by_bot=True, after=message)
            for shown in found:
                if shown["reply_to"] == message:
                    return shown
            changes = await self._control.wait(seq, 1.0, SEEN_KINDS)
            seq = max([seq, *(change["seq"] for change in changes)])


def _ns(seconds: float) -> int:
    return int(seconds * 1e9)


def own_ns(passed: dict[str, int]) -> int:
    """Return how long an order was in the gateway alone until an answer left it."""
    return passed["answer sent"] - passed["server to gateway"]


def network_ns(passed: dict[str, int]) -> int:
    """Return how long it was on the network, there and back."""
    there = passed["server to gateway"] - passed["begun"]
    return there + passed["person sees"] - passed["answer sent"]


def hop_times(passed: dict[str, int]) -> dict[str, int]:
    """Return how long each hop took, in ns; what nobody saw is left out.

    The robot and the answer go at once: both count from the moment at which it is on disk.
    """
    branches = {"robot received": "on disk", "answer sent": "on disk"}
    times: dict[str, int] = {}
    before = "begun"
    for hop in HOPS:
        if hop not in passed:
            continue
        times[hop] = passed[hop] - passed[branches.get(hop, before)]
        before = hop
    return times


def simulated_omni() -> Profile:
    """Return the robot that is driven, in this process."""
    return load_profile(shipped_profiles()["omni"], link="simulated")


def ros_omni() -> Profile:
    """Return the robot that is driven, as a ROS 2 node elsewhere."""
    return load_profile(shipped_profiles()["omni"])


@asynccontextmanager
async def hop_site(
    control: Control, profile: Profile, lines: Sequence[str] = DRIVEN
) -> AsyncIterator[HopSite]:
    """Run a gateway over a network as the paper's while inside, and one person at it.

    Args:
        control: Of the stand-in.
        profile: Of the robot.
        lines: What it is told, in turns.

    Raises:
        TimeoutError: It does not answer.
    """
    clock = OrderClock()
    await control.call("set_limits", limits=None)
    person = await control.create_user("Person")
    settings = read_settings(
        "bench", {"token": TOKEN, "api_base": control.api_base, "poll_timeout_s": 1}
    )
    messenger = TelegramMessenger(
        "bench", settings, CLOCK, line=ClockedClient(settings, clock), rates=PUBLISHED.times(100.0)
    )
    async with AsyncExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="rosic-bench-")))
        latch = FileLatch(folder / "stops")
        stack.push_async_callback(latch.close)
        parts = parts_of(
            ClockedStore(folder, clock),
            messenger,
            robot=robot_factory(profile.link.kind),
            latch=latch,
        )
        gateway = Gateway(
            GatewaySettings(
                profiles=(profile,),
                people=(
                    ConfiguredPerson("person", (Address("telegram", str(person)),), ("operator",)),
                ),
                limit=RateLimit(burst=1e9, per_s=1e9),
            ),
            parts,
        )
        await gateway.open()
        stack.push_async_callback(gateway.close)
        gateway.pipeline.executor.watching.observe(clock)
        running = asyncio.create_task(gateway.run())
        stack.push_async_callback(_ended, running)
        site = HopSite(control, person, clock, lines)
        await _listening(control, person)
        await control.call("set_latency", seconds=PAPER_ROUND_TRIP_S, bits_per_s=PAPER_BITS_PER_S)
        stack.push_async_callback(control.call, "set_latency", seconds=0.0)
        yield site


async def _ended(running: asyncio.Task[None]) -> None:
    running.cancel()
    await asyncio.wait([running])


async def _listening(control: Control, person: int) -> None:
    """Wait until the gateway answers."""
    async with asyncio.timeout(LISTENS_WITHIN_S):
        while not any(call["method"] == "getUpdates" for call in await control.calls()):  # noqa: ASYNC110
            await asyncio.sleep(0.1)
        await control.say(person, person, "status")
        while not await control.messages(person, by_bot=True):  # noqa: ASYNC110 - elsewhere
            await asyncio.sleep(0.1)
