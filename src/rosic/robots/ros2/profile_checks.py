"""What a profile must keep where it speaks of ROS, and where its parts have to agree."""

from __future__ import annotations

import re
from math import ceil
from typing import TYPE_CHECKING, Final

from rosic.contracts.file_rules import ValidationFinding, nearest
from rosic.core.robot.file_transfer import CONTENT_BYTES
from rosic.core.robot.skill import DURATION, SkillClass
from rosic.robots.ros2.answer_fields import answered_fields, unjudged
from rosic.robots.ros2.answer_fields import named as named_codes
from rosic.robots.ros2.profile import VELOCITIES

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

    from rosic.contracts.file_rules import Place
    from rosic.core.robot.skill import Parameter
    from rosic.robots.ros2.joints import Joints
    from rosic.robots.ros2.profile import Deliver, Ros2Files, Ros2Profile, Ros2Skill, Ros2Telemetry

# Types of which a field is known to be yes or no, without asking ROS.
BOOLEANS: Final = {"std_msgs/msg/Bool": "data", "std_srvs/srv/SetBool": "data"}
TWICE: Final = 2.0
IN_PARCELS: Final = ("$name", "$path", "$sha256", "$size", "$kind", "$text", "$content")
_AXIS: Final = re.compile(r"(?:^|\.)((?:linear|angular)\.[xyz])$")

# ---- values and skills ----


def located(made: Ros2Telemetry) -> Iterator[ValidationFinding]:
    """See that a value that comes from the graph is found there."""
    if bool(made.topic) != bool(made.type) or bool(made.topic) != bool(made.field):
        yield ValidationFinding(
            (), "A reported value needs topic, type and field, or none of them."
        )


def streamed(skill: Ros2Skill) -> Iterator[ValidationFinding]:
    """See that velocities are sent for a time, and that people say for how long."""
    topic = skill.topic
    if topic is None:
        return
    if topic.stream_hz == 0 and topic.type in VELOCITIES:
        yield ValidationFinding(
            ("topic",),
            "A single velocity would keep the robot moving.",
            "Give stream_hz, so that it is sent for a time and ends in zero.",
        )
    if topic.stream_hz > 0:
        duration = skill.parameters.get(DURATION)
        if duration is None or duration.unit != "s" or not (duration.min or 0) > 0:
            yield ValidationFinding(
                ("topic", "stream_hz"),
                f"A stream needs a parameter '{DURATION}' in s that is above 0.",
                "Its max is the longest time the robot is driven by one command.",
            )


def fitting_booleans(skill: Ros2Skill) -> Iterator[ValidationFinding]:
    """See that a field that is yes or no is given one, by itself or by what a choice stands for."""
    if skill.topic is not None:
        place, kind, sent = ("topic", "message"), skill.topic.type, skill.topic.message
    elif skill.service is not None:
        place, kind, sent = ("service", "request"), skill.service.type, skill.service.request
    else:
        return
    field = BOOLEANS.get(kind, "")
    if field not in sent or _is_boolean(skill, sent[field]):
        return
    yield ValidationFinding(
        (*place, field),
        f"'{field}' of {kind} is true or false, and {sent[field]!r} is neither.",
        "Write true or false, or $state.value with means: { on: { value: true } } and so on.",
    )


def _is_boolean(skill: Ros2Skill, value: object) -> bool:
    if isinstance(value, bool):
        return True
    name, _, part = str(value)[1:].partition(".")
    parameter = skill.parameters.get(name)
    if str(value)[:1] != "$" or parameter is None:
        return str(value)[:1] == "$"  # said elsewhere: there is no such parameter
    meanings = parameter.means.values()
    return bool(meanings) and all(isinstance(m.get(part), bool) for m in meanings)


# ---- trajectories ----


def moved(profile: Ros2Profile) -> Iterator[ValidationFinding]:
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


