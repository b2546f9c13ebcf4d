"""`rosic bench pipeline`: an order that is not done ends the bench, and is no result."""

from __future__ import annotations

import asyncio

import msgspec
import pytest

from rosic.bench import orders, pipeline
from rosic.bench.senders import BenchMessenger
from rosic.core.message import Chat, Outbound
from tests.pace import pace

BRIEF = msgspec.structs.replace(pipeline.CASES[0], orders=500, people=20)
CHAT = Chat("bench", "0")


async def test_every_order_that_counts_has_acted_once() -> None:
    (ran,) = await orders.run(BRIEF)

    assert len(ran.times_ns) >= BRIEF.orders
    assert ran.rate_per_s > 0


async def test_cases_that_are_compared_take_turns_and_each_order_acts_once() -> None:
    few, many = await orders.run(BRIEF, msgspec.structs.replace(BRIEF, people=40))

    assert len(few.slices) == len(many.slices) == orders.SLICES
    for ran in (few, many):
        assert sum(n for n, _ in ran.slices) == len(ran.times_ns) >= BRIEF.orders


@pytest.mark.parametrize(
    "text", ["robot1 is busy.", "robot1: skill0\nsent 14:02:07\nfailed 14:02:08: stuck"]
)
async def test_an_order_that_is_not_done_is_no_result(text: str) -> None:
    messenger = BenchMessenger()
    ended = messenger.ended["7"] = asyncio.get_running_loop().create_future()
    said = Outbound(chat=CHAT, text=text, reply_to="7")

    await (messenger.edit("7", said) if "\n" in text else messenger.send(said))

    with pytest.raises(AssertionError, match="no result"):
        await asyncio.wait_for(ended, 60 * pace())
