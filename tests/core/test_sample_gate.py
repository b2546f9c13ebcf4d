"""What the gate of samples promises, whatever comes, in whatever order, however late."""

from __future__ import annotations

from math import inf, isfinite, nan
from typing import TYPE_CHECKING

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rosic.core.sample_gate import (
    FIRST_WITHIN_S,
    LATE_S,
    LIVE_MOST_S,
    LiveEnd,
    LiveRange,
    LiveSample,
    SampleGate,
    SampleVerdict,
)
from rosic.core.time_units import SECOND_NS

if TYPE_CHECKING:
    from rosic.core.robot.skill import Argument

TAKEN = SampleVerdict.TAKEN
RANGES = (
    LiveRange("linear", -0.8, 0.8),
    LiveRange("angular", -1.5, 1.5),
    LiveRange("gear", 0, 3, True),
)
FIXED: dict[str, Argument] = {"side": "left", "duration": 0.1}
START_NS = 5 * SECOND_NS
LATE_NS = int(LATE_S * SECOND_NS)

numbers = st.one_of(
    st.floats(allow_nan=True, allow_infinity=True),
    st.integers(-(10**400), 10**400),
    st.booleans(),
    st.none(),
    st.text(max_size=3),
    st.floats(-2, 2),
)
values = st.dictionaries(st.sampled_from(["linear", "angular", "gear", "duration", "x"]), numbers)
good_values = st.dictionaries(st.sampled_from(["linear", "angular", "gear"]), st.floats(-5, 5))


def a_gate(*, begun: bool = True, watchdog_s: float = 0.5) -> SampleGate:
    gate = SampleGate(b"one", RANGES, FIXED)
    if begun:
        gate.begin(START_NS, watchdog_s=watchdog_s)
    return gate


def check_bounded(gate: SampleGate, asked: dict[str, float], clamped: tuple[str, ...]) -> None:
    for one in RANGES:
        value, wanted = gate.values[one.name], asked.get(one.name, 0.0)
        assert isinstance(value, int | float)
        assert isfinite(value)
        assert one.low <= value <= one.high
        assert abs(value) <= abs(wanted), "never faster than was asked"
        assert value * wanted >= 0, "never the other way"
        assert isinstance(value, int) == one.integer
        assert (one.name in clamped) == (value != wanted)


