"""What a profile must keep besides types, forms and bounds: where its parts have to agree."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Final

from msgspec.structs import replace

from rosic.config.profile_fields import BOUNDS, FORMS, HIDDEN
from rosic.config.profile_rest import unseen_axes
from rosic.config.profile_skill_validation import expected, meant, moved, of_trajectory
from rosic.config.profile_types import fitting_booleans, of_one_type, said_stop, watched
from rosic.contracts.file_rules import Place, Rules, ValidationFinding, nearest
from rosic.core.alerts.rule import InvalidAlertRule, compile_rule, read_run, rules_of
from rosic.core.language import UnitTable, Vocabulary
from rosic.core.language.command import NO_COMMANDS
from rosic.core.policy.scope import AMONG, FILES, READ, RESUME
from rosic.core.robot.file_transfer import CONTENT_BYTES
from rosic.core.robot.profile import Deliver, Files, Profile, Telemetry
from rosic.core.robot.skill import Parameter, Skill, SkillClass

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

STREAMED: Final = "duration"
# One message of these keeps a robot moving until something else is said.
VELOCITIES: Final = frozenset({"geometry_msgs/msg/Twist", "geometry_msgs/msg/TwistStamped"})
# These words have a meaning for every robot, and are rights of their own.
RESERVED: Final = frozenset({READ, RESUME, FILES, *AMONG, "stop"})
FLEET: Final = "fleet"
NO_STRATEGY: Final = frozenset({"back", "now", "idle"})
IN_PARCELS: Final = ("$name", "$path", "$sha256", "$size", "$kind", "$text", "$content")


def profile_rules(units: UnitTable) -> Rules:
    """Return everything a profile is checked against."""

    def parameter(made: Parameter) -> Iterator[ValidationFinding]:
        yield from _unit(made.unit, units)
        yield from _whole(made)

    def telemetry(made: Telemetry) -> Iterator[ValidationFinding]:
        yield from _unit(made.unit, units)
        if bool(made.topic) != bool(made.type) or bool(made.topic) != bool(made.field):
            yield ValidationFinding(
                (), "A reported value needs topic, type and field, or none of them."
            )
        if made.full != 1.0 and made.unit != "%":
            yield ValidationFinding(("full",), "'full' is of a share: it needs the unit %.")

    def words(made: Profile) -> Iterator[ValidationFinding]:
        fault = clash([made], units)
        if fault:
            yield ValidationFinding(_said_in(made, fault), fault, "Choose another word.")

    def alerts(made: Profile) -> Iterator[ValidationFinding]:
        yield from _alerts(made, units)

    return Rules(
        bounds=BOUNDS,
        forms=FORMS,
        hidden=HIDDEN,
        checks={
            Parameter: (parameter,),
            Telemetry: (telemetry,),
            Files: (_folders, _delivered),
            Skill: (_placeholders, _streams, fitting_booleans),
            Profile: (
                _reserved,
                _located,
                _bound,
                _texts,
                watched,
                _stoppable,
                said_stop,
                of_one_type,
                moved,
                _strategies,
                expected,
                words,
                alerts,
            ),
        },
    )


def clash(profiles: Sequence[Profile], units: UnitTable) -> str:
    """Say why people could not speak to these robots; empty when they could."""
    try:
        Vocabulary.build(profiles, units, NO_COMMANDS)
    except ValueError as fault:
        sentence = str(fault).rstrip(".")
        return f"{sentence[:1].upper()}{sentence[1:]}."
    return ""


def _said_in(profile: Profile, sentence: str) -> Place:
    """Find the part of a profile whose name a sentence quotes."""
    quoted = {word.casefold() for word in re.findall(r"""["']([^"']+)["']""", sentence)}
    for key in ("words", "groups"):
        if quoted & {word.casefold() for word in getattr(profile, key)}:
            return (key,)
    # Of two that clash, the later one is easier to rename.
    for name, skill in reversed(profile.skills.items()):
        if quoted & {word.casefold() for word in skill.words}:
            return ("skills", name, "words")
        for parameter in skill.parameters:
            if quoted >= {name, parameter}:
                return ("skills", name, "parameters", parameter)
    return next((("skills", name) for name in profile.skills if name in quoted), ("id",))


def _unit(unit: str, units: UnitTable) -> Iterator[ValidationFinding]:
    if unit and units.find(unit) is None:
        close = nearest(unit, units.exact, say_all=False)
        yield ValidationFinding(("unit",), f"{unit!r} is not a unit ROSIC knows.", close)


def _whole(parameter: Parameter) -> Iterator[ValidationFinding]:
    for key in ("min", "max", "default"):
        value = getattr(parameter, key)
        if parameter.integer and isinstance(value, float) and not value.is_integer():
            yield ValidationFinding(
                (key,), f"'{key}' must be a whole number, as 'integer' is true."
            )


def _sent(skill: Skill) -> tuple[Place, dict[str, float | int | str | bool]]:
    """Return where a skill's binding keeps what it sends, and what that is."""
    if skill.topic is not None:
        return ("topic", "message"), skill.topic.message
    if skill.service is not None:
        return ("service", "request"), skill.service.request
    if skill.action is not None:
        return ("action", "goal"), skill.action.goal | of_trajectory(skill.action.trajectory)
    if skill.set_parameters is not None:
        return ("set_parameters", "values"), skill.set_parameters.values
    return (), {}


