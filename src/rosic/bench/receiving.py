"""What receiving costs: from an update to the robot's adapter, beside an empty handler."""

from __future__ import annotations

import asyncio
import gc
import os
import tempfile
from contextlib import asynccontextmanager
from functools import partial
from pathlib import Path
from time import perf_counter_ns
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any, TypeVar

from telegram import Bot, Update
from telegram.ext import Application, MessageHandler, filters

from rosic.app import heap
from rosic.app.face import face_of
from rosic.app.gateway import Gateway, Parts, Settings
from rosic.app.people import Seed
from rosic.app.units import compile_units
from rosic.bench.stand_in import TOKEN
from rosic.core.identity import Address
from rosic.core.rate import RateLimit
from rosic.core.robot import Busy, Link, Profile
from rosic.core.skill import Parameter, Skill
from rosic.messengers.telegram.line import Line
from rosic.messengers.telegram.messenger import TelegramMessenger
from rosic.messengers.telegram.settings import read_settings
from rosic.robots.memory import MemoryRobot
from rosic.stores.database import DatabaseStore
from rosic.stores.latch import MemoryLatch
from rosic.stores.memory import MemoryStore
from rosic.system import SystemClock, SystemEntropy

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Awaitable, Callable, Sequence

    from rosic.contracts.robot import Tell
    from rosic.contracts.store import Store
    from rosic.core.order import Order, Outcome
    from rosic.testing.telegram import Control

T = TypeVar("T")
CLOCK = SystemClock()
PEOPLE = 200
BLOCK = 50
FIRST = 100
PAGE = bytes(4_096)
PAUSE_S = 0.0005
"""Between two updates: what is written and said of one is no part of the next."""


class Watched(MemoryRobot):
    """Notes when its adapter was given an order."""

    async def execute(self, order: Order, tell: Tell) -> Outcome:
        """Note the time before anything else."""
        now_ns = perf_counter_ns()
        if WAITING:
            WAITING.pop().set_result(now_ns)
        return await super().execute(order, tell)


WAITING: list[asyncio.Future[int]] = []


class Handed(Line):
    """A line that gives out what it is handed, and takes whatever is said.

    Attributes:
        given_ns: When the last update was given out.
    """

    def __init__(self) -> None:
        super().__init__(read_settings("bench", {"token": TOKEN}))
        self.given_ns = 0
        self._next: asyncio.Queue[dict[str, Any]] = asyncio.Queue()

    def hand(self, update: dict[str, Any]) -> None:
        """Have the next poll bring this."""
        self._next.put_nowait(update)

    @asynccontextmanager
    async def held(self) -> AsyncIterator[Any]:
        """No connection."""
        yield _Anybody()

    async def ask(self, act: Callable[[Any], Awaitable[T]], *, within_s: float = 0.0) -> T:
        """Take it."""
        del within_s
        return await act(_Anybody())

    async def updates(self, offset: int | None, timeout_s: int, kinds: Sequence[str]) -> list[Any]:
        """Give out one update, or nothing in time: whoever is silent for long is not believed."""
        del offset, kinds
        if not timeout_s and self._next.empty():
            return []
        try:
            async with asyncio.timeout(timeout_s):
                update = await self._next.get()
        except TimeoutError:
            return []
        self.given_ns = perf_counter_ns()
        return [update]


class _Anybody:
    """A bot that says yes to everything."""

    async def get_me(self) -> SimpleNamespace:
        return SimpleNamespace(username="bench_bot", can_read_all_group_messages=True)

    def __getattr__(self, name: str) -> Callable[..., Awaitable[SimpleNamespace]]:
        async def yes(*_args: object, **_more: object) -> SimpleNamespace:
            return SimpleNamespace(message_id=1)

        return yes


