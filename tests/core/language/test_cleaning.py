# ruff: noqa: RUF001 - people type what is ambiguous
from __future__ import annotations

import sys
from time import thread_time
from unicodedata import combining, normalize

import pytest

from rosic.app.features import command_table
from rosic.bench.recorder import pace_of_machine
from rosic.core.language import clean, clean_name, hears_stop, inert_text, without_codes
from rosic.core.language.sanitise import MOST_MARKS, drawn, fold_word, normalised, quote

ABOVE, BELOW = "\u0301", "\u0316"
"""Canonical order puts the second before the first."""


def test_what_cannot_be_seen_goes() -> None:
    assert clean("a\x00b\u200bc\u202ed\ufeffe\ud800f\x7fg") == "abcdefg"
    assert clean("one\r\ntwo\u2028three\tfour") == "one\ntwo\nthree four"


def test_what_people_write_stays() -> None:
    for text in ("omni move 1 m", "Grüße, 世界! 🦾", "रुको", "قف", "a\nb", "x ≤ 5"):
        assert clean(text) == text


def test_a_name_is_one_short_line_of_plain_forms() -> None:
    assert clean_name(" ＫＵＫＡ\u202e\n iiwa ") == "KUKA iiwa"
    assert len(clean_name("n" * 1000)) == 64


def test_a_name_gives_no_command() -> None:
    for name in ("/unlock Eve", "\uff0funlock Eve", "/\u200bunlock Eve"):
        assert clean_name(name) == "\u2215unlock Eve"
    assert clean_name("Ada/Bo 1/2") == "Ada/Bo 1/2"
    assert clean_name(clean_name("/a")) == clean_name("/a")
    assert quote("/stop") == '"\u2215stop"'


def test_a_quotation_is_short() -> None:
    assert quote("mv\x00oe\n") == '"mvoe"'
    assert len(quote("x" * 10_000)) == 35


def test_a_word_is_folded_without_changing_its_number() -> None:
    assert fold_word("５０ｃｍ") == "50cm"
    assert fold_word("٢٫٥") == "2.5"
    assert fold_word("\u22125") == "-5"
    assert fold_word("㎝") == "cm"
    # NFKC alone would make 102 of it, and 112 of the next.
    assert fold_word("10²") == "10²"
    assert fold_word("1½") == "1½"
    assert fold_word("①") == "①"


def test_of_the_marks_on_a_letter_the_first_thirty_are_kept() -> None:
    """As many as Unicode's Stream-Safe Text has room for; no language needs as many."""
    thirty = (ABOVE + BELOW) * 15
    thirty_sorted = BELOW * 15 + ABOVE * 15
    assert normalised("x" + thirty) == "x" + thirty_sorted
    for beyond in (ABOVE, BELOW, BELOW * 4_000, "\uff9e" * 40):
        assert normalised(f"x{thirty}{beyond}y") == normalised(f"x{thirty}y")
    assert normalised(f"x{thirty}yx{thirty}") == normalised(f"x{thirty}yx") + thirty_sorted
    signs = "\U0001f916\u2265" * 40
    assert normalised(signs) == signs


def test_there_is_no_mark_of_which_more_are_kept() -> None:
    """Of every character that canonical order moves; each is three marks at most."""
    for character in map(chr, range(sys.maxunicode + 1)):
        apart = normalize("NFKD", character)
        if combining(apart[0]):
            found = normalised("x" + character * 100)
            assert len(normalize("NFD", found)) <= 1 + 3 * MOST_MARKS, hex(ord(character))


@pytest.mark.parametrize("read", [normalised, drawn])
def test_marks_out_of_order_take_no_time(read: object) -> None:
    """To sort them took 0.1 s; of four times as many, half a second."""
    assert callable(read)
    read("x" + ABOVE * 2 + BELOW)  # what is made once is made
    began_s = thread_time()
    read("x" + ABOVE * 2_047 + BELOW * 2_047)
    assert thread_time() - began_s < 0.020 * pace_of_machine()


def test_a_stop_is_heard_beneath_marks() -> None:
    assert hears_stop("s" + (ABOVE + BELOW) * 40 + "top") == ()


def test_no_command_is_made_of_what_a_robot_says() -> None:
    slash = "\u2215"
    assert inert_text("say /resume, (/stop) or\n/start x") == (
        f"say {slash}resume, ({slash}stop) or\n{slash}start x"
    )
    for harmless in ("1/2", "km/h", "a / b", "and/or", "see http://x.y/z"):
        assert inert_text(harmless) == harmless
    assert inert_text("\u202e/stop") == f"{slash}stop"
    assert inert_text("https://T.me/bot?start=c") == f"https://T.me{slash}bot?start=c"


@pytest.mark.parametrize(
    ("text", "kept"),
    [
        ("/code 123456", "/code -"),
        ("Code\t123456", "Code -"),
        ("/code@lab_bot 123456", "/code@lab_bot -"),
        ("/authenticator 123456", "/authenticator -"),
        ("join WAVE-LEFT", "join -"),
        ("hello\n/start WAVE-LEFT\nstop", "hello\n/start -\nstop"),
        ("/code\n123456\nhello", "/code\n-\nhello"),
    ],
)
def test_no_code_is_left_of_a_line_that_brings_one(text: str, kept: str) -> None:
    assert without_codes(text, command_table(), "-") == kept


@pytest.mark.parametrize(
    "text", ["", "omni move 1 m", "two\r\nlines\n", "/authenticator reset Bo", "/code", "decode 1"]
)
def test_what_brings_none_stays_as_it_was(text: str) -> None:
    assert without_codes(text, command_table(), "-") == text
