"""What a case comes to: middles, tails, how far its runs lie apart, and what stays in doubt."""

from __future__ import annotations

from math import exp, expm1

import pytest

from rosic.bench.report import case_of, quantile

MS_NS = 1_000_000


def test_the_spread_is_of_runs_beside_their_own_pace() -> None:
    runs = [(1.0, [2.0 * MS_NS]), (1.0, [4.0 * MS_NS]), (1.0, [6.3 * MS_NS])]

    slow_hour = case_of("one", runs, [1_000.0, 2_000.0, 3_000.0])
    same_hour = case_of("one", runs, [1_000.0, 1_000.0, 1_000.0])

    assert slow_hour.spread == pytest.approx(0.025)  # 2.0, 2.0 and 2.1 times the pace
    assert same_hour.spread == pytest.approx(2.15 / 4, abs=1e-3)
    assert case_of("one", runs[:1], [1_000.0]).spread is None


def test_a_tail_that_only_some_runs_had_is_no_less_there() -> None:
    quiet, stalled = [1.0 * MS_NS] * 90, [*[1.0 * MS_NS] * 60, *[300.0 * MS_NS] * 30]
    seen = case_of("one", [(1.0, quiet), (1.0, quiet), (1.0, stalled)], tails=True)
    assert (seen.p50_us, seen.p90_us, seen.p99_us) == (1_000.0, 300_000.0, 300_000.0)


@pytest.mark.parametrize(
    ("share", "found"), [(0.0, 1), (0.01, 1), (0.5, 50), (0.99, 99), (0.991, 100), (1.0, 100)]
)
def test_quantiles_are_of_the_nearest_rank(share: float, found: int) -> None:
    assert quantile(range(100, 0, -1), share) == found
    assert quantile([1.0, 2.0], 0.5) == 1.0


def test_what_is_in_doubt_of_a_few_runs_is_little_of_many() -> None:
    """Student's t at 99.5 % is 4.604 for four degrees of freedom, 2.861 for nineteen."""
    runs = [(1.0, [1e6 * exp(sign * 0.1)]) for sign in (-1, 1)]
    assert case_of("one", runs).doubt == pytest.approx(99.0)  # two say nearly nothing
    five = case_of("one", [*runs, *runs, (1.0, [1e6])]).doubt
    assert five == pytest.approx(expm1(4.604 * 0.1 / 5**0.5), rel=0.01)
    twenty = case_of("one", runs * 10).doubt
    assert twenty == pytest.approx(expm1(2.861 * 0.1026 / 20**0.5), rel=0.01)
    assert case_of("one", runs[:1]).doubt is None


def test_tails_keep_a_thousand_times_in_order() -> None:
    times = [float(number * 1_000) for number in range(2_500)]

    kept = case_of("one", [(1.0, times)], tails=True)

    assert len(kept.samples_us) == 834
    assert list(kept.samples_us) == sorted(kept.samples_us)
    assert (kept.p90_us, kept.max_us) == (2_249.0, 2_499.0)
