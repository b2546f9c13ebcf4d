"""What receiving costs: from an update to the robot's adapter, beside an empty handler."""

from __future__ import annotations

import asyncio
import gc
import json
import os
import tempfile
from contextlib import AsyncExitStack, asynccontextmanager
from functools import partial
from pathlib import Path
from time import perf_counter_ns
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any, TypeVar

import msgspec
from telegram import Bot, Update
from telegram.ext import Application, MessageHandler, filters
from telegram.request import BaseRequest

from rosic.app import runtime
from rosic.app.gateway import Gateway, GatewaySettings
from rosic.app.people import ConfiguredPerson
from rosic.bench.bot_api_process import TOKEN
from rosic.bench.report import quantile
from rosic.bench.sites import CLOCK, parts_of
from rosic.core.identity import Address
from rosic.core.rate_limit import RateLimit
from rosic.core.records import Fact
from rosic.core.robot.profile import Busy, Link, Profile
from rosic.core.robot.skill import Parameter, Skill
from rosic.core.time_units import SECOND_NS
from rosic.messengers.telegram.bot_client import BotClient
from rosic.messengers.telegram.messenger import TelegramMessenger
from rosic.messengers.telegram.settings import read_settings
from rosic.messengers.telegram.updates import ApiAnswer
from rosic.robots.memory import MemoryRobot
from rosic.stores.database import DatabaseStore
from rosic.stores.memory import MemoryStore

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Awaitable, Callable, Mapping, Sequence

    from rosic.contracts.robot import Tell
    from rosic.contracts.store import Store
    from rosic.core.order import Order, Outcome
    from rosic.testing.telegram import Control

T = TypeVar("T")
PEOPLE = 200
BLOCK = 50
FIRST = 100
PAGE = bytes(4_096)
PROMISED_ABOVE_US, PROMISED_DURABLE_US = 60.0, 1_000.0
TMPFS = Path("/dev/shm")  # noqa: S108 - the one folder that is certainly no disk
DURABLE = "receiving: ROSIC, durable claim"
IN_MEMORY = "receiving: ROSIC, record in memory"
PEER = "receiving: python-telegram-bot, empty handler"
SYNC = "this disk: one page written and synced"
NO_DISK = "receiving: ROSIC, durable claim on tmpfs"
NOTHING = Fact(kind="bench", key="nothing", body=b"")
PAUSE_S = 0.0005
"""Between two updates: what is written and said of one is no part of the next."""


class WatchedRobot(MemoryRobot):
    """Notes when its adapter was given an order."""

    async def execute(self, order: Order, tell: Tell) -> Outcome:
        """Note the time before anything else."""
        now_ns = perf_counter_ns()
        if WAITING:
            WAITING.pop().set_result(now_ns)
        return await super().execute(order, tell)


WAITING: list[asyncio.Future[int]] = []


class ScriptedBotClient(BotClient):
    """A line that gives out what it is handed, and takes whatever is said.

    Attributes:
        given_ns: When the last update was given out.
    """

    def __init__(self, token: str = TOKEN) -> None:
        super().__init__(read_settings("bench", {"token": token}))
        self.given_ns = 0
        self._next: asyncio.Queue[bytes] = asyncio.Queue()

    def hand(self, payload: bytes) -> None:
        """Have the next poll bring this, as it comes over the wire."""
        self._next.put_nowait(payload)

    @asynccontextmanager
    async def held(self) -> AsyncIterator[Any]:
        """No connection."""
        yield _Anybody()

    async def ask(self, act: Callable[[Any], Awaitable[T]], *, within_s: float = 0.0) -> T:
        """Take it."""
        del within_s
        return await act(_Anybody())

    async def updates(
        self, offset: int | None, timeout_s: int, kinds: Sequence[str], limit: int
    ) -> list[Any]:
        """Give out one update, or nothing in time: whoever is silent for long is not believed."""
        del offset, kinds, limit
        if not timeout_s and self._next.empty():
            return []
        try:
            async with asyncio.timeout(timeout_s):
                payload = await self._next.get()
        except TimeoutError:
            return []
        self.given_ns = perf_counter_ns()
        return msgspec.json.decode(payload, type=ApiAnswer).result or []


class _Anybody:
    """A bot that says yes to everything."""

    async def get_me(self) -> SimpleNamespace:
        return SimpleNamespace(username="bench_bot", can_read_all_group_messages=True)

    async def get_chat_administrators(self, *_args: object, **_more: object) -> tuple[()]:
        return ()

    def __getattr__(self, name: str) -> Callable[..., Awaitable[SimpleNamespace]]:
        async def yes(*_args: object, **_more: object) -> SimpleNamespace:
            return SimpleNamespace(message_id=1)

        return yes


async def received(
    orders: int, beside: Mapping[str, Callable[[int], Awaitable[int]]]
) -> dict[str, list[int]]:
    """Return, for each kind, how long each update took in nanoseconds; blocks take turns.

    Args:
        orders: So many updates of each kind.
        beside: Others than ROSIC: each handles the update of a number, and says how long it took.
    """
    async with AsyncExitStack() as stack:

        def folder(where: str | None = None) -> Path:
            made = tempfile.TemporaryDirectory(prefix="rosic-bench-", dir=where)
            return Path(stack.enter_context(made))

        async def rosic_in(at: Path) -> Callable[[int], Awaitable[int]]:
            return await stack.enter_async_context(_rosic(DatabaseStore(at, clock=CLOCK)))

        disk = folder()
        sides: dict[str, Callable[[int], Awaitable[int]]] = {
            DURABLE: await rosic_in(disk),
            IN_MEMORY: await stack.enter_async_context(_rosic(MemoryStore())),
            **beside,
            SYNC: partial(synced, disk / "page"),
        }
        if TMPFS.is_dir():  # noqa: ASYNC240 - before anything is measured
            sides[NO_DISK] = await rosic_in(folder(str(TMPFS)))
        runtime.settle()
        return await _in_turns(sides, orders)