# Time since the last, how long it took, the step of its number, its values, for whom.
arrivals = st.lists(
    st.tuples(
        st.integers(0, LATE_NS + LATE_NS // 2),
        st.integers(0, 3 * LATE_NS),
        st.integers(-2, 3),
        values | good_values,
        st.sampled_from([b"one", b"one", b"one", b"two"]),
    ),
    max_size=40,
)


@given(arrivals, st.integers(-(10**20), 10**20))
def test_whatever_comes_only_what_is_young_in_order_and_bounded_steers(
    arriving: list[tuple[int, int, int, dict[str, float], bytes]], apart_ns: int
) -> None:
    gate, now_ns, number, last = a_gate(), START_NS, 0, -10
    gate.measure(START_NS + apart_ns, START_NS)  # the clocks are known to be so far apart
    silent_since_ns: int | None = None
    clamped = 0
    for past_ns, took_ns, step, some, order in arriving:
        now_ns += past_ns
        number += step
        ended_before = gate.end
        result = gate.take(LiveSample(order, some, now_ns - took_ns + apart_ns, number), now_ns)
        if result.verdict is TAKEN:
            assert ended_before is None
            assert order == b"one"
            assert number > last
            assert took_ns <= LATE_NS
            assert set(some) <= {"linear", "angular", "gear"}
            if silent_since_ns is not None:
                assert now_ns - silent_since_ns <= LATE_NS
            sent_ns = now_ns - took_ns
            silent_since_ns = sent_ns if silent_since_ns is None else max(silent_since_ns, sent_ns)
            check_bounded(gate, some, result.clamped)
            clamped += bool(result.clamped)
        if order == b"one":
            last = max(last, number) if ended_before is None else last
    assert gate.values["side"] == "left"
    assert gate.values["duration"] == 0.1
    assert sum(gate.counts.values()) == len(arriving)
    assert len(gate.counts) == len(SampleVerdict), "nothing that grows"
    assert gate.clamped == clamped


@given(st.integers(0, 4 * LATE_NS), st.floats(0.05, 2.0))
def test_what_was_silent_for_too_long_is_over_for_good(gap_ns: int, watchdog_s: float) -> None:
    gate = a_gate(watchdog_s=watchdog_s)
    allowed_ns = min(LATE_NS, int(watchdog_s * SECOND_NS))
    assert gate.take(LiveSample(b"one", {"linear": 0.5}, 0, 1), START_NS).taken
    later = gate.take(LiveSample(b"one", {"linear": 0.5}, gap_ns, 2), START_NS + gap_ns)
    assert later.taken == (gap_ns <= allowed_ns)
    if not later.taken:
        assert gate.end is LiveEnd.SILENT
        assert not gate.take(LiveSample(b"one", {}, gap_ns, 3), START_NS + gap_ns).taken
        assert gate.look(START_NS) is LiveEnd.SILENT


@given(st.lists(st.integers(-10 * LATE_NS, 10 * LATE_NS), min_size=1, max_size=30))
def test_no_clock_that_is_set_makes_young_what_has_waited(set_by_ns: list[int]) -> None:
    """However their clock is set, in all no sample is believed to be younger than by `LATE_S`."""
    gate, ahead_ns, now_ns = a_gate(), 0, START_NS
    gate.measure(START_NS, START_NS)
    for number, by_ns in enumerate(set_by_ns, 1):
        ahead_ns += by_ns
        now_ns += SECOND_NS // 100
        took_ns = 2 * LATE_NS + 1
        sample = LiveSample(b"one", {"linear": 0.5}, now_ns - took_ns + ahead_ns, number)
        result = gate.take(sample, now_ns)
        if result.taken:
            # It took longer than is allowed: only its clock can have hidden that.
            assert ahead_ns > 0
            assert took_ns - min(ahead_ns, took_ns + LATE_NS) <= LATE_NS


def test_a_slow_first_sample_is_set_right_by_quicker_ones() -> None:
    """Without having asked its clock, the first one tells; it may have taken long."""
    gate = a_gate()
    assert gate.take(LiveSample(b"one", {}, START_NS - LATE_NS // 2, 1), START_NS).taken
    now_ns = START_NS + LATE_NS // 4
    assert gate.take(LiveSample(b"one", {}, now_ns, 2), now_ns).taken
    now_ns += LATE_NS // 4
    late_ns = now_ns - LATE_NS - 1
    assert gate.take(LiveSample(b"one", {}, late_ns, 3), now_ns).verdict is SampleVerdict.LATE
    young_ns = now_ns - LATE_NS // 2
    assert gate.take(LiveSample(b"one", {}, young_ns, 4), now_ns).taken


def test_a_clock_that_runs_ahead_by_more_than_that_steers_nothing() -> None:
    gate = a_gate()
    assert gate.take(LiveSample(b"one", {}, 0, 1), START_NS).taken
    ahead = LiveSample(b"one", {}, LATE_NS + 1, 2)
    assert gate.take(ahead, START_NS).verdict is SampleVerdict.AHEAD
    assert gate.take(LiveSample(b"one", {}, LATE_NS, 3), START_NS).taken
    once_more = LiveSample(b"one", {}, LATE_NS + 1, 4)
    assert gate.take(once_more, START_NS).verdict is SampleVerdict.AHEAD, (
        "in all, and not each time"
    )


def test_before_its_turn_nothing_is_taken_and_nothing_is_silent() -> None:
    gate = a_gate(begun=False)
    assert gate.take(LiveSample(b"one", {}, 0, 1), START_NS).verdict is SampleVerdict.WAITING
    assert gate.look(START_NS + 100 * SECOND_NS) is None
    late_ns = START_NS + 100 * SECOND_NS
    gate.begin(late_ns, watchdog_s=0.5)
    assert gate.look(late_ns + int(FIRST_WITHIN_S * SECOND_NS)) is None
    assert gate.look(late_ns + int(FIRST_WITHIN_S * SECOND_NS) + 1) is LiveEnd.SILENT


def test_it_lasts_no_longer_than_it_may() -> None:
    gate, now_ns = a_gate(), START_NS
    for number in range(1, 100_000):
        if not gate.take(LiveSample(b"one", {}, now_ns, number), now_ns).taken:
            break
        now_ns += SECOND_NS // 5
    assert gate.end is LiveEnd.TIME_OVER
    assert 0 <= (now_ns - START_NS) / SECOND_NS - LIVE_MOST_S < 0.21


def test_narrower_bounds_hold_for_what_was_said_before() -> None:
    gate = a_gate()
    gate.take(LiveSample(b"one", {"linear": 0.8, "angular": 1.0}, 0, 1), START_NS)
    gate.confine((LiveRange("linear", -0.2, 0.2), RANGES[1], RANGES[2]))
    assert gate.values["linear"] == 0.2
    assert gate.values["angular"] == 1.0


@pytest.mark.parametrize("end", list(LiveEnd))
def test_the_first_end_counts(end: LiveEnd) -> None:
    gate = a_gate()
    gate.close(end)
    gate.close()
    gate.release()
    assert gate.look(START_NS + 10 * SECOND_NS) is end
    assert gate.take(LiveSample(b"one", {}, 0, 1), START_NS).verdict is SampleVerdict.OVER


@pytest.mark.parametrize("value", [nan, inf, 10**400, True, "1", None])
def test_of_a_sample_with_one_bad_value_nothing_counts(value: object) -> None:
    gate = a_gate()
    gate.take(LiveSample(b"one", {"linear": 0.5}, 0, 1), START_NS)
    bad = {"linear": 0.1, "angular": value}
    result = gate.take(LiveSample(b"one", bad, 0, 2), START_NS)  # type: ignore[arg-type]
    assert result.verdict is SampleVerdict.NO_NUMBER
    assert gate.values["linear"] == 0.5


def test_before_any_sample_everything_that_is_steered_is_zero() -> None:
    gate = SampleGate(b"one", RANGES, {"linear": 0.5, "side": "left"})
    assert gate.values == {"linear": 0.0, "angular": 0.0, "gear": 0, "side": "left"}


@pytest.mark.parametrize(("watchdog_s", "allowed_s"), [(0.2, 0.2), (5.0, LATE_S)])
def test_the_shorter_of_both_times_counts(watchdog_s: float, allowed_s: float) -> None:
    allowed_ns = int(allowed_s * SECOND_NS)
    gate = a_gate(watchdog_s=watchdog_s)
    gate.measure(0, START_NS)
    assert gate.take(LiveSample(b"one", {}, -allowed_ns, 1), START_NS).taken, "not a moment less"
    late = a_gate(watchdog_s=watchdog_s)
    late.measure(0, START_NS)
    sample = LiveSample(b"one", {}, -allowed_ns - 1, 1)
    assert late.take(sample, START_NS).verdict is SampleVerdict.LATE
    assert gate.look(START_NS) is None
    assert gate.look(START_NS + 1) is LiveEnd.SILENT


def test_a_clock_that_is_asked_once_samples_have_come_tells_nothing() -> None:
    gate = a_gate()
    gate.take(LiveSample(b"one", {}, 0, 1), START_NS)
    gate.measure(10 * LATE_NS, START_NS)
    assert gate.take(LiveSample(b"one", {}, 0, 2), START_NS).taken


def test_a_name_is_said_as_far_as_it_can_be_read() -> None:
    gate = a_gate()
    long = gate.take(LiveSample(b"one", {"x" * 9_000: 1.0}, 0, 1), START_NS)
    assert long.sentence == f"{'x' * 40} cannot be steered."
    no_number = SampleGate(b"one", (LiveRange("y" * 50, -1, 1),), {})
    no_number.begin(START_NS, watchdog_s=0.5)
    said = no_number.take(LiveSample(b"one", {"y" * 50: nan}, 0, 1), START_NS).sentence
    assert said == f"{'y' * 40} is no finite number."


def test_wider_bounds_hold_for_what_was_said_before() -> None:
    gate = a_gate()
    gate.confine((LiveRange("linear", -0.2, 0.2), RANGES[1], RANGES[2]))
    assert gate.take(LiveSample(b"one", {"linear": 0.8}, 0, 1), START_NS).clamped == ("linear",)
    gate.confine(RANGES)
    assert gate.values["linear"] == 0.8
