"""`rosic bench pipeline`: an order that is not done ends the bench, and is no result."""

from __future__ import annotations

import asyncio

import msgspec
import pytest

from rosic.bench import pipeline
from rosic.bench.lanes import BenchMessenger
from rosic.core.message import Chat, Outbound

BRIEF = msgspec.structs.replace(pipeline.CASES[0], orders=500, people=20)
CHAT = Chat("bench", "0")


async def test_every_order_that_counts_has_acted_once() -> None:
    rate_per_s, times = await pipeline.run(BRIEF)

    assert len(times) >= BRIEF.orders
    assert rate_per_s > 0


@pytest.mark.parametrize(
    "text", ["robot1 is busy.", "robot1: skill0\nsent 14:02:07\nfailed 14:02:08: stuck"]
)
async def test_an_order_that_is_not_done_is_no_result(text: str) -> None:
    messenger = BenchMessenger()
    ended = messenger.ended["7"] = asyncio.get_running_loop().create_future()
    said = Outbound(chat=CHAT, text=text, reply_to="7")

    await (messenger.edit("7", said) if "\n" in text else messenger.send(said))

    with pytest.raises(AssertionError, match="no result"):
        await asyncio.wait_for(ended, 10.0)
