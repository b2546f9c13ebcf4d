"""From an event of Matrix's to a message of ours. Pure: the same event, the same message.

Identity is the account's id. Display names, aliases and avatars are shown, and never compared:
anybody may choose any of them.
"""

from __future__ import annotations

import html
import re
from typing import TYPE_CHECKING, Any, Final, NamedTuple

from rosic.core.identity import Address
from rosic.core.language import is_urgent
from rosic.core.message import (
    Chat,
    ChatKind,
    GeoPoint,
    Inbound,
    IncomingFile,
    MessageValidity,
)
from rosic.core.time_units import SECOND_NS
from rosic.messengers.matrix.content import enclosed_id, relation

if TYPE_CHECKING:
    from collections.abc import Mapping

PLATFORM: Final = "matrix"
MILLISECOND_NS: Final = SECOND_NS // 1_000
MESSAGE: Final = "m.room.message"
REACTION: Final = "m.reaction"
FILES: Final = frozenset({"m.file", "m.image", "m.video", "m.audio"})
BY_PROGRAMS: Final = "m.notice"
"""What programs say to each other is not answered
(https://spec.matrix.org/latest/client-server-api/#mnotice); a stop of one counts."""
_PLACE: Final = re.compile(
    r"geo:(?P<latitude>-?\d{1,2}(?:\.\d{1,20})?),(?P<longitude>-?\d{1,3}(?:\.\d{1,20})?)"
    r"(?:,-?\d{1,9}(?:\.\d{1,20})?)?(?:;[\w.;=%-]{0,200})?",
    re.ASCII,
)
_PILL: Final = re.compile(
    r'\s*(?:<p>)?<a href="https://matrix\.to/#/(?P<user>[^"]{1,300})">(?P<shown>[^<]{1,300})</a>'
)
_AFTER_NAME: Final = " \t:,"


class RoomEvent(NamedTuple):
    """An event of a room, as it was written: decrypted, where it came encrypted.

    Attributes:
        room: Its id.
        kind: How many can read along there.
        event: Its id.
        sent_ms: What the sender's homeserver says; it may say anything.
        content: As it came. None of it is checked yet.
    """

    room: str
    kind: ChatKind
    event: str
    sender: str
    type: str
    sent_ms: int
    content: Mapping[str, Any]


class ReceivedMoment(NamedTuple):
    """How it was received.

    Attributes:
        received_ns: When, on our wall clock.
        listening_since_ns: Since when we listened.
    """

    received_ns: int
    listening_since_ns: int


class OfferedNonce(NamedTuple):
    """A button beneath a message of ours: what a tap on it carries."""

    message: str
    nonce: str


class Known(NamedTuple):
    """What is known beside the event itself.

    Attributes:
        own: Our account.
        author: Who wrote what it refers to; empty where that is not known.
        offered: The button that it taps, by a reaction or by its number; None for none.
        shown_as: The sender's display name.
    """

    own: str
    author: str = ""
    offered: OfferedNonce | None = None
    shown_as: str = ""


def read(event: RoomEvent, known: Known, received: ReceivedMoment) -> Inbound | None:
    """Return what a person wrote or tapped; None for what is not for us, or malformed."""
    if event.sender == known.own or not event.event:
        return None
    if known.offered is not None:
        return _tap(event, known, known.offered, received)
    if event.type != MESSAGE:
        return None
    if changes(event.content):
        return _changed(event, known, received)
    return _message(event, known, received)


def changes(content: Mapping[str, Any]) -> bool:
    """Whether a content is an edit.

    What it changes stands outside of the ciphertext, where a homeserver can take it away: its new
    words stand inside, and so an edit never comes as something new.
    """
    return relation(content)[0] == "m.replace" or "m.new_content" in content


def refers_to(event: RoomEvent) -> tuple[str, str]:
    """Return the message that an event taps or answers, and the sign or number that may do it.

    Empty where it does neither.
    """
    related, target = relation(event.content)
    if event.type == REACTION:
        link = event.content.get("m.relates_to")
        key = _text(link, "key")
        return (target, key) if related == "m.annotation" and key else ("", "")
    answered = answers(event.content)
    if event.type != MESSAGE or changes(event.content) or not answered:
        return "", ""
    return answered, _without_quotation(_text(event.content, "body"), quoted=True).strip()


def answers(content: Mapping[str, Any]) -> str:
    """Return the message that somebody replied to; empty for none.

    In a thread every message names the one before it, for clients that show no threads.
    """
    link = content.get("m.relates_to")
    if not isinstance(link, dict) or link.get("is_falling_back") is True:
        return ""
    return _text(link.get("m.in_reply_to"), "event_id")


def chat_of(event: RoomEvent) -> Chat:
    """Return where it was said: in a thread, which groups alone have as parts."""
    related, root = relation(event.content)
    threaded = related == "m.thread" and event.kind is ChatKind.GROUP
    return Chat(PLATFORM, event.room, event.kind, root if threaded else "")


def sent_ns(event: RoomEvent, received: ReceivedMoment) -> int:
    """Return when it was sent: never in the future, so that no lifetime is lengthened."""
    return max(0, min(event.sent_ms * MILLISECOND_NS, received.received_ns))


# ---- each kind ----


