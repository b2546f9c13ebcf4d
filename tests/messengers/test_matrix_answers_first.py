"""An answer reaches the homeserver before it is asked for more."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

from rosic.core.message import Chat, Outbound
from tests.messengers.matrix_lab import ADA, HostileLab, hostile_lab

if TYPE_CHECKING:
    from pathlib import Path

ROOM = "!room:example.org"
TRIES = 20
"""A busy machine may be slower than what is waited; never to wait is seen in none of them."""


async def answered_first(lab: HostileLab, body: str) -> bool:
    """Let Ada say something that is answered; return whether the answer came before a sync."""
    came = asyncio.create_task(lab.hears(body))
    asked = lab.server.asked
    begun, sent = len(asked), len(lab.server.sent)
    taking = asyncio.create_task(lab.gives({ROOM: [lab.plain(ADA, body)]}))
    await came
    await lab.messenger.send(Outbound(chat=Chat("matrix", ROOM), text=f"answer to {body}"))
    await lab.until(lambda: len(lab.server.sent) > sent)
    await taking
    first = next(path for method, path in asked[begun:] if method == "PUT" or path == "/sync")
    return first != "/sync"


async def test_an_answer_goes_before_the_next_sync(tmp_path: Path) -> None:
    async with hostile_lab(tmp_path) as lab:
        await lab.gives(joined={ROOM: lab.entering(ADA, encrypted=False)})
        await lab.gives()
        await lab.listens()

        assert any([await answered_first(lab, f"status {n}") for n in range(TRIES)])
