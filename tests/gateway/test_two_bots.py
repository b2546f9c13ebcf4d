"""Two bots of one gateway: each counts its messages by itself (I1). And what was known before."""

from __future__ import annotations

import asyncio
import json
import time
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING, Any, ClassVar

import msgspec
import pytest

from rosic.app.gateway import Gateway, GatewaySettings
from rosic.app.messenger_setup import CLOCKS_APART_NS, KIND
from rosic.app.people import ConfiguredPerson
from rosic.bench.sites import CLOCK, parts_of
from rosic.core.identity import Address
from rosic.core.records import Fact
from rosic.core.robot.profile import Busy
from rosic.errors import StoreFault
from rosic.messengers.telegram import incoming, updates
from rosic.messengers.telegram.messenger import TelegramMessenger
from rosic.messengers.telegram.settings import read_settings
from rosic.robots.memory import MemoryRobot
from rosic.stores.memory import MemoryStore
from tests.gateway.place import profile
from tests.gateway.received import ADA, Batches, Receiving

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

    from rosic.contracts.robot import Tell
    from rosic.core.order import Order, Outcome
    from rosic.core.records import Record

BO = 77
FIRST, SECOND = "4242:first", "2323:second"
WITHIN_S = 60.0


class Counted(MemoryRobot):
    """Counts what it was told, over all runs."""

    told: ClassVar[list[str]] = []

    async def execute(self, order: Order, tell: Tell) -> Outcome:
        Counted.told.append(order.skill.id)
        return await super().execute(order, tell)


class NoRoom(MemoryStore):
    """Has no room for what is to be kept of identities."""

    async def write(self, *records: Record) -> None:
        if any(isinstance(r, Fact) and r.kind == KIND for r in records):
            raise StoreFault("the disk is full")
        await super().write(*records)


class Dated(TelegramMessenger):
    """Notes since when what was sent names its account."""

    since_ns = 0

    def account_since(self, since_ns: int, *, several: bool) -> None:
        self.since_ns = since_ns
        super().account_since(since_ns, several=several)


class Undated(TelegramMessenger):
    """Names its account in nothing, as the earlier version had it."""

    def account_since(self, since_ns: int, *, several: bool) -> None:  # noqa: ARG002
        super().account_since(2**62, several=several)


class Bots:
    """A gateway with two bots, and what comes in by each."""

    def __init__(
        self, gateway: Gateway, bots: list[Receiving], messengers: list[TelegramMessenger]
    ) -> None:
        self.gateway = gateway
        self.messengers = messengers
        self.first, self.second = bots[0], bots[-1]

    async def settled(self) -> None:
        for bot in (self.first, self.second):
            await bot.drained()
        async with asyncio.timeout(WITHIN_S):
            while not self.gateway.quiet:  # noqa: ASYNC110 - nobody is told when that begins
                await asyncio.sleep(0.01)


@asynccontextmanager
async def bots(
    store: MemoryStore, *tokens: str, made: type[TelegramMessenger] = TelegramMessenger
) -> AsyncIterator[Bots]:
    """Let a gateway run that keeps its record in a store."""
    lines = [Batches(token) for token in tokens or (FIRST, SECOND)]
    messengers = [
        made(f"bot{n}", read_settings("lab", {"token": token}), CLOCK, line=line)
        for n, (line, token) in enumerate(zip(lines, tokens or (FIRST, SECOND), strict=True))
    ]
    people = (
        ConfiguredPerson("Ada", (Address("telegram", str(ADA)),), ("admin",)),
        ConfiguredPerson("Bo", (Address("telegram", str(BO)),), ("admin",)),
    )
    omni = profile("omni", busy=Busy.QUEUE)
    gateway = Gateway(
        GatewaySettings(profiles=(omni,), people=people, lease_idle_s=0.0),
        parts_of(store, *messengers, robot=Counted),
    )
    await gateway.open()
    running = asyncio.create_task(gateway.run())
    try:
        async with asyncio.timeout(WITHIN_S):
            while any(m.catching_up() for m in messengers):  # noqa: ASYNC110 - nobody is told
                await asyncio.sleep(0.01)
        found = [
            Receiving(gateway, line, m._listener) for line, m in zip(lines, messengers, strict=True)
        ]
        yield Bots(gateway, found, messengers)
    finally:
        running.cancel()
        await asyncio.wait([running])
        await gateway.close()


def in_group(kind: str) -> dict[str, Any]:
    return {"chat": {"id": -1_005, "type": kind, "title": "Lab"}}


async def test_messages_of_the_same_number_to_two_bots_are_two_commands() -> None:
    Counted.told.clear()
    async with bots(MemoryStore()) as place:
        for bot in (place.first, place.second):
            bot.give(bot.message(ADA, "omni look"), bot.message(ADA, "omni wave"))
        await place.settled()
    assert sorted(Counted.told) == ["look", "look", "wave", "wave"]


@pytest.mark.parametrize("kind", ["group", "supergroup"])
async def test_what_both_bots_hear_in_a_group_is_one_command(kind: str) -> None:
    Counted.told.clear()
    async with bots(MemoryStore()) as place:
        if kind == "group":  # where each of them counts for itself
            place.first.give(place.first.message(ADA, "hello"))
        for bot in (place.first, place.second):
            bot.give(bot.message(ADA, "omni wave", **in_group(kind)))
        await place.settled()
    assert Counted.told == ["wave"]


