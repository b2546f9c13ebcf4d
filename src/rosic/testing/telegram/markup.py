"""Formatted text: HTML and MarkdownV2 (https://core.telegram.org/bots/api#formatting-options)."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, NamedTuple

from rosic.testing.telegram.entities import utf16_len
from rosic.testing.telegram.refusals import bad_request

if TYPE_CHECKING:
    from rosic.testing.telegram.state import JsonObject


# ---- markup markdown ----

# MarkdownV2 style (https://core.telegram.org/bots/api#markdownv2-style).

RESERVED = frozenset("_*[]()~`>#+-=|{}.!")
MARKS = {
    "*": "bold",
    "_": "italic",
    "__": "underline",
    "~": "strikethrough",
    "||": "spoiler",
    "`": "code",
    "```": "pre",
    "[": "text_link",
}
MARK = re.compile(r"```|__|\|\||[*_~`\[]")
LANGUAGE = re.compile(r"([A-Za-z0-9+#-]+)\n|\n")
RAW = frozenset({"`", "```"})


class Scanner:
    """Reads the text once, from left to right.

    Quotations (lines that begin with ">") and custom emoji are not understood: their reserved
    characters are refused like any other that is not escaped.
    """

    def __init__(self, text: str) -> None:
        self._text = text
        self._at = 0
        self._parts: list[str] = []
        self._size = 0
        self._open: list[tuple[str, JsonObject]] = []
        self._entities: list[JsonObject] = []

    def run(self) -> tuple[str, list[JsonObject]]:
        """Return the plain text and the entities.

        Raises:
            ApiError: 400, a reserved character is not escaped, or an entity does not end.
        """
        while self._at < len(self._text):
            self._step()
        if self._open:
            kind = MARKS[self._open[-1][0]].title().replace("_", "")
            raise _malformed(f"Can't find end of {kind} entity at byte offset {self._byte()}")
        ordered = sorted(self._entities, key=lambda e: (e["offset"], -e["length"]))
        return "".join(self._parts), ordered

    def _step(self) -> None:
        text, at = self._text, self._at
        inside = self._open[-1][0] if self._open else ""
        if text[at] == "\\" and at + 1 < len(text) and 0 < ord(text[at + 1]) < 127:
            self._plain(text[at + 1], 2)
        elif inside in RAW:
            self._within_code(inside)
        elif inside == "[" and text[at] == "]":
            self._link()
        elif match := MARK.match(text, at):
            self._mark(match.group())
        elif text[at] in RESERVED:
            raise _malformed(
                f"Character '{text[at]}' is reserved and must be escaped with the preceding '\\'"
            )
        else:
            self._plain(text[at], 1)

    def _within_code(self, mark: str) -> None:
        if self._text.startswith(mark, self._at):
            self._at += len(mark)
            self._close()
        else:
            self._plain(self._text[self._at], 1)

    def _mark(self, mark: str) -> None:
        self._at += len(mark)
        if self._open and self._open[-1][0] == mark:
            self._close()
            return
        entity: JsonObject = {"type": MARKS[mark], "offset": self._size}
        if mark == "```" and (language := LANGUAGE.match(self._text, self._at)):
            self._at = language.end()
            if language[1]:
                entity["language"] = language[1]
        self._open.append((mark, entity))

    def _link(self) -> None:
        end = self._text.find(")", self._at)
        if not self._text.startswith("](", self._at) or end < 0:
            raise _malformed(f"Can't find end of a URL at byte offset {self._byte()}")
        self._open[-1][1]["url"] = self._text[self._at + 2 : end]
        self._at = end + 1
        self._close()

    def _close(self) -> None:
        _, entity = self._open.pop()
        length = self._size - entity["offset"]
        if length:
            self._entities.append({**entity, "length": length})

    def _plain(self, character: str, width: int) -> None:
        self._parts.append(character)
        self._size += utf16_len(character)
        self._at += width

    def _byte(self) -> int:
        return len(self._text[: self._at].encode())


def parse_markdown(text: str) -> tuple[str, list[JsonObject]]:
    """Return the text without its marks, and the entities that they meant."""
    return Scanner(text).run()


def _malformed(reason: str) -> Exception:
    return bad_request(f"can't parse entities: {reason}")


# ---- markup ----

# ---- markup html ----

# HTML style (https://core.telegram.org/bots/api#html-style).

TAGS = {
    "b": "bold",
    "strong": "bold",
    "i": "italic",
    "em": "italic",
    "u": "underline",
    "ins": "underline",
    "s": "strikethrough",
    "strike": "strikethrough",
    "del": "strikethrough",
    "tg-spoiler": "spoiler",
    "span": "spoiler",
    "a": "text_link",
    "code": "code",
    "pre": "pre",
    "blockquote": "blockquote",
    "tg-emoji": "custom_emoji",
}
NAMED = {"lt": "<", "gt": ">", "amp": "&", "quot": '"'}
PIECE = re.compile(
    r"<(?P<end>/?)(?P<tag>[a-zA-Z-]*)(?P<attributes>[^<>]*)>"
    r"|&(?:(?P<name>lt|gt|amp|quot)|#(?P<number>\d{1,7})|#x(?P<hex>[0-9a-fA-F]{1,6}));"
    r"|(?P<stray><)"
)
ATTRIBUTE = re.compile(r"\s+([a-zA-Z-]+)(?:=(?:\"([^\"]*)\"|'([^']*)'|([^\s\"'>]+)))?")


class Open(NamedTuple):
    """A tag that waits for its end."""

    tag: str
    entity: JsonObject
    begun_at: int


class Reader:
    """Collects plain text and entities while the pieces go by."""

    def __init__(self) -> None:
        self._parts: list[str] = []
        self._size = 0
        self._open: list[Open] = []
        self._entities: list[JsonObject] = []

    def plain(self, text: str) -> None:
        """Add text."""
        self._parts.append(text)
        self._size += utf16_len(text)

    def begin(self, tag: str, attributes: str, at: int) -> None:
        """Begin an entity."""
        if tag not in TAGS:
            raise _malformed(f'Unsupported start tag "{tag}" at byte offset {at}')
        entity: JsonObject = {"type": TAGS[tag], "offset": self._size}
        self._open.append(Open(tag, entity | _details(tag, attributes, at), at))

    def end(self, tag: str, at: int) -> None:
        """End the entity that began last."""
        if not self._open:
            raise _malformed(f"Unexpected end tag at byte offset {at}")
        opened = self._open.pop()
        if tag not in {"", opened.tag}:
            raise _malformed(
                f"Unmatched end tag at byte offset {at}, "
                f'expected "</{opened.tag}>", found "</{tag}>"'
            )
        if opened.tag == "code" and self._open and self._open[-1].tag == "pre":
            # "<pre><code class=...>" is one entity with a language.
            self._open[-1].entity.update(
                {k: v for k, v in opened.entity.items() if k == "language"}
            )
            return
        length = self._size - opened.entity["offset"]
        if opened.tag == "code":
            opened.entity.pop("language", None)
        if length and (opened.tag != "a" or "url" in opened.entity):
            self._entities.append({**opened.entity, "length": length})

    def result(self) -> tuple[str, list[JsonObject]]:
        """Return text and entities.

        Raises:
            ApiError: 400, a tag was never closed.
        """
        if self._open:
            last = self._open[-1]
            raise _malformed(f'Can\'t find end tag corresponding to start tag "{last.tag}"')
        ordered = sorted(self._entities, key=lambda e: (e["offset"], -e["length"]))
        return "".join(self._parts), ordered


def parse_html(text: str) -> tuple[str, list[JsonObject]]:
    """Return the text without tags, and the entities that they meant."""
    reader, at = Reader(), 0
    for piece in PIECE.finditer(text):
        reader.plain(text[at : piece.start()])
        at = piece.end()
        offset = len(text[: piece.start()].encode())
        if piece["stray"] is not None or (piece["tag"] == "" and not piece["end"]):
            raise _malformed(f'Unsupported start tag "" at byte offset {offset}')
        if piece["tag"] is None:
            reader.plain(_character(piece))
        elif piece["end"]:
            reader.end(piece["tag"].lower(), offset)
        else:
            reader.begin(piece["tag"].lower(), piece["attributes"], offset)
    reader.plain(text[at:])
    return reader.result()


def _character(piece: re.Match[str]) -> str:
    if piece["name"]:
        return NAMED[piece["name"]]
    code = int(piece["number"]) if piece["number"] else int(piece["hex"], 16)
    return chr(code) if 0 < code < 0x110000 and not 0xD800 <= code < 0xE000 else piece.group()


def _details(tag: str, attributes: str, at: int) -> JsonObject:
    given = {m[1].lower(): m[2] or m[3] or m[4] or "" for m in ATTRIBUTE.finditer(attributes)}
    if ATTRIBUTE.sub("", attributes).strip():
        raise _malformed(
            f"Attribute without a value or unclosed quote in the tag at byte offset {at}"
        )
    if tag == "span" and given.get("class") != "tg-spoiler":
        raise _malformed('Tag "span" must have class "tg-spoiler" at byte offset ' + str(at))
    if tag == "a" and given.get("href"):
        return {"url": given["href"]}
    if tag == "code" and given.get("class", "").startswith("language-"):
        return {"language": given["class"].removeprefix("language-")}
    if tag == "tg-emoji":
        return {"custom_emoji_id": given.get("emoji-id", "")}
    if tag == "blockquote" and "expandable" in given:
        return {"type": "expandable_blockquote"}
    return {}


# ---- markup ----


def parse(text: str, mode: str) -> tuple[str, list[JsonObject]]:
    """Return the text without its markup, and the entities.

    Raises:
        ApiError: 400, when the markup is not well formed, or the mode is neither HTML nor
            MarkdownV2 (the old Markdown mode is legacy, and refused here on purpose).
    """
    match mode.lower():
        case "html":
            return parse_html(text)
        case "markdownv2":
            return parse_markdown(text)
        case _:
            raise bad_request("unsupported parse_mode")


def trimmed(text: str, marked: list[JsonObject]) -> tuple[str, list[JsonObject]]:
    """Return the text without outer white space, and its entities moved and shortened with it."""
    bare = text.strip()
    if bare == text:
        return text, marked
    lost = utf16_len(text[: len(text) - len(text.lstrip())])
    size = utf16_len(bare)
    kept: list[JsonObject] = []
    for entity in marked:
        start = max(0, entity["offset"] - lost)
        end = min(size, entity["offset"] + entity["length"] - lost)
        if end > start:
            kept.append({**entity, "offset": start, "length": end - start})
    return bare, kept
