"""What a profile must keep where choices stand for numbers and arms follow trajectories."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosic.contracts.file_rules import Place, ValidationFinding, nearest
from rosic.core.robot.benchmark import POSE

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rosic.core.robot.profile import Profile
    from rosic.core.robot.skill import Skill


# ---- choices and trajectories ----


def meant(skill: Skill, place: Place, written: str) -> Iterator[ValidationFinding]:
    """See that ``$place.x`` is among what the choices of a parameter stand for.

    Args:
        skill: Whose parameter is there.
        place: Where it is written.
        written: Without the sign: ``place.x``, or the name alone.
    """
    name, dot, part = written.partition(".")
    means = skill.parameters[name].means
    known = next(iter(means.values()), {})
    if dot and part not in known:
        hint = nearest(part, known) or f"Say under 'means' of {name} what its choices stand for."
        yield ValidationFinding(
            place, f"${written}: the choices of {name} do not stand for '{part}'.", hint
        )
    elif means and not dot:
        hint = f"Write ${name}.{next(iter(known), 'x')}."
        yield ValidationFinding(place, f"${name} is a word; what it stands for has names.", hint)


# ---- expectations ----


def expected(profile: Profile) -> Iterator[ValidationFinding]:
    """See that a benchmark speaks of what there is."""
    for name, skill in profile.skills.items():
        benchmark = skill.benchmark
        if benchmark is None:
            continue
        place: Place = ("skills", name, "benchmark")
        if benchmark.energy is not None and benchmark.battery not in profile.telemetry:
            yield ValidationFinding(
                (*place, "energy"),
                "What it takes of its battery needs the telemetry of that.",
                nearest(benchmark.battery, profile.telemetry),
            )
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
            place,
            f"{name!r} is not a number that this skill asks for.",
            nearest(name, skill.parameters),
        )
