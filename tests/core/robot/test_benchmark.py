"""What is judged of a task, and what is not."""

from __future__ import annotations

from math import nan, pi
from typing import Any

import pytest

from rosic.core.robot.benchmark import (
    Benchmark,
    BenchmarkKind,
    BenchmarkMeasurement,
    Deviation,
    ErrorBound,
    judge,
)
from rosic.core.robot.view import Pose

MOVE = Benchmark(
    duration_s=2.0,
    per_s={"distance": 4.0},
    energy=1.0,
    errors={"distance": ErrorBound(measured="distance_m", wanted="$distance", within=0.05)},
)


def judged(
    benchmark: Benchmark = MOVE, wanted: dict[str, float] | None = None, **measured: object
) -> list[tuple[BenchmarkKind, float]]:
    given = BenchmarkMeasurement(**({"took_s": 5.0} | measured))  # type: ignore[arg-type]
    found = judge(
        benchmark,
        {"distance": 1.0},
        given,
        {"distance": 1.0} if wanted is None else wanted,
        "%",
    )
    return [(one.kind, round(one.found, 6)) for one in found]


def test_what_is_as_expected_is_fine() -> None:
    assert judged(took_s=9.0, used=1.0, facts={"distance_m": 1.049}) == []


def test_each_bound_is_judged_by_itself() -> None:
    assert judged(took_s=9.1) == [(BenchmarkKind.LATE, 9.1)]
    assert judged(used=1.2) == [(BenchmarkKind.ENERGY, 1.2)]
    assert judged(facts={"distance_m": 0.8}) == [(BenchmarkKind.ERROR, 0.2)]
    assert judged(took_s=10.0, used=2.0, facts={"distance_m": 2.0}) == [
        (BenchmarkKind.LATE, 10.0),
        (BenchmarkKind.ENERGY, 2.0),
        (BenchmarkKind.ERROR, 1.0),
    ]


def test_what_was_not_measured_is_not_judged() -> None:
    assert judged(used=None, facts={}) == []
    assert judged(facts={"distance_m": nan}) == []
    assert judged(wanted={}, facts={"distance_m": 9.0}) == []


def test_a_heading_goes_round() -> None:
    bound = ErrorBound(measured="pose.yaw", wanted=pi, within=0.1)
    benchmark = Benchmark(errors={"heading": bound})
    near = judged(benchmark, {"heading": pi}, pose=Pose(0.0, 0.0, yaw_rad=-pi + 0.05))
    far = judged(benchmark, {"heading": pi}, pose=Pose(0.0, 0.0, yaw_rad=-pi + 0.2))
    assert near == []
    assert far == [(BenchmarkKind.ERROR, 0.2)]


def test_the_bound_is_said_with_it() -> None:
    [found] = judge(MOVE, {"distance": 0.5}, BenchmarkMeasurement(took_s=7.0), {}, "%")
    assert found == Deviation(BenchmarkKind.LATE, 7.0, 6.0, "s")


@pytest.mark.parametrize(
    ("wrong", "sentence"),
    [
        ({}, "needs duration_s, energy or errors"),
        ({"duration_s": nan}, "finite"),
        ({"duration_s": -1.0}, "not below 0"),
        ({"duration_s": 1.0, "late": 1.0}, "late must be above 1"),
        ({"energy": 1.0, "per_s": {"x": 1.0}}, "per_s needs duration_s"),
    ],
)
def test_a_benchmark_that_is_none_is_refused(wrong: dict[str, Any], sentence: str) -> None:
    with pytest.raises(ValueError, match=sentence):
        Benchmark(**wrong)
