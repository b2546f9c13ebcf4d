"""A listener whose Telegram is a list of answers, and whose clock a test lets run."""

from __future__ import annotations

import asyncio
import json
from contextlib import asynccontextmanager, suppress
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias, cast

import msgspec

from rosic.core.secret import Secret
from rosic.core.time_units import SECOND_NS
from rosic.errors import ConfigurationError, MessengerFault
from rosic.messengers.telegram.bot_client import ApiBot, BotClient
from rosic.messengers.telegram.chats import Chats
from rosic.messengers.telegram.polling import Poller
from rosic.messengers.telegram.reading import UpdateHooks, moved
from rosic.messengers.telegram.settings import API_BASE, TelegramSettings
from rosic.testing.clock import ManualClock, settle
from rosic.testing.messenger_harness import settled

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

    from rosic.core.message import ChatEvent, Inbound, Reaction

Data: TypeAlias = dict[str, Any]
Answer: TypeAlias = "list[Any] | Exception | Held"

ADA, EVE = 1001, 666
LAB = -1002
POLL_S = 20


class Held(NamedTuple):
    """A call that fails after a while."""

    error: Exception
    seconds: float


class Asked(NamedTuple):
    """One request for updates."""

    at_s: float
    offset: int | None
    timeout_s: int
    limit: int


class ScriptedBot:
    """Answers as it was told to; at the end of the script it answers no more."""

    def __init__(self, clock: ManualClock, answers: list[Answer], who: list[Any]) -> None:
        self.asked: list[Asked] = []
        self.answers = list(answers)
        self._clock = clock
        self._who = list(who)
        self.began_ns = clock.monotonic_ns()

    async def get_me(self) -> object:
        """Say who the bot is."""
        found = self._who.pop(0)
        if isinstance(found, Held):
            await self._clock.sleep(found.seconds)
            found = found.error
        if isinstance(found, Exception):
            raise found
        return found

    async def raw_updates(
        self, offset: int | None, timeout_s: int, _kinds: object, limit: int
    ) -> list[Any]:
        """Give the next answer."""
        at_s = (self._clock.monotonic_ns() - self.began_ns) / SECOND_NS
        self.asked.append(Asked(round(at_s, 3), offset, timeout_s, limit))
        if not self.answers:
            await asyncio.Event().wait()
        answer = self.answers.pop(0)
        if isinstance(answer, Held):
            await self._clock.sleep(answer.seconds)
            answer = answer.error
        if isinstance(answer, Exception):
            raise answer
        return answer


class ScriptedLine(BotClient):
    """Leads to a scripted bot."""

    def __init__(self, bot: ScriptedBot, api_base: str) -> None:
        super().__init__(TelegramSettings(token=Secret("42:token"), api_base=api_base))
        self.bot = bot
        self.open = 0

    @asynccontextmanager
    async def held(self) -> AsyncIterator[ApiBot]:
        """Keep it."""
        self.open += 1
        try:
            yield cast("ApiBot", self.bot)
        finally:
            self.open -= 1


class HarnessInbox:
    """A listener, what it was told, and what it passed on."""

    def __init__(
        self, *answers: Answer, who: list[Any] | None = None, api_base: str = API_BASE
    ) -> None:
        self.clock = ManualClock()
        account = SimpleNamespace(username="lab_bot", can_read_all_group_messages=True)
        self.bot = ScriptedBot(self.clock, list(answers), who or [account])
        self.line = ScriptedLine(self.bot, api_base)
        self.chats = Chats(self.moved)
        self.alarms: list[MessengerFault] = []
        self.passed: list[ChatEvent] = []
        self.reacted: list[Reaction] = []
        self.heard: list[Inbound] = []
        self.held_up: dict[str, asyncio.Event] = {}
        self.listener = Poller("lab", self.line, self.chats, self.clock, POLL_S, self.alarms.append)
        self.hooks = UpdateHooks(
            settle=settled,
            known=lambda _address: True,
            serves=lambda _chat: True,
            passed=self.passed.append,
            reacted=self.reacted.append,
            account_since_ns=0,
            one_of_several=False,
        )

    def moved(self, old: str, new: str) -> None:
        """Pass on what a messenger passes on."""
        self.hooks.passed(moved(old, new))

    async def receive(self, inbound: Inbound) -> None:
        """Note what is handed over; wait with what a test holds up."""
        self.heard.append(inbound)
        if inbound.text in self.held_up:
            await self.held_up[inbound.text].wait()

    @asynccontextmanager
    async def listening(self, seconds: float = 0.0) -> AsyncIterator[asyncio.Task[None]]:
        """Listen, and let so much time pass."""
        task = asyncio.ensure_future(self.listener.run(self.receive, self.hooks))
        try:
            for _ in range(20):
                await settle()
            await self.clock.advance(seconds)
            yield task
        finally:
            task.cancel()
            with suppress(asyncio.CancelledError, MessengerFault, ConfigurationError):
                await task
            assert self.line.open == 0, "the connections were closed"

    @property
    def texts(self) -> list[str]:
        """What was handed over, in order."""
        return [inbound.text for inbound in self.heard]

    @property
    def asked_at_s(self) -> list[float]:
        """When updates were asked for."""
        return [asked.at_s for asked in self.bot.asked]


def raw(number: int, **parts: object) -> msgspec.Raw:
    return msgspec.Raw(json.dumps({"update_id": number, **parts}).encode())


def person(who: int) -> Data:
    return {"id": who, "is_bot": False, "first_name": "A"}


def text(number: int, said: str, who: int = ADA, chat: int | None = None, **more: Any) -> Any:  # noqa: ANN401
    place = {"id": chat, "type": "supergroup"} if chat else {"id": who, "type": "private"}
    message = {"message_id": number, "date": 1, "chat": place, "from": person(who), "text": said}
    return raw(number, message={**message, **more})


def tap(number: int, nonce: str) -> msgspec.Raw:
    under = {"message_id": 5, "chat": {"id": ADA, "type": "private"}}
    query = {"id": "q", "from": person(ADA), "message": under, "data": nonce}
    return raw(number, callback_query=query)


def member(number: int, before: str, now: str) -> msgspec.Raw:
    bot = {"id": 42, "is_bot": True, "first_name": "B"}
    change = {
        "chat": {"id": LAB, "type": "supergroup", "title": "Lab"},
        "from": person(ADA),
        "old_chat_member": {"user": bot, "status": before},
        "new_chat_member": {"user": bot, "status": now},
    }
    return raw(number, my_chat_member=change)
