from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from rosic.messengers.telegram.formatting import clean, shorten, split, units


def test_a_text_that_fits_is_left_alone() -> None:
    assert split("  *omni*\n\n done ") == ["  *omni*\n\n done "]
    assert split("") == [""]


def test_it_is_cut_at_a_line_if_there_is_one() -> None:
    lines = "\n".join(f"omni: line {number}" for number in range(40))
    parts = split(lines, 100)
    assert all(units(part) <= 100 for part in parts)
    assert "\n".join(parts) == lines


def test_it_is_cut_at_a_word_if_there_is_no_line() -> None:
    assert split("aaaa bbbb cccc dddd", 10) == ["aaaa bbbb", "cccc dddd"]


def test_it_is_counted_as_telegram_counts() -> None:
    assert units("a🤖") == 3
    parts = split("🤖" * 10, 7)
    assert parts == ["🤖🤖🤖", "🤖🤖🤖", "🤖🤖🤖", "🤖"]


def test_no_character_is_taken_apart() -> None:
    family = "👩\u200d🔧"
    assert all(part.endswith("🔧") for part in split(family * 5, 12))
    assert split("e\u0301" * 5, 5) == ["e\u0301" * 2, "e\u0301" * 2, "e\u0301"]


def test_half_a_character_is_replaced() -> None:
    assert clean("a\ud83eb") == "a\ufffdb"
    assert clean("\ud83e\udd16") == "🤖"


def test_what_has_no_second_part_is_shortened() -> None:
    assert shorten("omni", 4) == "omni"
    assert shorten("omni move", 5) == "omni…"


@given(st.text(max_size=300), st.integers(min_value=8, max_value=40))
def test_nothing_is_lost_but_white_space(text: str, limit: int) -> None:
    parts = split(text, limit)
    assert all(units(part) <= limit for part in parts)
    assert "".join("".join(parts).split()) == "".join(clean(text).split())
