"""Sending, editing and deleting (https://core.telegram.org/bots/api#updating-messages)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import msgspec

from rosic.core.time_units import HOUR_S
from rosic.testing.telegram import entities, keyboards, markup, objects
from rosic.testing.telegram.methods.call import (
    ADMINS,
    Call,
    Method,
    message_of,
    present_in,
    require_admin,
    require_right,
    spend,
    unsupported,
    writable,
)
from rosic.testing.telegram.parameters import CallParameters, Kind
from rosic.testing.telegram.refusals import NOT_MODIFIED, bad_request
from rosic.testing.telegram.state import Content, JsonObject, Message, ServerChat

if TYPE_CHECKING:
    from rosic.testing.telegram.world import World

MAX_TEXT = 4096
MAX_CAPTION = 1024
DELETABLE_S = 48 * HOUR_S
CREATIONS = frozenset(
    {
        "group_chat_created",
        "supergroup_chat_created",
        "channel_chat_created",
        "forum_topic_created",
    }
)

SENDING = {
    "business_connection_id": Kind.TEXT,
    "chat_id": Kind.CHAT,
    "message_thread_id": Kind.INTEGER,
    "direct_messages_topic_id": Kind.INTEGER,
    "disable_notification": Kind.FLAG,
    "protect_content": Kind.FLAG,
    "allow_paid_broadcast": Kind.FLAG,
    "message_effect_id": Kind.TEXT,
    "suggested_post_parameters": Kind.OBJECT,
    "reply_parameters": Kind.OBJECT,
    "reply_markup": Kind.OBJECT,
}
FORMATTED = {"parse_mode": Kind.TEXT, "link_preview_options": Kind.OBJECT}
CAPTIONED = {
    "caption": Kind.TEXT,
    "parse_mode": Kind.TEXT,
    "caption_entities": Kind.ARRAY,
    "show_caption_above_media": Kind.FLAG,
}
ADDRESSED = {
    "business_connection_id": Kind.TEXT,
    "chat_id": Kind.CHAT,
    "message_id": Kind.INTEGER,
    "inline_message_id": Kind.TEXT,
    "reply_markup": Kind.OBJECT,
}
LACKING = (
    "business_connection_id",
    "direct_messages_topic_id",
    "suggested_post_parameters",
    "inline_message_id",
)
REPLY_FIELDS = frozenset(
    {
        "message_id",
        "chat_id",
        "allow_sending_without_reply",
        "quote",
        "quote_parse_mode",
        "quote_entities",
        "quote_position",
        "checklist_task_id",
        "poll_option_id",
    }
)
"""https://core.telegram.org/bots/api#replyparameters."""


def formatted(
    args: CallParameters, field: str, entity_field: str, most: int
) -> tuple[str, list[JsonObject]]:
    """Return text and entities as they are kept: parsed, trimmed, completed, checked for length.

    Lengths count UTF-16 code units "after entities parsing"
    (https://core.telegram.org/bots/api#sendmessage). That outer white space goes is the published
    server's.
    """
    text, given = args.text(field), args.array(entity_field)
    try:
        text.encode()
    except UnicodeEncodeError:
        raise bad_request("strings must be encoded in UTF-8") from None
    if mode := args.text("parse_mode"):
        text, marked = markup.parse(text, mode)
    else:
        marked = entities.checked(text, given or [])
    text, marked = markup.trimmed(text, marked)
    if entities.utf16_len(text) > most:
        raise bad_request(
            "message is too long" if field == "text" else "message caption is too long"
        )
    return text, entities.complete(text, marked)


def send_message(world: World, call: Call) -> JsonObject:
    """https://core.telegram.org/bots/api#sendmessage."""
    text, marked = formatted(call.args, "text", "entities", MAX_TEXT)
    if not text:
        raise bad_request("message text is empty")
    return sent(world, call, Content(text=text, entities=marked))


def sent(world: World, call: Call, content: Content) -> JsonObject:
    """Put the bot's message into the chat and return it as Telegram does."""
    refuse_lacking(world, call)
    keyboard = keyboards.checked(call.args.object("reply_markup"))
    chat = writable(world, call.args)
    reply_to = replied(world, call, chat)
    thread_id = topic(call.args, chat)
    spend(world, call, chat)
    received = msgspec.structs.replace(
        content, reply_markup=keyboard, received_s=world.clock.now_s()
    )
    message = world.keep(
        Message(
            chat_id=chat.id,
            message_id=world.new_message_id(chat),
            date=world.clock.date(),
            versions=[received],
            from_id=None if chat.kind == "channel" else world.bot.id,
            sender_chat_id=chat.id if chat.kind == "channel" else None,
            reply_to=reply_to,
            thread_id=thread_id,
            silent=call.args.flag("disable_notification"),
            own=True,
        )
    )
    chat.hear_bot(world.bot.id)
    world.journal.add("sent", chat_id=chat.id, message_id=message.message_id)
    return objects.message(message, world.state)


def replied(world: World, call: Call, chat: ServerChat) -> int | None:
    """Return the message to reply to (https://core.telegram.org/bots/api#replyparameters)."""
    parameters = call.args.object("reply_parameters")
    if not parameters:
        return None
    for field in set(parameters) - REPLY_FIELDS:
        world.journal.violation(call.method, f"unknown field {field!r} in reply_parameters")
    if parameters.get("chat_id") not in {None, chat.id} or "quote" in parameters:
        raise unsupported(world, call, "replying to another chat, or with a quote,")
    number = parameters.get("message_id")
    if type(number) is int and world.find(chat.id, number) is not None:
        return number
    if parameters.get("allow_sending_without_reply") is True:
        return None
    raise bad_request("message to be replied not found")


