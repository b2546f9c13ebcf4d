"""When feedback that came again and again counts as ceased."""

from __future__ import annotations

import pytest

from rosic.robots.ros2.goal_watch import STEADY, FeedbackPulse

S = 1_000_000_000


def fed(*times_s: float) -> FeedbackPulse:
    pulse = FeedbackPulse(0)
    for at_s in times_s:
        pulse.beat(int(at_s * S))
    return pulse


def test_feedback_that_came_again_and_again_has_ceased_after_the_deadline() -> None:
    pulse = fed(*(0.1 * n for n in range(1, STEADY + 1)))
    assert not pulse.ceased(int(3.4 * S), 3.0)
    assert pulse.ceased(int(3.6 * S), 3.0)
    pulse.beat(int(3.6 * S))
    assert not pulse.ceased(int(3.7 * S), 3.0)


def test_stages_that_are_told_of_are_no_steady_feedback() -> None:
    assert not fed(*(0.1 * n for n in range(1, STEADY))).ceased(1000 * S, 3.0)
    assert not FeedbackPulse(0).ceased(1000 * S, 3.0)


def test_feedback_that_is_slow_by_nature_is_waited_for() -> None:
    pulse = fed(2, 4, 6, 8, 10)
    assert not pulse.ceased(15 * S, 3.0)
    assert pulse.ceased(17 * S, 3.0)


@pytest.mark.parametrize(("now_s", "quiet"), [(1.4, False), (1.6, True)])
def test_it_is_quiet_before_it_has_ceased(now_s: float, quiet: bool) -> None:
    assert fed(0.5).quiet(int(now_s * S)) is quiet
    assert FeedbackPulse(0).quiet(int(now_s * S))