async def _in_turns(
    sides: dict[str, Callable[[int], Awaitable[int]]], orders: int
) -> dict[str, list[int]]:
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


def findings(found: dict[str, list[int]]) -> tuple[str, ...]:
    """Return what was promised of receiving, and what was seen."""
    p50_us = {name: quantile(times, 0.5) / 1e3 for name, times in found.items()}
    own_us = p50_us[IN_MEMORY] - p50_us[PEER]
    without = (
        f"Without the durable claim: {own_us:.1f} us above python-telegram-bot's dispatch of an "
        f"empty handler at the median (promised: at most {PROMISED_ABOVE_US:.0f})."
    )
    durable = (
        f"With it: {p50_us[DURABLE] / 1e3:.2f} ms at the median (promised: below "
        f"{PROMISED_DURABLE_US / 1e3:.0f}), where the disk takes {p50_us[SYNC] / 1e3:.2f} ms to "
        "write and sync one page."
    )
    lines = [without, durable]
    if NO_DISK in p50_us:
        lines.append(
            f"With it on a file system in memory, which syncs nothing: {p50_us[NO_DISK]:.1f} us; "
            "the rest is the disk's."
        )
    return tuple(lines)


async def synced(file: Path, _number: int) -> int:
    """Return how long the disk alone takes for what a claim cannot do without."""

    def write() -> int:
        with file.open("ab", buffering=0) as page:
            began_ns = perf_counter_ns()
            page.write(PAGE)
            os.fdatasync(page.fileno())  # as SQLite does
            return perf_counter_ns() - began_ns

    return await asyncio.to_thread(write)


@asynccontextmanager
async def _rosic(store: Store) -> AsyncIterator[Callable[[int], Awaitable[int]]]:
    """Let a gateway run; yield what hands it one update and waits until the order is given."""
    line = ScriptedBotClient()
    messenger = TelegramMessenger(
        "bench", read_settings("bench", {"token": TOKEN}), CLOCK, line=line
    )
    gateway = _gateway(messenger, store)
    await gateway.open()
    running = asyncio.create_task(gateway.run())

    async def one(number: int) -> int:
        given = asyncio.get_running_loop().create_future()
        WAITING.append(given)
        line.hand(_payload(number))
        given_ns: int = await asyncio.wait_for(given, 10)
        while len(gateway.pipeline.executor):  # noqa: ASYNC110 - a length tells nobody
            await asyncio.sleep(PAUSE_S)
        await store.write(NOTHING)  # behind whatever else of this one goes to the disk
        return given_ns - line.given_ns

    try:
        yield one
    finally:
        running.cancel()
        await asyncio.wait([running])
        await gateway.close()


@asynccontextmanager
async def empty_handler(control: Control) -> AsyncIterator[Callable[[int], Awaitable[int]]]:
    """Let python-telegram-bot's application run with one handler that does nothing."""
    called_ns = 0

    async def nothing(_update: object, _context: object) -> None:
        nonlocal called_ns
        called_ns = perf_counter_ns()

    bot = Bot(TOKEN, base_url=control.api_base)
    application = Application.builder().bot(bot).updater(None).build()
    application.add_handler(MessageHandler(filters.ALL, nothing))

    async def one(number: int) -> int:
        payload = _payload(number)
        began_ns = perf_counter_ns()
        (raw,) = BaseRequest.parse_json_payload(payload)["result"]
        await application.process_update(Update.de_json(raw, bot))
        await asyncio.sleep(PAUSE_S)
        return called_ns - began_ns

    async with application:
        yield one


def _payload(number: int) -> bytes:
    """Return the answer of Telegram's that brings an update."""
    person = 7_000_000_001 + number % PEOPLE
    name = f"Person {person}"
    update = {
        "update_id": 1_000 + number,
        "message": {
            "message_id": 1_000 + number,
            "date": CLOCK.wall_ns() // SECOND_NS,
            "from": {"id": person, "is_bot": False, "first_name": name, "language_code": "en"},
            "chat": {"id": person, "type": "private", "first_name": name},
            "text": "omni go 0.5 m",
        },
    }
    return json.dumps({"ok": True, "result": [update]}).encode()


def _gateway(messenger: TelegramMessenger, store: Store) -> Gateway:
    people = range(7_000_000_001, 7_000_000_001 + PEOPLE)
    skill = Skill(
        id="go", lifetime_s=60.0, parameters={"distance": Parameter(unit="m", min=0.01, max=5.0)}
    )
    profile = Profile(
        id="omni", link=Link(kind="memory"), busy=Busy.QUEUE, queue_length=64, skills={"go": skill}
    )
    return Gateway(
        GatewaySettings(
            profiles=(profile,),
            people=tuple(
                ConfiguredPerson(f"person {n}", (Address("telegram", str(n)),), ("operator",))
                for n in people
            ),
            limit=RateLimit(burst=1e9, per_s=1e9),
            lease_idle_s=0.0,
        ),
        parts_of(store, messenger, robot=WatchedRobot),
    )
