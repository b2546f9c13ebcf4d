"""From an update of Telegram's to a message of ours. Pure: the same update, the same message.

Identity is the numeric id. A user name is compared in one place only, where a command is addressed
to a bot (``/stop@this_bot``), and only with the bot's own.
"""

from __future__ import annotations

import re
from functools import lru_cache
from typing import TYPE_CHECKING, Final, NamedTuple

from rosic.core.identity import Address
from rosic.core.language import hears_stop
from rosic.core.language.stop_detection import FIRST_LINES, LAST_LINES
from rosic.core.message import (
    Chat,
    ChatEvent,
    ChatEventKind,
    ChatKind,
    GeoPoint,
    Inbound,
    IncomingFile,
    MessageValidity,
    Reaction,
)
from rosic.core.time_units import SECOND_NS
from rosic.messengers.telegram import updates

if TYPE_CHECKING:
    from collections.abc import Callable

PLATFORM = "telegram"
CHATS_KEPT: Final = 4_096

_ADDRESSED = re.compile(r"(?P<command>/[A-Za-z0-9_]{1,64})@(?P<name>[A-Za-z0-9_]{1,64})(?!\w)")
_NAMED = re.compile(r"@(?P<name>[A-Za-z0-9_]{1,64})(?!\w)")
_MENTIONED = re.compile(r"@(?P<name>[A-Za-z0-9_]{1,64})(?!\w)[\s,:]*")
_KINDS = {
    "private": ChatKind.PRIVATE,
    "group": ChatKind.GROUP,
    "supergroup": ChatKind.GROUP,
    "channel": ChatKind.CHANNEL,
}


def _never(_sent_ns: int) -> bool:
    return False


class ReceivedAt(NamedTuple):
    """How it was received.

    Attributes:
        received_ns: When, on our wall clock.
        listening_since_ns: Since when we listened.
        account: The bot's own id.
        account_since_ns: By Telegram's clock: what was sent earlier goes without the bot's id.
        away: Whether the network was, when something was sent.
    """

    received_ns: int
    listening_since_ns: int
    account: str = ""
    account_since_ns: int = 0
    away: Callable[[int], bool] = _never


def read(
    update: updates.Update, own_name: str, received: ReceivedAt, *, may_stop: bool = True
) -> Inbound | None:
    """Return what a person wrote or tapped; None for what is not for us.

    Args:
        update: Just received.
        own_name: The bot's user name, without the @.
        received: When, and since when we listened.
        may_stop: Whoever sent it may stop something: a stop counts whomever it names. In words of
            strangers none is looked for, which costs more than all the rest.
    """
    if update.callback_query is not None:
        return _tap(update.callback_query, received)
    for message, standing in (
        (update.message, _standing),
        (update.edited_message, _edited),
        (update.channel_post, _channel),
        (update.edited_channel_post, _channel),
    ):
        if message is not None:
            return _text(message, standing(message), own_name, received, may_stop=may_stop)
    return None


def author(update: updates.Update) -> Address | None:
    """Return whose account sent an update; None where Telegram does not tell whose it was.

    A stop counts without a name, too (I17), so these are not taken for strangers'.
    """
    message = update.message or update.edited_message
    if update.callback_query is not None:
        return Address(PLATFORM, str(update.callback_query.sender.id))
    if message is None or _standing(message) in {
        MessageValidity.ANONYMOUS,
        MessageValidity.CHANNEL,
    }:
        return None
    return Address(PLATFORM, str(_author(message)))


def moved(update: updates.Update) -> tuple[str, str] | None:
    """Return the old and the new id of a group that became a supergroup."""
    message = update.message
    if message is None:
        return None
    if message.migrate_to_chat_id is not None:
        return str(message.chat.id), str(message.migrate_to_chat_id)
    if message.migrate_from_chat_id is not None:
        return str(message.migrate_from_chat_id), str(message.chat.id)
    return None


def passing(update: updates.Update, *, hears_groups: bool) -> ChatEvent | None:
    """Return what happened to a chat: we came or went, or are told more or less; somebody left.

    Args:
        update: Just received.
        hears_groups: Privacy mode is off, so that we hear everything in every group.
    """
    if (mine := update.my_chat_member) is not None:
        return _own_passing(mine, hears_groups=hears_groups)
    if (other := update.chat_member) is not None:
        gone = other.old_chat_member.present and not other.new_chat_member.present
        return _left(other.chat, other.new_chat_member.user.id) if gone else None
    return _noted(update.message) if update.message is not None else None


def reaction(update: updates.Update) -> Reaction | None:
    """Return what somebody has put beside a message, and who; nobody, for a bot or a channel."""
    found = update.message_reaction
    if found is None or not (emoji := updates.added(found)):
        return None
    who = found.user
    known = who is not None and not who.is_bot and who.id != updates.GROUP_ANONYMOUS_BOT
    return Reaction(
        chat=_chat(found.chat),
        message=str(found.message_id),
        who=Address(PLATFORM, str(who.id)) if who is not None and known else None,
        emoji=emoji,
    )


