"""The record, for tests: what people see, and what the bot did."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from rosic.testing.telegram import keyboards, objects
from rosic.testing.telegram.refusals import ControlError

if TYPE_CHECKING:
    from collections.abc import Collection

    from rosic.testing.telegram.state import ButtonPress, Content, JsonObject, Message
    from rosic.testing.telegram.world import World


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

    def messages(self, chat: int, *, by_bot: bool = False) -> list[JsonObject]:
        """Return all messages of a chat, oldest first, or only the bot's own."""
        kept = self.world.state.messages.get(chat, {}).values()
        return [self._seen(m) for m in kept if not by_bot or self._by_bot(m)]

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
