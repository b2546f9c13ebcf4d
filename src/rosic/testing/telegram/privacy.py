"""Which messages a bot hears of.

https://core.telegram.org/bots/features#privacy-mode and
https://core.telegram.org/bots/faq#what-messages-will-my-bot-get.
"""

from __future__ import annotations

from rosic.testing.telegram.entities import cut
from rosic.testing.telegram.state import (
    ANONYMOUS_ADMIN_ID,
    CHANNEL_BOT_ID,
    Message,
    ServerChat,
    State,
)

SERVICE_FIELDS = frozenset(
    {
        "new_chat_members",
        "left_chat_member",
        "new_chat_title",
        "group_chat_created",
        "supergroup_chat_created",
        "migrate_to_chat_id",
        "migrate_from_chat_id",
        "pinned_message",
        "forum_topic_created",
    }
)

ADMINS = frozenset({"creator", "administrator"})
PRESENT = ADMINS | {"member", "restricted"}
STAND_INS = frozenset({ANONYMOUS_ADMIN_ID, CHANNEL_BOT_ID})


def visible(message: Message, chat: ServerChat, state: State, *, private: bool) -> bool:
    """Say whether the bot gets an update about this message.

    With `private`, privacy mode is on for the bot.
    """
    author = state.users.get(message.from_id or 0)
    if author is not None and author.is_bot and author.id not in STAND_INS:
        # "Bots will not be able to see messages from other bots", nor their own.
        return False
    if chat.kind == "private":
        return True
    status = chat.members.get(state.bot.id, "left")
    if status not in PRESENT:
        return False
    if chat.kind == "channel" or status in ADMINS or not private:
        # "Bots that were added to the group as admins always receive all messages."
        return True
    return _meant_for(message, chat, state)


def _meant_for(message: Message, chat: ServerChat, state: State) -> bool:
    """Say what privacy mode lets through: service messages, commands, replies, mentions.

    That a mention of the bot gets through is common experience; Telegram's list does not name it.
    """
    if SERVICE_FIELDS & set(message.extra):
        return True
    if (message.extra.get("via_bot") or {}).get("id") == state.bot.id:
        return True
    replied = state.messages.get(chat.id, {}).get(message.reply_to or 0)
    if replied is not None and replied.from_id == state.bot.id:
        return True
    return _names_bot(message, chat, state)


def _names_bot(message: Message, chat: ServerChat, state: State) -> bool:
    content = message.content
    text = content.text or content.caption or ""
    own = f"@{state.bot.username}".lower()
    for entity in content.entities or content.caption_entities:
        part = cut(text, entity["offset"], entity["length"]).lower()
        if entity["type"] == "mention" and part == own:
            return True
        if entity["type"] == "text_mention" and entity["user"]["id"] == state.bot.id:
            return True
        if entity["type"] == "bot_command" and _is_own_command(part, own, chat, state):
            return True
    return False


def _is_own_command(command: str, own: str, chat: ServerChat, state: State) -> bool:
    """`/stop@this_bot` always; a bare `/stop` "if the bot was the last bot to send a message"."""
    _, at, addressed = command.partition("@")
    if at:
        return f"@{addressed}" == own
    return chat.last_bot_id in {None, state.bot.id}