def _placeholders(skill: Skill) -> Iterator[ValidationFinding]:
    place, sent = _sent(skill)
    if not place:
        return
    written = {key: str(value)[1:] for key, value in sent.items() if str(value).startswith("$")}
    named = {key: name.partition(".")[0] for key, name in written.items()}
    unknown = {key: name for key, name in named.items() if name not in skill.parameters}
    for key, name in unknown.items():
        hint = nearest(name, skill.parameters) or "This skill has no parameters."
        yield ValidationFinding((*place, key), f"${name} is not a parameter of this skill.", hint)
    for key in () if unknown else named:
        yield from meant(skill, (*place, key), written[key])
    used = {*named.values(), *([STREAMED] if _is_streamed(skill) else [])}
    for name in () if unknown else skill.parameters:
        if name not in used:
            yield ValidationFinding(
                ("parameters", name),
                f"'{name}' is asked of people but never sent to the robot.",
                f"Write ${name} where it belongs under {'.'.join(map(str, place))}.",
            )


def _is_streamed(skill: Skill) -> bool:
    topic = skill.topic
    return topic is not None and (topic.stream_hz > 0 or topic.type in VELOCITIES)


def _streams(skill: Skill) -> Iterator[ValidationFinding]:
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
        duration = skill.parameters.get(STREAMED)
        if duration is None or duration.unit != "s" or not (duration.min or 0) > 0:
            yield ValidationFinding(
                ("topic", "stream_hz"),
                f"A stream needs a parameter '{STREAMED}' in s that is above 0.",
                "Its max is the longest time the robot is driven by one command.",
            )


def _reserved(profile: Profile) -> Iterator[ValidationFinding]:
    if FLEET in (profile.id, *profile.groups):
        yield ValidationFinding(
            ("id",), f"'{FLEET}' cannot be a robot: it means all that is known of them."
        )
    for name in profile.skills:
        if name in RESERVED:
            yield ValidationFinding(
                ("skills", name), f"'{name}' cannot be a skill: it means the same for every robot."
            )


def _bound(profile: Profile) -> Iterator[ValidationFinding]:
    if profile.link.kind != "ros2":
        return
    if not profile.link.namespace:
        yield ValidationFinding(
            ("link",),
            "A ros2 robot needs a namespace.",
            f"For example /{profile.id}; / for one that has none.",
        )
    for name, skill in profile.skills.items():
        if not _sent(skill)[0] and not profile.link.dialogue:
            yield ValidationFinding(
                ("skills", name),
                f"'{name}' says nothing of how ROS carries it out.",
                "Give one of topic, service, action, set_parameters.",
            )


def _texts(profile: Profile) -> Iterator[ValidationFinding]:
    for name, skill in profile.skills.items():
        for key, parameter in skill.parameters.items():
            place: Place = ("skills", name, "parameters", key)
            if not parameter.text:
                continue
            if not profile.link.dialogue:
                yield ValidationFinding(
                    place,
                    "Free text goes to a robot only over its dialogue.",
                    "Set link.dialogue to true, or give choices instead of text.",
                )
            elif _sent(skill)[0]:
                yield ValidationFinding(
                    place, "Free text never goes into a topic, service or action."
                )


