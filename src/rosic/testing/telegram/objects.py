"""Telegram's objects as they look on the wire (https://core.telegram.org/bots/api#available-types)."""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rosic.testing.telegram.state import (
        ButtonPress,
        Content,
        JsonObject,
        Message,
        ServerChat,
        State,
        User,
    )


ICON_COLOUR = 7_322_096
"""Of a topic; the first of the six that Telegram has."""


def user(who: User) -> JsonObject:
    """https://core.telegram.org/bots/api#user."""
    shown: JsonObject = {"id": who.id, "is_bot": who.is_bot, "first_name": who.first_name}
    for field in ("last_name", "username", "language_code"):
        if (value := getattr(who, field)) is not None:
            shown[field] = value
    return shown


def chat(where: ServerChat, state: State) -> JsonObject:
    """https://core.telegram.org/bots/api#chat."""
    shown: JsonObject = {"id": where.id, "type": where.kind}
    if where.kind == "private":
        who = user(state.users[where.id])
        shown |= {k: who[k] for k in ("first_name", "last_name", "username") if k in who}
        return shown
    shown["title"] = where.title or ""
    if where.username:
        shown["username"] = where.username
    if where.is_forum:
        shown["is_forum"] = True
    return shown


def message(what: Message, state: State, *, with_reply: bool = True) -> JsonObject:
    """https://core.telegram.org/bots/api#message.

    The replied-to message is shown without its own reply: "will not contain further
    reply_to_message fields even if it itself is a reply".
    """
    shown: JsonObject = {"message_id": what.message_id}
    if what.from_id is not None:
        shown["from"] = user(state.users[what.from_id])
    if what.sender_chat_id is not None:
        shown["sender_chat"] = chat(state.chats[what.sender_chat_id], state)
    shown["chat"] = chat(state.chats[what.chat_id], state)
    shown["date"] = what.date
    if what.edit_date is not None:
        shown["edit_date"] = what.edit_date
    if what.thread_id is not None:
        shown |= {"message_thread_id": what.thread_id, "is_topic_message": True}
        if with_reply and what.reply_to is None:
            shown |= _beginning(what, state)
    if with_reply and what.reply_to is not None:
        replied = state.messages[what.chat_id].get(what.reply_to)
        if replied is not None and not replied.deleted:
            shown["reply_to_message"] = message(replied, state, with_reply=False)
    return {**shown, **content(what.content), **what.extra}


def _beginning(what: Message, state: State) -> JsonObject:
    """Return what a message in a topic replies to where it replies to nothing: the topic's start.

    A topic is the thread of the service message that created it
    (https://core.telegram.org/api/forum), so every message in it answers at least that one.
    """
    where, thread = state.chats[what.chat_id], what.thread_id
    if thread is None or thread not in where.topics_by:
        return {}
    began = {
        "message_id": thread,
        "from": user(state.users[where.topics_by[thread]]),
        "chat": chat(where, state),
        "date": what.date,
        "message_thread_id": thread,
        "is_topic_message": True,
        "forum_topic_created": {"name": where.topics[thread], "icon_color": ICON_COLOUR},
    }
    return {"reply_to_message": began}


def content(what: Content) -> JsonObject:
    """Return the fields of a message that an edit can change."""
    shown: JsonObject = {}
    if what.text is not None:
        shown["text"] = what.text
    if what.entities:
        shown["entities"] = what.entities
    shown |= what.media
    if what.caption:
        shown["caption"] = what.caption
    if what.caption_entities:
        shown["caption_entities"] = what.caption_entities
    if what.reply_markup and "inline_keyboard" in what.reply_markup:
        shown["reply_markup"] = what.reply_markup
    return shown


def callback_query(query: ButtonPress, state: State) -> JsonObject:
    """https://core.telegram.org/bots/api#callbackquery; it has no date.

    A message that was deleted is shown as https://core.telegram.org/bots/api#inaccessiblemessage.
    """
    where = state.chats[query.chat_id]
    pressed = state.messages[query.chat_id][query.message_id]
    if pressed.deleted:
        seen: JsonObject = {
            "chat": chat(where, state),
            "message_id": query.message_id,
            "date": 0,
        }
    else:
        seen = message(pressed, state)
    return {
        "id": query.id,
        "from": user(state.users[query.user_id]),
        "message": seen,
        "chat_instance": where.instance,
        "data": query.data,
    }


def reacted(
    what: Message, state: State, who: int, old: list[str], *, anonymous: bool
) -> tuple[str, JsonObject]:
    """Return which update tells of a new reaction, and that update, without its date.

    https://core.telegram.org/bots/api#messagereactionupdated names a user, or the chat in whose
    name somebody anonymous reacted; #messagereactioncountupdated counts where nobody is named.
    """
    where = state.chats[what.chat_id]
    shown: JsonObject = {"chat": chat(where, state), "message_id": what.message_id}
    if where.kind == "channel":
        counted = Counter(one for several in what.reactions.values() for one in several)
        shown["reactions"] = [
            {"type": _emoji(one), "total_count": count} for one, count in counted.items()
        ]
        return "message_reaction_count", shown
    if anonymous:
        shown["actor_chat"] = shown["chat"]
    else:
        shown["user"] = user(state.users[who])
    shown["old_reaction"] = [_emoji(one) for one in old]
    shown["new_reaction"] = [_emoji(one) for one in what.reactions[who]]
    return "message_reaction", shown


def _emoji(emoji: str) -> JsonObject:
    """https://core.telegram.org/bots/api#reactiontypeemoji."""
    return {"type": "emoji", "emoji": emoji}


def member(who: User, status: str, withheld: Sequence[str] = ()) -> JsonObject:
    """https://core.telegram.org/bots/api#chatmember, in the form that belongs to the status."""
    shown: JsonObject = {"user": user(who), "status": status}
    if status == "creator":
        shown["is_anonymous"] = False
    elif status == "administrator":
        shown |= {right: right not in withheld for right in ADMIN_RIGHTS}
        shown |= {"can_be_edited": False, "is_anonymous": False}
    elif status == "restricted":
        shown |= {"is_member": True, "until_date": 0} | dict.fromkeys(MEMBER_RIGHTS, False)
    elif status == "kicked":
        shown["until_date"] = 0
    return shown


ADMIN_RIGHTS = (
    "can_manage_chat",
    "can_delete_messages",
    "can_manage_video_chats",
    "can_restrict_members",
    "can_promote_members",
    "can_change_info",
    "can_invite_users",
    "can_post_stories",
    "can_edit_stories",
    "can_delete_stories",
    "can_send_welcome_messages",
    "can_pin_messages",
    "can_post_messages",
    "can_edit_messages",
)
"""https://core.telegram.org/bots/api#chatmemberadministrator."""

MEMBER_RIGHTS = (
    "can_send_messages",
    "can_send_audios",
    "can_send_documents",
    "can_send_photos",
    "can_send_videos",
    "can_send_video_notes",
    "can_send_voice_notes",
    "can_send_polls",
    "can_send_other_messages",
    "can_add_web_page_previews",
    "can_change_info",
    "can_invite_users",
    "can_pin_messages",
    "can_manage_topics",
    "can_react_to_messages",
    "can_edit_tag",
)
"""https://core.telegram.org/bots/api#chatmemberrestricted."""
