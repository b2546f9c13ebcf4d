"""What adapters say of their quality is so, and the page says what they say."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from tests import quality

if TYPE_CHECKING:
    from pathlib import Path

ASKED = [
    quality.QualityRule("one", "bronze", "One."),
    quality.QualityRule("two", "silver", "Two."),
    quality.QualityRule("three", "gold", "Three."),
]
DONE = quality.QualityAnswer("done", shown_by=("tests/quality.py",))
TODO = quality.QualityAnswer("todo", why="Not yet.")
EXEMPT = quality.QualityAnswer("exempt", why="There is none.")


@pytest.mark.parametrize("name", sorted(quality.adapters()))
def test_what_an_adapter_says_is_there(name: str) -> None:
    assert quality.untrue(quality.adapters()[name], quality.rules()) == []


def test_every_messenger_that_people_have_answers() -> None:
    folders = {path.parent.name for path in quality.MESSENGERS.glob("*/messenger.py")}
    assert set(quality.adapters()) == folders - {"mcp", "program"}, "those are for programs"


def test_the_page_is_written_of_what_adapters_say() -> None:
    assert quality.PAGE.read_text(encoding="utf-8") == quality.page(), "run: make texts"


@pytest.mark.parametrize(
    ("answers", "tier"),
    [
        ((TODO, DONE, DONE), ""),
        ((DONE, TODO, DONE), "bronze"),
        ((DONE, EXEMPT, TODO), "silver"),
        ((EXEMPT, DONE, DONE), "gold"),
    ],
)
def test_a_tier_needs_all_before_it(answers: tuple[quality.QualityAnswer, ...], tier: str) -> None:
    said = dict(zip(("one", "two", "three"), answers, strict=True))
    assert quality.tier_of(said, ASKED) == tier


@pytest.mark.parametrize(
    ("answer", "wrong"),
    [
        (quality.QualityAnswer("done"), "nothing shows it"),
        (quality.QualityAnswer("done", ("tests/nowhere.py",)), "tests/nowhere.py is not there"),
        (
            quality.QualityAnswer("done", ("tests/quality.py::test_none",)),
            "tests/quality.py::test_none is not there",
        ),
        (quality.QualityAnswer("todo"), "no sentence says why"),
        (quality.QualityAnswer("perhaps", why="So."), "perhaps is no answer"),
    ],
)
def test_what_is_said_and_not_so_is_found(answer: quality.QualityAnswer, wrong: str) -> None:
    said = {"one": answer, "two": DONE, "three": TODO}
    assert quality.untrue(said, ASKED) == [f"one: {wrong}"]


def test_a_rule_that_is_not_answered_and_an_answer_without_one_are_found() -> None:
    said = {"one": DONE, "two": DONE, "four": DONE}
    assert quality.untrue(said, ASKED) == ["three: not answered", "four: no such rule"]


def test_two_answers_to_one_rule_are_refused(tmp_path: Path) -> None:
    (tmp_path / "lines").mkdir()
    (tmp_path / "lines" / "quality.toml").write_text(
        '[done]\none = ["tests"]\n[todo]\none = "Not yet."\n'
    )
    with pytest.raises(AssertionError, match=r"\['one'\] are answered twice"):
        quality.adapters(tmp_path)
