"""What nobody said stays within one's own limits, and that is said; what was said is refused."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest
from msgspec.structs import replace

from rosic.core.policy.roles import Role, SkillPrecondition
from rosic.core.robot.skill import Parameter
from tests.gateway.place import BO, FLEET, MOVE, Place
from tests.gateway.test_agreed_acts import Noting
from tests.gateway.test_rights import lab, rules

if TYPE_CHECKING:
    from collections.abc import Iterator

STUDENT = Role(scopes=("*:*",), limits=("distance <= 1 m",), priority=5)
FAR = replace(
    MOVE,
    parameters={
        **MOVE.parameters,
        "distance": Parameter(unit="m", min=0.01, max=5.0, default=2.0),
        "speed": Parameter(unit="m/s", min=0.05, max=2.0, default=1.0),
    },
)
METRE = {"direction": "forward", "distance": 1.0, "speed": 1.0}


@pytest.fixture(autouse=True)
def _far(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    fleet = tuple(replace(p, skills={**p.skills, "move": FAR}) for p in FLEET)
    monkeypatch.setattr("tests.gateway.test_rights.FLEET", fleet)
    monkeypatch.setattr(Place, "kind", Noting)
    Noting.done.clear()
    yield
    Noting.done.clear()


async def asks(place: Place, line: str) -> str:
    return await place.say(line, account=BO, chat=BO)


def arguments() -> list[dict[str, object]]:
    return [values for _, _, values in Noting.done]


async def test_a_default_above_ones_limit_is_lowered_to_it_and_said() -> None:
    async with lab(rules(student=STUDENT), {"Bo": "student"}) as place:
        told = await asks(place, "omni move")
        assert arguments() == [METRE]
        assert "omni: move, 1.00 m forward" in told
        assert "as much as your limit allows (distance <= 1 m)" in told


async def test_of_several_lines_only_the_one_that_was_lowered_says_so() -> None:
    async with lab(rules(student=STUDENT), {"Bo": "student"}) as place:
        await asks(place, "omni move\nomni move 0.5 m")
        await place.quiet()
        shown = [told.outbound.text for told in place.chat.told]
        assert any("1.00 m forward, as much as your limit allows" in text for text in shown)
        assert any("0.50 m forward" in text for text in shown)
        assert not any("0.50 m forward, as much" in text for text in shown)


async def test_a_task_stays_within_ones_limit_as_an_order_of_ones_own_does() -> None:
    async with lab(rules(student=STUDENT), {"Bo": "student"}) as place:
        await asks(place, "/task omni move")
        await place.quiet()
        assert arguments() == [METRE]
        lowered = "move, 1.00 m forward, as much as your limit allows (distance <= 1 m) · task 1"
        assert any(lowered in told.outbound.text for told in place.chat.told)


async def test_what_was_said_above_the_limit_is_refused_as_ever() -> None:
    async with lab(rules(student=STUDENT), {"Bo": "student"}) as place:
        told = await asks(place, "omni move 1.5 m")
        assert "for you, move is allowed with distance <= 1 m. Nothing was done." in told
        told = await asks(place, "omni move distance=2")
        assert "for you, move is allowed with distance <= 1 m. Nothing was done." in told
        assert arguments() == []


async def test_of_a_group_all_are_lowered() -> None:
    async with lab(rules(student=STUDENT), {"Bo": "student"}) as place:
        await asks(place, "swarm move left")
        assert arguments() == [{**METRE, "direction": "left"}] * 2


def _swarm(monkeypatch: pytest.MonkeyPatch, **parameters: Parameter) -> None:
    """Let cf2 have other parameters than the others."""
    other = replace(FAR, parameters={**FAR.parameters, **parameters})
    fleet = tuple(
        replace(p, skills={**p.skills, "move": other if p.id == "cf2" else FAR}) for p in FLEET
    )
    monkeypatch.setattr("tests.gateway.test_rights.FLEET", fleet)


@pytest.mark.parametrize(
    ("limit", "unit", "default", "metres"),
    [
        ("distance <= 1 m", "cm", 200.0, 1.0),
        ("distance <= 1 m", "cm", 50.0, 0.5),
        ("distance <= 1 m", "m", 0.5, 0.5),
        ("distance >= 3 m", "cm", 200.0, 3.0),
        ("distance >= 3 m", "m", 4.0, 3.0),
    ],
)
async def test_of_a_group_each_reads_it_in_its_own_unit_and_none_goes_further_than_it_has_to(
    monkeypatch: pytest.MonkeyPatch, limit: str, unit: str, default: float, metres: float
) -> None:
    most = 500.0 if unit == "cm" else 5.0
    _swarm(monkeypatch, distance=Parameter(unit=unit, min=0.01, max=most, default=default))
    student = replace(STUDENT, limits=(limit,))
    async with lab(rules(student=student), {"Bo": "student"}) as place:
        await asks(place, "swarm move")
        assert [values["distance"] for values in arguments()] == [pytest.approx(metres)] * 2


async def test_where_one_would_be_lowered_and_another_raised_nothing_is_done(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    _swarm(monkeypatch, distance=Parameter(unit="m", min=0.01, max=5.0, default=0.1))
    student = replace(STUDENT, limits=("distance <= 1 m", "distance >= 0.5 m"))
    async with lab(rules(student=student), {"Bo": "student"}) as place:
        assert "Nothing was done." in await asks(place, "swarm move")
        assert arguments() == []


async def test_a_whole_number_below_ones_limit_is_raised_above_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    turns = Parameter(min=0, max=10, default=1, integer=True)
    fleet = tuple(
        replace(p, skills={"move": replace(FAR, parameters={"turns": turns})}) for p in FLEET
    )
    monkeypatch.setattr("tests.gateway.test_rights.FLEET", fleet)
    student = replace(STUDENT, limits=("turns >= 1.5",))
    async with lab(rules(student=student), {"Bo": "student"}) as place:
        await asks(place, "omni move")
        assert arguments() == [{"turns": 2}]


async def test_what_is_asked_first_shows_what_it_is_lowered_to() -> None:
    care = SkillPrecondition(scopes=("omni:move",), confirm=True)
    async with lab(rules(care, student=STUDENT), {"Bo": "student"}) as place:
        assert (await asks(place, "omni move")).startswith("omni: move, 1.00 m forward")
        await place.tap(*place.button("Do it"), account=BO)
        assert arguments() == [METRE]


async def test_what_a_menu_proposes_can_be_done() -> None:
    async with lab(rules(student=STUDENT), {"Bo": "student"}) as place:
        await asks(place, "use omni")
        await place.tap(*place.button("Move"), account=BO)
        assert place.last()[1].text.startswith("omni: move, 1.00 m forward")
        await place.tap(*place.button("Do it"), account=BO)
        assert arguments() == [METRE]


async def test_ones_own_setting_is_not_said_to_be_somebody_elses_rule() -> None:
    async with lab(rules()) as place:
        await asks(place, "/settings speed 0.5 m/s")
        told = await asks(place, "omni move speed=1")
        assert told == (
            "omni: move is allowed with speed <= 0.5 m/s by your own settings. Nothing was done. "
            "To change that: /settings speed"
        )
        told = await asks(place, "omni move")
        assert "as much as your own setting allows (speed <= 0.5 m/s)" in told
        assert arguments() == [{"direction": "forward", "distance": 2.0, "speed": 0.5}]
