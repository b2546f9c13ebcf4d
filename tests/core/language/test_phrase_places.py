"""Times and places in lines as people write them: plans, kept places, and what keeps one."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from rosic.core.language import (
    Do,
    LanguageReader,
    LineContext,
    Proposed,
    Vocabulary,
    VocabularyHolder,
    understand,
)
from rosic.core.language.arguments import bind
from rosic.core.language.kept_places import KeptPlace
from rosic.core.order import SpokenValue
from rosic.errors import Refusal
from tests.core.language.test_corpus import VOCABULARY, read

if TYPE_CHECKING:
    from rosic.core.robot.skill import Argument

PLANNED = (
    ("omni move 1 m at 15:00", "/schedule 15:00 omni move 1 m"),
    ("kuka1 home in 10 minutes", "/schedule in 10 min kuka1 home"),
    ("kuka1 greif um 10", "/schedule 10:00 kuka1 grasp"),
    ("cf1 heb ab um 2", "/schedule 2:00 cf1 takeoff"),
    ("in an hour omni move 1 m", "/schedule in 1 h omni move 1 m"),
    ("omni 1 m vor in einer halben Stunde", "/schedule in 0.5 h omni move forward 1 m"),
    ("morgen um halb acht omni 1 m vor", "/schedule tomorrow 7:30 omni move forward 1 m"),
    ("morgen um Viertel nach acht omni 1 m vor", "/schedule tomorrow 8:15 omni move forward 1 m"),
    ("morgen um 8 Uhr 30 omni einen Meter vor", "/schedule tomorrow 8:30 omni move forward 1 m"),
    ("tomorrow at half past eight omni move 1 m", "/schedule tomorrow 8:30 omni move 1 m"),
    ("omni move 1 m at 3 pm", "/schedule 15:00 omni move 1 m"),
    ("mañana a las ocho y media omni avanza 1 m", "/schedule tomorrow 8:30 omni move forward 1 m"),
    ("demain à 8h omni avance de 1 m", "/schedule tomorrow 8:00 omni move forward 1 m"),
    ("omni avance 1 m dans deux heures", "/schedule in 2 h omni move forward 1 m"),
    ("amanhã às oito e meia omni avança 1 m", "/schedule tomorrow 8:30 omni move forward 1 m"),
    ("明天下午三点omni前进一米", "/schedule tomorrow 15:00 omni move forward 1 m"),
    ("明天八点半omni前进一米", "/schedule tomorrow 8:30 omni move forward 1 m"),
)


@pytest.mark.parametrize(("text", "meant"), PLANNED)
def test_what_is_said_for_a_time_is_proposed_for_it_and_never_for_now(
    text: str, meant: str
) -> None:
    line = read(text, "")
    assert isinstance(line, Proposed)
    assert line.offers == (meant,)


def test_a_time_without_an_hour_is_no_plan() -> None:
    line = read("tomorrow morning omni move 1 m", "")
    assert not any(offer.startswith("/schedule") for offer in getattr(line, "offers", ()))


def kept(*names: str) -> Vocabulary:
    """Return what can be said where omni has places of these names."""
    holder = VocabularyHolder(VOCABULARY)
    where: dict[str, Argument] = {"x": 1.0, "y": 2.0, "yaw": 0.0}
    values = (SpokenValue("x", 1.0, "m"), SpokenValue("y", 2.0, "m"))
    holder.keep_places("omni", {name: KeptPlace(name, "goto", values, where) for name in names})
    return holder.current


GONE_TO = ("dock", "küche", "cocina", "quai", "base", "车库")


@pytest.mark.parametrize(
    "text",
    [
        "go to the dock",
        "omni go to the dock please",
        "drive omni to the dock",
        "fahr zum dock",
        "omni fahr in die Küche",
        "ve a la cocina",
        "lleva omni a la cocina",
        "va au quai",
        "vai pra base",
        "去车库",
        "omni 去车库",
    ],
)
def test_a_kept_place_is_gone_to_in_any_language(text: str) -> None:
    vocabulary = kept(*GONE_TO)
    [line] = understand(text, vocabulary, LineContext("omni", frozenset({"omni"})))
    assert isinstance(line, Do)
    assert bind(vocabulary, "omni", line.skills[0], line.spoken)["x"] == 1.0
    [line] = understand(text, VOCABULARY, LineContext("omni", frozenset({"omni"})))
    if isinstance(line, Do):  # without it nothing is gone to
        with pytest.raises(Refusal):
            bind(VOCABULARY, "omni", line.skills[0], line.spoken)


@pytest.mark.parametrize(
    "text",
    [
        "don't go to the dock",
        "omni went to the dock",
        "omni dock",
        "bring omni dock",
        "leave the dock",
        "move 1 m to the dock",
        "the dock",
        "can you go to the dock?",
        "go to the dock at 8",
    ],
)
def test_what_only_speaks_of_a_kept_place_goes_nowhere(text: str) -> None:
    vocabulary = kept(*GONE_TO)
    [line] = understand(text, vocabulary, LineContext("omni", frozenset({"omni"})))
    if isinstance(line, Do):
        with pytest.raises(Refusal):
            bind(vocabulary, "omni", line.skills[0], line.spoken)


def test_a_place_that_is_forgotten_is_a_word_like_any_other() -> None:
    holder = VocabularyHolder(kept("dock"))
    holder.keep_places("omni", {})
    assert "dock" not in holder.current.words["omni"].senses
    holder.replace(VOCABULARY)
    assert holder.current.words["omni"].places == frozenset()
    holder = VocabularyHolder(kept("dock"))
    holder.replace(VOCABULARY)
    assert holder.current.words["omni"].places == {"dock"}, "a new fleet keeps it"


KEPT = (
    ("this is the dock", "dock"),
    ("omni this is the dock", "dock"),
    ("remember this place as barn", "barn"),
    ("das ist die Küche", "küche"),
    ("merk dir das als Scheune", "scheune"),
    ("esto es la cocina", "cocina"),
    ("c'est le quai", "quai"),
    ("isto é a garagem", "garagem"),
    ("这是充电桩", "充电桩"),
    ("把这里叫做车库", "车库"),
)


@pytest.mark.parametrize(("text", "name"), KEPT)
def test_this_is_the_dock_is_proposed_as_a_place(text: str, name: str) -> None:
    line = read(text, "omni")
    assert isinstance(line, Proposed)
    assert line.offers == (f"/place omni {name}",)


def test_where_nobody_is_chosen_a_place_is_kept_for_whoever_was_asked_last() -> None:
    everybody = frozenset(VOCABULARY.profiles)
    [line] = understand("this is the dock", VOCABULARY, LineContext("", everybody))
    assert isinstance(line, Proposed)
    assert line.offers == ("/place cf1 dock", "/place cf2 dock", "/place cf3 dock")
    assert line.follows
    last = read("omni move 1 m", "")
    assert isinstance(last, Do)
    reader = LanguageReader(VocabularyHolder(VOCABULARY))
    assert reader.following("this is the dock", last, everybody) == ("/place omni dock",)


@pytest.mark.parametrize("text", ["this is great", "this is the map", "this is not the dock"])
def test_what_names_no_place_keeps_none(text: str) -> None:
    line = read(text, "omni")
    assert not any(offer.startswith("/place ") for offer in getattr(line, "offers", ()))
