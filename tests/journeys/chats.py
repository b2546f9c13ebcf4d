"""Private chats of people with a gateway, whichever messenger they have."""

from __future__ import annotations

from contextlib import asynccontextmanager
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol

from rosic.testing.telegram.newcomer import ChatReader
from tests.journeys.fleet import TOKEN
from tests.journeys.running import WITHIN_S, fake_telegram

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Callable, Sequence
    from pathlib import Path

    from tests.journeys.running import Launcher


class ShownMessage(NamedTuple):
    """A message of the gateway, as a person sees it now.

    Attributes:
        reply_to: Which message it answers; empty for none.
        place: How many of the gateway's stand above it.
        labels: Of its buttons.
        picture: It shows one.
    """

    id: str
    text: str
    reply_to: str
    place: int
    labels: tuple[str, ...]
    picture: bool


class PrivateChats(Protocol):
    """What people do in one messenger.

    Attributes:
        messenger: The table of the configuration that reaches it, called `lab`.
    """

    messenger: str

    async def open(self, people: Sequence[str]) -> None:
        """Give each an account."""

    def address(self, name: str) -> str:
        """Return by which address a configuration knows somebody."""

    async def meet(self) -> None:
        """Open everybody's chat with a gateway that listens."""

    async def say(self, name: str, text: str) -> str:
        """Have somebody write; return the message."""

    async def messages(self, name: str) -> list[ShownMessage]:
        """Return what the gateway shows somebody, oldest first."""

    async def tap(self, name: str, message: ShownMessage, label: str) -> None:
        """Have somebody tap a button."""

    async def until(self, name: str, look: Callable[[], Any]) -> Any:  # noqa: ANN401
        """Look after each change of somebody's chat until something is found; else None."""

    async def settle(self) -> None:
        """Say in the end what a correct client would not have done."""


class TelegramChats:
    """People at the fake Bot API server."""

    def __init__(self, place: ChatReader) -> None:
        self.messenger = f'kind = "telegram"\ntoken = "{TOKEN}"\napi_base = "{place.control.url}"\n'
        self._place = place
        self._accounts: dict[str, int] = {}

    async def open(self, people: Sequence[str]) -> None:
        for name in people:
            self._accounts[name] = await self._place.control.create_user(name)

    def address(self, name: str) -> str:
        return f"telegram:{self._accounts[name]}"

    async def meet(self) -> None:
        """They are open."""

    async def say(self, name: str, text: str) -> str:
        return str(await self._place.say(self._accounts[name], text))

    async def messages(self, name: str) -> list[ShownMessage]:
        found = await self._place.control.messages(self._accounts[name], by_bot=True)
        return [_shown(message, place) for place, message in enumerate(found)]

    async def tap(self, name: str, message: ShownMessage, label: str) -> None:
        account = self._accounts[name]
        await self._place.control.tap(account, account, int(message.id), label)

    async def until(self, name: str, look: Callable[[], Any]) -> Any:  # noqa: ANN401
        del name  # the server tells of all changes
        return await self._place.until(look)

    async def settle(self) -> None:
        assert await self._place.control.violations() == []


def _shown(message: dict[str, Any], place: int) -> ShownMessage:
    return ShownMessage(
        id=str(message["message_id"]),
        text=message["text"] or "",
        reply_to=str(message["reply_to"] or ""),
        place=place,
        labels=tuple(one["text"] for row in message.get("buttons") or [] for one in row),
        picture=bool(message["photo"]),
    )


@asynccontextmanager
async def telegram_chats(folder: Path, launcher: Launcher) -> AsyncIterator[TelegramChats]:
    """Run the server while inside."""
    async with fake_telegram(folder, launcher, "--no-limits", "--no-privacy") as control:
        yield TelegramChats(ChatReader(control, WITHIN_S))
