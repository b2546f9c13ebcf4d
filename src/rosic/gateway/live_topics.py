"""Which streamed skill publishes a topic, and what a message of that topic means for it.

For protocols whose clients publish messages to topics: what a profile binds to a
skill's motion is published by a live order of that skill, with its bounds, lease and watchdog, and
by nothing else.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Final, NamedTuple

from rosic.core.i18n import said
from rosic.core.robot.skill import DURATION
from rosic.core.sample_gate import is_finite_number
from rosic.errors import NotUnderstood

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

    from rosic.core.robot.profile import Profile, RobotId
    from rosic.core.robot.skill import Argument, Skill

HEADER: Final = "header"
"""Of a message that has one; what is sent to the robot bears the time of its sending."""
DEEPEST: Final = 8
AHEAD: Final = "linear.x"
"""Of a velocity; what is before it in a field's name, where the velocity is."""
OUT_OF_PLANE: Final = ("linear.z", "angular.x", "angular.y")


class LiveTopic(NamedTuple):
    """A topic that a skill streams to.

    Attributes:
        robot: Whose skill.
        skill: Its id.
        topic, type: As the profile has them.
        parameters: Field to the parameter that it takes.
        literals: Field to the value that it always has.
        out_of_plane: Fields of a velocity that cannot change the way of a robot that moves in a
            plane: it is sent zero there, whatever a message says.
    """

    robot: RobotId
    skill: str
    topic: str
    type: str
    parameters: Mapping[str, str]
    literals: Mapping[str, Argument | bool]
    out_of_plane: frozenset[str] = frozenset()

    def ignored(self, message: Mapping[str, object]) -> tuple[str, ...]:
        """Return the fields of a message that are not followed, and whose rest is."""
        if not self.out_of_plane:
            return ()
        given = flat(message)
        return tuple(field for field, value in given if value and field in self.out_of_plane)

    def values(self, message: Mapping[str, object]) -> dict[str, float]:
        """Return what a message says of the skill's parameters, SI, unbounded.

        Args:
            message: As a client sent it: its fields nested or dotted; what is left out is zero.

        Raises:
            NotUnderstood: A field that the skill does not send is not zero and might have changed
                the robot's way, two that are one parameter differ, or a value is no number. Nothing
                of the message is followed.
        """
        found: dict[str, float] = {}
        given = dict(flat(message))
        for field, value in given.items():
            if field.partition(".")[0] == HEADER:
                continue
            name = self.parameters.get(field)
            if name is None:
                self._check_literal(field, value)
            elif not is_finite_number(value):
                raise NotUnderstood(said("{field} is no finite number.", field=field[:80]))
            elif found.setdefault(name, value) != value:
                raise NotUnderstood(
                    said("{field} differs from what it goes together with.", field=field[:80])
                )
        for field, literal in self.literals.items():
            if field not in given and literal and field.partition(".")[0] != HEADER:
                self._check_literal(field, 0.0)
        return found

    def _check_literal(self, field: str, value: object) -> None:
        if field in self.out_of_plane and is_finite_number(value):
            return
        literal = self.literals.get(field, 0.0)
        if value == literal or (field not in self.literals and not value):
            return
        raise NotUnderstood(
            said(
                "{field} must be {value}: {robot} is not driven by it here.",
                field=field[:80],
                value=f"{literal:g}" if isinstance(literal, int | float) else str(literal),
                robot=self.robot,
            )
        )


def live_topic(profiles: Iterable[Profile], topic: str, type_name: str = "") -> LiveTopic | None:
    """Return the streamed skill that publishes a topic; None: none of these robots has one.

    Args:
        profiles: Of the robots that may be meant; mostly one has the topic.
        topic: As a client names it: absolute, or without the first slash.
        type_name: As a client names it, with ``/msg/`` or without; empty: not said.

    Raises:
        NotUnderstood: It is published as another type.
    """
    for profile in profiles:
        for skill in profile.skills.values():
            found = _streamed(profile.id, skill)
            if found is None or _absolute(found.topic) != _absolute(topic):
                continue
            if type_name and _plain(type_name) != _plain(found.type):
                raise NotUnderstood(
                    said("{topic} is of the type {type}.", topic=found.topic, type=found.type)
                )
            return found
    return None


def bound_topics(profiles: Iterable[Profile]) -> dict[str, tuple[RobotId, str]]:
    """Return every topic that moves a robot, by its absolute name: whose, and by which skill.

    Nobody publishes one of these but by an order.
    """
    return {
        _absolute(skill.sent.topic): (profile.id, name)
        for profile in profiles
        for name, skill in profile.skills.items()
        if skill.sent.topic
    }


def _streamed(robot: RobotId, skill: Skill) -> LiveTopic | None:
    sent = skill.sent
    if not skill.streams or not sent.topic:
        return None
    parameters: dict[str, str] = {}
    literals: dict[str, Argument | bool] = {}
    for field, value in sent.values.items():
        if not isinstance(value, str) or value[:1] != "$":
            literals[field] = value
            continue
        parameter = skill.parameters.get(value[1:])
        if parameter is None or parameter.choices is not None or value[1:] == DURATION:
            return None  # what a choice stands for cannot be told from a number
        parameters[field] = value[1:]
    away = _out_of_plane(frozenset(parameters) | frozenset(literals))
    return LiveTopic(robot, skill.id, sent.topic, sent.type, parameters, literals, away)


def _out_of_plane(sent: frozenset[str]) -> frozenset[str]:
    """Return what of a velocity is out of the plane of a robot that is sent only what is in it.

    Panels for robots of every kind fill these fields with what they please; a base has nothing that
    could follow them. Of a robot that is sent any of them, none is left out.
    """
    before = {field.removesuffix(AHEAD) for field in sent if field.endswith(AHEAD)}
    away = frozenset(f"{place}{field}" for place in before for field in OUT_OF_PLANE)
    return frozenset() if away & sent else away


def flat(
    message: Mapping[str, object], depth: int = 0, before: str = ""
) -> Iterator[tuple[str, object]]:
    """Go through the fields of a message, each by its dotted name."""
    for name, value in message.items():
        field = f"{before}{name}"
        if isinstance(value, Mapping) and depth < DEEPEST:
            yield from flat(value, depth + 1, f"{field}.")
        else:
            yield field, value


def _absolute(topic: str) -> str:
    return f"/{topic.strip('/')}"


def _plain(type_name: str) -> str:
    return type_name.replace("/msg/", "/")
