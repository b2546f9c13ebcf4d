"""The server as one object, embedded in a test or run by `python -m rosic.testing.telegram`."""

from __future__ import annotations

import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING, Self

import msgspec
from aiohttp import web

from rosic.testing.telegram import keyboards, objects
from rosic.testing.telegram.control_door import ControlDoor
from rosic.testing.telegram.door import BotDoor
from rosic.testing.telegram.faults import ServerFault, ServerFaults
from rosic.testing.telegram.groups import Groups
from rosic.testing.telegram.journal import Journal
from rosic.testing.telegram.limits import Limiter
from rosic.testing.telegram.people import People
from rosic.testing.telegram.refusals import ControlError
from rosic.testing.telegram.settings import Limits, ServerClock, Settings
from rosic.testing.telegram.world import World, dump_state, load_state, new_state

if TYPE_CHECKING:
    from collections.abc import Callable, Collection
    from types import TracebackType

    from rosic.testing.telegram.state import ButtonPress, Content, JsonObject, Message


# ---- record ----

# The record, for tests: what people see, and what the bot did.


class ServerRecord:
    """The control side's eyes."""

    world: World

    @property
    def violations(self) -> list[JsonObject]:
        """What no correct client does: unknown methods and parameters, wrong types, impatience."""
        return self.world.journal.violations

    @property
    def calls(self) -> list[JsonObject]:
        """Every call: `seq`, `time_s`, `method`, `parameters`, `code`, `description`, `fault`."""
        return self.world.journal.calls

    @property
    def seq(self) -> int:
        """The number of the newest change; give it to `wait`."""
        return self.world.journal.seq

    def message(self, chat: int, message: int) -> JsonObject:
        """Return one message as the person sees it, with its history; deleted ones too."""
        found = self.world.state.messages.get(chat, {}).get(message)
        if found is None:
            raise ControlError(f"there is no message {message} in chat {chat}")
        return self._seen(found)

    def messages(self, chat: int, *, by_bot: bool = False, after: int = 0) -> list[JsonObject]:
        """Return the messages of a chat after one, oldest first, or only the bot's own."""
        kept = self.world.state.messages.get(chat, {}).values()
        later = (m for m in kept if m.message_id > after)
        return [self._seen(m) for m in later if not by_bot or self._by_bot(m)]

    def press(self, query_id: str) -> JsonObject:
        """Return one press of a button and every answer the bot gave."""
        return self._pressed(self.world.state.queries[query_id])

    def presses(self, chat: int) -> list[JsonObject]:
        """Return every press of a button in a chat, oldest first."""
        queries = self.world.state.queries.values()
        return [self._pressed(query) for query in queries if query.chat_id == chat]

    def _pressed(self, query: ButtonPress) -> JsonObject:
        return {
            "id": query.id,
            "user_id": query.user_id,
            "chat_id": query.chat_id,
            "message_id": query.message_id,
            "data": query.data,
            "pressed_s": query.pressed_s,
            "answers": query.answers,
        }

    def file(self, file_id: str) -> bytes:
        """Return the content of a file that Telegram holds."""
        held = self.world.state.files[file_id]
        return Path(held.left).read_bytes() if held.left else held.content

    def pending(self) -> int:
        """Return how many updates the bot has not confirmed."""
        return len(self.world.queue)

    def changes(self, after: int = 0, kinds: Collection[str] = ()) -> list[JsonObject]:
        """Return what happened after the change numbered `after`."""
        return self.world.journal.since(after, kinds)

    async def wait(
        self, after: int, timeout_s: float = 10.0, kinds: Collection[str] = ()
    ) -> list[JsonObject]:
        """Return what happened after change `after`, waiting for the first; [] if none came."""
        return await self.world.journal.wait(after, timeout_s, kinds)

    def clear_record(self) -> None:
        """Forget calls, violations and changes; messages stay."""
        self.world.journal.clear()

    def _by_bot(self, message: Message) -> bool:
        return message.own or message.from_id == self.world.bot.id

    def _seen(self, message: Message) -> JsonObject:
        chat = self.world.state.chats[message.chat_id]
        author = self.world.state.users.get(message.from_id or 0)
        return {
            "chat_id": message.chat_id,
            "message_id": message.message_id,
            "from": None if author is None else author.id,
            "from_name": None if author is None else author.first_name,
            "by_bot": self._by_bot(message),
            "sender_chat": message.sender_chat_id,
            "date": message.date,
            "edit_date": message.edit_date,
            "reply_to": message.reply_to,
            "thread": message.thread_id,
            "deleted": message.deleted,
            "silent": message.silent,
            "pinned": message.message_id in chat.pinned,
            "reactions": {str(who): emoji for who, emoji in message.reactions.items()},
            "extra": message.extra,
            **_version(message.content),
            "versions": [_version(version) for version in message.versions],
        }