def _one(
    joints: Joints, skill: Ros2Skill, name: str, parameter: str
) -> Iterator[ValidationFinding]:
    choices = _of(skill, parameter).choices if parameter in skill.parameters else {}
    for choice in choices or {"": ()}:
        if choice not in joints.limits:
            yield ValidationFinding(
                ("skills", name, "parameters", parameter, "choices"),
                f"{choice!r} is none of this robot's joints.",
                nearest(choice, joints.limits),
            )


def _all(joints: Joints, skill: Ros2Skill, name: str, to: str) -> Iterator[ValidationFinding]:
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


def _of(skill: Ros2Skill, parameter: str) -> Parameter:
    return skill.parameters[parameter]


# ---- stopping and rest ----


def stoppable(profile: Ros2Profile) -> Iterator[ValidationFinding]:
    """See that what moves is stopped by more than nothing, and that its rest is measured."""
    moving = [s for s in profile.skills.values() if s.kind is SkillClass.MOTION]
    if not moving or profile.unstoppable:
        return
    stop = profile.stop
    if stop is not None and not (stop.service or stop.zero or stop.cancel_only):
        yield ValidationFinding(
            ("stop",),
            "'stop' names neither a service nor a velocity topic to zero.",
            "A robot that holds when its goals are cancelled says so: cancel_only: true.",
        )
    by_goals = stop is None or stop.cancel_only
    if by_goals and any(skill.action is None for skill in moving):
        yield ValidationFinding(
            (),
            "'stop' is missing: nothing would stop this robot.",
            "Give stop a service, a velocity topic to zero, or both.",
        )
    if profile.at_rest is None:
        yield ValidationFinding(
            (),
            "'at_rest' is missing: a stop of this robot could never be confirmed.",
            "Name a topic and the fields that are near zero when it stands still.",
        )


def said_stop(profile: Ros2Profile) -> Iterator[ValidationFinding]:
    """See that a stop says yes or no to a service that asks; without ROS, of what is known."""
    stop = profile.stop
    field = BOOLEANS.get(stop.type, "") if stop is not None and stop.service else ""
    if stop is None or not field or isinstance(stop.request.get(field), bool):
        return
    yield ValidationFinding(
        ("stop", "type"),
        f"A stop by {stop.type} has to say {field}: by itself it is false, which releases a brake.",
        f"Write request: {{ {field}: true }}, or false where that is what stops this robot.",
    )


def released(profile: Ros2Profile) -> Iterator[ValidationFinding]:
    """Say that a stop that is switched on has to be switched off, too."""
    stop = profile.stop
    field = BOOLEANS.get(stop.type, "") if stop is not None and stop.service else ""
    if stop is None or not field or stop.release:
        return
    yield ValidationFinding(
        ("stop", "type"),
        f"If the stop {stop.service} holds until it is told otherwise, nothing releases it: "
        "after a resume the robot would not move.",
        f"Write release: {{ {field}: {str(not stop.request.get(field)).lower()} }} in that case.",
    )


def watched(profile: Ros2Profile) -> Iterator[ValidationFinding]:
    """See that a stream is sent often enough for the robot's own time-out."""
    for name, skill in profile.skills.items():
        hz = skill.topic.stream_hz if skill.topic is not None else 0.0
        # One lost message must not make the robot stumble.
        if hz > 0 and profile.watchdog_s is not None and hz * profile.watchdog_s < TWICE:
            yield ValidationFinding(
                ("skills", name, "topic", "stream_hz"),
                f"{hz:g} Hz is too slow for a robot that stops by itself after "
                f"{profile.watchdog_s:g} s.",
                f"Send at {TWICE / profile.watchdog_s:g} Hz or more.",
            )


def unseen_axes(profile: Ros2Profile) -> Iterator[ValidationFinding]:
    """Say which axes a skill sends velocities along while rest is measured along others alone."""
    if profile.at_rest is None:
        return
    seen = _axes(profile.at_rest.fields)
    for name, skill in profile.skills.items():
        if skill.topic is None or not seen:
            continue
        for axis in sorted(_axes(skill.topic.message) - seen):
            yield ValidationFinding(
                ("at_rest", "field"),
                f"'{name}' sends {axis}, which 'at_rest' does not measure: a stop could be "
                "confirmed while it still moves so.",
                f"Add the field that ends in {axis}, separated by a comma.",
            )


