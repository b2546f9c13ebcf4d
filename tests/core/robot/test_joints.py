"""Moves of an arm: no joint further or faster than it may."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rosic.robots.ros2.joints import SHORTEST_S, JointLimit, OutOfReach, plan

LIMITS = {
    "base": JointLimit(min=-3.0, max=3.0, speed=1.0),
    "elbow": JointLimit(min=0.0, max=2.0, speed=2.0),
}
POSES = st.tuples(st.floats(-3.0, 3.0), st.floats(0.0, 2.0))


@given(start=POSES, goal=POSES, share=st.floats(0.01, 1.0))
def test_no_joint_is_faster_than_its_share(
    start: tuple[float, ...], goal: tuple[float, ...], share: float
) -> None:
    move = plan(LIMITS, start, goal, share)
    for limit, here, there in zip(LIMITS.values(), start, goal, strict=True):
        # A smooth step is half as fast again at its middle as on the whole.
        assert 1.5 * abs(there - here) / move.duration_s <= limit.speed * share * (1 + 1e-9)


@given(start=POSES, goal=POSES)
def test_a_fraction_goes_from_nothing_to_all(
    start: tuple[float, ...], goal: tuple[float, ...]
) -> None:
    move = plan(LIMITS, start, goal, 1.0)
    assert move.fraction(goal) == 1.0
    if start != goal:
        assert move.fraction(start) == pytest.approx(0.0)


def test_a_short_way_still_takes_a_while() -> None:
    assert plan(LIMITS, (0.0, 1.0), (0.0, 1.0), 1.0).duration_s == SHORTEST_S


@pytest.mark.parametrize("goal", [(3.01, 1.0), (0.0, -0.01), (0.0, float("nan"))])
def test_a_joint_that_would_go_too_far_is_named(goal: tuple[float, ...]) -> None:
    with pytest.raises(OutOfReach) as far:
        plan(LIMITS, (0.0, 1.0), goal, 0.5)
    assert far.value.joint == ("base" if goal[0] else "elbow")


@pytest.mark.parametrize(
    "limits",
    [
        {"min": 1, "max": 1, "speed": 1},
        {"min": 0, "max": 1, "speed": 0},
        {"min": 0, "max": float("inf"), "speed": 1},
    ],
)
def test_limits_that_are_none_are_refused(limits: dict[str, float]) -> None:
    with pytest.raises(ValueError, match="must be"):
        JointLimit(**limits)