@pytest.mark.parametrize(
    "text",
    [
        "@lab_a_bot hello\nomni wave",
        "/status@lab_a_bot\nomni wave",
        "omni wave\n@lab_b_bot thanks",
        "omni wave\n/help@lab_b_bot",
        "\n@lab_a_bot\u2028\r\n\n@lab_b_bot\nomni wave",
    ],
)
@pytest.mark.parametrize("second_first", [False, True])
@pytest.mark.parametrize("kind", ["group", "supergroup"])
async def test_in_a_group_a_line_is_the_same_whichever_bot_is_named(
    text: str, kind: str, *, second_first: bool
) -> None:
    """Each of them takes its own name out of the text, and what is said to the other."""
    Counted.told.clear()
    async with bots(MemoryStore()) as place:
        place.first.listener.reading.own_name = "lab_a_bot"
        place.second.listener.reading.own_name = "lab_b_bot"
        if kind == "group":  # where each of them counts for itself
            place.first.give(place.first.message(ADA, "hello"))
            await place.settled()
        for bot in (place.second, place.first) if second_first else (place.first, place.second):
            bot.give(bot.message(ADA, text, **in_group(kind)))
        await place.settled()
    assert Counted.told == ["wave"]


@pytest.mark.parametrize(("kind", "account"), [("group", "42"), ("supergroup", "")])
def test_all_who_are_in_a_supergroup_share_its_numbers(kind: str, account: str) -> None:
    message = {"message_id": 7, "date": 1, "text": "omni wave"} | in_group(kind)
    message["from"] = {"id": ADA, "is_bot": False, "first_name": "Ada"}
    update = updates.parse(msgspec.Raw(json.dumps({"update_id": 1, "message": message}).encode()))
    inbound = incoming.read(update, "abot", incoming.ReceivedAt(10**18, 0, "42"))
    assert inbound is not None
    assert inbound.account == account


async def test_in_a_small_group_every_other_line_second_or_person_is_another_command() -> None:
    """What somebody says twice in a second, too: the second of one bot is that of the other."""
    Counted.told.clear()
    async with bots(MemoryStore()) as place:
        now_s = int(time.time())  # once it is open: what is too old is not done
        lines = (
            (ADA, "omni wave", now_s),
            (ADA, "omni wave", now_s - 1),
            (ADA, "omni look", now_s),
            (ADA, "omni wave", now_s),
        )
        for said in (lines, [(BO, "omni wave", now_s)]):  # who comes after Ada has done with it
            for bot in (place.first, place.second):
                bot.give(
                    *(
                        bot.message(who, text, date=date_s, **in_group("group"))
                        for who, text, date_s in said
                    )
                )
            await place.settled()
    assert sorted(Counted.told) == ["look", *["wave"] * 4]


async def test_in_a_small_group_the_same_line_after_a_restart_is_another_command() -> None:
    """Of what was said before, nobody counts any more; the second in which it was said remains."""
    Counted.told.clear()
    store = MemoryStore()
    for before_s in (1, 0):
        async with bots(store) as place:
            date_s = int(time.time()) - before_s  # once it is open: what is too old is not done
            for bot in (place.first, place.second):
                bot.give(bot.message(ADA, "omni wave", date=date_s, **in_group("group")))
            await place.settled()
    assert Counted.told == ["wave", "wave"]


async def test_a_small_group_with_one_bot_is_known_by_its_own_numbers() -> None:
    """Nothing is taken for something else there, also where we begin anew between two lines."""
    Counted.told.clear()
    store, now_s = MemoryStore(), int(time.time())
    for before in range(2):
        async with bots(store, FIRST) as place:
            earlier = [place.first.message(ADA, "hello") for _ in range(before)]
            again = place.first.message(ADA, "omni wave", date=now_s, **in_group("group"))
            place.first.give(*earlier, again)
            await place.settled()
    assert Counted.told == ["wave", "wave"]


async def test_what_is_brought_once_more_over_a_restart_is_done_once() -> None:
    Counted.told.clear()
    store = MemoryStore()
    message: dict[str, Any] = {}
    for _ in range(3):
        async with bots(store) as place:
            message = message or place.first.message(ADA, "omni look")
            place.first.give(message)
            await place.settled()
    assert Counted.told == ["look"]


async def test_what_an_earlier_version_did_is_not_done_again_after_the_upgrade() -> None:
    """Its record knows messages without the bot, and Telegram may bring one of them once more."""
    Counted.told.clear()
    store = MemoryStore()
    async with bots(store, made=Undated) as place:
        message = place.first.message(ADA, "omni look")
        place.first.give(message)
        await place.settled()
    del store._facts[KIND, "account"]
    for _ in range(2):
        async with bots(store, made=Dated) as place:
            assert isinstance(place.messengers[0], Dated)
            assert place.messengers[0].since_ns > CLOCKS_APART_NS
            place.first.give(message)
            await place.settled()
    assert Counted.told == ["look"]


async def test_what_cannot_be_written_down_does_not_hold() -> None:
    """Else the next run would know none of the messages of this one."""
    Counted.told.clear()
    store = NoRoom()
    message: dict[str, Any] = {}
    for _ in range(2):
        async with bots(store) as place:
            message = message or place.first.message(ADA, "omni look")
            place.first.give(message)
            await place.settled()
    assert Counted.told == ["look"]
