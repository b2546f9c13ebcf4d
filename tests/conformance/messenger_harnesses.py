"""The messengers of this project, each with the people on its other side."""

from __future__ import annotations

from contextlib import asynccontextmanager
from typing import TYPE_CHECKING

from rosic.core.message import Chat, MessageValidity
from rosic.messengers.memory import MemoryMessenger
from rosic.messengers.telegram.messenger import telegram_messenger
from rosic.system import SystemClock
from rosic.testing.messengers import SeenMessage
from rosic.testing.telegram import FakeTelegram

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

    from rosic.contracts.messenger import Messenger


class HurriedClock(SystemClock):
    """The real time, except that nobody waits long."""

    async def sleep(self, seconds: float) -> None:
        """Wait a twentieth."""
        await super().sleep(seconds / 20)


UNUSUAL = (MessageValidity.EDITED, MessageValidity.FORWARDED)


class MemoryStage:
    """People who are method calls."""

    people: tuple[str, ...] = ("ada", "bob")
    keeps = True
    taps = True
    unusual: tuple[MessageValidity, ...] = UNUSUAL

    def __init__(self, patience_s: float = 30.0) -> None:
        self.patience_s = patience_s
        self.memory = MemoryMessenger(clock=SystemClock())
        self.messenger: Messenger = self.memory

    def chat(self, person: str) -> Chat:
        return Chat("memory", f"chat of {person}")

    async def write(self, person: str, text: str) -> None:
        self.memory.say(text, account=person, chat=f"chat of {person}")

    async def write_unusually(self, person: str, text: str, standing: MessageValidity) -> None:
        self.memory.say(text, account=person, chat=f"chat of {person}", standing=standing)

    async def tap(self, person: str, message: str, label: str) -> None:
        buttons = (b for row in self.memory.shown(message).buttons for b in row)
        button = next(button for button in buttons if button.label == label)
        self.memory.tap(button, under=message, account=person)

    async def screen(self, person: str) -> list[SeenMessage]:
        told = [one for one in self.memory.told if one.outbound.chat == self.chat(person)]
        return [
            SeenMessage(one.message, self.memory.shown(one.message).text)
            for one in told
            if not one.edited
        ]

    async def files(self, person: str) -> list[tuple[str, bytes]]:
        told = [one.outbound for one in self.memory.told if not one.edited]
        return [
            (one.attachment.name, one.attachment.content)
            for one in told
            if one.attachment is not None and one.chat == self.chat(person)
        ]

    async def enclose(self, person: str, name: str, content: bytes) -> None:
        self.memory.enclose(name, content, account=person, chat=f"chat of {person}")

    async def pinned(self, person: str) -> list[str]:
        return self.memory.pinned.get(self.chat(person).id, [])

    async def unconfirmed(self) -> int:
        return len(self.memory.unconfirmed())

    @asynccontextmanager
    async def outage(self) -> AsyncIterator[None]:
        self.memory.down = True
        yield
        self.memory.down = False


class TelegramStage:
    """People in the strict stand-in for Telegram, with its flood limits."""

    patience_s = 60.0
    keeps = True
    taps = True
    unusual: tuple[MessageValidity, ...] = UNUSUAL

    def __init__(self, server: FakeTelegram) -> None:
        self.server = server
        self.accounts = {name: server.create_user(name) for name in ("Ada", "Bob")}
        self.people: tuple[str, ...] = tuple(self.accounts)
        settings = {"token": server.token, "api_base": server.api_base}
        self.messenger: Messenger = telegram_messenger("lab", settings, HurriedClock())

    def chat(self, person: str) -> Chat:
        return Chat("telegram", str(self.accounts[person]))

    async def write(self, person: str, text: str) -> None:
        self.server.say(self.accounts[person], self.accounts[person], text)

    async def write_unusually(self, person: str, text: str, standing: MessageValidity) -> None:
        account, other = self.accounts[person], self.accounts["Bob"]
        if standing is MessageValidity.FORWARDED:
            self.server.say(account, account, text, forward_origin=other)
            return
        written = self.server.say(account, account, "hello")
        self.server.edit(account, written, text)

    async def tap(self, person: str, message: str, label: str) -> None:
        account = self.accounts[person]
        self.server.tap(account, account, int(message), label)

    async def screen(self, person: str) -> list[SeenMessage]:
        shown = self.server.messages(self.accounts[person], by_bot=True)
        return [
            SeenMessage(str(one["message_id"]), one["text"] or one.get("caption") or "")
            for one in shown
            if not one["deleted"]
        ]

    async def files(self, person: str) -> list[tuple[str, bytes]]:
        found = []
        for one in self.server.messages(self.accounts[person], by_bot=True):
            if one.get("document"):
                held = one["document"]
                found.append((held["file_name"], self.server.file(held["file_id"])))
            elif one.get("photo"):
                found.append(("", self.server.file(one["photo"][-1]["file_id"])))
        return found

    async def enclose(self, person: str, name: str, content: bytes) -> None:
        self.server.send_file(self.accounts[person], self.accounts[person], name, content)

    async def pinned(self, person: str) -> list[str]:
        shown = self.server.messages(self.accounts[person], by_bot=True)
        return [str(one["message_id"]) for one in shown if one["pinned"]]

    async def unconfirmed(self) -> int:
        return self.server.pending()

    @asynccontextmanager
    async def outage(self) -> AsyncIterator[None]:
        self.server.fail("bad_gateway", "*", times=10_000)
        yield
        self.server.calm()


@asynccontextmanager
async def telegram_stage() -> AsyncIterator[TelegramStage]:
    async with FakeTelegram() as server:
        yield TelegramStage(server)
        assert server.violations == []
