"""People write as they talk: what is exact acts, what is meant is proposed, and a tap does it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest
from msgspec.structs import replace

from tests.gateway.place import BO, FLEET, MOVE, VI, Place
from tests.gateway.test_meant_in_groups import acts, heard

if TYPE_CHECKING:
    from rosic.core.robot.profile import Profile

REVERSE = {"direction": {"forward": "back", "back": "forward"}}


def fleet() -> tuple[Profile, ...]:
    """Return robots of which a move can be undone."""
    move = replace(MOVE, reverse=REVERSE)
    return tuple(replace(robot, skills={**robot.skills, "move": move}) for robot in FLEET)


def labels(place: Place) -> list[str]:
    """Return what the buttons under the last message say."""
    return [button.label for row in place.last()[1].buttons for button in row]


async def test_what_is_exact_acts_in_other_words() -> None:
    async with Place(fleet=fleet()).open() as place:
        for text, shown in (
            ("omni 50 cm vor", "move, 0.50 m forward"),
            ("can you move omni half a meter to the left?", "move, 0.50 m left"),
            ("omni 前进一米", "move, 1.00 m forward"),
        ):
            said = await place.say(text)
            assert shown in said
            assert "done" in said
        assert acts(place) == {"omni": 3}


async def test_a_proposal_shows_robot_and_values_and_only_a_tap_does_it() -> None:
    async with Place(fleet=fleet()).open() as place:
        said = await place.say("omni ein bisschen vor")
        assert said == "Is that what you mean? Nothing was done yet."
        assert labels(place) == [
            "omni move forward 0.5 m",
            "omni move forward 1 m",
            "omni move forward 2 m",
        ]
        assert acts(place) == {}
        assert "done" in await place.tap(*place.button("omni move forward 0.5 m"))
        assert acts(place) == {"omni": 1}


async def test_nobody_else_taps_a_proposal() -> None:
    async with Place(fleet=fleet()).open() as place:
        await place.say("omni ein bisschen vor")
        message, nonce = place.button("omni move forward 0.5 m")
        await place.tap(message, nonce, account=BO)
        assert acts(place) == {}


async def test_a_proposal_gives_nobody_a_right() -> None:
    async with Place(fleet=fleet()).open() as place:
        await place.say("omni ein bisschen vor", account=VI)
        said = await place.tap(*place.button("omni move forward 0.5 m"), account=VI)
        assert "right" in said
        assert acts(place) == {}


@pytest.mark.parametrize(
    ("text", "label"),
    [
        ("again", "Do it"),
        ("no, back", "omni move back 1 m"),
        ("the other way", "omni move back 1 m"),
        ("nein, zurück", "omni move back 1 m"),
        ("the same but 2 m", "omni move 2 m"),
        ("a bit more", "omni move 0.5 m"),
    ],
)
async def test_what_is_vague_goes_on_from_the_last_order(text: str, label: str) -> None:
    async with Place(fleet=fleet()).open() as place:
        await place.say("omni move 1 m")
        await place.say(text)
        assert label in labels(place)
        assert acts(place) == {"omni": 1}
        assert "done" in await place.tap(*place.button(label))
        assert acts(place) == {"omni": 2}


@pytest.mark.parametrize("text", ["undo", "/undo", "go back", "not that"])
async def test_an_undo_proposes_the_reverse_of_the_last_order(text: str) -> None:
    async with Place(fleet=fleet()).open() as place:
        await place.say("use omni")
        await place.say("move 1 m")
        await place.say(text)
        assert labels(place)[0] == "omni move back 1 m"
        assert acts(place) == {"omni": 1}
        await place.say("use cf1")
        await place.say("undo")
        assert "omni move back 1 m" not in labels(place), "what is taken back then is the choice"
        assert acts(place) == {"omni": 1}


async def test_a_change_of_words_voids_nothing_that_is_proposed() -> None:
    async with Place(fleet=fleet()).open() as place:
        await place.say("omni ein bisschen vor")
        button = place.button("omni move forward 0.5 m")
        await place.say("/settings language en")
        assert "done" in await place.tap(*button)
        assert acts(place) == {"omni": 1}


async def test_somebody_elses_order_is_not_gone_on_from() -> None:
    async with Place(fleet=fleet()).open() as place:
        await place.say("omni move 2 m", account=BO)
        await place.say("the same but 1 m")
        assert "omni" not in " ".join(labels(place))


QUESTIONS = (
    ("where is omni?", "omni"),
    ("wo ist omni?", "omni"),
    ("¿dónde está omni?", "omni"),
    ("which robots are there?", "Which robot?"),
    ("what can omni do?", "omni can:"),
    ("was kannst du?", "help"),
)


@pytest.mark.parametrize(("text", "answer"), QUESTIONS)
async def test_questions_are_answered_and_move_nothing(text: str, answer: str) -> None:
    async with Place(fleet=fleet()).open() as place:
        assert answer in await place.say(text)
        assert acts(place) == {}


async def test_whoever_greets_is_shown_what_to_begin_with() -> None:
    async with Place(fleet=fleet()).open() as place:
        assert await place.say("good morning") == "Hello. Which robot?"
        assert labels(place) == ["cf1", "cf2", "kuka1", "omni"]
        assert await place.say("thank you!") == "You are welcome."
        assert await place.say("never mind") == "All right. Nothing was done."
        assert (await place.say("who are you?")).startswith("I am ROSIC, a program:")


DENIALS = (
    "omni should never move 1 m",
    "do not move omni 1 m",
    "why did omni move 1 m?",
    "if omni moves forward 1 m it hits the wall",
    "omni a avance de 1 m",
    "omni esta 1 m a la izquierda",
)


@pytest.mark.parametrize("text", DENIALS)
async def test_what_is_no_order_moves_nothing(text: str) -> None:
    async with Place(fleet=fleet()).open() as place:
        await place.say(text)
        assert acts(place) == {}


async def test_people_who_talk_about_robots_are_not_interrupted() -> None:
    async with Place(fleet=fleet()).open() as place:
        for text in ("hello", "a bit more", "faster", "vor 50 cm", "what happened?", "thanks"):
            assert await heard(place, text) == "", text
        assert acts(place) == {}
        assert await heard(place, "setze omni einen Meter vor") == ""
        assert await heard(place, "thanks for the wave omni") == ""
        assert acts(place) == {}
        assert "done" in await heard(place, "omni 50 cm vor")
        assert acts(place) == {"omni": 1}


async def test_in_a_group_what_names_a_robot_first_or_addresses_us_is_answered() -> None:
    async with Place(fleet=fleet()).open() as place:
        assert "mean" in await heard(place, "omni ein bisschen vor")
        assert "Hello" in await heard(place, "hello", addressed=True)
        assert acts(place) == {}


async def test_the_same_words_are_read_otherwise_where_they_may_be_overheard() -> None:
    async with Place(fleet=fleet()).open() as place:
        assert await heard(place, "hello") == ""
        assert "Hello" in await place.say("hello")
        assert await heard(place, "hello") == ""


async def test_a_chat_with_nobody_to_go_on_from_offers_the_first_steps() -> None:
    async with Place(fleet=fleet()).open() as place:
        await place.say("use omni")
        await place.say("faster")
        assert labels(place)[0] == "omni move forward 0.5 m"
