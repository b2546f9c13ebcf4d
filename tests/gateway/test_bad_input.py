"""Whatever is written, a gateway answers with a sentence and loses nothing."""

from __future__ import annotations

import logging
from random import Random
from typing import TYPE_CHECKING

import pytest

from rosic.core.message import ChatKind, MessageValidity
from tests.core.language.test_total import mutated, noise
from tests.gateway.place import ADA, BO, STRANGER, VI, Place

if TYPE_CHECKING:
    from collections.abc import Iterator

SENTENCES = [
    ("robx move 1 m", 'I do not know "robx".'),
    ("omni fly 1 m", 'omni has no "fly".'),
    ("omni move speed=1", 'omni: move has no "speed".'),
    ("omni move 3 N", "omni: 3 N is a force; distance takes a length (m). Nothing was done."),
    ("omni move 3 furlongz", 'omni: move does not know "furlongz".'),
    ("omni move nan m", "omni: distance takes a finite number. Nothing was done."),
    ("omni move inf m", "omni: distance takes a finite number. Nothing was done."),
    ("omni move -1 m", "omni: distance cannot be negative. Nothing was done."),
    ("omni move 1e400 m", "omni: distance takes a finite number. Nothing was done."),
    ("omni move " + "9" * 400 + " m", "omni: distance takes a finite number. Nothing was done."),
    ("", "There was nothing to read."),
    ("\u202eomni move 1 m", "invisible marks"),
    ("omni move 1 m " * 400, "I read at most"),
    ("a" * 4_096, "I do not know"),
    ("a" * 100_000, "I read at most"),
    ("\x00\x07", "There was nothing to read."),
    ("\ud800 omni", "omni can:"),
    ("\ud800", "There was nothing to read."),
]


@pytest.fixture
def errors(caplog: pytest.LogCaptureFixture) -> Iterator[list[str]]:
    found: list[str] = []
    yield found
    wrong = [r.getMessage() for r in caplog.records if r.levelno >= logging.ERROR]
    assert not wrong, wrong


@pytest.mark.parametrize(("text", "part"), SENTENCES)
async def test_the_sentence_a_person_meets(text: str, part: str, errors: list[str]) -> None:
    async with Place().open() as place:
        told = await place.say(text)
        assert part in told, told
        assert place.acted() == 0, errors
        await place.say("omni move 1 m")
        assert place.acted() == 1, "the next message is not harmed"


MESSAGES = 3_000


async def carry(count: int) -> None:
    random = Random(7)  # noqa: S311 - the same messages every time
    accounts = (ADA, BO, VI, STRANGER)
    async with Place().open() as place:
        for number in range(count):
            text = noise(random) if number % 4 == 0 else mutated(random)
            account = accounts[number % 4]
            place.chat.say(
                text,
                account=account,
                chat=random.choice(("1", "2", "g")),
                kind=random.choice(list(ChatKind)),
                standing=random.choice(list(MessageValidity))
                if number % 5 == 0
                else MessageValidity.FRESH,
                sent_ns=place.clock.wall_ns() - random.choice((0, 10**9, 10**13)),
            )
            if number % 10 == 0:
                await place.clock.advance(0.5)
            if number % 50 == 0:
                await place.say("resume omni", message=f"r{number}")
        await place.quiet()
        assert sum(place.acted(name) for name in place.gateway.robots) > count // 200


async def test_thousands_of_generated_messages_raise_nothing(errors: list[str]) -> None:
    await carry(MESSAGES)
    assert not errors


@pytest.mark.campaign
@pytest.mark.limit(1800)
async def test_a_hundred_thousand_generated_messages_raise_nothing(errors: list[str]) -> None:
    await carry(100_000)
    assert not errors
