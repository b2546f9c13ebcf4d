"""What a profile must keep about what ROS carries: one type a name, and streams that are fast."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from rosic.contracts.file_rules import ValidationFinding

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rosic.contracts.file_rules import Place
    from rosic.core.robot.profile import Profile
    from rosic.core.robot.skill import Skill

TWICE: Final = 2.0
# Types of which a field is known to be yes or no, without asking ROS.
BOOLEANS: Final = {"std_msgs/msg/Bool": "data", "std_srvs/srv/SetBool": "data"}


def of_one_type(profile: Profile) -> Iterator[ValidationFinding]:
    """See that every topic, service and action has one type, wherever it is named."""
    if profile.link.kind != "ros2":
        return
    known: dict[tuple[str, str], str] = {}
    for place, sort, name, kind in _named(profile):
        full = name if name.startswith("/") else f"{profile.link.namespace.rstrip('/')}/{name}"
        other = known.setdefault((sort, full), kind)
        if other != kind:
            yield ValidationFinding(
                place,
                f"The {sort} {name} has the type {other} elsewhere in this profile, and {kind} "
                "here: it can have one only.",
                f"Ask the robot which: ros2 {sort} type {full}.",
            )


def _named(profile: Profile) -> Iterator[tuple[Place, str, str, str]]:
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


def fitting_booleans(skill: Skill) -> Iterator[ValidationFinding]:
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


def said_stop(profile: Profile) -> Iterator[ValidationFinding]:
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


def _is_boolean(skill: Skill, value: object) -> bool:
    if isinstance(value, bool):
        return True
    name, _, part = str(value)[1:].partition(".")
    parameter = skill.parameters.get(name)
    if str(value)[:1] != "$" or parameter is None:
        return str(value)[:1] == "$"  # said elsewhere: there is no such parameter
    meanings = parameter.means.values()
    return bool(meanings) and all(isinstance(m.get(part), bool) for m in meanings)


def watched(profile: Profile) -> Iterator[ValidationFinding]:
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
