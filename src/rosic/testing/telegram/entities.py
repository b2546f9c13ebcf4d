"""Entities of a text: UTF-16 offsets, what Telegram finds by itself, and what it refuses.

https://core.telegram.org/bots/api#messageentity; offsets and lengths count UTF-16 code units.
"""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any

from rosic.testing.telegram.refusals import bad_request

if TYPE_CHECKING:
    from rosic.testing.telegram.state import JsonObject

GIVEN_KINDS = frozenset(
    {
        "mention",
        "hashtag",
        "cashtag",
        "bot_command",
        "url",
        "email",
        "phone_number",
        "bold",
        "italic",
        "underline",
        "strikethrough",
        "spoiler",
        "blockquote",
        "expandable_blockquote",
        "code",
        "pre",
        "text_link",
        "text_mention",
        "custom_emoji",
        "date_time",
    }
)

FOUND = (
    (
        "bot_command",
        re.compile(r"(?<![\w/<>@])/[A-Za-z0-9_]{1,64}(?:@[A-Za-z0-9_]{3,32})?(?![\w/])"),
    ),
    ("email", re.compile(r"(?<![\w.+-])[\w.+-]{1,64}@[A-Za-z0-9-]{1,63}(?:\.[A-Za-z]{2,24})+")),
    ("mention", re.compile(r"(?<![\w@])@[A-Za-z][A-Za-z0-9_]{2,31}(?!\w)")),
    (
        "url",
        re.compile(
            r"(?:https?://[^\s<>]{1,2000}|(?<![\w@.])(?:(?:[a-z0-9-]{1,63}\.){1,5}"
            r"(?:com|org|net|io|dev|me|ru|de|uk|eu|info|app)|(?:[0-9]{1,3}\.){3}[0-9]{1,3})"
            r"(?:/[^\s<>]{0,2000})?(?!\w))",
            re.IGNORECASE,
        ),
    ),
    ("hashtag", re.compile(r"(?<![\w#])#(?=[\d_]{0,255}[^\W\d_])\w{1,255}")),
    ("cashtag", re.compile(r"(?<![\w$])\$(?:1INCH|[A-Z]{1,8})(?![\w$])")),
    (
        "phone_number",
        re.compile(
            r"(?<![\w+.,:-])(?:\+[0-9](?:[ ()-]{0,2}[0-9]){6,14}|[0-9]{10,15})"
            r"(?!\w)"
        ),
    ),
)
"""What Telegram marks by itself in every text. Its exact rules are not published."""

OPAQUE = frozenset({"code", "pre", "text_link", "text_mention"})
"""Within these nothing is found."""


def utf16_len(text: str) -> int:
    """Return the length in UTF-16 code units."""
    return len(text) + sum(1 for character in text if ord(character) > 0xFFFF)


def cut(text: str, offset: int, length: int) -> str:
    """Return the part that an entity marks."""
    raw = text.encode("utf-16-le", "surrogatepass")
    return raw[2 * offset : 2 * (offset + length)].decode("utf-16-le", "replace")


def found(text: str) -> list[JsonObject]:
    """Return the entities that Telegram finds by itself, in order, none over another."""
    entities: list[JsonObject] = []
    for kind, pattern in FOUND:
        for match in pattern.finditer(text):
            offset = utf16_len(text[: match.start()])
            entity = {"type": kind, "offset": offset, "length": utf16_len(match.group())}
            if not any(_overlap(entity, other) for other in entities):
                entities.append(entity)
    return sorted(entities, key=lambda entity: int(entity["offset"]))


def complete(text: str, given: list[JsonObject]) -> list[JsonObject]:
    """Return the given entities together with those that Telegram finds beside them."""
    opaque = [entity for entity in given if entity["type"] in OPAQUE]
    more = [e for e in found(text) if not any(_overlap(e, other) for other in opaque)]
    known = [(e["type"], e["offset"], e["length"]) for e in given]
    more = [e for e in more if (e["type"], e["offset"], e["length"]) not in known]
    return sorted([*given, *more], key=lambda entity: (entity["offset"], -entity["length"]))


def checked(text: str, given: list[Any]) -> list[JsonObject]:
    """Return entities that a bot sent, ready to be kept.

    Raises:
        ApiError: 400, for an entity that is no object, of no known type, or outside the text.
    """
    size = utf16_len(text)
    return [_checked(entity, size, text) for entity in given]


def _checked(entity: object, size: int, text: str) -> JsonObject:
    if not isinstance(entity, dict):
        raise bad_request("can't parse MessageEntity: Expected an Object")
    if entity.get("type") not in GIVEN_KINDS:
        raise bad_request("can't parse MessageEntity: Unsupported type specified")
    offset, length = entity.get("offset"), entity.get("length")
    if type(offset) is not int or type(length) is not int:
        raise bad_request('can\'t parse MessageEntity: Field "offset" must be of type Number')
    if offset < 0 or length <= 0 or offset + length > size:
        # Telegram's docs are silent on this; the published server says this for negative values and
        # drops an entity beyond the end. A correct client sends neither, so both are refused here.
        raise bad_request(
            f"entity beginning at UTF-16 offset {offset} ends after the end of the text"
            f" at UTF-16 offset {offset + length}"
        )
    if "\ufffd" in cut(text, offset, length) and "\ufffd" not in text:
        raise bad_request(f"entity begins in a middle of a UTF-16 symbol at byte offset {offset}")
    return entity


def _overlap(one: JsonObject, other: JsonObject) -> bool:
    begins_before = bool(one["offset"] < other["offset"] + other["length"])
    return begins_before and bool(other["offset"] < one["offset"] + one["length"])