def _noted(message: updates.TelegramMessage) -> ChatEvent | None:
    """Return what a service message says; these arrive in privacy mode, too."""
    gone = message.left_chat_member
    if isinstance(gone, dict) and type(gone.get("id")) is int and not gone.get("is_bot"):
        return _left(message.chat, gone["id"])
    return None


def _own_passing(update: updates.MemberUpdate, *, hears_groups: bool) -> ChatEvent | None:
    old, new = update.old_chat_member, update.new_chat_member
    hears = hears_groups or new.status == "administrator"
    heard = hears_groups or old.status == "administrator"
    if old.present != new.present:
        what = ChatEventKind.ADDED if new.present else ChatEventKind.REMOVED
    elif new.present and hears != heard:
        what = ChatEventKind.HEARING if hears else ChatEventKind.DEAF
    else:
        return None
    return ChatEvent(
        chat=_chat(update.chat),
        what=what,
        who=Address(PLATFORM, str(update.sender.id)),
        title=update.chat.title,
        deaf=not hears,
    )


def _left(chat: updates.TelegramChat, who: int) -> ChatEvent:
    return ChatEvent(chat=_chat(chat), what=ChatEventKind.LEFT, who=Address(PLATFORM, str(who)))


def addressed_here(text: str, own_name: str, *, may_stop: bool = True) -> str | None:
    """Return the text without this bot's name where it addresses it; None if it means another bot.

    A stop counts whomever it names: with two bots in a group, a hurried tap in the menu picks
    either. Each line stays one, because a command's identity holds its place.
    """
    if "@" not in text:
        return text
    own = own_name.casefold()
    said = text.split("\n")
    lines: list[str | None] = list(said)
    # Of more lines than anybody follows only those are looked at that a stop is looked for in.
    for at in {*range(len(said))[:FIRST_LINES], *range(len(said))[-LAST_LINES:]}:
        if "@" in said[at]:
            lines[at] = _line(said[at], own, may_stop=may_stop)
    if all(line is None for line in lines):
        return None
    return "\n".join(line or "" for line in lines)


def _line(line: str, own_name: str, *, may_stop: bool) -> str | None:
    if mention := _MENTIONED.match(line):
        named, rest = mention["name"].casefold(), line[mention.end() :]
        if named == own_name:
            line = rest
        elif named.endswith("bot"):  # as the name of every bot does, and of no person
            return line if may_stop and hears_stop(rest) is not None else None
    if not (command := _ADDRESSED.match(line)):
        return line
    bare = command["command"] + line[command.end() :]
    if command["name"].casefold() == own_name or (may_stop and hears_stop(bare) is not None):
        return bare
    return None


def _text(
    message: updates.TelegramMessage,
    standing: MessageValidity,
    own_name: str,
    received: ReceivedAt,
    *,
    may_stop: bool,
) -> Inbound | None:
    written = message.text or message.caption
    enclosed = _enclosed(message)
    place = _placed(message)
    bare = None if enclosed is None and place is None else ""
    text = addressed_here(written, own_name, may_stop=may_stop) if written else bare
    if text is None:
        return None
    named, replied = _names(written or "", own_name), _replied_bot(message)
    to_another = replied not in {"", own_name.casefold()} and not named
    if to_another and not (may_stop and hears_stop(text) is not None):
        return None  # an answer to another bot, of another gateway perhaps
    date = message.date if message.edit_date is None else message.edit_date
    # The beginning of the second in which it was sent: a lifetime is never lengthened.
    sent_ns = min(date * SECOND_NS, received.received_ns)
    return Inbound(
        sender=Address(PLATFORM, str(_author(message))),
        chat=_chat(message.chat, message),
        message=str(message.message_id),
        text=text,
        sent_ns=sent_ns,
        received_ns=received.received_ns,
        listening_since_ns=received.listening_since_ns,
        standing=standing,
        answers=_answered(message),
        answers_us=_answers_us(message, own_name, received.account),
        shown_as="" if message.sender is None else message.sender.first_name,
        locale="" if message.sender is None else message.sender.language_code or "",
        addressed=named or bool(replied),
        enclosed=enclosed,
        place=place,
        account=_account(message, received),
        network_away=received.away(sent_ns),
        written="" if written is None or written == text else written,
        links=updates.links(message),
    )


def _account(message: updates.TelegramMessage, received: ReceivedAt) -> str:
    """Return whose count a message's number is: in supergroups and channels all share one.

    Everywhere else each bot counts for itself
    (https://core.telegram.org/api/updates: message boxes).
    """
    shared = message.chat.type in {"supergroup", "channel"}
    earlier = message.date * SECOND_NS < received.account_since_ns
    return "" if shared or earlier else received.account


def _placed(message: updates.TelegramMessage) -> GeoPoint | None:
    found = updates.placed(message)
    return None if found is None else GeoPoint(found.latitude, found.longitude)


def _enclosed(message: updates.TelegramMessage) -> IncomingFile | None:
    file = updates.enclosed(message)
    if file is None:
        return None
    size = max(file.file_size, 0)
    return IncomingFile(id=file.file_id, name=file.file_name, media_type=file.mime_type, size=size)


