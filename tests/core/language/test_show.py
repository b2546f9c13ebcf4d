from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from rosic.core.language import Do, Vocabulary, bind, show
from rosic.core.language.formatting import show_bound, show_number, show_value
from rosic.core.robot.skill import Skill

if TYPE_CHECKING:
    from tests.core.language.conftest import Means


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("omni move 50 cm left", "move, 0.50 m left"),
        ("omni move 2 m 0.5 m/s", "move, 2.00 m, 0.5 m/s forward"),
        ("omni turn right 0.25 turn", "turn, 90 deg right"),
        ("kuka1 grasp", "grasp, 15 N"),
        ("kuka1 grasp 20", "grasp, 20 N"),
        ("kuka1 move joint 3 -30 deg", "move joint, joint 3, -30 deg"),
        ("cf1 goto 1 -2 1.5", "goto, x 1.00 m, y -2.00 m, z 1.50 m"),
        ("yumi handover", "handover"),
        ("oven heat 212 °F", "heat, 100 °C"),
        ("omni go home", "go home"),
        ("echo hello\nthere".replace("\n", " "), 'say, "hello there"'),
    ],
)
def test_what_an_order_does_in_the_units_of_the_profile(
    means: Means, vocabulary: Vocabulary, text: str, shown: str
) -> None:
    line = means(text)
    assert isinstance(line, Do)
    arguments = bind(vocabulary, line.robots[0], line.skills[0], line.spoken)

    assert show(vocabulary, line.robots[0], line.skills[0], arguments) == shown


def test_an_unknown_skill_or_argument_is_no_reason_to_fail(vocabulary: Vocabulary) -> None:
    assert show(vocabulary, "nobody", Skill(id="fly"), {"x": 1.0}) == "fly"
    grasp = vocabulary.profiles["kuka1"].skills["grasp"]
    assert show(vocabulary, "kuka1", grasp, {"force": 7.0, "colour": "red"}) == "grasp, 7 N"
    assert show(vocabulary, "kuka1", grasp, {}) == "grasp"


@pytest.mark.parametrize(
    ("value", "shown"),
    [
        (0, "0"),
        (-0.0, "0"),
        (15, "15"),
        (0.25, "0.25"),
        (1 / 3, "0.333"),
        (1e-9, "1e-09"),
        (123456.7891, "123456.789"),
        (1e12, "1e+12"),
        (float("nan"), "nan"),
        (float("inf"), "inf"),
    ],
)
def test_a_number_is_short(value: float, shown: str) -> None:
    assert show_number(value) == shown


def test_a_value_is_shown_in_its_unit(vocabulary: Vocabulary) -> None:
    exact = vocabulary.units.exact
    assert show_value(0.5, exact["m"]) == "0.50 m"
    assert show_value(0.0123, exact["m"]) == "0.012 m"
    assert show_value(0.5, exact["cm"]) == "50 cm"
    assert show_value(0.2, exact["%"]) == "20 %"


def test_a_bound_is_rounded_inwards(vocabulary: Vocabulary) -> None:
    feet = vocabulary.units.exact["ft"]
    assert show_bound(0.0, 5.0, feet, upper=True) == "16.4"
    assert show_bound(5.0, 9.0, feet, upper=False) == "16.41"
    assert show_bound(-5.0, 0.0, feet, upper=False) == "-16.4"
    assert show_bound(0.0, 5.0, feet, upper=False) == "0"
    assert show_bound(0.0, 3.048, feet, upper=True) == "10"
    # Too near to each other for four digits.
    assert show_bound(5.0, 5.0001, feet, upper=True) == "16.4045"
