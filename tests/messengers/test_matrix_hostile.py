"""What a stranger or a homeserver sends so that a stop is lost, or more than a stop counts."""

from __future__ import annotations

import asyncio
from collections import Counter

import pytest

from rosic.core.identity import Address
from rosic.core.message import Chat, Inbound, MessageValidity
from rosic.core.policy.roles import Assurance
from rosic.messengers.matrix.reading import ReadEvent
from rosic.messengers.matrix.rooms import entered_at
from rosic.messengers.matrix.sync_window import SyncWindow

OWN = "@robots:example.org"


async def handed_over(text: str) -> Inbound:
    """Return how an urgent message is handed over."""
    heard: list[Inbound] = []

    async def receive(inbound: Inbound) -> None:
        heard.append(inbound)

    async def weigh(_one: ReadEvent) -> Inbound:
        raise AssertionError("a stop waits for no look at keys")

    inbound = Inbound(
        sender=Address("matrix", "@ada:example.org"),
        chat=Chat("matrix", "!room:example.org"),
        message="$one",
        text=text,
        sent_ns=1,
        received_ns=1,
    )
    one = ReadEvent(inbound, urgent=True, known=True, reaction=False, evidence=None)
    async with asyncio.TaskGroup() as group:
        window = SyncWindow(group, receive, weigh, Counter())
        batch = window.begin("token")
        window.admit(one, batch)
        window.close(batch)
    (found,) = heard
    return found


@pytest.mark.parametrize("text", ["stop kuka1\nomni move 1 m", "stop\r\nomni move 1 m"])
async def test_beside_a_stop_that_nobody_looked_at_nothing_counts(text: str) -> None:
    found = await handed_over(text)
    assert (found.text, found.standing) == (text, MessageValidity.ANONYMOUS)


async def test_what_turns_out_to_be_no_stop_may_only_look() -> None:
    found = await handed_over("stop")
    assert found.standing is MessageValidity.UNVERIFIED
    assert found.assurance is Assurance.PROVIDER_READABLE


def test_only_what_came_as_an_event_of_the_room_is_one() -> None:
    source = {"type": "m.room.member", "state_key": OWN, "content": {"membership": "invite"}}
    assert entered_at([source], OWN) == 1
    assert entered_at([{"type": "m.room.encrypted", "content": source}], OWN) == 0
