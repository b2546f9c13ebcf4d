"""A chat as a picture: nothing sticks out, nothing is lost, and the same is drawn the same."""

from __future__ import annotations

from typing import TYPE_CHECKING
from xml.etree import ElementTree as ET

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rosic.testing.telegram.picture import WIDTH, cut, draw, in_picture, width_of, wrapped
from rosic.testing.telegram.transcript import App, Bubble, Key, Quote, Transcript

if TYPE_CHECKING:
    from collections.abc import Iterator

SVG = "{http://www.w3.org/2000/svg}"
TEXTS = st.text(st.characters(exclude_categories=["Cs", "Cc"]) | st.just("\n"), max_size=120)
KEYS = st.lists(st.builds(Key, st.text(min_size=1, max_size=40), st.integers(0, 99)), max_size=3)
BUBBLES = st.builds(
    Bubble,
    text=TEXTS,
    at=st.just("14:02"),
    message=st.integers(1, 3),
    name=st.text(max_size=40),
    own=st.booleans(),
    keys=st.lists(KEYS.filter(bool).map(tuple), max_size=3).map(tuple),
    edited=st.booleans(),
    past=st.booleans(),
    answers=st.none() | st.builds(Quote, st.integers(1, 3), TEXTS, TEXTS),
    tap=st.integers(0, 1),
)


def places(svg: str) -> Iterator[tuple[float, float]]:
    """Return where each rectangle and each measured line begins and ends, from left to right."""
    for one in ET.fromstring(svg).iter():  # noqa: S314 - drawn here
        if one.tag == f"{SVG}rect":
            left = float(one.get("x", 0))
            yield left, left + float(one.attrib["width"])
        elif one.tag == f"{SVG}text" and "textLength" in one.attrib:
            long, x = float(one.attrib["textLength"]), float(one.attrib["x"])
            left = x - long / 2 if one.get("text-anchor") == "middle" else x
            yield left, left + long


@given(TEXTS, st.floats(20, 400))
def test_no_line_is_wider_than_allowed_and_no_letter_is_lost(text: str, most: float) -> None:
    lines = wrapped(text, 15, most)
    assert all(width_of(line, 15) <= most or len(line.strip()) <= 1 for line in lines)
    assert "".join("".join(lines).split()) == "".join(text.split())


def test_lines_break_where_words_end_and_begin_as_far_in_as_they_were() -> None:
    assert wrapped("one two three\n  four", 10, 40) == ["one two", "three", "  four"]
    assert wrapped("", 10, 40) == [""]


def test_accents_are_as_wide_as_the_letter_under_them() -> None:
    assert width_of("für Ärzte", 15) == width_of("fur Arzte", 15)
    assert width_of("a\u0308", 15) == width_of("a", 15)
    assert width_of("\u4f60", 10) == 10


def test_what_does_not_fit_a_line_is_cut_off() -> None:
    assert cut("short", 13, 200) == "short"
    long = cut("a button whose label is far too long for a phone", 13, 100)
    assert long.endswith("\u2026")
    assert width_of(long, 13) <= 100


@given(st.lists(BUBBLES, max_size=6), st.text(max_size=60))
def test_nothing_sticks_out_and_the_transcript_is_in_the_picture(
    bubbles: list[Bubble], title: str
) -> None:
    shown = Transcript(title, tuple(bubbles))
    svg = draw(shown)
    assert all(left >= 0 and right <= WIDTH for left, right in places(svg))
    assert in_picture(svg) == shown
    assert draw(in_picture(svg)) == svg


@given(st.lists(BUBBLES, max_size=6), st.text(max_size=60))
def test_every_line_says_how_long_it_is_so_that_no_font_carries_it_out(
    bubbles: list[Bubble], title: str
) -> None:
    svg = ET.fromstring(draw(Transcript(title, tuple(bubbles), below=title)))  # noqa: S314
    for line in svg.iter(f"{SVG}text"):
        shown = line.text or ""
        if len(shown) > 2 and width_of(shown, 1.0):  # a number in a disc has room
            assert line.get("textLength"), shown


def test_markup_in_a_message_stays_text() -> None:
    said = "</metadata><script>alert(1)</script> & <b>"
    svg = draw(Transcript(said, (Bubble(text=said, at="14:02", message=1, keys=((Key(said),),)),)))
    tags = {one.tag.removeprefix(SVG) for one in ET.fromstring(svg).iter()}  # noqa: S314
    assert tags == {"svg", "metadata", "rect", "path", "circle", "text"}


def test_the_messengers_own_words_are_in_the_persons_language() -> None:
    bubble = Bubble(text="/start", at="14:02", message=1, tap=1, edited=True)
    svg = draw(Transcript("Roboter", (bubble,), app=App("STARTEN", "bearbeitet")))
    assert ">STARTEN<" in svg
    assert ">bearbeitet 14:02<" in svg


def test_another_picture_holds_no_transcript() -> None:
    with pytest.raises(ValueError, match="holds no transcript"):
        in_picture("<svg/>")
