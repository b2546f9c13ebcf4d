"""A mission is laid out: who waits for whom."""

from __future__ import annotations

import pytest

from rosic.core.fleet.mission import (
    DEEPEST,
    TASKS_AT_MOST,
    InvalidMission,
    Mission,
    MissionPart,
    lay_out,
)
from rosic.core.language.numbers import UnitTable


def task(name: str) -> MissionPart:
    return MissionPart(on="w1", steps=(name,))


NO_UNITS = UnitTable({}, {})


def laid(mission: Mission, *others: Mission) -> list[tuple[str, tuple[int, ...]]]:
    known = {one.name: one for one in (mission, *others)}
    return [(leaf.part.steps[0], leaf.after) for leaf in lay_out(mission, known, NO_UNITS)]


def test_parts_follow_each_other_and_what_is_side_by_side_is_waited_for() -> None:
    mission = Mission(
        name="m",
        do=(
            task("a"),
            MissionPart(together=(task("b"), MissionPart(sequence=(task("c"), task("d"))))),
            task("e"),
        ),
    )
    assert laid(mission) == [("a", ()), ("b", (0,)), ("c", (0,)), ("d", (2,)), ("e", (1, 3))]


def test_another_mission_stands_for_its_parts() -> None:
    other = Mission(name="other", do=(task("x"), task("y")))
    mission = Mission(name="m", do=(MissionPart(mission="other"), task("z")))
    assert laid(mission, other) == [("x", ()), ("y", (0,)), ("z", (1,))]


def test_a_circle_is_refused_where_it_is_entered() -> None:
    first = Mission(name="first", do=(task("a"), MissionPart(mission="second")))
    second = Mission(name="second", do=(MissionPart(together=(MissionPart(mission="first"),)),))
    with pytest.raises(InvalidMission, match="in a circle: first -> second -> first") as found:
        laid(first, second)
    assert found.value.place == ("do", 1, "mission")
    with pytest.raises(InvalidMission, match="m -> m"):
        laid(Mission(name="m", do=(MissionPart(mission="m"),)))


def test_what_is_too_large_or_unknown_is_refused() -> None:
    with pytest.raises(InvalidMission, match=f"more than {TASKS_AT_MOST}"):
        laid(Mission(name="m", do=(task("a"),) * (TASKS_AT_MOST + 1)))
    with pytest.raises(InvalidMission, match="No mission is called 'gone'"):
        laid(Mission(name="m", do=(MissionPart(mission="gone"),)))
    doubling = [Mission(name="m0", do=(task("a"), task("b")))]
    doubling += [
        Mission(name=f"m{n}", do=(MissionPart(mission=f"m{n - 1}"),) * 2) for n in range(1, 40)
    ]
    with pytest.raises(InvalidMission, match="more than"):
        laid(doubling[-1], *doubling)


def test_missions_that_include_each_other_without_end_in_sight_are_refused_at_once() -> None:
    chain = [Mission(name="m0", do=(task("a"),))]
    chain += [Mission(name=f"m{n}", do=(MissionPart(mission=f"m{n - 1}"),)) for n in range(1, 900)]
    assert laid(chain[DEEPEST], *chain) == [("a", ())]
    with pytest.raises(InvalidMission, match="more than 16 deep"):
        laid(chain[-1], *chain)
    nothing = [Mission(name="m0", do=())]
    nothing += [
        Mission(name=f"m{n}", do=(MissionPart(mission=f"m{n - 1}"),) * 10) for n in range(1, 12)
    ]
    with pytest.raises(InvalidMission, match="more than 200 missions"):
        laid(nothing[-1], *nothing)
