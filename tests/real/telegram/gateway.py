"""A Telegram messenger at work against the strict stand-in for Telegram."""

from __future__ import annotations

import asyncio
import json
import time
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING, Any

from rosic.core.message import Chat, ChatEvent, Inbound, Outbound
from rosic.messengers.telegram.messenger import TelegramMessenger, telegram_messenger
from rosic.testing.messenger_harness import settled
from tests.pace import pace

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Callable

    from rosic.errors import MessengerFault
    from rosic.testing.telegram import FakeTelegram

PATIENCE_S = 60.0 * pace()


class Hurried:
    """Real time, except that nobody waits long, and that a test may let an hour pass."""

    def __init__(self, hurry: float = 20.0) -> None:
        self.hurry = hurry
        self.passed_s = 0.0

    def wall_ns(self) -> int:
        return time.time_ns() + int(self.passed_s * 1e9)

    def monotonic_ns(self) -> int:
        return time.monotonic_ns() + int(self.passed_s * 1e9)

    async def sleep(self, seconds: float) -> None:
        await asyncio.sleep(seconds / self.hurry)


class Gateway:
    """The messenger, what it handed over, and what it raised an alarm about."""

    def __init__(self, server: FakeTelegram, **settings: Any) -> None:  # noqa: ANN401
        self.server = server
        self.clock = Hurried()
        given = {"token": server.token, "api_base": server.api_base, "poll_timeout_s": 1}
        self.messenger: TelegramMessenger = telegram_messenger("lab", given | settings, self.clock)
        self.heard: list[Inbound] = []
        self.alarms: list[MessengerFault] = []
        self.messenger.settle_with(settled)
        self.messenger.alarm_with(self.alarms.append)
        self.passings: list[ChatEvent] = []
        self.messenger.watch_chats(self.passings.append)

    async def receive(self, inbound: Inbound) -> None:
        self.heard.append(inbound)

    @property
    def texts(self) -> list[str]:
        return [inbound.text for inbound in self.heard]

    @asynccontextmanager
    async def running(self) -> AsyncIterator[asyncio.Task[None]]:
        run = asyncio.create_task(self.messenger.run(self.receive))
        try:
            yield run
        finally:
            run.cancel()
            await asyncio.wait([run], timeout=PATIENCE_S)
            assert run.done()

    @asynccontextmanager
    async def listening(self) -> AsyncIterator[asyncio.Task[None]]:
        """Run, and wait until the backlog is drained."""
        before = self.messenger._listener._listening
        async with self.running() as run:
            await self.until(lambda: self.messenger._listener._listening is not before)
            await self.until(lambda: not self.frozen)
            yield run

    @property
    def frozen(self) -> bool:
        return self.messenger._listener._listening.frozen

    async def until(self, condition: Callable[[], object]) -> None:
        give_up_s = time.monotonic() + PATIENCE_S
        while not condition():
            assert time.monotonic() < give_up_s, "it did not happen in time"
            await asyncio.sleep(0.005)

    async def hear(self, count: int) -> list[Inbound]:
        """Wait until so many messages have been handed over."""
        await self.until(lambda: len(self.heard) >= count)
        return self.heard

    async def hears(self, text: str) -> Inbound:
        """Wait until a message has been handed over, and return it as it came first."""
        await self.until(lambda: text in self.texts)
        return self.heard[self.texts.index(text)]

    def let_pass(self, seconds: float) -> None:
        """Let time pass on both sides."""
        self.clock.passed_s += seconds
        self.server.advance(seconds)

    def calls(self, method: str) -> list[dict[str, Any]]:
        return [call for call in self.server.calls if call["method"] == method]

    def given(self, method: str, parameter: str) -> list[Any]:
        """Return what the calls of a method gave for one of its parameters."""
        return [json.loads(call["parameters"][parameter]) for call in self.calls(method)]


def to(chat: int, text: str, **more: Any) -> Outbound:  # noqa: ANN401
    return Outbound(chat=Chat("telegram", str(chat)), text=text, **more)


def is_backlog(inbound: Inbound) -> bool:
    return inbound.sent_ns < inbound.listening_since_ns