def _version(content: Content) -> JsonObject:
    """Return one form of a message; `received_s` is when the server got it."""
    shown = objects.content(content)
    return {
        "text": content.text if content.text is not None else content.caption,
        "entities": content.entities or content.caption_entities,
        "photo": shown.get("photo"),
        "document": shown.get("document"),
        "animation": shown.get("animation"),
        "buttons": [
            [dict(button) for button in row]
            for row in (content.reply_markup or {}).get("inline_keyboard", [])
        ],
        "callback_data": [
            button["callback_data"]
            for button in keyboards.buttons(content.reply_markup)
            if "callback_data" in button
        ],
        "reply_markup": content.reply_markup,
        "received_s": content.received_s,
    }


# ---- server ----

# ---- trouble for tests ----


class ServerSwitches:
    """The control side's switches. All are off at first, except the limits."""

    world: World
    faults: ServerFaults

    def fail(self, kind: str, method: str = "*", times: int = 1, **details: object) -> None:
        """Let the next `times` calls of a method fail; see `ServerFault` for kinds and details."""
        try:
            order = {"kind": kind, "method": method, "times": times, **details}
            self.faults.orders.append(msgspec.convert(order, ServerFault))
        except msgspec.ValidationError as error:
            raise ControlError(str(error)) from None

    def calm(self) -> None:
        """End all faults and the latency."""
        self.faults.clear()

    def set_latency(self, seconds: float, bits_per_s: float = 0.0) -> None:
        """Add this to every call, half before and half after it takes effect."""
        self.faults.slow_down(seconds, bits_per_s)

    def set_limits(self, limits: JsonObject | Limits | None) -> None:
        """Choose other flood limits, starting anew; None switches them off."""
        chosen = msgspec.convert(limits, Limits) if isinstance(limits, dict) else limits
        self.world.limiter.set(chosen)

    def advance(self, seconds: float) -> None:
        """Move the server's time; retention, limits and dates follow."""
        self.world.clock.advance(seconds)

    def shift_dates(self, seconds: float) -> None:
        """Put dates on new messages that are off by this much: a platform whose clock is wrong."""
        self.world.clock.shift_dates(seconds)

    def duplicate(self, *, new_id: bool = False) -> None:
        """Queue the next update twice, under the same update_id or a new one."""
        self.world.queue.duplicate_next(new_id=new_id)

    def reorder(self) -> None:
        """Give the next two or more updates in reversed order."""
        self.world.queue.reverse_next()

    def jump(self, next_update_id: int) -> None:
        """Choose the next update_id; lower ones too, while none waits."""
        self.world.queue.jump(next_update_id)

    def put_update(self, kind: str, payload: JsonObject) -> int | None:
        """Queue any update whatever, for what this server does not model (polls, payments)."""
        lifetime_s = self.world.settings.update_lifetime_s
        return self.world.queue.put(kind, payload, self.world.clock.now_s() + lifetime_s)

    def foreign_webhook(self, url: str) -> None:
        """Set a webhook as a thief of the token would, or remove it with ""."""
        if url:
            self.world.queue.expel()
        self.world.state.webhook.redirect(url)