def _message(event: RoomEvent, known: Known, received: ReceivedMoment) -> Inbound | None:
    content = event.content
    kind, body = _text(content, "msgtype"), _text(content, "body")
    enclosed = _enclosed(content) if kind in FILES else None
    place = _place(content) if kind == "m.location" else None
    if kind in FILES:
        written = body if _text(content, "filename") not in {"", body} else ""
    else:
        written = "" if place is not None else body
    if not written.strip() and enclosed is None and place is None:
        return None
    answered = answers(content)
    unquoted = _without_quotation(written, quoted=bool(answered))
    text, named = _addressed(unquoted, content, known.own)
    if kind not in {"m.text", "m.location", *FILES} and not is_urgent(text):
        return None
    answers_us = bool(answered) and known.author in {"", known.own}
    return Inbound(
        sender=Address(PLATFORM, event.sender),
        chat=chat_of(event),
        message=event.event,
        text=text,
        sent_ns=sent_ns(event, received),
        received_ns=received.received_ns,
        listening_since_ns=received.listening_since_ns,
        standing=_standing(kind),
        answers=answered,
        answers_us=answers_us,
        shown_as=known.shown_as,
        addressed=named or (bool(answered) and known.author == known.own),
        enclosed=enclosed,
        place=place,
        written="" if unquoted == text else unquoted,
    )


def _changed(event: RoomEvent, known: Known, received: ReceivedMoment) -> Inbound | None:
    """Return an edit: it goes by the id of what it changes, and does nothing but stop (I17)."""
    new = event.content.get("m.new_content")
    related, target = relation(event.content)
    if related != "m.replace":
        target = event.event
    if not isinstance(new, dict) or not target:
        return None
    text, named = _addressed(_text(new, "body"), new, known.own)
    if not text.strip() or known.author not in {"", event.sender}:
        return None
    return Inbound(
        sender=Address(PLATFORM, event.sender),
        chat=chat_of(event),
        message=target,
        text=text,
        sent_ns=sent_ns(event, received),
        received_ns=received.received_ns,
        listening_since_ns=received.listening_since_ns,
        standing=MessageValidity.EDITED,
        shown_as=known.shown_as,
        addressed=named,
    )


def _tap(
    event: RoomEvent, known: Known, offered: OfferedNonce, received: ReceivedMoment
) -> Inbound:
    """Return a tap. It is dated when it is received; one that was late is backlog."""
    late = event.sent_ms * MILLISECOND_NS < received.listening_since_ns
    since_ns = received.received_ns + 1 if late else received.listening_since_ns
    return Inbound(
        sender=Address(PLATFORM, event.sender),
        chat=chat_of(event),
        message=event.event,
        text="",
        sent_ns=received.received_ns,
        received_ns=received.received_ns,
        listening_since_ns=since_ns,
        standing=MessageValidity.FRESH,
        nonce=offered.nonce,
        tap=event.event,
        under=offered.message,
        shown_as=known.shown_as,
    )


def _standing(kind: str) -> MessageValidity:
    """Say whether a person wrote this; whose device it came from is looked at elsewhere (I17)."""
    return MessageValidity.FRESH if kind != BY_PROGRAMS else MessageValidity.VIA_BOT


def _enclosed(content: Mapping[str, Any]) -> IncomingFile | None:
    found = enclosed_id(content)
    if not found:
        return None
    info = content.get("info")
    size = info.get("size") if isinstance(info, dict) else 0
    return IncomingFile(
        id=found,
        name=_text(content, "filename") or _text(content, "body"),
        media_type=_text(info, "mimetype"),
        size=size if type(size) is int and size > 0 else 0,
    )


def _place(content: Mapping[str, Any]) -> GeoPoint | None:
    found = _PLACE.fullmatch(_text(content, "geo_uri"))
    if found is None:
        return None
    latitude, longitude = float(found["latitude"]), float(found["longitude"])
    if abs(latitude) > 90 or abs(longitude) > 180:  # noqa: PLR2004 - degrees
        return None
    return GeoPoint(latitude, longitude)


def _without_quotation(text: str, *, quoted: bool) -> str:
    """Return a reply without what it repeats for clients that show no replies."""
    if not quoted or not text.startswith("> "):
        return text
    head, _, rest = text.partition("\n\n")
    return rest if all(line.startswith(">") for line in head.split("\n")) else text


def _addressed(text: str, content: Mapping[str, Any], own: str) -> tuple[str, bool]:
    """Return a text without our name where it begins with it, and whether it names us.

    A client writes our display name there, and in the markup beside it the account that it means.
    Only that is compared.
    """
    mentions = content.get("m.mentions")
    users = mentions.get("user_ids") if isinstance(mentions, dict) else None
    named = (isinstance(users, list) and own in users) or own in text
    for name in (own, _pill(content, own)):
        if name and text.startswith(name):
            rest = text[len(name) :]
            if not rest or rest[0] in _AFTER_NAME or rest[0].isspace():
                return rest.lstrip(_AFTER_NAME), True
    return text, named


def _pill(content: Mapping[str, Any], own: str) -> str:
    """Return how the markup of a text shows our account, where it begins with it."""
    found = _PILL.match(_text(content, "formatted_body"))
    if found is None or html.unescape(found["user"]).replace("%40", "@").replace("%3A", ":") != own:
        return ""
    return html.unescape(found["shown"])


def _text(content: object, key: str) -> str:
    """Return a text of a content; empty where there is none, or something else."""
    value = content.get(key) if isinstance(content, dict) else None
    return value if isinstance(value, str) else ""
