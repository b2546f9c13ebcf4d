"""What ends continuous motion (I6), and that it stays ended."""

from __future__ import annotations

import pytest

from rosic.core.deadman import INTERRUPTED, STOOD_STILL, BreakCause, DeadMan, MotionBreak

S = 1_000_000_000


def dead_man() -> DeadMan:
    return DeadMan(0, watchdog_s=0.5, heard_within_s=1.0)


def test_what_is_sent_in_time_and_heard_goes_on() -> None:
    looks = dead_man()
    assert all(looks.look(tick * S // 20, 0.05) is None for tick in range(1, 200))


@pytest.mark.parametrize(
    ("now_s", "age_s", "there", "heard", "cause"),
    [
        (0.6, 0.0, True, True, BreakCause.LATE),
        (0.4, 1.1, True, False, BreakCause.SILENT),
        (0.4, 1.1, True, True, BreakCause.UNMEASURED),
        (0.4, 0.0, False, True, BreakCause.GONE),
        (0.6, 9.0, False, False, BreakCause.LATE),
    ],
)
def test_a_break_is_final(
    now_s: float, age_s: float, there: bool, heard: bool, cause: BreakCause
) -> None:
    looks = dead_man()
    broken = looks.look(int(now_s * S), age_s, there=there, heard=heard)
    assert broken is not None
    assert broken.cause is cause
    assert looks.look(int(now_s * S) + 1, 0.0) is broken, "both sides are well again"
    assert looks.last_ns == 0


def test_what_came_to_rest_by_itself_goes_on_no_more() -> None:
    looks = dead_man()
    rests = [looks.look(tick * S // 20, 0.05, rests=tick > 10) for tick in range(1, 60)]
    assert rests[30] is None, "a moment at rest is none yet"
    assert rests[-1] is not None
    assert rests[-1].cause is BreakCause.RESTED
    assert rests[-1].seconds == pytest.approx(1.05, abs=0.06)


def test_a_robot_that_began_anew_knows_nothing_of_what_it_was_told() -> None:
    looks = dead_man()
    broken = looks.look(S // 10, 0.0, another=BreakCause.REBORN)
    assert broken is not None
    assert broken.cause is BreakCause.REBORN
    assert looks.look(S // 5, 0.0) is broken


def test_who_may_be_the_robot_that_began_anew_is_not_driven_on() -> None:
    looks = dead_man()
    broken = looks.look(S // 10, 0.0, another=BreakCause.NAMELESS)
    assert broken is not None
    assert broken.cause is BreakCause.NAMELESS
    assert looks.look(S // 5, 0.0) is broken


def test_a_look_that_is_too_long_ago_lets_nothing_be_sent() -> None:
    looks = dead_man()
    looks.look(S // 10, 0.0)
    assert not looks.late(S // 2)
    assert looks.late(7 * S // 10)


def test_only_our_own_breaks_are_marked_as_ours() -> None:
    codes = {cause: MotionBreak(cause, 1.0).code for cause in BreakCause}
    assert codes.pop(BreakCause.LATE) == STOOD_STILL
    assert set(codes.values()) == {INTERRUPTED}