async def received(control: Control, orders: int) -> dict[str, list[int]]:
    """Return, for each kind, how long each update took in nanoseconds; blocks take turns."""
    with tempfile.TemporaryDirectory(prefix="rosic-bench-") as folder:
        durable = DatabaseStore(Path(folder), clock=CLOCK)
        async with (
            _rosic(durable) as by_rosic_on_disk,
            _rosic(MemoryStore()) as by_rosic,
            _foreign(control) as by_other,
        ):
            heap.settle()
            sides: dict[str, Callable[[int], Awaitable[int]]] = {
                "receiving: ROSIC, durable claim": by_rosic_on_disk,
                "receiving: ROSIC, record in memory": by_rosic,
                "receiving: python-telegram-bot, empty handler": by_other,
                "this disk: one page written and synced": partial(_synced, Path(folder) / "page"),
            }
            found: dict[str, list[int]] = {name: [] for name in sides}
            try:
                for first in range(0, FIRST + orders, BLOCK):
                    for name, side in sides.items():
                        times = [await side(first + n) for n in range(BLOCK)]
                        if first >= FIRST:
                            found[name] += times
            finally:
                gc.unfreeze()
            return found


async def _synced(file: Path, _number: int) -> int:
    """Return how long the disk alone takes for what a claim cannot do without."""

    def write() -> int:
        with file.open("ab", buffering=0) as page:
            began_ns = perf_counter_ns()
            page.write(PAGE)
            os.fsync(page.fileno())
            return perf_counter_ns() - began_ns

    return await asyncio.to_thread(write)


@asynccontextmanager
async def _rosic(store: Store) -> AsyncIterator[Callable[[int], Awaitable[int]]]:
    """Let a gateway run; yield what hands it one update and waits until the order is given."""
    line = Handed()
    messenger = TelegramMessenger("bench", read_settings("bench", {"token": TOKEN}), CLOCK,
                                  line=line)  # fmt: skip
    gateway = _gateway(messenger, store)
    await gateway.open()
    running = asyncio.create_task(gateway.run())

    async def one(number: int) -> int:
        given = asyncio.get_running_loop().create_future()
        WAITING.append(given)
        line.hand(_update(number))
        given_ns: int = await asyncio.wait_for(given, 10)
        while len(gateway.pipeline.lives):  # noqa: ASYNC110 - a length tells nobody
            await asyncio.sleep(PAUSE_S)
        return given_ns - line.given_ns

    try:
        yield one
    finally:
        running.cancel()
        await asyncio.wait([running])
        await gateway.close()


@asynccontextmanager
async def _foreign(control: Control) -> AsyncIterator[Callable[[int], Awaitable[int]]]:
    """Let python-telegram-bot's application run with one handler that does nothing."""
    called_ns = 0

    async def nothing(_update: object, _context: object) -> None:
        nonlocal called_ns
        called_ns = perf_counter_ns()

    bot = Bot(TOKEN, base_url=control.api_base)
    application = Application.builder().bot(bot).updater(None).build()
    application.add_handler(MessageHandler(filters.ALL, nothing))

    async def one(number: int) -> int:
        raw = _update(number)
        began_ns = perf_counter_ns()
        await application.process_update(Update.de_json(raw, bot))
        await asyncio.sleep(PAUSE_S)
        return called_ns - began_ns

    async with application:
        yield one


def _update(number: int) -> dict[str, Any]:
    person = 7_000_000_001 + number % PEOPLE
    name = f"Person {person}"
    return {
        "update_id": 1_000 + number,
        "message": {
            "message_id": 1_000 + number,
            "date": CLOCK.wall_ns() // 1_000_000_000,
            "from": {"id": person, "is_bot": False, "first_name": name, "language_code": "en"},
            "chat": {"id": person, "type": "private", "first_name": name},
            "text": "omni go 0.5 m",
        },
    }


def _gateway(messenger: TelegramMessenger, store: Store) -> Gateway:
    people = range(7_000_000_001, 7_000_000_001 + PEOPLE)
    skill = Skill(
        id="go", lifetime_s=60.0, parameters={"distance": Parameter(unit="m", min=0.01, max=5.0)}
    )
    profile = Profile(
        id="omni", link=Link(kind="memory"), busy=Busy.QUEUE, queue_length=64, skills={"go": skill}
    )
    return Gateway(
        Settings(
            profiles=(profile,),
            people=tuple(
                Seed(f"person {n}", (Address("telegram", str(n)),), ("operator",)) for n in people
            ),
            limit=RateLimit(burst=1e9, per_s=1e9),
            lease_idle_s=0.0,
        ),
        Parts(
            messengers=(messenger,),
            robot_factory=lambda _kind: Watched,
            store=store,
            latch=MemoryLatch(),
            clock=CLOCK,
            entropy=SystemEntropy(),
            units=compile_units(),
            face=face_of(),
        ),
    )