def topic(args: CallParameters, chat: ServerChat) -> int | None:
    """Return the topic that `message_thread_id` names (https://core.telegram.org/bots/api#sendmessage)."""
    if "message_thread_id" not in args:
        return None
    thread_id = args.integer("message_thread_id")
    if thread_id not in chat.topics:
        raise bad_request("message thread not found")
    return thread_id


def refuse_lacking(world: World, call: Call) -> None:
    """Refuse what Telegram has and this server does not."""
    for name in LACKING:
        if name in call.args:
            raise unsupported(world, call, name)


def edit_message_text(world: World, call: Call) -> JsonObject:
    """https://core.telegram.org/bots/api#editmessagetext; none given, the keyboard goes."""
    text, marked = formatted(call.args, "text", "entities", MAX_TEXT)
    if not text:
        raise bad_request("message text is empty")
    message = editable(world, call)
    if message.content.text is None:
        raise bad_request("there is no text in the message to edit")
    return edited(world, call, message, {"text": text, "entities": marked})


def edit_message_caption(world: World, call: Call) -> JsonObject:
    """https://core.telegram.org/bots/api#editmessagecaption."""
    caption, marked = formatted(call.args, "caption", "caption_entities", MAX_CAPTION)
    message = editable(world, call)
    if not message.content.media:
        raise bad_request("there is no caption in the message to edit")
    changes = {"caption": caption or None, "caption_entities": marked}
    return edited(world, call, message, changes)


def edit_message_reply_markup(world: World, call: Call) -> JsonObject:
    """https://core.telegram.org/bots/api#editmessagereplymarkup."""
    return edited(world, call, editable(world, call), {})


def editable(world: World, call: Call) -> Message:
    """Return a message of the bot's own; nobody else's can be edited.

    "it is currently only possible to edit messages without reply_markup or with inline keyboards"
    (https://core.telegram.org/bots/api#updating-messages).
    """
    refuse_lacking(world, call)
    chat = writable(world, call.args)
    message = message_of(world, call.args, chat, "message to edit")
    own = message.from_id == world.bot.id or chat.kind == "channel"
    markup_kept = message.content.reply_markup or {"inline_keyboard": []}
    if not own or "pinned_message" in message.extra or "inline_keyboard" not in markup_kept:
        raise bad_request("message can't be edited")
    return message


def edited(world: World, call: Call, message: Message, changes: dict[str, Any]) -> JsonObject:
    """Add a version to the message, unless it would be the same as the present one."""
    keyboard = keyboards.checked(call.args.object("reply_markup"), inline_only=True)
    spend(world, call, world.state.chats[message.chat_id])
    version = msgspec.structs.replace(
        message.content, **changes, reply_markup=keyboard, received_s=world.clock.now_s()
    )
    if objects.content(version) == objects.content(message.content):
        raise bad_request(NOT_MODIFIED)
    message.edit(version, world.clock.date())
    world.journal.add("edited", chat_id=message.chat_id, message_id=message.message_id)
    return objects.message(message, world.state)


def delete_message(world: World, call: Call) -> bool:
    """https://core.telegram.org/bots/api#deletemessage, with its list of limitations.

    "A message can only be deleted if it was sent less than 48 hours ago", whoever asks; "service
    messages about a supergroup, channel, or forum topic creation can't be deleted".
    """
    chat = present_in(world, call.args)  # also where nothing more can be said
    message = message_of(world, call.args, chat, "message to delete")
    _require_deleting(world, chat, message)
    if CREATIONS & set(message.extra):
        raise bad_request("message can't be deleted")
    if world.clock.date() - message.date >= DELETABLE_S:
        raise bad_request("message can't be deleted for everyone")
    message.delete()
    if message.message_id in chat.pinned:
        chat.pinned.remove(message.message_id)
    world.journal.add("deleted", chat_id=chat.id, message_id=message.message_id)
    return True


def _require_deleting(world: World, chat: ServerChat, message: Message) -> None:
    """Raise a 400 unless the bot may delete this message, however old it is.

    Everything in a private chat; its own in a group; other people's in a basic group as an
    administrator, in a supergroup or a channel with `can_delete_messages`; its own in a channel
    with `can_post_messages`.
    """
    if chat.kind == "private" or (message.own and chat.kind != "channel"):
        return
    withheld = chat.withheld.get(world.bot.id, ())
    posts = world.bot_status(chat) in ADMINS and "can_post_messages" not in withheld
    if chat.kind == "channel" and message.own and posts:
        return
    if chat.kind == "group":
        require_admin(world, chat, "message can't be deleted")
    else:
        require_right(world, chat, "can_delete_messages", "message can't be deleted")


METHODS = {
    "sendMessage": Method(
        {**SENDING, **FORMATTED, "text": Kind.TEXT, "entities": Kind.ARRAY}, send_message
    ),
    "editMessageText": Method(
        {**ADDRESSED, **FORMATTED, "text": Kind.TEXT, "entities": Kind.ARRAY}, edit_message_text
    ),
    "editMessageCaption": Method({**ADDRESSED, **CAPTIONED}, edit_message_caption),
    "editMessageReplyMarkup": Method(ADDRESSED, edit_message_reply_markup),
    "deleteMessage": Method({"chat_id": Kind.CHAT, "message_id": Kind.INTEGER}, delete_message),
}
