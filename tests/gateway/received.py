"""A whole gateway behind the real listener of Telegram, on a loop that meters its steps."""

from __future__ import annotations

import asyncio
import json
import time
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING, Any
from unicodedata import combining

import msgspec

from rosic.app.features import command_table
from rosic.app.gateway import Gateway, GatewaySettings
from rosic.app.people import ConfiguredPerson
from rosic.bench.bot_api_process import TOKEN
from rosic.bench.receiving import ScriptedBotClient
from rosic.bench.sites import CLOCK, parts_of
from rosic.bench.strangers import NAMED, LoopStep, MeteredLoop
from rosic.core.identity import Address
from rosic.core.rate_limit import RateLimit
from rosic.messengers.telegram.messenger import TelegramMessenger
from rosic.messengers.telegram.settings import read_settings
from rosic.stores.memory import MemoryStore
from tests.gateway.place import FLEET

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Iterator, Sequence
    from random import Random

    from rosic.contracts.store import Store
    from rosic.core.fleet.mission import Mission
    from rosic.core.robot.profile import Profile
    from rosic.messengers.telegram.polling import Poller
    from rosic.stores.stop_latch import MemoryLatch

ADA, BO, STRANGER = 1, 2, 99
LONGEST = 4_096
HANDLED_WITHIN_S = 60.0
TURNS = 20

LIGATURE = "\ufdfa"
MARKS = (
    "a" + "".join(chr(code) * 50 for code in range(0x5BE, 0x590, -1) if combining(chr(code))),
    "a" + "\u0301" * 2_047 + "\u0316" * 2_047,
    "a" + "\u0344\u0316" * 2_047,
    "a" + ("\u0301" * 30 + "\uff9e") * 132,
)
"""Each has one letter with marks on it that canonical order moves past very many others."""
PIECES = (
    LIGATURE,
    LIGATURE + " ",
    LIGATURE + "\n",
    "\u3316",
    "\u3316 ",
    "\u3316\n",
    "\u2177 ",
    "\u00e9",
    "a\u0301 ",
    "\u0301",
    "\u200d",
    "\u3000",
    "\u505c",
    "\U0001f6d1 ",
    "\U0001f6d1x\n",
    "\u0663",
    " ",
    "\n",
    "\t",
    "a b ",
    "a, ",
    ", ",
    ": ",
    "; ",
    "1 ",
    "1,",
    "1.",
    "-",
    "--",
    "/",
    "/a ",
    "@",
    "@a ",
    "@abot\n",
    "@abot stop\n",
    "a@b.",
    "x",
    "xx ",
    "aaa ",
    "stop ",
    "not stop\n",
    "st0p x\n",
    "(",
    '"',
    "*",
    "= ",
    "a=1 ",
    "#a ",
    "t.me/",
    "omni ",
    "swarm ",
    "omni:move ",
    "for 1h ",
    "14:00 ",
    "every mon 8:00 ",
    "until tomorrow ",
    "with distance <= 1 m ",
    "as ",
    "and ",
    "Bo ",
    "if omni battery < 20 ",
    "prio ",
    "a,b;",
    "0123456789abcdef ",
    "ABCD-EFGH ",
    "\\",
    "\r\n",
)
"""Each is the beginning of something that people say, or grows where it is read."""
HEADS = (
    "",
    "a",
    "/",
    "omni ",
    "omni move ",
    "swarm move ",
    "move ",
    "status ",
    "resume ",
    "use ",
    "help ",
    "stop ",
    "start ",
    "/start ",
    "join ",
    "@abot ",
    "/stop@abot ",
    "/robot add ",
    *(f"/{verb} " for verb in sorted(command_table().words)),
)
TAILS = ("", "b", " b", "\nstop", " as x", " confirmed", " priority x")


class Batches(ScriptedBotClient):
    """Gives out what it is given as the Bot API does: a hundred at most, until confirmed."""

    def __init__(self, token: str = TOKEN) -> None:
        super().__init__(token)
        self.waiting: list[dict[str, Any]] = []
        self.polls = 0
        self._given = asyncio.Event()

    def give(self, updates: Sequence[dict[str, Any]]) -> None:
        self.waiting += updates
        self._given.set()

    async def updates(
        self, offset: int | None, timeout_s: int, kinds: Sequence[str], limit: int
    ) -> list[Any]:
        del kinds
        self.polls += 1
        if offset is not None:
            self.waiting = [one for one in self.waiting if one["update_id"] >= offset]
        if not self.waiting and timeout_s:
            self._given.clear()
            try:
                async with asyncio.timeout(timeout_s):
                    await self._given.wait()
            except TimeoutError:
                return []
        await asyncio.sleep(0.001)
        said = [json.dumps(one).encode() for one in self.waiting[:limit]]
        await asyncio.sleep(0)  # what the other side has to do is no step of ours
        return [msgspec.Raw(one) for one in said]


