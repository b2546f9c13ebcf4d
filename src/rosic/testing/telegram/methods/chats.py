"""Chats and their members: looking, pinning, reacting, leaving."""

from __future__ import annotations

from rosic.testing.telegram import objects
from rosic.testing.telegram.methods.call import (
    ADMINS,
    Call,
    Method,
    chat_of,
    message_of,
    present_in,
    require_right,
    unsupported,
    writable,
)
from rosic.testing.telegram.parameters import Kind
from rosic.testing.telegram.refusals import bad_request
from rosic.testing.telegram.state import Content, JsonObject, Message, ServerChat
from rosic.testing.telegram.world import PRESENT, World, full_chat

ACTIONS = frozenset(
    {
        "typing",
        "upload_photo",
        "record_video",
        "upload_video",
        "record_voice",
        "upload_voice",
        "upload_document",
        "choose_sticker",
        "find_location",
        "record_video_note",
        "upload_video_note",
    }
)
"""https://core.telegram.org/bots/api#sendchataction."""

REACTIONS = frozenset(
    {
        "❤",
        "👍",
        "👎",
        "🔥",
        "🥰",
        "👏",
        "😁",
        "🤔",
        "🤯",
        "😱",
        "🤬",
        "😢",
        "🎉",
        "🤩",
        "🤮",
        "💩",
        "🙏",
        "👌",
        "🕊",
        "🤡",
        "🥱",
        "🥴",
        "😍",
        "🐳",
        "❤‍🔥",
        "🌚",
        "🌭",
        "💯",
        "🤣",
        "⚡",
        "🍌",
        "🏆",
        "💔",
        "🤨",
        "😐",
        "🍓",
        "🍾",
        "💋",
        "🖕",
        "😈",
        "😴",
        "😭",
        "🤓",
        "👻",
        "👨‍💻",
        "👀",
        "🎃",
        "🙈",
        "😇",
        "😨",
        "🤝",
        "✍",
        "🤗",
        "🫡",
        "🎅",
        "🎄",
        "☃",
        "💅",
        "🤪",
        "🗿",
        "🆒",
        "💘",
        "🙉",
        "🦄",
        "😘",
        "💊",
        "🙊",
        "😎",
        "👾",
        "🤷‍♂",
        "🤷",
        "🤷‍♀",
        "😡",
    }
)
"""https://core.telegram.org/bots/api#reactiontypeemoji."""


def plain_emoji(emoji: str) -> str:
    """Return an emoji as Telegram lists it, without the sign that asks for colours."""
    return emoji.replace("\ufe0f", "")


NO_PIN = "not enough rights to manage pinned messages in the chat"


def get_chat(world: World, call: Call) -> JsonObject:
    """https://core.telegram.org/bots/api#getchat."""
    return full_chat(present_in(world, call.args), world.state)


def send_chat_action(world: World, call: Call) -> bool:
    """https://core.telegram.org/bots/api#sendchataction."""
    if call.args.text("action") not in ACTIONS:
        raise bad_request("wrong parameter action in request")
    chat = writable(world, call.args)
    world.journal.add("action", chat_id=chat.id, action=call.args.text("action"))
    return True


def pin_chat_message(world: World, call: Call) -> bool:
    """https://core.telegram.org/bots/api#pinchatmessage; a service message tells the chat."""
    chat = writable(world, call.args)
    message = message_of(world, call.args, chat, "message to pin")
    _require_pins(world, chat)
    if message.message_id in chat.pinned:
        chat.pinned.remove(message.message_id)
    chat.pinned.append(message.message_id)
    world.journal.add("pinned", chat_id=chat.id, message_id=message.message_id)
    _tell_pinned(world, chat, message)
    return True


def _require_pins(world: World, chat: ServerChat) -> None:
    """https://core.telegram.org/bots/api#pinchatmessage: which right, depends on the chat."""
    right = {"supergroup": "can_pin_messages", "channel": "can_edit_messages"}.get(chat.kind, "")
    require_right(world, chat, right, NO_PIN)


def _tell_pinned(world: World, chat: ServerChat, message: Message) -> None:
    """Queue the service message; a bot hears of its own pin, as the published server does it."""
    note = world.keep(
        Message(
            chat_id=chat.id,
            message_id=world.new_message_id(chat),
            date=world.clock.date(),
            versions=[Content(received_s=world.clock.now_s())],
            from_id=None if chat.kind == "channel" else world.bot.id,
            extra={"pinned_message": objects.message(message, world.state, with_reply=False)},
        )
    )
    kind = "channel_post" if chat.kind == "channel" else "message"
    expires_s = note.date + world.settings.update_lifetime_s
    world.queue.put(kind, objects.message(note, world.state), expires_s)