DEFAULT_TOKEN = "4242424242:not-a-real-token-for-tests-only"  # noqa: S105 - it opens nothing
PUBLISHED = Limits()
USUAL = Settings()
MAX_REQUEST = 64 * 1024 * 1024
STOP_WITHIN_S = 0.5


def to_stderr(line: str) -> None:
    """Report a violation where a developer sees it."""
    sys.stderr.write(f"telegram: {line}\n")
    sys.stderr.flush()


class FakeTelegram(People, Groups, ServerSwitches, ServerRecord):
    """A strict Bot API server on a port of its own.

    Args:
        token: The one token that works; the number before its colon is the bot's id.
        port: 0 takes a free one.
        limits: Flood limits; None switches them off.
        settings: The bot and Telegram's times.
        state_file: Read when the server starts, if it exists, and written when it stops: an outage.
        wall_s: The clock below the server's own.

    Attributes:
        host: Where to listen; choose before `start`.
        report: Given one line for each violation; standard error at first.
    """

    host = "127.0.0.1"

    def __init__(
        self,
        *,
        token: str = DEFAULT_TOKEN,
        port: int = 0,
        limits: Limits | None = PUBLISHED,
        settings: Settings = USUAL,
        state_file: Path | None = None,
        wall_s: Callable[[], float] = time.time,
    ) -> None:
        self.token = token
        self.port = port
        self.report: Callable[[str], None] = to_stderr
        self.faults = ServerFaults()
        self._state_file = state_file
        self._runner: web.AppRunner | None = None
        self._door: BotDoor | None = None
        state = new_state(settings, int(token.partition(":")[0]))
        if state_file is not None and state_file.exists():
            state = load_state(state_file.read_bytes())
        clock = ServerClock(wall_s, state.clock_shift_s)
        journal = Journal(clock, self._tell)
        self.world = World(state, clock, journal, Limiter(limits), settings)

    def _tell(self, line: str) -> None:
        self.report(line)

    @property
    def url(self) -> str:
        """The server's root, for aiogram's `TelegramAPIServer.from_base`."""
        return f"http://{self.host}:{self.port}"

    @property
    def api_base(self) -> str:
        """For python-telegram-bot's `base_url`; the token follows directly."""
        return f"{self.url}/bot"

    @property
    def file_base(self) -> str:
        """For python-telegram-bot's `base_file_url`; the token follows directly."""
        return f"{self.url}/file/bot"

    async def start(self) -> None:
        """Listen. The port is known afterwards.

        Raises:
            OSError: The port is taken.
        """
        app = web.Application(client_max_size=MAX_REQUEST)
        self._door = BotDoor(self.world, self.faults, self.token)
        app.add_routes(self._door.routes())
        app.add_routes(ControlDoor(self).routes())
        # No access log: paths hold the token.
        self._runner = web.AppRunner(app, access_log=None, shutdown_timeout=STOP_WITHIN_S)
        await self._runner.setup()
        site = web.TCPSite(self._runner, self.host, self.port)
        await site.start()
        self.port = int(self._runner.addresses[0][1])

    async def stop(self) -> None:
        """Stop within a second: waiting polls are answered with nothing, hangs end."""
        if self._door is not None:
            self._door.close()
        if self._runner is not None:
            await self._runner.cleanup()
        self.save()

    def save(self) -> None:
        """Write the state to its file, if one was given."""
        if self._state_file is None:
            return
        draft = self._state_file.with_name(self._state_file.name + ".new")
        draft.write_bytes(dump_state(self.world))
        draft.replace(self._state_file)

    async def __aenter__(self) -> Self:
        await self.start()
        return self

    async def __aexit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        await self.stop()
