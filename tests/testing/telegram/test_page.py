"""docs/fake-bot-api.md says what is true."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from rosic.testing.telegram.control_door import VERBS
from rosic.testing.telegram.dispatch import METHODS

PAGE = (Path(__file__).parents[3] / "docs" / "fake-bot-api.md").read_text(encoding="utf-8")
SOURCES = "".join(
    path.read_text(encoding="utf-8")
    for path in sorted((Path(__file__).parents[3] / "src/rosic/testing/telegram").rglob("*.py"))
)
DOCUMENTATION = "https://core.telegram.org/bots/api"
BLOCKS = re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL)


@pytest.mark.parametrize("block", BLOCKS)
async def test_the_examples_run(block: str) -> None:
    names: dict[str, object] = {}
    exec(compile(block, "docs/fake-bot-api.md", "exec"), names)  # noqa: S102 - our own page
    example = names["example"]
    assert callable(example)
    await example()


def test_there_are_examples() -> None:
    assert len(BLOCKS) == 3


def test_every_verb_is_explained() -> None:
    assert [verb for verb in VERBS if f"`{verb}" not in PAGE] == []


def test_every_method_has_a_row_that_says_what_it_refuses_and_what_is_left_out() -> None:
    _, _, record = PAGE.partition("## Every method")
    rows = [line.split("|") for line in record.splitlines() if line.startswith("| [`")]
    named = [found for row in rows for found in re.findall(r"\[`(\w+)`\]\((\S+)\)", row[1])]
    assert sorted(name for name, _ in named) == sorted(METHODS)
    wrong = [name for name, page in named if page != f"{DOCUMENTATION}#{name.lower()}"]
    assert wrong == [], "a method is documented elsewhere"
    assert {len(row) for row in rows} == {6}


@pytest.mark.parametrize(
    "words",
    sorted({
        words
        for row in PAGE.partition("## Every method")[2].splitlines()
        if row.startswith("| [`")
        for words in re.findall(r"`([^`]+)`", row.split("|")[3])
        if "..." not in words and words not in {"retry_after", "Logged out"}
    }),
)  # fmt: skip
def test_the_words_of_a_refusal_are_those_of_the_server(words: str) -> None:
    assert words in SOURCES or words.removesuffix(" not found") in SOURCES
