"""Formatted text: HTML and MarkdownV2 (https://core.telegram.org/bots/api#formatting-options)."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosic.testing.telegram.entities import utf16_len
from rosic.testing.telegram.markup_html import parse_html
from rosic.testing.telegram.markup_markdown import parse_markdown
from rosic.testing.telegram.refusals import bad_request

if TYPE_CHECKING:
    from rosic.testing.telegram.state import JsonObject


def parse(text: str, mode: str) -> tuple[str, list[JsonObject]]:
    """Return the text without its markup, and the entities.

    Raises:
        ApiError: 400, when the markup is not well formed, or the mode is neither HTML nor
        MarkdownV2
            (the old Markdown mode is legacy, and refused here on purpose).
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