class Receiving:
    """What is received, and how long each step of it took.

    Attributes:
        gateway: The whole of it.
        listener: The real one.
    """

    def __init__(self, gateway: Gateway, line: Batches, listener: Poller) -> None:
        self.gateway = gateway
        self.listener = listener
        self._line = line
        self._number = 1_000

    def message(self, who: int, text: str, **unusual: Any) -> dict[str, Any]:  # noqa: ANN401
        """Return an update: a private message of somebody."""
        message = {
            "message_id": 0,
            "date": int(time.time()),
            "from": {"id": who, "is_bot": False, "first_name": "P", "language_code": "en"},
            "chat": {"id": who, "type": "private"},
            "text": text,
        } | unusual
        return self.update(message=message)

    def edited(self, who: int, text: str) -> dict[str, Any]:
        """Return an update: a message of somebody that was changed."""
        update = self.message(who, text)
        message = update.pop("message")
        return {**update, "edited_message": {**message, "edit_date": message["date"]}}

    def post(self, channel: int, text: str) -> dict[str, Any]:
        """Return an update: a post in somebody's channel, which names nobody."""
        update = self.message(channel, text)
        message = update.pop("message")
        del message["from"]
        chat = {"id": channel, "type": "channel", "title": "C"}
        return {**update, "channel_post": {**message, "chat": chat, "sender_chat": chat}}

    def update(self, **parts: Any) -> dict[str, Any]:  # noqa: ANN401
        """Return an update with a number of its own."""
        self._number += 1
        for part in parts.values():
            if isinstance(part, dict) and "message_id" in part:
                part["message_id"] = self._number
        return {"update_id": self._number, **parts}

    def give(self, *updates: dict[str, Any]) -> None:
        """Have the next poll bring these."""
        self._line.give(updates)

    async def longest(self, *updates: dict[str, Any]) -> LoopStep:
        """Have these received to the end; return the longest step meanwhile."""
        loop = asyncio.get_running_loop()
        assert isinstance(loop, MeteredLoop)
        await asyncio.sleep(0)  # what the test did until now is no step of what is received
        loop.reset()
        self._line.give(updates)
        await self.drained()
        return loop.longest

    async def drained(self) -> None:
        """Wait until everything is received to the end."""
        async with asyncio.timeout(HANDLED_WITHIN_S):
            while self._line.waiting or self.listener.reading.behind:  # noqa: ASYNC110 - a length tells nobody
                await asyncio.sleep(0.001)
            for _ in range(TURNS):
                await asyncio.sleep(0)


@asynccontextmanager
async def receiving(
    store: Store | None = None,
    latch: MemoryLatch | None = None,
    fleet: tuple[Profile, ...] = FLEET,
    missions: tuple[Mission, ...] = (),
) -> AsyncIterator[Receiving]:
    """Let a gateway with memory robots listen; Ada is an admin, Bo an operator, without limits."""
    line = Batches()
    messenger = TelegramMessenger("lab", read_settings("lab", {"token": TOKEN}), CLOCK, line=line)
    people = (
        ConfiguredPerson("Ada", (Address("telegram", str(ADA)),), ("admin",)),
        ConfiguredPerson("Bo", (Address("telegram", str(BO)),), ("operator",)),
    )
    unlimited = RateLimit(burst=1e9, per_s=1e9)
    settings = GatewaySettings(profiles=fleet, people=people, limit=unlimited, missions=missions)
    gateway = Gateway(settings, parts_of(store or MemoryStore(), messenger, latch=latch))
    await gateway.open()
    running = asyncio.create_task(gateway.run())
    try:
        async with asyncio.timeout(HANDLED_WITHIN_S):
            while messenger.catching_up():  # noqa: ASYNC110 - nobody is told when that ends
                await asyncio.sleep(0.01)
        yield Receiving(gateway, line, messenger._listener)
    finally:
        running.cancel()
        await asyncio.wait([running])
        await gateway.close()


def texts() -> Iterator[str]:
    """Yield every beginning with every piece, as long as a message can be."""
    for head in HEADS:
        for piece in PIECES:
            yield filled(head, piece)
        for text in (NAMED, *MARKS):
            yield head + text[: LONGEST - len(head)]


def filled(head: str, piece: str, tail: str = "") -> str:
    """Return a text of the greatest length that consists of a piece, over and over."""
    room = LONGEST - len(head) - len(tail)
    return head + (piece * LONGEST)[:room] + tail


def mixed(chance: Random) -> str:
    """Return a text that is made at random: lines of several pieces, some of them repeated."""
    parts: list[str] = []
    while sum(map(len, parts)) < LONGEST:
        some = "".join(chance.choice(PIECES) for _ in range(chance.randint(1, 4)))
        if chance.random() < 0.1:
            some = "".join(chance.choices(MARKS[0], k=chance.choice((40, 400, 4_000))))
        parts.append(chance.choice(HEADS) if chance.random() < 0.2 else "")
        parts.append(some * chance.choice((1, 3, 50, 2_000)) + chance.choice(("", "\n")))
    return "".join(parts)[: LONGEST - 12] + chance.choice(TAILS)
