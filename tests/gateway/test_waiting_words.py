"""Whoever writes wait or no while a robot moves for them is shown what ends it; nothing stops."""

from __future__ import annotations

import pytest

from rosic.core.language import hears_cancel, hears_stop, hears_wait
from rosic.core.language.wait_detection import WAIT
from rosic.core.message import ChatKind
from tests.gateway.place import BO, Place

LONG_S = 10_000.0
MOVES = "omni: move, 1.00 m forward"
GOES_ON = (
    f"What you asked for has not ended yet ({MOVES}). "
    "To end it, tap a button or say stop or cancel."
)


def _works(place: Place) -> bool:
    return place.gateway.rooms.linker.current("omni") is not None


WORDS = """
    wait, Wait!, no, NO NO, nooo, warte, warten, Warte mal, nein, hold on, oops, omni wait, attends,
    espera, нет, подожди, 等一下, 待って, 잠깐만, no; not there
"""


@pytest.mark.parametrize("word", [word.strip() for word in WORDS.split(",")])
async def test_it_offers_what_ends_it(word: str) -> None:
    async with Place().open() as place:
        place.robot("omni").work_s = LONG_S
        await place.say("omni move 1 m")
        assert await place.say(word) == GOES_ON
        assert _works(place), "a word of every day stops nothing"
        labels = [b.label for row in place.last()[1].buttons for b in row]
        assert labels == ["STOP omni", "Cancel omni"]
        told = await place.tap(*place.button("Cancel omni"))
        assert "omni is at rest" in told
        assert not _works(place)


async def test_of_a_robot_that_is_not_there_nothing_is_said_but_that() -> None:
    async with Place().open() as place:
        for name in ("omni", "kuka1"):
            place.robot(name).work_s = LONG_S
            await place.say(f"{name} wave")
        place.robot("omni").online = False
        assert await place.say("no") == (
            f"{GOES_ON.replace(MOVES, 'omni: wave; kuka1: wave')} "
            "omni is not there; whether it moves is not known."
        )
        await place.say("/language de")
        assert "omni ist nicht da; ob er sich bewegt, ist nicht bekannt." in await place.say("nein")


async def test_its_stop_button_stops() -> None:
    async with Place().open() as place:
        place.robot("omni").work_s = LONG_S
        await place.say("omni move 1 m")
        await place.say("wait")
        await place.tap(*place.button("STOP omni"))
        assert place.robot("omni").gate.latched


async def test_who_has_nothing_under_way_is_answered_as_always() -> None:
    async with Place().open() as place:
        place.robot("omni").work_s = LONG_S
        await place.say("omni move 1 m")
        assert "not ended yet" not in await place.say("no", account=BO, chat="2")
        assert "not ended yet" not in await place.say("wait for omni", account=BO, chat="2")


async def test_in_a_group_only_a_line_that_says_nothing_else() -> None:
    async with Place().open() as place:
        place.robot("omni").work_s = LONG_S
        group = {"kind": ChatKind.GROUP, "chat": "-5"}
        await place.say("omni move 1 m", **group)
        assert await place.say("no problem, we have an hour", **group) == ""
        assert await place.say("no", account=BO, **group) == "", "it is not Bo's to end"
        assert await place.say("no, wait", **group) == GOES_ON


async def test_what_was_asked_for_elsewhere_is_not_shown_in_a_group() -> None:
    async with Place().open() as place:
        place.robot("omni").work_s = place.robot("kuka1").work_s = LONG_S
        group, another = ({"kind": ChatKind.GROUP, "chat": chat} for chat in ("-5", "-6"))
        await place.say("omni move 1 m")
        for word in ("wait", "no", "omni wait"):
            assert "move" not in await place.say(word, **group)
        await place.say("kuka1 wave", **group)
        assert "wave" not in await place.say("no", **another)
        assert await place.say("no", **group) == GOES_ON.replace(MOVES, "kuka1: wave")
        assert await place.say("no") == GOES_ON.replace(MOVES, f"{MOVES}; kuka1: wave")


def test_none_of_them_is_a_stop_or_a_cancel() -> None:
    for word in WAIT:
        assert hears_stop(word) is None, word
        assert hears_cancel(word) is None, word
        assert hears_wait(word), word
