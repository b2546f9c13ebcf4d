"""No chat drives a robot live: only what ROSIC itself serves may mark a message so."""

from __future__ import annotations

import re

from tests.shape.tree import source

LIVE = re.compile(r"\blive\s*=\s*(?!=|False\b)")
CHATS = ("rosic.messengers.",)


def marked(texts: dict[str, str]) -> list[str]:
    """Return the chats in whose source a message is marked as live."""
    return [name for name, text in texts.items() if name.startswith(CHATS) and LIVE.search(text)]


def test_no_chat_marks_a_message_as_live() -> None:
    assert marked(source()) == []


def test_one_that_does_is_found() -> None:
    name = "rosic.messengers.telegram.incoming"
    assert marked({name: "Inbound(sender=a, live=True)"}) == [name]
    assert marked({name: "replace(inbound, live = wanted)"}) == [name]
    assert marked({name: "Inbound(sender=a, live=False)", "rosic.api.page": "live=True"}) == []
