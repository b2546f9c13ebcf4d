"""The pretended Telegram as one object: state, clock, queue, record, and what both sides share."""

from __future__ import annotations

from typing import TYPE_CHECKING

import msgspec

from rosic.testing.telegram import objects, privacy
from rosic.testing.telegram.state import (
    ANONYMOUS_ADMIN_ID,
    CHANNEL_BOT_ID,
    SERVICE_ID,
    JsonObject,
    Message,
    ServerChat,
    State,
    User,
)
from rosic.testing.telegram.updates import UpdateQueue

if TYPE_CHECKING:
    from rosic.testing.telegram.journal import Journal
    from rosic.testing.telegram.limits import Limiter
    from rosic.testing.telegram.settings import ServerClock, Settings

PRESENT = frozenset({"creator", "administrator", "member", "restricted"})


class World:
    """Everything behind the two doors of the server, the bot's and the test's."""

    def __init__(
        self,
        state: State,
        clock: ServerClock,
        journal: Journal,
        limiter: Limiter,
        settings: Settings,
    ) -> None:
        self.state = state
        self.clock = clock
        self.journal = journal
        self.limiter = limiter
        self.settings = settings
        self.queue = UpdateQueue(state, clock, journal, settings)
        self.started_s = clock.now_s()

    @property
    def bot(self) -> User:
        """The bot itself."""
        return self.state.bot

    def serial(self) -> int:
        """Return a number never returned before."""
        return self.state.next_serial()

    def new_message_id(self, chat: ServerChat) -> int:
        """Return the next id in this chat.

        Private chats and basic groups of one bot share a counter, supergroups and channels have
        their
        own: an id alone names no message. Telegram's docs say only "inside this chat"
        (https://core.telegram.org/bots/api#message); the rest is common experience.
        """
        counter = chat.id if chat.kind in {"supergroup", "channel"} else 0
        self.state.counters[counter] = self.state.counters.get(counter, 0) + 1
        return self.state.counters[counter]

    def keep(self, message: Message) -> Message:
        """Put a new message into its chat."""
        self.state.messages.setdefault(message.chat_id, {})[message.message_id] = message
        return message

    def find(self, chat_id: int, message_id: int) -> Message | None:
        """Return a message that was not deleted."""
        message = self.state.messages.get(chat_id, {}).get(message_id)
        return None if message is None or message.deleted else message

    def bot_status(self, chat: ServerChat) -> str:
        """Return the bot's own status in a chat; "left" when it never was there."""
        return chat.members.get(self.bot.id, "left")

    def announce(self, message: Message, *, edited: bool = False) -> int | None:
        """Queue the update about what somebody else wrote, if this bot may see it.

        Returns:
            The update_id, or None when the bot does not hear of it.
        """
        chat = self.state.chats[message.chat_id]
        if not privacy.visible(message, chat, self.state, private=self.settings.privacy):
            return None
        kind = "channel_post" if chat.kind == "channel" else "message"
        written = message.edit_date if edited and message.edit_date is not None else message.date
        return self.queue.put(
            f"edited_{kind}" if edited else kind,
            objects.message(message, self.state),
            written + self.settings.update_lifetime_s,
        )


def new_state(settings: Settings, bot_id: int) -> State:
    """Return a Telegram where nobody is yet, except Telegram's own accounts and the bot."""
    bot = User(
        id=bot_id,
        first_name=settings.bot_name,
        username=settings.bot_username,
        is_bot=True,
    )
    own = [
        bot,
        User(id=SERVICE_ID, first_name="Telegram"),
        User(id=ANONYMOUS_ADMIN_ID, first_name="Group", username="GroupAnonymousBot", is_bot=True),
        User(id=CHANNEL_BOT_ID, first_name="Channel", username="Channel_Bot", is_bot=True),
    ]
    return State(bot=bot, users={account.id: account for account in own})


def load_state(content: bytes) -> State:
    """Read a state written by `dump_state`."""
    state = msgspec.json.decode(content, type=State)
    state.users[state.bot.id] = state.bot
    return state


def dump_state(world: World) -> bytes:
    """Return the whole state as JSON, the token excepted."""
    return msgspec.json.encode(
        msgspec.structs.replace(world.state, clock_shift_s=world.clock.shift_s)
    )


def full_chat(chat: ServerChat, state: State) -> JsonObject:
    """https://core.telegram.org/bots/api#chatfullinfo."""
    shown = objects.chat(chat, state)
    shown |= {
        "accent_color_id": chat.id % 7,
        "max_reaction_count": 11,
        "accepted_gift_types": dict.fromkeys(
            (
                "unlimited_gifts",
                "limited_gifts",
                "unique_gifts",
                "premium_subscription",
                "gifts_from_channels",
            ),
            False,
        ),
    }
    if chat.linked_chat_id is not None:
        shown["linked_chat_id"] = chat.linked_chat_id
    pinned = [state.messages[chat.id][pin] for pin in chat.pinned]
    if pinned:
        shown["pinned_message"] = objects.message(pinned[-1], state)
    return shown
