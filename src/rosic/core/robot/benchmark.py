"""How a robot should carry out a skill: for how long, with how much of its battery, how exactly.

The paper's benchmarks of Algorithm 2. Pure: what was measured comes in, what deviates goes out.
"""

from __future__ import annotations

import enum
from collections.abc import Mapping
from math import isfinite, pi
from typing import Final

import msgspec

from rosic.core.robot.view import Pose

DEVIATION: Final = "deviation"
"""What rules call it."""
FINE: Final = "none"
POSE: Final = ("pose.x", "pose.y", "pose.yaw")


class ErrorBound(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """How far a measured number may be from what was asked for; everything in SI.

    Attributes:
        measured: A fact that the robot reports at the end (``distance_m``), or where it then is on
            its map: ``pose.x``, ``pose.y``, ``pose.yaw``.
        wanted: ``$distance``, ``$place.x`` or a number.
        within: How far apart they may be.
    """

    measured: str
    wanted: float | str
    within: float

    def __post_init__(self) -> None:
        if not (isfinite(self.within) and self.within > 0):
            raise ValueError("within must be above 0")


class Benchmark(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What is expected of a robot that carries out a skill.

    Attributes:
        duration_s: How long it takes.
        per_s: Parameter to how long each m, rad, N of it takes besides.
        late: So many times as long is late.
        energy: How much of the battery it takes at most, in the unit of that telemetry.
        battery: Which value of the telemetry that is.
        errors: What is measured at the end, by a name.
    """

    duration_s: float | None = None
    per_s: dict[str, float] = {}
    late: float = 1.5
    energy: float | None = None
    battery: str = "battery"
    errors: dict[str, ErrorBound] = {}

    def __post_init__(self) -> None:
        numbers = (self.duration_s or 0.0, self.late, self.energy or 0.0, *self.per_s.values())
        if not all(map(isfinite, numbers)) or min(numbers) < 0:
            raise ValueError("a benchmark is made of finite numbers that are not below 0")
        if self.late <= 1:
            raise ValueError("late must be above 1: so many times as long as expected")
        if self.per_s and self.duration_s is None:
            raise ValueError("per_s needs duration_s, if only 0")
        if self.duration_s is None and self.energy is None and not self.errors:
            raise ValueError("a benchmark needs duration_s, energy or errors")

    def expected_s(self, arguments: Mapping[str, object]) -> float | None:
        """Return how long it should take with these arguments, in SI; None if that is not said.

        Of the arguments only numbers count.
        """
        if self.duration_s is None:
            return None
        given = ((arguments.get(name, 0.0), each_s) for name, each_s in self.per_s.items())
        return self.duration_s + sum(
            abs(value) * each_s for value, each_s in given if isinstance(value, (int, float))
        )


class BenchmarkKind(enum.Enum):
    """In which way something was not as expected."""

    LATE = "late"
    ENERGY = "energy"
    ERROR = "error"


class Deviation(msgspec.Struct, frozen=True):
    """One thing that was not as expected.

    Attributes:
        name: Of the error bound; else empty.
        found, bound: What was measured, and the most it may be; of an error, how far apart.
        unit: Of both: s, the battery's, or SI (empty).
    """

    kind: BenchmarkKind
    found: float
    bound: float
    unit: str = ""
    name: str = ""


class BenchmarkMeasurement(msgspec.Struct, frozen=True, kw_only=True):
    """What was measured while a skill was carried out.

    Attributes:
        took_s: From its beginning to its end.
        used: Of the battery; None if that was not reported.
        facts: The robot's own, SI.
        pose: Where it is at the end.
    """

    took_s: float
    used: float | None = None
    facts: Mapping[str, float] = {}
    pose: Pose | None = None

    def number(self, name: str) -> float | None:
        """Return a measured number; None if it was not measured."""
        if name in POSE:
            pose = self.pose
            found = None if pose is None else (pose.x_m, pose.y_m, pose.yaw_rad)[POSE.index(name)]
        else:
            found = self.facts.get(name)
        return found if found is not None and isfinite(found) else None


class BenchmarkVerdict(msgspec.Struct, frozen=True):
    """How a task was that came to its end.

    Attributes:
        skill: As people read it.
        expected_s: None if nothing is expected.
    """

    skill: str
    took_s: float
    expected_s: float | None
    used: float | None
    deviations: tuple[Deviation, ...]


def judge(
    benchmark: Benchmark,
    arguments: Mapping[str, object],
    measured: BenchmarkMeasurement,
    wanted: Mapping[str, float],
    unit: str,
) -> tuple[Deviation, ...]:
    """Return everything that was not as expected; what was not measured is not judged.

    Args:
        benchmark: What is expected.
        arguments: Of the order, SI.
        measured: What came of it.
        wanted: Error bound to what was asked for, SI.
        unit: Of the battery.
    """
    found: list[Deviation] = []
    expected_s = benchmark.expected_s(arguments)
    if expected_s is not None and measured.took_s > expected_s * benchmark.late:
        bound_s = expected_s * benchmark.late
        found.append(Deviation(BenchmarkKind.LATE, measured.took_s, bound_s, "s"))
    used = measured.used
    if benchmark.energy is not None and used is not None and used > benchmark.energy:
        found.append(Deviation(BenchmarkKind.ENERGY, used, benchmark.energy, unit))
    for name, bound in benchmark.errors.items():
        number, target = measured.number(bound.measured), wanted.get(name)
        if number is None or target is None:
            continue
        apart = abs(number - target)
        if bound.measured == POSE[2]:
            apart = abs((number - target + pi) % (2 * pi) - pi)
        if apart > bound.within:
            found.append(Deviation(BenchmarkKind.ERROR, apart, bound.within, name=name))
    return tuple(found)
