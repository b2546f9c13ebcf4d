# ruff: noqa: RUF001 - people type what is ambiguous
from __future__ import annotations

import pytest

from rosic.app.commands import command_table
from rosic.core.language import clean, clean_name, inert_text, without_codes
from rosic.core.language.sanitise import fold_word, quote


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
