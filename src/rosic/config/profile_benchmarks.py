"""What a profile must keep where it says what is expected of a skill."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosic.config.source_map import Place, nearest
from rosic.config.validation import ValidationFinding
from rosic.core.robot.benchmark import POSE

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rosic.core.robot.profile import Profile
    from rosic.core.robot.skill import Skill


def expected(profile: Profile) -> Iterator[ValidationFinding]:
    """See that a benchmark speaks of what there is."""
    for name, skill in profile.skills.items():
        benchmark = skill.benchmark
        if benchmark is None:
            continue
        place: Place = ("skills", name, "benchmark")
        if benchmark.energy is not None and benchmark.battery not in profile.telemetry:
            yield ValidationFinding(
                (*place, "energy"), "What it takes of its battery needs the telemetry of that.",
                nearest(benchmark.battery, profile.telemetry),
            )  # fmt: skip
        for parameter in benchmark.per_s:
            yield from _numeric(skill, (*place, "per_s", parameter), parameter)
        for key, bound in benchmark.errors.items():
            at: Place = (*place, "errors", key)
            if bound.measured in POSE and profile.pose is None:
                yield ValidationFinding(
                    (*at, "measured"), "Where it is needs the profile's 'pose'."
                )
            if isinstance(bound.wanted, str):
                yield from _wanted(skill, (*at, "wanted"), bound.wanted)


def _wanted(skill: Skill, place: Place, written: str) -> Iterator[ValidationFinding]:
    name, dot, part = written[1:].partition(".")
    if written[:1] != "$":
        yield ValidationFinding(
            place, f"{written!r} is neither a number nor a parameter.", "Write $name."
        )
    elif not dot:
        yield from _numeric(skill, place, name)
    elif name not in skill.parameters or any(
        not isinstance(meaning.get(part), float)
        for meaning in skill.parameters[name].means.values()
    ):
        yield ValidationFinding(place, f"{written} is no number that a choice stands for.")


def _numeric(skill: Skill, place: Place, name: str) -> Iterator[ValidationFinding]:
    parameter = skill.parameters.get(name)
    if parameter is None or parameter.choices is not None or parameter.text:
        yield ValidationFinding(
            place, f"{name!r} is not a number that this skill asks for.",
            nearest(name, skill.parameters),
        )  # fmt: skip