def _axes(paths: Iterable[str]) -> set[str]:
    return {found[1] for path in paths if (found := _AXIS.search(path))}


def enough_s(every_s: float) -> float:
    """Return an `AtRest.within_s` for what comes so often: one message may be lost, to 0.5 s."""
    return ceil(4 * every_s - 0.1) / 2


# ---- the graph ----


def reached(profile: Ros2Profile) -> Iterator[ValidationFinding]:
    """See that the graph and the way of every skill are said."""
    if not profile.link.namespace:
        yield ValidationFinding(
            ("link",),
            "A ros2 robot needs a namespace.",
            f"For example /{profile.id}; / for one that has none.",
        )
    for name, skill in profile.skills.items():
        if not skill.sent.place and not profile.link.dialogue:
            yield ValidationFinding(
                ("skills", name),
                f"'{name}' says nothing of how ROS carries it out.",
                "Give one of topic, service, action, set_parameters.",
            )


def of_one_type(profile: Ros2Profile) -> Iterator[ValidationFinding]:
    """See that every topic, service and action has one type, wherever it is named."""
    known: dict[tuple[str, str], str] = {}
    for place, sort, name, kind in named(profile):
        full = full_name(profile, name)
        other = known.setdefault((sort, full), kind)
        if other != kind:
            yield ValidationFinding(
                place,
                f"The {sort} {name} has the type {other} elsewhere in this profile, and {kind} "
                "here: it can have one only.",
                f"Ask the robot which: ros2 {sort} type {full}.",
            )


def named(profile: Ros2Profile) -> Iterator[tuple[Place, str, str, str]]:
    """Yield where a name is given, of what sort it is, the name and its type."""
    stop, deliver = profile.stop, profile.files.deliver if profile.files is not None else None
    if stop is not None and stop.service:
        yield ("stop", "type"), "service", stop.service, stop.type
    if stop is not None and stop.zero:
        yield ("stop", "zero_type"), "topic", stop.zero, stop.zero_type
    for skill in profile.skills.values():
        place: Place = ("skills", skill.id)
        if skill.service is not None:
            yield (*place, "service", "type"), "service", skill.service.name, skill.service.type
        if skill.topic is not None:
            yield (*place, "topic", "type"), "topic", skill.topic.name, skill.topic.type
        if skill.action is not None:
            yield (*place, "action", "type"), "action", skill.action.name, skill.action.type
    if deliver is not None and deliver.service is not None:
        where: Place = ("files", "deliver", "service", "type")
        yield where, "service", deliver.service.name, deliver.service.type


def reaches(profile: Ros2Profile) -> Iterator[str]:
    """Return the names on the graph by which one robot alone is moved, stopped and measured.

    Two arms may share a topic that shows the joints of both, but not the fields of it by which
    their rest is measured.
    """
    moving = {skill.id for skill in profile.skills.values() if skill.kind is SkillClass.MOTION}
    for (part, *where), sort, name, _ in named(profile):
        # A light or a camera may belong to a room, and to every robot in it.
        if part == "stop" or (part == "skills" and where[0] in moving):
            yield f"the {sort} {full_name(profile, name)}"
    if profile.at_rest is not None:
        for field in profile.at_rest.fields:
            yield f"{field} of the topic {full_name(profile, profile.at_rest.topic)}"
    if profile.link.dialogue:
        yield f"the topic {full_name(profile, 'to_robot_topic')}"


def full_name(profile: Ros2Profile, name: str) -> str:
    """Return a name from the root."""
    return name if name.startswith("/") else f"{profile.link.namespace.rstrip('/')}/{name}"


