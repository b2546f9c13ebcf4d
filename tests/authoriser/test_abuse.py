"""Misuse by rule: what counts, what never does, and who is spared."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rosic.authoriser.abuse import AbuseDetector, AbuseLimits, InvalidateKey, Threshold, _Window
from rosic.core.robot.skill import SkillClass
from rosic.testing.clock import ManualClock

LIMITS = AbuseLimits(refused=Threshold(5, 60.0), burst=Threshold(20, 10.0))
HARMLESS = (SkillClass.STOP, SkillClass.OBSERVE)


def rules(clock: ManualClock, *, only: str = "") -> AbuseDetector:
    return AbuseDetector(
        clock, LIMITS, only_admin=lambda p: p == only, name=lambda p: p.capitalize()
    )


def said(
    misuse: AbuseDetector, times: int, refused: str = "", who: str = "cy"
) -> list[InvalidateKey]:
    found = [misuse.attempted(who, SkillClass.MOTION, refused) for _ in range(times)]
    return [act for act in found if act is not None]


def test_too_many_refused_attempts_end_a_key() -> None:
    misuse = rules(ManualClock())
    assert said(misuse, 5, "not-permitted") == []
    (act,) = said(misuse, 1, "not-permitted")
    assert (act.principal, act.rule, act.spare) == ("cy", "refused", False)
    assert act.to_person == (
        "Your access has ended, because there were 6 refused attempts within 60 seconds. "
        "Ask an admin."
    )
    assert act.to_admins == (
        "The access of Cy was ended by rule: 6 refused attempts within 60 seconds. "
        "Look, then invite them again."
    )
    # Said once; the count begins anew.
    assert said(misuse, 5, "not-permitted") == []


def test_a_burst_ends_a_key_whatever_came_of_it() -> None:
    misuse = rules(ManualClock())
    assert said(misuse, 20) == []
    assert [act.rule for act in said(misuse, 1)] == ["burst"]


@pytest.mark.parametrize("kind", HARMLESS)
def test_stops_and_questions_are_never_misuse(kind: SkillClass) -> None:
    misuse = rules(ManualClock())
    for _ in range(10_000):
        assert misuse.attempted("cy", kind, "not-permitted") is None
    assert said(misuse, 5, "not-permitted") == []


@pytest.mark.parametrize(
    "refused", ["robot-busy", "robot-taken", "not-understood", "expired", "out-of-bounds"]
)
async def test_bad_luck_is_no_misuse(refused: str) -> None:
    clock = ManualClock()
    misuse = rules(clock)
    for _ in range(50):
        assert said(misuse, 1, refused) == []
        await clock.advance(1.0)


async def test_now_and_then_is_no_misuse() -> None:
    clock = ManualClock()
    misuse = rules(clock)
    for _ in range(100):
        assert said(misuse, 1, "not-permitted") == []
        await clock.advance(15.0)


def test_nobody_answers_for_another() -> None:
    misuse = rules(ManualClock())
    for number in range(100):
        assert said(misuse, 5, "not-permitted", f"p{number}") == []


def test_the_only_admin_is_spared_and_it_is_said() -> None:
    misuse = rules(ManualClock(), only="ada")
    (act,) = said(misuse, 6, "not-permitted", "ada")
    assert act.spare
    assert act.to_person == ""
    assert act.to_admins == (
        "Ada is the only admin, so their access was not ended, although there were "
        "6 refused attempts within 60 seconds. Look whether somebody else uses their account."
    )


@given(st.lists(st.integers(min_value=0, max_value=20), min_size=1, max_size=80))
def test_a_window_is_close_to_the_truth(gaps: list[int]) -> None:
    """Never less than what lies within half a span, never more than within two."""
    window, now, times = _Window(10e-9, 0), 0, []
    for gap in gaps:
        now += gap
        times.append(now)
        count = window.add(now)
        assert count <= sum(t > now - 20 for t in times)
        assert count >= sum(t >= now - now % 10 for t in times)


def test_a_principal_costs_the_same_whatever_they_send() -> None:
    window = _Window(60.0, 0)
    for now in range(0, 10**9, 10**5):
        window.add(now)
    assert set(_Window.__slots__) == {"_before", "_now", "_span", "_span_ns"}
    assert all(isinstance(getattr(window, name), int) for name in _Window.__slots__)


def test_a_crowd_takes_no_more_room() -> None:
    misuse = rules(ManualClock())
    for number in range(30_000):
        misuse.attempted(f"p{number}", SkillClass.MOTION)
    assert len(misuse._windows) == 20_000


@pytest.mark.parametrize("values", [(0, 1.0), (1, 0.0), (1, float("nan")), (1, float("inf"))])
def test_a_threshold_that_is_none_is_refused(values: tuple[int, float]) -> None:
    with pytest.raises(ValueError, match="threshold"):
        Threshold(*values)
