"""What a profile must keep where choices stand for numbers and arms follow trajectories."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosic.contracts.file_rules import Place, ValidationFinding, nearest
from rosic.core.robot.benchmark import POSE

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rosic.core.robot.joints import Joints
    from rosic.core.robot.profile import Profile
    from rosic.core.robot.skill import Parameter, Skill, Trajectory


# ---- choices and trajectories ----


def of_trajectory(trajectory: Trajectory | None) -> dict[str, float | int | str | bool]:
    """Return what a trajectory is made of, by its key in the file."""
    if trajectory is None:
        return {}
    return {"to": trajectory.to, "joint": trajectory.joint, "speed": trajectory.speed}


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


def moved(profile: Profile) -> Iterator[ValidationFinding]:
    """See that skills with a trajectory know the joints, and stay within their limits."""
    for name, skill in profile.skills.items():
        trajectory = skill.action.trajectory if skill.action is not None else None
        if trajectory is None:
            continue
        place: Place = ("skills", name, "action", "trajectory")
        if profile.joints is None:
            yield ValidationFinding(
                place, "A trajectory needs to know the joints.", "Give the profile 'joints'."
            )
        elif trajectory.joint:
            yield from _one(profile.joints, skill, name, trajectory.joint[1:])
        else:
            yield from _all(profile.joints, skill, name, trajectory.to[1:])


def _one(joints: Joints, skill: Skill, name: str, parameter: str) -> Iterator[ValidationFinding]:
    choices = _of(skill, parameter).choices if parameter in skill.parameters else {}
    for choice in choices or {"": ()}:
        if choice not in joints.limits:
            yield ValidationFinding(
                ("skills", name, "parameters", parameter, "choices"),
                f"{choice!r} is none of this robot's joints.",
                nearest(choice, joints.limits),
            )


def _all(joints: Joints, skill: Skill, name: str, to: str) -> Iterator[ValidationFinding]:
    parameter, _, part = to.partition(".")
    if parameter not in skill.parameters:
        return
    for choice, meaning in _of(skill, parameter).means.items():
        place: Place = ("skills", name, "parameters", parameter, "means", choice, part)
        positions = meaning.get(part, ())
        if not isinstance(positions, tuple) or len(positions) != len(joints.limits):
            yield ValidationFinding(place, f"A pose of this robot has {len(joints.limits)} joints.")
            continue
        for (joint, limit), position in zip(joints.limits.items(), positions, strict=True):
            if not limit.min <= position <= limit.max:
                yield ValidationFinding(
                    place,
                    f"{joint} goes from {limit.min:g} to {limit.max:g}, "
                    f"and is at {position:g} here.",
                )


def _of(skill: Skill, parameter: str) -> Parameter:
    return skill.parameters[parameter]


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
