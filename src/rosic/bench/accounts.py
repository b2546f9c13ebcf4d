"""Where the paper's algorithms send: to the stand-in, by a real bot, or by a real account.

Secrets come from the environment alone: a command line is seen by everybody on the machine.
"""

from __future__ import annotations

import os
from contextlib import AsyncExitStack, asynccontextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, Protocol

from rosic.bench.bot_api_process import TOKEN, stand_in
from rosic.bench.hops import PAPER_BITS_PER_S, PAPER_ROUND_TRIP_S
from rosic.errors import ConfigurationError, how_to_install
from rosic.messengers.telegram.bot_client import BotClient
from rosic.messengers.telegram.errors import ErrorKind, TelegramError
from rosic.messengers.telegram.settings import API_BASE, read_settings

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Callable

STAND_IN: Final = "stand-in"
BOT: Final = "bot"
ACCOUNT: Final = "account"
BOT_TOKEN: Final = "ROSIC_BENCH_TOKEN"  # noqa: S105 - of the environment, not the token itself
BOT_CHAT: Final = "ROSIC_BENCH_CHAT"
API_ID: Final = "ROSIC_BENCH_API_ID"
API_HASH: Final = "ROSIC_BENCH_API_HASH"
SESSION: Final = "rosic-bench"
"""As the paper's ``session_name``: Telethon keeps a file of it, which is as good as a password."""
ME: Final = "me"
UNKNOWN_BOT: Final = "The Bot API does not know this token: look at {name}."
NO_NETWORK: Final = "The Bot API does not answer: {why}"
NOT_SET: Final = "Set {names} in the environment first."
NO_TELETHON: Final = "A real account needs Telethon, which is not installed."
NOT_SENT: Final = "A message did not go through: {why}"
METHODS: Final = {
    STAND_IN: "Sent by the Bot API client of ROSIC to a stand-in of Telegram's server in a process "
    "of its own, over a network of 26 Mbit/s and 60 ms there and back, without limits.",
    BOT: "Sent by a real bot to a chat of it, over the Bot API.",
    ACCOUNT: "Sent by a real account to itself by Telethon, as the paper did.",
}


class MessageSender(Protocol):
    """What sends a message to somebody, and is connected while it does."""

    async def connect(self) -> None:
        """Connect, and find out whether it is let in.

        Raises:
            ConfigurationError: It is not, or nobody answers.
        """
        ...

    async def send(self, text: str) -> None:
        """Send a message, and wait until the server has it.

        Raises:
            ConnectionError: It did not go through; says why.
        """
        ...

    async def disconnect(self) -> None:
        """Let go of the connection."""
        ...


class BotSender:
    """Sends by a bot, through the client that ROSIC itself speaks through.

    Args:
        token: Of the bot.
        chat: Which chat.
        api_base: Of the server.
    """

    def __init__(self, token: str, chat: str, *, api_base: str = API_BASE) -> None:
        self._client = BotClient(read_settings("bench", {"token": token, "api_base": api_base}))
        self._chat = chat
        self._held = AsyncExitStack()

    async def connect(self) -> None:
        """Connect, and ask who the bot is."""
        await self._held.enter_async_context(self._client.held())
        try:
            await self._client.ask(lambda bot: bot.get_me())
        except TelegramError as trouble:
            await self._held.aclose()
            if trouble.kind is ErrorKind.UNUSABLE:
                raise ConfigurationError(UNKNOWN_BOT.format(name=BOT_TOKEN)) from trouble
            raise ConfigurationError(NO_NETWORK.format(why=trouble)) from trouble

    async def send(self, text: str) -> None:
        """Send it to the chat."""
        try:
            await self._client.ask(lambda bot: bot.send_message(self._chat, text))
        except TelegramError as trouble:
            raise ConnectionError(NOT_SENT.format(why=trouble)) from trouble

    async def disconnect(self) -> None:
        """Close the connection."""
        await self._held.aclose()


class AccountSender:
    """Sends by somebody's own account to itself, by Telethon, as Algorithm 9 does.

    Args:
        make: Makes a client as `telethon.TelegramClient` is.
    """

    def __init__(self, make: Callable[[], Any]) -> None:
        self._make = make
        self._client: Any = None

    async def connect(self) -> None:
        """Make a client and start it: the first time it asks for a number and a code."""
        self._client = self._make()
        try:
            await self._client.start()
        except Exception as trouble:  # a library's own, of many kinds
            raise ConfigurationError(NO_NETWORK.format(why=trouble)) from trouble

    async def send(self, text: str) -> None:
        """Send it to oneself."""
        try:
            await self._client.send_message(ME, text)
        except Exception as trouble:  # a library's own, of many kinds
            raise ConnectionError(NOT_SENT.format(why=trouble)) from trouble

    async def disconnect(self) -> None:
        """Disconnect the client."""
        await self._client.disconnect()


def from_environment(*names: str) -> tuple[str, ...]:
    """Return what the environment says.

    Raises:
        ConfigurationError: Something is not set; names all that is missing.
    """
    missing = [name for name in names if not os.environ.get(name)]
    if missing:
        raise ConfigurationError(NOT_SET.format(names=" and ".join(missing)))
    return tuple(os.environ[name] for name in names)


def telethon_client() -> Any:  # noqa: ANN401 - of an extra, which is not typed
    """Return Telethon's client for the account of the environment.

    Raises:
        ConfigurationError: It is not installed, or the environment does not say whose it is.
    """
    try:
        from telethon import TelegramClient  # noqa: PLC0415 - an extra
    except ImportError:
        raise ConfigurationError(NO_TELETHON, hint=f"Run: {how_to_install('account')}") from None
    api_id, api_hash = from_environment(API_ID, API_HASH)
    if not api_id.isdecimal():
        raise ConfigurationError(f"{API_ID} is a number: see https://my.telegram.org.")
    # As good as a password, once somebody has signed in: nobody else of this machine reads it.
    Path(f"{SESSION}.session").touch(mode=0o600)
    return TelegramClient(SESSION, int(api_id), api_hash)


@asynccontextmanager
async def sender(over: str) -> AsyncIterator[MessageSender]:
    """Yield what sends: not connected yet.

    Args:
        over: ``stand-in``, ``bot`` or ``account``.

    Raises:
        ConfigurationError: Something is not set or not installed.
    """
    if over == BOT:
        token, chat = from_environment(BOT_TOKEN, BOT_CHAT)
        yield BotSender(token, chat)
    elif over == ACCOUNT:
        telethon_client()  # says at once what is missing
        yield AccountSender(telethon_client)
    else:
        async with stand_in() as control:
            await control.call("set_limits", limits=None)
            await control.call(
                "set_latency", seconds=PAPER_ROUND_TRIP_S, bits_per_s=PAPER_BITS_PER_S
            )
            person = await control.create_user("Person")
            yield BotSender(TOKEN, str(person), api_base=control.api_base)