def among(profile: Ros2Profile) -> Iterator[ValidationFinding]:
    """See that a strategy reaches the robot's nodes."""
    if profile.strategies and not profile.link.among:
        yield ValidationFinding(
            ("strategies",),
            "A strategy reaches the robot over its link to other robots.",
            "Set link.among to true.",
        )


# ---- files ----


def delivered(files: Ros2Files) -> Iterator[ValidationFinding]:
    """See that a file goes one way, and that what is sent is of the file."""
    deliver = files.deliver
    if deliver is None:
        return
    if (deliver.topic is None) == (deliver.service is None):
        yield ValidationFinding(
            ("deliver",), "A file is delivered by a topic or by a service: one of them."
        )
        return
    yield from _in_parcels(files, deliver)
    if deliver.topic is not None and deliver.topic.stream_hz:
        yield ValidationFinding(
            ("deliver", "topic", "stream_hz"), "A file is sent once, not streamed."
        )
    if deliver.receipt is not None and deliver.topic is None:
        yield ValidationFinding(("deliver", "receipt"), "The answer of a service is its receipt.")
    if deliver.digest and deliver.service is None:
        yield ValidationFinding(
            ("deliver", "digest"), "Only a service answers; a topic needs a receipt."
        )


def _in_parcels(files: Ros2Files, deliver: Deliver) -> Iterator[ValidationFinding]:
    place = ("deliver", *(("topic", "message") if deliver.topic else ("service", "request")))
    named = {key: str(value) for key, value in deliver.sent.items() if str(value)[:1] == "$"}
    for key, name in named.items():
        if name not in IN_PARCELS:
            hint = nearest(name, IN_PARCELS)
            yield ValidationFinding((*place, key), f"{name} is nothing that a file has.", hint)
    if not named:
        yield ValidationFinding(
            (*place,), "Nothing of the file is sent.", "Write $path where it belongs."
        )
    if "$path" in named.values() and not files.inbox:
        yield ValidationFinding((*place,), "$path needs an inbox for the file to lie in.")
    if deliver.carries and files.max_mb * 1e6 > CONTENT_BYTES:
        yield ValidationFinding(
            ("max_mb",),
            f"A message holds {CONTENT_BYTES / 1e6:g} MB at most.",
            f"Set max_mb to {CONTENT_BYTES / 1e6:g}, or send $path of a file in the inbox.",
        )


# ---- all of it ----


def advice(profile: Ros2Profile) -> Iterator[ValidationFinding]:
    """Say what is allowed, but worse than it could be."""
    moves = any(skill.kind is SkillClass.MOTION for skill in profile.skills.values())
    if moves and profile.stop is None:
        yield ValidationFinding(
            (),
            "'stop' is missing: a stop only cancels the goals of this robot's actions.",
            "Name the robot's own stop service; if it has none, write cancel_only: true.",
        )
    yield from unseen_axes(profile)
    yield from released(profile)
    for name, skill in profile.skills.items():
        topic = skill.topic
        if skill.kind is SkillClass.MOTION and topic is not None and topic.stream_hz == 0:
            yield ValidationFinding(
                ("skills", name, "topic"),
                f"'{name}' is sent over a topic, which does not acknowledge.",
                "An action tells people whether and how it ended.",
            )
    yield from judged_by_nobody(profile)


def judged_by_nobody(profile: Ros2Profile) -> Iterator[ValidationFinding]:
    """Say which answers are taken for success whatever they say, as far as types are installed."""
    for name, skill in profile.skills.items():
        way, binding = ("action", skill.action) if skill.action else ("service", skill.service)
        if binding is None:
            continue
        codes = unjudged(binding, binding.type, answered_fields(binding.type) or {})
        if not codes:
            continue
        yield ValidationFinding(
            ("skills", name, way),
            f"Nothing says by which field an answer of '{name}' tells success: "
            "whatever it answers reads as done.",
            f"In {binding.type}, {named_codes(codes)}.",
        )
