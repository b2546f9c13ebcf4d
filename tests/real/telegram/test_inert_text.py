"""What a robot or a person says leads nowhere: no link, no mention, no address in any message."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING

import pytest
from msgspec.structs import replace

from rosic.core.message import Attachment, StreamedContent
from rosic.messengers.telegram.formatting import inert
from rosic.testing.telegram.entities import cut
from tests.pace import patience
from tests.real.telegram.gateway import Gateway, to

if TYPE_CHECKING:
    from collections.abc import AsyncGenerator

    from rosic.testing.telegram import FakeTelegram
    from rosic.testing.telegram.state import JsonObject

FAULTY = (
    "stück 🤖: see http://evil.example/x?y or evil.com, EVIL.ORG/a and tg://resolve?domain=evil, "
    "ask @stranger_x, write to a.b@evil.com. Now #follow $EVIL, 10.0.0.7/a or +1-212-555-0123!"
)
LINKS = {
    "url",
    "email",
    "mention",
    "text_link",
    "text_mention",
    "hashtag",
    "cashtag",
    "phone_number",
}
CARD = "4111 1111 1111 1111"


def marked(message: JsonObject, kinds: set[str]) -> list[str]:
    """Return the parts of a message that are marked so."""
    return [
        cut(message["text"], one["offset"], one["length"])
        for one in message["entities"]
        if one["type"] in kinds
    ]


def check(message: JsonObject) -> None:
    assert message["text"] == FAULTY, "it is read as it was said"
    assert marked(message, LINKS) == []
    assert marked(message, {"code"}) == [
        "http://evil.example/x?y",
        "evil.com",
        "EVIL.ORG/a",
        "tg://resolve?domain=evil,",
        "@stranger_x",
        "a.b@evil.com",
        "#follow",
        "$EVIL",
        "10.0.0.7/a",
        "+1-212-555-0123",
    ]


async def test_a_message_and_its_edit_lead_nowhere(
    server: FakeTelegram, gateway: Gateway, ada: int
) -> None:
    sent = await gateway.messenger.send(to(ada, FAULTY))
    check(server.messages(ada, by_bot=True)[-1])
    await gateway.messenger.edit(sent, to(ada, "done"))
    await gateway.messenger.edit(sent, to(ada, FAULTY))
    check(server.messages(ada, by_bot=True)[-1])


async def test_what_stands_beneath_a_file_leads_nowhere(
    server: FakeTelegram, gateway: Gateway, ada: int
) -> None:
    async def read() -> AsyncGenerator[bytes]:
        yield b"PK"

    for attachment in (
        Attachment("a.zip", "application/zip", b"PK"),
        Attachment("a.zip", "application/zip", pieces=StreamedContent(2, read)),
    ):
        await gateway.messenger.send(replace(to(ada, FAULTY), attachment=attachment))
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


def marks(text: str) -> list[str]:
    return [cut(text, one.offset, one.length) for one in inert(text) or ()]


@pytest.mark.parametrize(
    "text",
    [
        "omni 2: x 1.50 m, 14:02:07",
        "2026-11-22 14:02:07",
        "2026-11-22T14:02:07Z",
        "from 22.11.2026 until 23.11.2026, 9:00-17:00",
        "52.520008, 13.404954",
        "robot #3, 1#, #",
        "it costs $5 or 5$",
        "10 20 30 40 50 60",
        "0 10 20 30 40 50",
        "0.1 0.2 0.3 0.4 0.5 0.6",
        "-1.2345678 rad",
        "1,234,567 steps",
        "code 123456",
        "Fri 2026-11-20 to 2026-11-27",
        "room 12-34",
        "5-10 m",
        "version 1.2.3",
        "C# and F#",
        "12 345 678",
        "1 2 3 4 5 6 7 8 9 0 1 2 3",
    ],
)
def test_an_ordinary_sentence_stays_plain(text: str) -> None:
    assert marks(text) == []


@pytest.mark.parametrize(
    "told",
    [
        "#help",
        "#ünder_1",
        "#1a",
        "$TON",
        "$1INCH",
        "+49 30 1234567",
        "+1 (650) 253-0000",
        "89161234567",
        "(030) 123 4567",
        "030 1234567",
        "0151 23456789",
        "650-253-0000",
        "650 253 0000",
        "555-0123",
        CARD,
        CARD.replace(" ", "-"),
        CARD.replace(" ", ""),
        "3782 822463 10005",
        "192.168.0.1:80/x",
        "ftp://evil.example",
        "tonsite://evil.ton",
    ],
)
def test_what_a_client_would_make_tappable_is_marked(told: str) -> None:
    assert marks(f"🤖 ({told} ), he said") == [told]


def test_a_number_in_an_invitation_takes_nothing_from_it() -> None:
    assert marks("Open https://t.me/lab_robots_bot?start=1234567-8901234 now") == []


def test_more_marks_than_telegram_keeps_are_one() -> None:
    text = "now " + "#a " * 150 + "end"
    assert marks(text) == ["#a " * 149 + "#a"]
    assert len(marks("#a " * 100)) == 100


@pytest.mark.parametrize(
    "piece",
    [
        "a",
        "a.",
        "@a",
        "a-",
        "http://",
        "a@",
        "1.",
        "é.",
        "#",
        "#1",
        "$A",
        "1",
        "1 ",
        "1-",
        "0",
        "+1 ",
        "(1",
        "01 2",
        "1  ",
        "10.0.0.",
    ],
)
def test_the_longest_text_takes_no_time(piece: str) -> None:
    text = (piece * 4_096)[:4_096]
    begun_s = time.process_time()
    inert(text)
    assert time.process_time() - begun_s < 0.5 * patience()
