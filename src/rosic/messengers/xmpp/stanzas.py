"""What a stanza says. Pure: the same stanza, the same message."""

from __future__ import annotations

import hashlib
import re
from datetime import datetime
from itertools import islice
from typing import TYPE_CHECKING, Final, NamedTuple
from urllib.parse import unquote

from rosic.core.identity import Address
from rosic.core.message import Chat, ChatKind, Inbound, IncomingFile, MessageValidity
from rosic.core.time_units import SECOND_NS

if TYPE_CHECKING:
    from xml.etree.ElementTree import Element

PLATFORM: Final = "xmpp"
BODY: Final = "{jabber:client}body"
REPLACE: Final = "{urn:xmpp:message-correct:0}replace"
REACTIONS: Final = "{urn:xmpp:reactions:0}"
REPLY: Final = "{urn:xmpp:reply:0}reply"
DELAY: Final = "{urn:xmpp:delay}delay"
OOB: Final = "{jabber:x:oob}"
USER: Final = "{http://jabber.org/protocol/muc#user}"
LONGEST_ID: Final = 100
_REPEATED: Final = re.compile(r"\A(?:>[^\n]*\n)+")
_LINK: Final = re.compile(r"https?://[^\s/?#]+/(?:[^\s?#]*/)?([^\s/?#]+)")
_UNSPEAKABLE: Final = re.compile("[^\t\n\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


class Moment(NamedTuple):
    """How something was received.

    Attributes:
        received_ns: When, on our wall clock.
        earliest_ns: It was on its way from the server since then, or later.
        since_ns: Since when we listen.
    """

    received_ns: int
    earliest_ns: int
    since_ns: int


def read(xml: Element, who: str, chat: Chat, moment: Moment) -> Inbound:
    """Return what somebody wrote, with or without words."""
    changed, reply = _of(xml, REPLACE, "id"), _of(xml, REPLY, "id")
    text, url = xml.findtext(BODY, ""), xml.findtext(f"{OOB}x/{OOB}url", "").strip()
    if reply:  # what it repeats of the message that it answers stands first
        text = _REPEATED.sub("", text)
    linked = _LINK.match(url) if url == text.strip() else None
    name = "" if linked is None else unquote(linked[1])
    return Inbound(
        sender=Address(PLATFORM, who),
        chat=chat,
        message=f"{changed[:LONGEST_ID]}#" if changed else identity(xml, chat),
        text="" if name else text,
        sent_ns=sent_ns(xml, moment),
        received_ns=moment.received_ns,
        listening_since_ns=moment.since_ns,
        standing=MessageValidity.EDITED if changed else MessageValidity.FRESH,
        answers=reply,
        enclosed=IncomingFile(id=url, name=name) if name and not changed else None,
        shown_as=xml.get("from", "").partition("/")[2] if chat.kind is ChatKind.GROUP else who,
    )


def identity(xml: Element, chat: Chat) -> str:
    """Return what a message is known by: its author's id for it, and one that no client chooses.

    Where the archive of the server or of the room gives none, it is a digest: some clients count
    from one again each time that they sign in.
    """
    given = archived(xml, chat.id) or archived(xml, xml.get("to", "").partition("/")[0])
    said = "\0".join((xml.get("from", ""), xml.findtext(BODY, "")))
    last = given or hashlib.blake2b(said.encode(), digest_size=12).hexdigest()
    return f"{meant(xml)[:LONGEST_ID]}#{last[:LONGEST_ID]}"


def archived(xml: Element, by: str) -> str:
    """Return what an archive calls a message (XEP-0359); empty where it does not."""
    named = (one for one in xml.iterfind("{urn:xmpp:sid:0}stanza-id") if one.get("by") == by)
    return next((one.get("id", "") for one in named), "")


def meant(xml: Element) -> str:
    """Return which message of its author it is, or changes."""
    return _of(xml, REPLACE, "id") or xml.get("id", "")


def name_for(message: str, chat: Chat) -> str:
    """Return how others call a message: in rooms as the room does, else as its author does."""
    own, _, given = message.rpartition("#")
    return given if own and chat.kind is ChatKind.GROUP else own or message


def sent_ns(xml: Element, moment: Moment) -> int:
    """Return when it was sent, as servers say (XEP-0203), or when it was at the earliest.

    An author may write such a stamp, too: the oldest counts, and none that lies ahead.
    """
    stamps = [_stamp_ns(one.get("stamp", "")) for one in xml.iterfind(DELAY)]
    if max(stamps, default=0) > moment.received_ns + 2 * SECOND_NS:
        return 0
    return min((*stamps, moment.received_ns)) if stamps else moment.earliest_ns


def reacted(xml: Element) -> tuple[str, tuple[str, ...]]:
    """Return which message somebody reacted to, and with what (XEP-0444)."""
    put = islice(xml.iterfind(f"{REACTIONS}reactions/{REACTIONS}reaction"), 9)
    return _of(xml, f"{REACTIONS}reactions", "id"), tuple((one.text or "")[:99] for one in put)


def is_private(xml: Element) -> bool:
    """Whether an account wrote it: what comes from a room to us alone has the room's address."""
    return xml.get("type", "normal") in {"normal", "chat"} and xml.find(f"{USER}x") is None


def is_history(xml: Element, room: str) -> bool:
    """Whether a room repeats it: whose nickname that was then nobody knows."""
    return any(one.get("from", "").startswith(room) for one in xml.iterfind(DELAY))


def is_encrypted(xml: Element) -> bool:
    """Whether its words are encrypted end to end: what stands in the open says only so."""
    return any(one.tag.endswith("}encrypted") for one in xml)


def speakable(text: str) -> str:
    """Return a text without what XML cannot hold: one such sign ends the stream."""
    return _UNSPEAKABLE.sub("", text.replace("\r\n", "\n").replace("\r", "\n"))


def _of(xml: Element, tag: str, key: str) -> str:
    found = xml.find(tag)
    return "" if found is None else found.get(key, "")


def _stamp_ns(stamp: str) -> int:
    """Return a time; 0, which is before everything, for what is none."""
    try:
        read = datetime.fromisoformat(stamp)
        return int(read.timestamp() * 1e6) * 1_000 if read.tzinfo else 0
    except (ValueError, OverflowError):
        return 0
