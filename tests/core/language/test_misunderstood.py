from __future__ import annotations

from typing import TYPE_CHECKING

import pytest
from msgspec.structs import replace

from rosic.core.language import Do, Misunderstood

if TYPE_CHECKING:
    from tests.core.language.conftest import Means


@pytest.mark.parametrize(
    ("text", "sentence", "offers"),
    [
        ("omni mvoe 2 m", 'omni has no "mvoe". Did you mean move?', ("omni move 2 m",)),
        (
            "KUKA iiwa grsap force = 20",
            'KUKA iiwa has no "grsap". Did you mean grasp?',
            ("KUKA iiwa grasp force=20",),
        ),
        ("omni sing", 'omni has no "sing". Say help omni.', ("help omni",)),
        ("omin move 2 m", 'I do not know "omin". Did you mean omni?', ("omni move 2 m",)),
        ("/staus", 'I do not know "staus". Did you mean status?', ("status",)),
        ("go-on", 'I do not know "go-on". Did you mean resume?', ("resume",)),
        ("abracadabra", 'I do not know "abracadabra". Say help for what can be said.', ("help",)),
        ("status omin", 'I know no robot "omin". Did you mean omni?', ("status omni",)),
        (
            "crazyflies1 takeoff 1 m",
            'I do not know "crazyflies1". Say help for what can be said.',
            ("help",),
        ),
        (
            "cf7 takeoff 1 m",
            'I do not know "cf7". Did you mean cf1, cf2 or cf3?',
            ("cf1 takeoff 1 m", "cf2 takeoff 1 m", "cf3 takeoff 1 m"),
        ),
        (
            "crazyfiles takeoff 1 m",
            'I do not know "crazyfiles". Did you mean crazyflies?',
            ("crazyflies takeoff 1 m",),
        ),
        ("use fridge", 'I know no robot "fridge". Say robots for those you may use.', ("robots",)),
        (
            "crazyflies tkeoff 1 m",
            'Nobody in crazyflies has "tkeoff". Did you mean takeoff?',
            ("crazyflies takeoff 1 m",),
        ),
        (
            "takeoff 1 m",
            "Which robot is to takeoff: crazyflies, cf1, cf2 or cf3?",
            ("crazyflies takeoff 1 m", "cf1 takeoff 1 m", "cf2 takeoff 1 m", "cf3 takeoff 1 m"),
        ),
        (
            "omni move 1,500 m",
            'omni: "1,500" may mean 1.5 or 1500. Nothing was done.',
            ("omni move 1.5 m", "omni move 1500 m"),
        ),
        (
            "omni move 1,000 m",
            'omni: "1,000" may mean 1 or 1000. Nothing was done.',
            ("omni move 1 m", "omni move 1000 m"),
        ),
        (
            "omni move 1,500m left",
            'omni: "1,500m" may mean 1.5m or 1500m. Nothing was done.',
            ("omni move 1.5m left", "omni move 1500m left"),
        ),
        ("they said we had to stop there", "To stop, send stop in a line of its own.", ("stop",)),
        ("", "There was nothing to read. Say help for what can be said.", ("help",)),
        (" \n\t\u200b\n", "There was nothing to read. Say help for what can be said.", ("help",)),
        ("/", 'I do not know "/". Say help for what can be said.', ("help",)),
        ("please", "Say help for what can be said.", ("help",)),
    ],
)
def test_what_may_have_been_meant(
    means: Means, text: str, sentence: str, offers: tuple[str, ...]
) -> None:
    assert means(text) == Misunderstood(sentence, offers)


def test_a_chosen_robot_that_cannot_does_not_pass_it_on(means: Means) -> None:
    assert means("grasp", "omni") == Misunderstood(
        'omni has no "grasp". Which robot is to grasp: kuka1?', ("kuka1 grasp",)
    )
    assert means("mvoe 2 m", "omni") == Misunderstood(
        'omni has no "mvoe". Did you mean move?', ("omni move 2 m",)
    )
    assert means("kuk1 grasp", "omni") == Misunderstood(
        'omni has no "kuk1". Did you mean kuka1?', ("kuka1 grasp",)
    )