def unpin_chat_message(world: World, call: Call) -> bool:
    """https://core.telegram.org/bots/api#unpinchatmessage; without an id, the most recent pin."""
    chat = writable(world, call.args)
    _require_pins(world, chat)
    pinned = call.args.integer("message_id", chat.pinned[-1] if chat.pinned else 0)
    if pinned not in chat.pinned:
        raise bad_request("message to unpin not found")
    chat.pinned.remove(pinned)
    world.journal.add("unpinned", chat_id=chat.id, message_id=pinned)
    return True


def unpin_all(world: World, call: Call) -> bool:
    """https://core.telegram.org/bots/api#unpinallchatmessages."""
    chat = writable(world, call.args)
    _require_pins(world, chat)
    for pinned in chat.pinned:
        world.journal.add("unpinned", chat_id=chat.id, message_id=pinned)
    chat.pinned.clear()
    return True


def get_chat_member(world: World, call: Call) -> JsonObject:
    """https://core.telegram.org/bots/api#getchatmember."""
    chat = present_in(world, call.args)
    person = world.state.users.get(call.args.integer("user_id"))
    if person is None:
        raise bad_request(
            "invalid user_id specified" if "user_id" in call.args else "user not found"
        )
    if chat.kind == "private":
        return objects.member(person, "member")
    withheld = chat.withheld.get(person.id, ())
    return objects.member(person, chat.members.get(person.id, "left"), withheld)


def get_chat_administrators(world: World, call: Call) -> list[JsonObject]:
    """https://core.telegram.org/bots/api#getchatadministrators: no other bots."""
    chat = present_in(world, call.args)
    if chat.kind == "private":
        raise bad_request("there are no administrators in the private chat")
    people = ((world.state.users[number], status) for number, status in chat.members.items())
    return [
        objects.member(who, status, chat.withheld.get(who.id, ()))
        for who, status in people
        if status in ADMINS and (not who.is_bot or who.id == world.bot.id)
    ]


def get_chat_member_count(world: World, call: Call) -> int:
    """https://core.telegram.org/bots/api#getchatmembercount."""
    chat = present_in(world, call.args)
    if chat.kind == "private":
        return 2
    return sum(1 for status in chat.members.values() if status in PRESENT)


def leave_chat(world: World, call: Call) -> bool:
    """https://core.telegram.org/bots/api#leavechat."""
    chat = chat_of(world, call.args)
    if chat.kind == "private":
        raise bad_request("chat member status can't be changed in private chats")
    present_in(world, call.args)
    chat.members[world.bot.id] = "left"
    world.journal.add("left", chat_id=chat.id)
    return True


def set_message_reaction(world: World, call: Call) -> bool:
    """https://core.telegram.org/bots/api#setmessagereaction: a bot may set one, and none paid."""
    chat = writable(world, call.args)
    message = message_of(world, call.args, chat, "message to react")
    wanted = call.args.array("reaction") or []
    if len(wanted) > 1:
        raise bad_request("REACTIONS_TOO_MANY")
    for reaction in wanted:
        if not isinstance(reaction, dict) or reaction.get("type") == "paid":
            raise bad_request("REACTION_INVALID")
        if reaction.get("type") != "emoji":
            raise unsupported(world, call, "a custom emoji as reaction")
        if plain_emoji(str(reaction.get("emoji"))) not in REACTIONS:
            raise bad_request("REACTION_INVALID")
    message.reactions[world.bot.id] = [reaction["emoji"] for reaction in wanted]
    world.journal.add(
        "reacted",
        chat_id=chat.id,
        message_id=message.message_id,
        emoji=message.reactions[world.bot.id],
    )
    return True


CHAT = {"chat_id": Kind.CHAT}
IN_CHAT = {**CHAT, "message_id": Kind.INTEGER}
METHODS = {
    "getChat": Method(CHAT, get_chat),
    "sendChatAction": Method(
        {
            **CHAT,
            "action": Kind.TEXT,
            "message_thread_id": Kind.INTEGER,
            "business_connection_id": Kind.TEXT,
        },
        send_chat_action,
    ),
    "pinChatMessage": Method(
        {**IN_CHAT, "disable_notification": Kind.FLAG, "business_connection_id": Kind.TEXT},
        pin_chat_message,
    ),
    "unpinChatMessage": Method(
        {**IN_CHAT, "business_connection_id": Kind.TEXT}, unpin_chat_message
    ),
    "unpinAllChatMessages": Method(CHAT, unpin_all),
    "getChatMember": Method({**CHAT, "user_id": Kind.INTEGER}, get_chat_member),
    "getChatAdministrators": Method({**CHAT, "return_bots": Kind.FLAG}, get_chat_administrators),
    "getChatMemberCount": Method(CHAT, get_chat_member_count),
    "leaveChat": Method(CHAT, leave_chat),
    "setMessageReaction": Method(
        {**IN_CHAT, "reaction": Kind.ARRAY, "is_big": Kind.FLAG}, set_message_reaction
    ),
}
