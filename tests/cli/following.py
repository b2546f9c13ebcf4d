"""What a page or a record needs that is followed from `rosic init` to a phone."""

from __future__ import annotations

import re
import time
from typing import TYPE_CHECKING

from tests.cli.terminal import rosic_at
from tests.pace import pace

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from rosic.testing.telegram import FakeTelegram

CODE = re.compile(r"\b[0-9A-Z]{4}-[0-9A-Z]{4}\b")
TELEGRAM = 'kind = "telegram"\n'


def answer_the_questions(
    folder: Path, words: Sequence[str], answers: Sequence[tuple[str, str]], token: str
) -> str:
    """Type an answer to each question as it comes; return what was shown when it was written."""
    with rosic_at(words, folder) as asked:
        for question, answer in answers:
            asked.wait_for(question)
            asked.type(token if answer == "TOKEN" else answer)
        assert asked.ended() == 0, asked.shown
        assert "Written: " in asked.shown
        return asked.shown


def lead_to(server: FakeTelegram, config: Path) -> None:
    """Write the address of a server into a configuration, as docs/fake-bot-api.md says."""
    text = config.read_text(encoding="utf-8")
    assert text.count(TELEGRAM) == 1
    config.write_text(text.replace(TELEGRAM, f'{TELEGRAM}api_base = "{server.api_base}"\n'))


async def shown(server: FakeTelegram, user: int, text: str) -> int:
    """Wait until somebody is told a text or offered a button; return the newest such message."""
    end_s = time.monotonic() + 20 * pace()
    while True:
        seq, seen = server.seq, server.messages(user, by_bot=True)
        for message in reversed(seen):
            labels = [key["text"] for row in message["buttons"] for key in row]
            if text in labels or text in (message["text"] or ""):
                return int(message["message_id"])
        told = [(m["text"], [k["text"] for row in m["buttons"] for k in row]) for m in seen]
        assert time.monotonic() < end_s, f"no {text!r} in: {told}"
        await server.wait(seq, 1.0)