def _tap(query: updates.CallbackQuery, received: ReceivedAt) -> Inbound | None:
    if query.message is None or query.data is None:
        return None
    return Inbound(
        sender=Address(PLATFORM, str(query.sender.id)),
        chat=_chat(query.message.chat, query.message),
        message=query.id,
        text="",
        sent_ns=received.received_ns,
        received_ns=received.received_ns,
        listening_since_ns=received.listening_since_ns,
        nonce=query.data,
        tap=query.id,
        under=str(query.message.message_id),
        shown_as=query.sender.first_name,
        locale=query.sender.language_code or "",
    )


def _replied(message: updates.TelegramMessage) -> updates.RepliedMessage | None:
    """Return the message that somebody replied to.

    In a topic Telegram shows every other message as a reply to the one that created the topic,
    which another bot may have done: nobody answers that.
    """
    first = message.reply_to_message
    if first is not None and message.is_topic_message:
        return None if first.message_id == message.message_thread_id else first
    return first


def _answered(message: updates.TelegramMessage) -> str:
    """Return the message that it replies to, if that is in the same chat."""
    first = _replied(message)
    return str(first.message_id) if first and first.chat.id == message.chat.id else ""


def _answers_us(message: updates.TelegramMessage, own_name: str, account: str) -> bool:
    """Whether it replies to a message of this bot's, in whatever chat that is.

    What Telegram itself brought from a channel into its discussion may have been this bot's, too.
    """
    first, elsewhere = _replied(message), message.external_reply
    author = first.sender if first is not None else None
    if isinstance(elsewhere, dict) and isinstance(origin := elsewhere.get("origin"), dict):
        author = author or origin.get("sender_user")
    if not isinstance(author, dict):
        return False
    if author.get("id") == updates.TELEGRAM:
        return True
    name = author.get("username")
    by_name = isinstance(name, str) and name.casefold() == own_name.casefold()
    return author.get("is_bot") is True and (by_name or str(author.get("id")) == account)


def _names(text: str, own_name: str) -> bool:
    """Whether a text names this bot anywhere."""
    own = own_name.casefold()
    return any(found["name"].casefold() == own for found in _NAMED.finditer(text))


def _replied_bot(message: updates.TelegramMessage) -> str:
    """Return the name of the bot whose message it replies to; empty where that is no bot's.

    Whatever has another form than documented is none: a stop must not be lost over it.
    """
    first = _replied(message)
    author = first.sender if first is not None else None
    if not isinstance(author, dict) or author.get("is_bot") is not True:
        return ""
    name = author.get("username")
    if author.get("id") in {updates.GROUP_ANONYMOUS_BOT, updates.CHANNEL_BOT}:
        return ""
    return name.casefold() if isinstance(name, str) else ""


def _author(message: updates.TelegramMessage) -> int:
    """Return the account that wrote; a channel or a stand-in where Telegram does not tell."""
    if message.sender is not None:
        return message.sender.id
    return (message.sender_chat or message.chat).id


def _chat(
    chat: updates.TelegramChat,
    message: updates.TelegramMessage | updates.RepliedMessage | None = None,
) -> Chat:
    kind = _KINDS.get(chat.type, ChatKind.GROUP)
    thread = message.message_thread_id if message is not None and message.is_topic_message else None
    return _place(chat.id, kind, thread)


@lru_cache(maxsize=CHATS_KEPT)
def _place(chat: int, kind: ChatKind, thread: int | None) -> Chat:
    """Return a chat: one for all its messages, of which thousands are remembered for a while."""
    return Chat(PLATFORM, str(chat), kind, "" if thread is None else str(thread))


def _channel(_: updates.TelegramMessage) -> MessageValidity:
    return MessageValidity.CHANNEL


def _edited(message: updates.TelegramMessage) -> MessageValidity:
    return MessageValidity.CHANNEL if message.chat.type == "channel" else MessageValidity.EDITED


def _standing(message: updates.TelegramMessage) -> MessageValidity:
    """Say whether a person wrote this, here and now, with their own hand (I17)."""
    sender = message.sender
    if message.is_automatic_forward or (
        sender and sender.id in {updates.TELEGRAM, updates.CHANNEL_BOT}
    ):
        return MessageValidity.CHANNEL
    if sender is None or message.sender_chat or sender.id == updates.GROUP_ANONYMOUS_BOT:
        return MessageValidity.ANONYMOUS
    if message.forward_origin is not None or message.forward_date is not None:
        return MessageValidity.FORWARDED
    if message.edit_date is not None:  # whatever kind of update it came in
        return MessageValidity.EDITED
    # A scheduled message was written earlier; what a bot says, in its own name or in that of a
    # business account, was written by nobody.
    by_bot = message.via_bot or message.sender_business_bot or message.business_connection_id
    if by_bot is not None or sender.is_bot or message.is_from_offline:
        return MessageValidity.VIA_BOT
    return MessageValidity.FRESH
