"""MarkdownV2 style (https://core.telegram.org/bots/api#markdownv2-style)."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from rosic.testing.telegram.entities import utf16_len
from rosic.testing.telegram.refusals import bad_request

if TYPE_CHECKING:
    from rosic.testing.telegram.state import JsonObject

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