@pytest.mark.parametrize(
    "said",
    ["{} grasp", "help {}", "status {}", "use {}", "resume {}", "{}", "grasp {}", "{} mvoe", "/{}"],
)
def test_what_a_person_may_not_see_is_as_unknown_as_what_does_not_exist(
    means: Means, said: str
) -> None:
    few = frozenset({"omni", "cf1"})
    there = means(said.format("kuka1"), visible=few)
    nowhere = means(said.format("zork1"), visible=few)

    assert isinstance(there, Misunderstood)
    assert isinstance(nowhere, Misunderstood)
    assert there.sentence.replace("kuka1", "zork1") == nowhere.sentence
    assert there.offers == nowhere.offers


def test_nothing_invisible_is_offered(means: Means) -> None:
    for text in (
        "kuka grasp",
        "kuk1 grasp",
        "yum handover",
        "takeof",
        "crazyflie takeoff",
        "grsap",
    ):
        line = means(text, visible=frozenset({"omni"}))
        assert isinstance(line, Misunderstood)
        assert line.offers == ("help",)


def test_a_skill_that_only_one_visible_robot_has_needs_no_name(means: Means) -> None:
    line = means("takeoff 1 m", visible=frozenset({"omni", "cf2"}))

    assert isinstance(line, Do)
    assert line.robots == ("cf2",)


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("x" * 4097, "That message has 4,097 characters; I read at most 4,096. Nothing was done."),
        (
            "omni move 1 m\n" * 5000,
            "That message has 70,000 characters; I read at most 4,096. Nothing was done.",
        ),
        (
            "x" * 100_000,
            "That message has 100,000 characters; I read at most 4,096. Nothing was done.",
        ),
        ("omni move 1 m\n" * 21, "That message has 21 lines; I read at most 20. Nothing was done."),
        ("omni move" + " 1" * 31, "That line has 33 words; I read at most 32. Nothing was done."),
        (
            "status" + " omni" * 32,
            "That line has 33 words; I read at most 32. Nothing was done.",
        ),
        (
            "omni move \u202e5 m",
            (
                "That line has invisible marks that show its words in another order. "
                "Please type it anew. Nothing was done."
            ),
        ),
    ],
)
def test_caps_come_first(means: Means, text: str, sentence: str) -> None:
    assert means(text) == Misunderstood(sentence)


def test_the_largest_message_is_read(means: Means) -> None:
    assert isinstance(means("omni move 1 m" + " " * 4083), Do)
    assert isinstance(means("omni move" + " please" * 28 + " 1 m"), Do)


@pytest.mark.parametrize(
    ("text", "offers"),
    [
        ("omni forward 1 m", ("omni move forward 1 m",)),
        ("omni vor 1 m", ("omni move vor 1 m",)),
        ("omni go forward 1 m", ("omni move forward 1 m",)),
        ("omni picture", ("picture omni",)),
    ],
)
def test_what_leaves_the_skill_out_or_says_it_the_other_way_round_is_offered(
    means: Means, text: str, offers: tuple[str, ...]
) -> None:
    line = means(text)
    assert isinstance(line, Misunderstood)
    assert line.offers == offers


@pytest.mark.parametrize("text", ["stat", "stio", "stapp", "anhaltn", "fermatti"])
def test_a_word_that_resembles_a_stop_offers_it_first(means: Means, text: str) -> None:
    line = means(text)
    assert isinstance(line, Misunderstood)
    assert line.offers[0] == "stop"


@pytest.mark.parametrize("text", ["hallo", "hello", "stand up", "grsp"])
def test_no_other_word_offers_a_stop(means: Means, text: str) -> None:
    line = means(text)
    assert isinstance(line, Misunderstood)
    assert "stop" not in line.offers


def test_politeness_and_the_words_of_a_button_are_understood(means: Means) -> None:
    plain = means("omni move 1 m")
    for text in ("bitte omni move 1 m", "omni bitte move 1 m"):
        assert means(text) == replace(plain, text=text)
    assert means("alle freigeben") == means("freigeben alle") == means("resume all")
