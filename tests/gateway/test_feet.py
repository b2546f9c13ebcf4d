"""Whoever chose feet reads no metre in anything that ROSIC says of itself."""

from __future__ import annotations

import re

import pytest

from rosic.core.i18n import ImperialCatalogue, in_language
from rosic.core.policy.limits import limit_in_words, quantity_in_words
from rosic.core.units import bound_in_words
from tests.gateway.place import Place
from tests.gateway.test_german_walk import CHATS, FLEET, SCRIPT, Simulated, follow

FEET = ImperialCatalogue(None)
_METRIC = re.compile(r"(?<![\w.,])-?\d+(?:[.,]\d+)? ?(?:mm|cm|km|m|kg)(?:/s)?(?![\w/])")
_TYPED = re.compile(r"/\S+(?: [^\s.,·)]+)*|\"[^\"]*\"")
MORE = """
A /settings speed 0.2 m/s
A omni move 2 m
A task omni move 2 m
A omni move 1 m speed=0.5
A /settings
A /me
A grant Bo operator omni with speed <= 0.3 m/s for 2h
B /me
A /role guest may omni:move with speed <= 0.3 m/s
A /invite operator omni with speed <= 0.3 m/s
A cf1 follow cf2
"""


def metres_in(text: str) -> list[str]:
    """Return what a text has in metres that nobody typed here."""
    found = _METRIC.findall(_TYPED.sub(" ", text))
    typed = {each.replace(",", ".") for each in _METRIC.findall(SCRIPT + MORE)}
    return [each for each in found if each.replace(",", ".") not in typed]


@pytest.mark.limit(300)
async def test_whoever_chose_feet_reads_no_metres_anywhere() -> None:
    found = []
    async with Simulated(fleet=FLEET).open() as place:
        for account in CHATS.values():
            await place.say("/settings units imperial", account=account, chat=account)
        for line in filter(None, (MORE + SCRIPT).splitlines()):
            for outbound in await follow(place, line):
                labels = [button.label for row in outbound.buttons for button in row]
                for text in (outbound.text, *labels):
                    found += [f"{line}: {metres_in(text)} in {text!r}"] * bool(metres_in(text))
    assert not found, "\n".join(dict.fromkeys(found))


@pytest.mark.parametrize(
    ("limit", "in_feet"),
    [
        ("speed <= 0.2 m/s", "speed <= 0.66 ft/s"),
        ("speed<=0.2m/s", "speed<=0.66 ft/s"),
        ("distance >= 1 m and distance <= 2 m", "distance >= 3.28 ft and distance <= 6.56 ft"),
        ("kuka1:grasp force <= 20 N", "kuka1:grasp force <= 20 N"),
        ("battery >= 20 %", "battery >= 20 %"),
    ],
)
def test_a_limit_is_read_in_ones_own_units(limit: str, in_feet: str) -> None:
    assert limit_in_words(limit) == limit
    assert in_language(limit_in_words(limit), FEET) == in_feet


@pytest.mark.parametrize("value", [0.01, 0.05, 0.8, 1.0, 5.0, 10.0, 123.456, -0.8, -10.0])
def test_bounds_in_feet_are_within_those_in_metres(value: float) -> None:
    for upper in (True, False):
        feet = float(in_language(bound_in_words(value, "m", upper=upper, with_unit=False), FEET))
        assert feet * 0.3048 == pytest.approx(value, rel=0.01)
        assert feet * 0.3048 <= value if upper else feet * 0.3048 >= value


def test_what_is_no_quantity_stays_as_it_was_said() -> None:
    assert in_language(quantity_in_words("as it is"), FEET) == "as it is"
    assert in_language(bound_in_words(0.0, "m", upper=True), FEET) == "0 ft"


async def test_a_number_without_a_unit_is_no_metre_to_whoever_reads_feet() -> None:
    async with Place().open() as place:
        await place.say("/settings units imperial")
        for typed, offers in (
            ("omni move 1", ["omni move 1 ft", "omni move 3.28 ft"]),
            ("omni move back 4", ["omni move back 4 ft", "omni move back 13.12 ft"]),
            ("omni move distance=2", ["omni move distance=2 ft", "omni move distance=6.56 ft"]),
        ):
            await place.say(typed)
            told = list(place.chat.told)[-1].outbound
            assert told.text.startswith("Say the unit of ")
            assert [button.label for row in told.buttons for button in row] == offers
        assert place.acted() == 0
        await place.say("omni move 1 ft")
        await place.say("/settings units metric")
        await place.say("kuka1 move 1")
        assert (place.acted(), place.acted("kuka1")) == (1, 1)
