"""What people read about benchmarks, and about how a robot is set."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosic.core.i18n import joined, said
from rosic.core.language import inert_text
from rosic.core.robot.benchmark import BenchmarkKind

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from rosic.core.robot.benchmark import BenchmarkVerdict, Deviation

VALUE_AT_MOST = 60


def expected(expected_s: float | None) -> str:
    """Return how long what it does should take; empty if nobody expects anything."""
    return "" if expected_s is None else said("expected to take {s} s", s=f"{expected_s:.1f}")


def late(expected_s: float) -> str:
    """Return that what it does takes too long."""
    return said("late: expected to take {s} s", s=f"{expected_s:.1f}")


def off(skill: str, deviations: Iterable[Deviation]) -> str:
    """Return what was not as expected of a task that was done."""
    found = joined(", ", [deviation(one) for one in deviations])
    return said("{skill} was off its benchmark: {what}", skill=skill, what=found)


def deviation(one: Deviation) -> str:
    """Return one thing that was not as expected."""
    if one.kind is BenchmarkKind.LATE:
        return said("{s} s instead of {most} s", s=f"{one.found:.1f}", most=f"{one.bound:.1f}")
    if one.kind is BenchmarkKind.ENERGY:
        return said(
            "{used} {unit} of the battery instead of {most} {unit}",
            used=f"{one.found:.1f}",
            most=f"{one.bound:.1f}",
            unit=one.unit,
        )
    return said(
        "{name} off by {error}, at most {most}",
        name=one.name.replace("_", " "),
        error=f"{one.found:.3g}",
        most=f"{one.bound:.3g}",
    )


def head(shown: str) -> str:
    """Return the first line about a robot."""
    return said("{robot}, against what is expected of it:", robot=shown)


def verdict(one: BenchmarkVerdict) -> str:
    """Return one line about the last time that a skill was done."""
    took = f"{one.took_s:.1f}"
    if one.expected_s is None:
        line = said("{skill}: took {s} s", skill=one.skill, s=took)
    else:
        line = said(
            "{skill}: took {s} s, expected {expected} s",
            skill=one.skill,
            s=took,
            expected=f"{one.expected_s:.1f}",
        )
    found = [deviation(each) for each in one.deviations]
    return joined(" · ", [line, *(found or [said("as expected")])])


def not_yet(skill: str) -> str:
    """Return that a skill was not measured yet."""
    return said("{skill}: not measured yet", skill=skill)


def none(shown: str) -> str:
    """Return that nothing is expected of a robot."""
    return said("{robot} has no benchmarks.", robot=shown)


def settings(lines: Sequence[str]) -> str:
    """Return how a robot is set."""
    return joined("\n", [said("Set from here:"), *lines])


def setting(name: str, value: object, by: str, when: str) -> str:
    """Return one parameter."""
    shown = f"{value:g}" if isinstance(value, float) else inert_text(str(value))[:VALUE_AT_MOST]
    return said("{name} = {value}, by {who} {time}", name=name, value=shown, who=by, time=when)
