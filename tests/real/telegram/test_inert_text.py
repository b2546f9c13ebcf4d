"""What a robot or a person says leads nowhere: no link, no mention, no address in any message."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING

import pytest
from msgspec.structs import replace

from rosic.core.message import Attachment, Pieces
from rosic.messengers.telegram.entities import inert
from rosic.testing.telegram.entities import cut
from tests.real.telegram.gateway import Gateway, to

if TYPE_CHECKING:
    from collections.abc import AsyncGenerator

    from rosic.testing.telegram import FakeTelegram
    from rosic.testing.telegram.state import JsonObject

WICKED = (
    "stück 🤖: see http://evil.example/x?y or evil.com, EVIL.ORG/a and tg://resolve?domain=evil, "
    "ask @stranger_x, write to a.b@evil.com."
)
LINKS = {"url", "email", "mention", "text_link", "text_mention"}


def marked(message: JsonObject, kinds: set[str]) -> list[str]:
    """Return the parts of a message that are marked so."""
    return [
        cut(message["text"], one["offset"], one["length"])
        for one in message["entities"]
        if one["type"] in kinds
    ]


def check(message: JsonObject) -> None:
    assert message["text"] == WICKED, "it is read as it was said"
    assert marked(message, LINKS) == []
    assert marked(message, {"code"}) == [
        "http://evil.example/x?y", "evil.com", "EVIL.ORG/a", "tg://resolve?domain=evil,",
        "@stranger_x", "a.b@evil.com",
    ]  # fmt: skip


async def test_a_message_and_its_edit_lead_nowhere(
    server: FakeTelegram, gateway: Gateway, ada: int
) -> None:
    sent = await gateway.messenger.send(to(ada, WICKED))
    check(server.messages(ada, by_bot=True)[-1])
    await gateway.messenger.edit(sent, to(ada, "done"))
    await gateway.messenger.edit(sent, to(ada, WICKED))
    check(server.messages(ada, by_bot=True)[-1])


async def test_what_stands_beneath_a_file_leads_nowhere(
    server: FakeTelegram, gateway: Gateway, ada: int
) -> None:
    async def read() -> AsyncGenerator[bytes]:
        yield b"PK"

    for attachment in (
        Attachment("a.zip", "application/zip", b"PK"),
        Attachment("a.zip", "application/zip", pieces=Pieces(2, read)),
    ):
        await gateway.messenger.send(replace(to(ada, WICKED), attachment=attachment))
        check(server.messages(ada, by_bot=True)[-1])


async def test_what_is_meant_to_be_tapped_can_be(
    server: FakeTelegram, gateway: Gateway, ada: int
) -> None:
    link = "https://t.me/lab_robots_bot?start=AbC_d-1"
    await gateway.messenger.send(
        to(ada, f"Open {link}. Or say /card or /stop omni: 0.50 m, 14:02.")
    )
    seen = server.messages(ada, by_bot=True)[-1]
    assert [one.rstrip(".") for one in marked(seen, {"url"})] == [link]
    assert marked(seen, {"bot_command"}) == ["/card", "/stop"]
    assert marked(seen, {"code"}) == []


@pytest.mark.parametrize("piece", ["a", "a.", "@a", "a-", "http://", "a@", "1.", "é."])
def test_the_longest_text_takes_no_time(piece: str) -> None:
    text = (piece * 4_096)[:4_096]
    begun_s = time.process_time()
    inert(text)
    assert time.process_time() - begun_s < 0.5
