"""Public classes are named in words that a reader of the field, or of the glossary, knows."""

from __future__ import annotations

import pytest

from tests.shape import names
from tests.shape.tree import source

# Each of its classes is named after the rule it breaks, as a sentence: `ForgetsTheFence`.
FAULTY = "rosic.testing.faulty."
GLOSSARY = names.GLOSSARY.read_text(encoding="utf-8")
LISTED = names.listed_words(names.FIELD_WORDS.read_text(encoding="utf-8"))


def named_source() -> dict[str, str]:
    return {name: text for name, text in source().items() if not name.startswith(FAULTY)}


def test_every_public_class_is_named_in_words_of_the_field_or_of_the_glossary() -> None:
    known = LISTED | names.terms_of(GLOSSARY)

    assert names.unknown_words(named_source(), known) == []


def test_the_list_holds_no_word_that_nobody_needs() -> None:
    assert names.unused_words(named_source(), LISTED) == []


def test_what_the_glossary_explains_is_not_listed_as_everybodys_word() -> None:
    assert sorted(LISTED & names.terms_of(GLOSSARY)) == []


def test_every_old_name_leads_to_one_that_is_there() -> None:
    lost = names.lost_names(names.RENAMED.read_text(encoding="utf-8"), source())
    assert lost == [], f"say in {names.RENAMED.name} where it is now"


def test_a_row_that_leads_nowhere_is_found() -> None:
    texts = {"rosic.a": "class Box(Tin):\n", "rosic_sim.b": "Pair = tuple\n"}
    there = [
        "`x.py` | `a.py`",
        "`x.py`, `y.py` | `a/__init__.py`",
        "`X` | `Pair` | `rosic_sim/b.py`",
    ]
    lost = [
        "`x.py` | `b.py`",
        "`X` | `Boxes` | `a.py`",
        "`X` | `Tin` | `a.py`",
        "`X` | `Box` | `c.py`",
    ]
    page = "\n".join(["| was | is |", "|---|---|", *(f"| {row} |" for row in there + lost)])

    assert names.lost_names(page, texts) == lost


@pytest.mark.parametrize(
    ("name", "word"),
    [("Custody", "custody"), ("AccessCustody", "custody"), ("RobotClerks", "clerks")],
)
def test_a_class_in_words_of_ones_own_is_found(name: str, word: str) -> None:
    texts = {"rosic.planted": f"class {name}:\n    pass\n"}
    known = LISTED | names.terms_of(GLOSSARY)

    assert names.unknown_words(texts, known) == [f"rosic.planted.{name}: {word}"]


def test_private_classes_and_functions_are_left_alone() -> None:
    text = "class _Custody:\n    pass\n\n\ndef custody() -> None:\n    pass\n"

    assert names.unknown_words({"rosic.planted": text}, set()) == []


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("RobotToRobotContext", ["robot", "to", "robot", "context"]),
        ("HTTPReply", ["http", "reply"]),
        ("Ros2Robot", ["ros", "robot"]),
        ("ApiBot", ["api", "bot"]),
    ],
)
def test_a_name_is_taken_apart(name: str, words: list[str]) -> None:
    assert names.words_of(name) == words


@pytest.mark.parametrize(
    ("word", "base"),
    [("queries", "query"), ("planning", "plan"), ("stores", "store"), ("renderer", "render")],
)
def test_forms_of_a_word_are_one_word(word: str, base: str) -> None:
    assert base in names.base_forms(word)


def test_only_the_first_column_of_the_glossary_explains_a_word() -> None:
    table = "| word | means |\n|---|---|\n| policy epoch | the number of custody |\n"

    assert names.terms_of(table) == {"policy", "epoch"}
