"""Codes and the words that two sides compare."""

from __future__ import annotations

import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rosic.authoriser.invite_codes import (
    ALPHABET,
    WORDS,
    code_said,
    codes_in,
    digest,
    join_text,
    new_code,
    normal,
    reads_as_stop,
    shared_words,
    without_these,
)
from rosic.core.identity import Address
from rosic.core.secret import Secret
from rosic.messengers.telegram.messenger import deep_link
from rosic.testing.clock import SeededEntropy


class Bytes:
    """Entropy that gives what it is told."""

    def __init__(self, content: bytes) -> None:
        self.content = content

    def token(self, length: int) -> bytes:
        assert length == len(self.content)
        return self.content


def test_a_code_has_forty_bits_and_no_lookalikes() -> None:
    assert len(set(ALPHABET)) == 32
    assert not set("ILOU") & set(ALPHABET)
    assert new_code(Bytes(bytes(5))).reveal() == "0000-0000"
    assert new_code(Bytes(b"\xff" * 5)).reveal() == "ZZZZ-ZZZZ"
    # Every bit counts: no two of these are the same.
    single = {new_code(Bytes((1 << n).to_bytes(5, "big"))).reveal() for n in range(40)}
    assert len(single) == 40


@pytest.mark.parametrize("code", ["4GS5-PARA", "PARA-Z5SY", "FMQC-PARA", "HA1T-HALT"])
def test_a_code_that_is_heard_as_a_stop_is_known_as_one(code: str) -> None:
    assert reads_as_stop(Secret(code))
    assert not reads_as_stop(Secret("7K3M-Q0ZD"))


def test_a_code_is_not_shown_by_accident() -> None:
    code = new_code(SeededEntropy())
    assert re.fullmatch(r"[0-9A-HJKMNP-TV-Z]{4}-[0-9A-HJKMNP-TV-Z]{4}", code.reveal())
    assert code.reveal() not in repr(code) + str(code)


@pytest.mark.parametrize("typed", ["7k3m-q0zd", "7K3M Q0ZD", "7k3mqOzd", " 7K3M\u2013QoZD "])
def test_a_code_is_read_however_it_is_typed(typed: str) -> None:
    assert normal(typed) == "7K3MQ0ZD"


def test_i_and_l_read_as_one() -> None:
    assert normal("ilIL-1111") == "11111111"


@pytest.mark.parametrize(
    "typed", ["", "7K3M", "7K3M-Q0Z", "7K3M-Q0ZDD", "7K3M-Q0ZU", "7K3M-Q0Z\u0661", "a" * 10_000]
)
def test_what_cannot_be_a_code_is_none(typed: str) -> None:
    assert normal(typed) is None


@given(st.text())
def test_reading_a_code_is_total(text: str) -> None:
    symbols = normal(text)
    assert symbols is None or all(symbol in ALPHABET for symbol in symbols)
    code_said(text)
    codes_in(text)


@given(st.binary(min_size=5, max_size=5))
def test_every_code_survives_the_ways_it_travels(drawn: bytes) -> None:
    code = new_code(Bytes(drawn))
    symbols = code.reveal().replace("-", "")
    link = deep_link("lab_robots_bot", code)
    payload = link.partition("?start=")[2]

    assert re.fullmatch(r"[A-Za-z0-9_-]{1,64}", payload)
    for said in (f"/start {payload}", f"/start@lab_robots_bot {payload}", link, join_text(code)):
        assert normal(code_said(said) or "") == symbols
    assert symbols in codes_in(f"look: {payload}, good?")


DASHES = "-\u00ad\u2010\u2011\u2012\u2013\u2014\u2015\u2212\u2e3a\ufe58\ufe63\uff0d"
BLANKS = " \t\n\u00a0\u2009\u200b\u3000\ufe0f\ufeff"
MARKUP = "_*`~|./\u0336"
IN_LINKS = ("%2D", "%2d", "%20")
BETWEEN = st.lists(st.sampled_from([*DASHES, *BLANKS, *MARKUP, *IN_LINKS]), max_size=3).map("".join)
AROUND = st.sampled_from(
    ["", "Hi Di:\njoin ", "type /start ", "tg://resolve?domain=lab&start=", "\u00fcU", "code is"]
) | st.text(max_size=20)
FULL_WIDTH = {ord(symbol): ord(symbol) + 0xFEE0 for symbol in ALPHABET}


def written(symbol: str) -> st.SearchStrategy[str]:
    """Return the ways to write a symbol that whoever reads it types as one."""
    alike = {"0": "Oo", "1": "IiLl"}.get(symbol, "")
    return st.sampled_from([symbol, symbol.lower(), symbol.translate(FULL_WIDTH), *alike])


@given(st.binary(min_size=5, max_size=5), st.data())
def test_a_code_is_found_and_taken_out_however_it_is_written(
    drawn: bytes, data: st.DataObject
) -> None:
    symbols = new_code(Bytes(drawn)).reveal().replace("-", "")
    shown = "".join(data.draw(written(s)) + data.draw(BETWEEN) for s in symbols)
    text = data.draw(AROUND) + shown + data.draw(AROUND)
    assert symbols in codes_in(text)
    kept = without_these(text, (symbols,), "(not kept)")
    assert symbols not in codes_in(kept)
    assert "(not kept)" in kept


def test_words_stay_beside_a_code_that_is_taken_out() -> None:
    text = "Hi Di \u2014 join _m3pq \u2011 kqe4_, or M3PQ%2DKQE4. Bye!"
    kept = "Hi Di \u2014 join _(-)_, or (-). Bye!"
    assert without_these(text, ("M3PQKQE4",), "(-)") == kept
    assert without_these(text, (), "(-)") is text


@pytest.mark.parametrize(
    "text", ["omni move 50 cm", "start omni move", "stop", "/start", "join", "hello-there you"]
)
def test_an_ordinary_message_hands_in_no_code(text: str) -> None:
    assert code_said(text) is None


def test_the_digest_needs_the_key() -> None:
    assert digest(b"a" * 32, "7K3MQ0ZD") != digest(b"b" * 32, "7K3MQ0ZD")
    assert len(digest(b"a" * 32, "7K3MQ0ZD")) == 16
    assert "7K3M" not in deep_link("bot", Secret("X")) + repr(Secret("7K3M"))


def test_the_words_are_short_distinct_and_unlike() -> None:
    assert len(WORDS) == 256 == len(set(WORDS))
    assert all(re.fullmatch(r"[a-z]{4,7}", word) for word in WORDS)
    alike = [(a, b) for a in WORDS for b in WORDS if a < b and differs_by_one(a, b)]
    assert alike == []


def differs_by_one(a: str, b: str) -> bool:
    if len(a) == len(b):
        return sum(x != y for x, y in zip(a, b, strict=True)) <= 1
    short, long = sorted((a, b), key=len)
    return len(long) - len(short) == 1 and any(
        long[:n] + long[n + 1 :] == short for n in range(len(long))
    )


def test_the_shared_words_depend_on_the_whole_redemption() -> None:
    here = Address("telegram", "1")
    said = shared_words("w1", "i1", here)
    others = {
        shared_words("w2", "i1", here),
        shared_words("w1", "i2", here),
        shared_words("w1", "i1", Address("telegram", "2")),
        shared_words("w1", "i1", Address("matrix", "1")),
    }
    assert said == shared_words("w1", "i1", here)
    assert said not in others
    assert len(said.split()) == 2
    # About 16 bits: a thousand redemptions rarely share their words.
    many = {shared_words(f"w{n}", "i1", here) for n in range(1_000)}
    assert len(many) > 970
