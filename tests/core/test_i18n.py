"""A sentence is English and can be said otherwise."""

from __future__ import annotations

import gettext

import pytest

from rosic.config.plugins import catalogue
from rosic.core.i18n import ImperialCatalogue, Sentence, in_language, joined, said, said_n
from rosic.core.units import measured

GERMAN = {
    "{robot} is free.": "{robot} ist frei.",
    "{who} has {robot} for {left}.": "{robot} gehört noch {left} lang {who}.",
    "an hour": "eine Stunde",
}


class German(gettext.NullTranslations):
    def gettext(self, message: str) -> str:
        return GERMAN.get(message, message)

    def ngettext(self, msgid1: str, msgid2: str, n: int) -> str:
        assert (msgid1, msgid2) == ("one message", "{n} messages")
        return "eine Nachricht" if n == 1 else "{n} Nachrichten"


def test_it_is_its_english_text() -> None:
    sentence = said("{robot} is free.", robot="kuka1")
    assert sentence == "kuka1 is free."
    assert type(str(sentence)) is str


def test_it_is_said_in_another_language_in_that_languages_order() -> None:
    sentence = said("{who} has {robot} for {left}.", who="Ana", robot="kuka1", left=said("an hour"))
    assert sentence == "Ana has kuka1 for an hour."
    assert in_language(sentence, German()) == "kuka1 gehört noch eine Stunde lang Ana."


@pytest.mark.parametrize(
    ("n", "english", "german"),
    [
        (0, "0 messages", "0 Nachrichten"),
        (1, "one message", "eine Nachricht"),
        (2, "2 messages", "2 Nachrichten"),
    ],
)
def test_a_number_chooses_the_form(n: int, english: str, german: str) -> None:
    sentence = said_n("one message", "{n} messages", n)
    assert (sentence, in_language(sentence, German())) == (english, german)


def test_a_row_keeps_each_sentence_and_leaves_names_alone() -> None:
    row = joined("\n", [said("{robot} is free.", robot="omni"), "omni", said("an hour")])
    assert row == "omni is free.\nomni\nan hour"
    assert in_language(row, German()) == "omni ist frei.\nomni\neine Stunde"
    assert in_language(joined(" ", [row]), German()) == in_language(row, German())


def test_what_a_person_wrote_is_no_template() -> None:
    sentence = said("{robot} is free.", robot="{left} {0}")
    assert in_language(sentence, German()) == "{left} {0} ist frei."
    assert in_language("an hour", German()) == "an hour"


def test_without_a_catalogue_it_stays_english() -> None:
    assert in_language(said("an hour"), None) == "an hour"
    assert not isinstance(in_language(said("an hour"), None), Sentence)


def test_decimals_have_a_comma_where_they_are_read_with_one() -> None:
    german, feet = catalogue("de"), ImperialCatalogue(catalogue("de"))
    way = measured("1.50 m", 1.5, "m")
    assert in_language(way, german) == "1,50 m"
    assert in_language(way, feet) == "4,92 ft"
    assert in_language(way, ImperialCatalogue(None)) == "4.92 ft"
    assert in_language(measured("12.5 N", 12.5, "N"), german) == "12,5 N"
    assert in_language(measured("22.5 deg", 22.5, "deg"), german) == "22,5 Grad"
    assert in_language(said("{hint}, else {default}", hint="x", default=0.25), german) == (
        "x, sonst 0,25"
    )
    assert str(way) == "1.50 m"
