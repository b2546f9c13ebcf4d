"""Every sentence of the code is in every catalogue, with the same fields, and compiled."""

from __future__ import annotations

from string import Formatter
from typing import TYPE_CHECKING

import pytest

from rosic.config.plugins import LANGUAGES, catalogue
from tests.texts import NotLiteral, compiled, languages, po_of, read, templates, templates_in

if TYPE_CHECKING:
    from babel.messages.catalog import Message


def said_in(message: Message) -> tuple[str, ...]:
    """Return the forms of a translation."""
    return (message.string,) if isinstance(message.string, str) else tuple(message.string or "")


def fields(form: str) -> set[tuple[str, str, str | None]]:
    """Return the fields of a form, with how each is shown."""
    return {
        (name, spec or "", conversion)
        for _, name, spec, conversion in Formatter().parse(form)
        if name is not None
    }


def differing(message: Message) -> list[str]:
    """Return the forms of a translation that have other fields than the English."""
    ours = (message.id,) if isinstance(message.id, str) else tuple(message.id)
    wanted = set().union(*(fields(form) for form in ours))
    # A form for one may say the number in words.
    least = set.intersection(*(fields(form) for form in ours))
    return [form for form in said_in(message) if not least <= fields(form) <= wanted]


def lacking(known: dict[object, Message]) -> list[object]:
    """Return the templates of the code that a catalogue does not know, or has no words for."""
    return [t for t in templates() if t not in known or not all(said_in(known[t]))]


@pytest.fixture(params=languages())
def language(request: pytest.FixtureRequest) -> str:
    return str(request.param)


def messages(language: str) -> dict[object, Message]:
    return {message.id: message for message in read(language) if message.id}


def test_every_language_on_offer_has_its_texts() -> None:
    assert {"en", *languages()} == set(LANGUAGES)
    assert catalogue("en") is None
    assert all(catalogue(code) is not None for code in languages())


def test_every_sentence_is_translated(language: str) -> None:
    assert not lacking(messages(language)), "make texts, then translate"


def test_nothing_is_kept_that_nobody_says(language: str) -> None:
    assert set(messages(language)) <= set(templates()), "make texts"


def test_a_translation_is_sure_of_itself(language: str) -> None:
    assert not [message.id for message in messages(language).values() if message.fuzzy]


def test_a_translation_has_the_same_fields(language: str) -> None:
    assert not [form for message in messages(language).values() for form in differing(message)]


def test_what_ships_is_what_was_translated(language: str) -> None:
    shipped = po_of(language).with_suffix(".mo").read_bytes()
    assert shipped == compiled(read(language)), "make texts"


@pytest.mark.parametrize(
    "line",
    ["said(text)", 'said(f"{x} is here")', 'said("")', 'said_n("one", many, 2)', 'said("a" + b)'],
)
def test_a_template_is_written_out(line: str) -> None:
    with pytest.raises(NotLiteral):
        list(templates_in(line, "a module"))


def test_the_rules_can_fail() -> None:
    known = messages("de")
    message = known.pop("{name} is unlocked.")
    assert lacking(known) == ["{name} is unlocked."]
    message.string = "{nome} ist frei."
    assert differing(message) == ["{nome} ist frei."]
    known[message.id] = message
    message.string = ""
    assert lacking(known) == [message.id]
