"""Asking for a code of the page: by oneself, in one's own chat, just now."""

from __future__ import annotations

import re

import pytest

from rosic.core.message import ChatKind
from rosic.core.time_units import MINUTE_NS
from rosic.features.sign_in.commands import may_carry_code
from tests.api.served import served

LINK = re.compile(r"^Or open: http://127\.0\.0\.1:0/#code=\S+$", re.MULTILINE)


@pytest.mark.parametrize(
    ("kind", "age_ns", "answer"),
    [
        (ChatKind.PRIVATE, 0, "Your code for the page:"),
        (ChatKind.GROUP, 0, "Write /signin to me alone"),
        (ChatKind.PRIVATE, 30 * MINUTE_NS, "is 30 minutes old"),
    ],
)
async def test_a_code_is_given_to_whoever_asks_alone_and_now(
    kind: ChatKind, age_ns: int, answer: str
) -> None:
    async with served() as place:
        asked_ns = place.server.context.kernel.machine_clock.wall_ns() - age_ns
        place.chat.say("/signin", account="ada", chat="ada", kind=kind, sent_ns=asked_ns)
        await place.until(lambda: any(answer in one.outbound.text for one in place.chat.told))
        given = any("Your code for the page:" in one.outbound.text for one in place.chat.told)
        assert given is (answer == "Your code for the page:")
        linked = [LINK.search(one.outbound.text) for one in place.chat.told]
        assert any(linked) is given


@pytest.mark.parametrize(
    ("url", "there"),
    [
        ("https://robots.example.org", True),
        ("http://127.0.0.1:8765", True),
        ("http://[::1]:8765", True),
        ("http://localhost:8765", True),
        ("http://192.0.2.7:8765", False),
        ("http://robots.example.org", False),
    ],
)
def test_a_link_carries_a_code_where_nobody_reads_along(url: str, *, there: bool) -> None:
    assert may_carry_code(url) is there