def _located(profile: Profile) -> Iterator[ValidationFinding]:
    if bool(profile.go_to) != (profile.frame is not None):
        yield ValidationFinding(
            (), "To be sent to a place on Earth, a robot needs both frame and go_to."
        )
    if not profile.go_to:
        return
    name, *axes = profile.go_to.split()
    if name not in profile.skills:
        hint = nearest(name, profile.skills)
        yield ValidationFinding(("go_to",), f"{name!r} is not a skill of this robot.", hint)
        return
    parameters = profile.skills[name].parameters
    for axis in axes:
        if axis not in parameters or parameters[axis].unit != "m":
            yield ValidationFinding(("go_to",), f"{axis!r} is not a parameter of {name} in m.")
    for other, parameter in parameters.items():
        if other not in axes and parameter.default is None:
            yield ValidationFinding(
                ("go_to",), f"{name} also asks for {other}, which a place does not say."
            )


def _folders(files: Files) -> Iterator[ValidationFinding]:
    if bool(files.accept) != files.takes:
        yield ValidationFinding(
            (),
            "Files are taken with both: which kinds to accept, and an inbox or deliver.",
        )
    if files.inbox and files.inbox.rstrip("/") == files.outbox.rstrip("/"):
        yield ValidationFinding(("outbox",), "What the robot gives needs a folder of its own.")


def _delivered(files: Files) -> Iterator[ValidationFinding]:
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


def _in_parcels(files: Files, deliver: Deliver) -> Iterator[ValidationFinding]:
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


def _stoppable(profile: Profile) -> Iterator[ValidationFinding]:
    moving = [s for s in profile.skills.values() if s.kind is SkillClass.MOTION]
    if profile.link.kind != "ros2" or not moving or profile.unstoppable:
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


def _strategies(profile: Profile) -> Iterator[ValidationFinding]:
    for name, strategy in profile.strategies.items():
        if name in NO_STRATEGY:
            yield ValidationFinding(
                ("strategies", name), f"'{name}' cannot be a strategy: it has a meaning already."
            )
        for key, parameter in strategy.parameters.items():
            if parameter.text:
                yield ValidationFinding(
                    ("strategies", name, "parameters", key),
                    "Free text goes to a robot only over its dialogue.",
                    "Give choices instead of text.",
                )
    if profile.strategies and profile.link.kind == "ros2" and not profile.link.among:
        yield ValidationFinding(
            ("strategies",),
            "A strategy reaches the robot over its link to other robots.",
            "Set link.among to true.",
        )


def _alerts(profile: Profile, units: UnitTable) -> Iterator[ValidationFinding]:
    if clash([profile], units):
        return
    yield from _low(profile, units)
    if not profile.alerts:
        return
    vocabulary = Vocabulary.build([profile], units, NO_COMMANDS)
    names: set[str] = set()
    for index, alert in enumerate(profile.alerts):
        if alert.name in names:
            yield ValidationFinding(
                ("alerts", index, "name"),
                f"Two rules are called {alert.name!r}.",
                "Tell them apart.",
            )
        names.add(alert.name)
        try:
            rule = compile_rule(profile, alert, units)
            if alert.run:
                read_run(rule, vocabulary)
        except InvalidAlertRule as wrong:
            sentence = str(wrong)
            yield ValidationFinding(
                ("alerts", index, wrong.key), f"{sentence[:1].upper()}{sentence[1:]}."
            )


def _low(profile: Profile, units: UnitTable) -> Iterator[ValidationFinding]:
    try:
        rules_of(replace(profile, alerts=()), units)
    except InvalidAlertRule as wrong:
        yield ValidationFinding(("telemetry",), f"An alarm cannot be made of alert_below: {wrong}.")


def advice(profile: Profile) -> Iterator[ValidationFinding]:
    """Say what is allowed, but worse than it could be."""
    if profile.link.kind != "ros2":
        return
    moves = any(skill.kind is SkillClass.MOTION for skill in profile.skills.values())
    if moves and profile.stop is None:
        yield ValidationFinding(
            (),
            "'stop' is missing: a stop only cancels the goals of this robot's actions.",
            "Name the robot's own stop service; if it has none, write cancel_only: true.",
        )
    yield from unseen_axes(profile)
    for name, skill in profile.skills.items():
        topic = skill.topic
        if skill.kind is SkillClass.MOTION and topic is not None and topic.stream_hz == 0:
            yield ValidationFinding(
                ("skills", name, "topic"),
                f"'{name}' is sent over a topic, which does not acknowledge.",
                "An action tells people whether and how it ended.",
            )
