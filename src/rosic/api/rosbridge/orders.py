"""Calling a service, or sending a goal to an action, that a profile binds to a skill: an order.

The fields of the request are read back into the skill's arguments, and into the choice that means
what they say; what its profile sends as it is has to be sent so.
Nothing else of the graph is called from here.
"""

from __future__ import annotations

from math import atan2, isclose, remainder, tau
from typing import TYPE_CHECKING, Any, Final, NamedTuple

from rosic.api.rosbridge.topics import absolute, plain_type
from rosic.core.i18n import said
from rosic.core.sample_gate import is_finite_number
from rosic.errors import NotFound, NotUnderstood
from rosic.gateway.live_topics import flat

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from rosic.api.callers import ApiCaller
    from rosic.api.context import ApiContext
    from rosic.contracts.graph_topics import GraphTopics
    from rosic.core.language.compiled import CompiledParameter
    from rosic.core.robot.profile import RobotId
    from rosic.core.robot.skill import Meaning, Skill

SERVICE, ACTION = "service", "action"
NEAR: Final = 1e-6
HEADING_RAD: Final = 1e-4
"""Clients round orientations."""


class BoundSkill(NamedTuple):
    """A skill that is carried out by a service or an action.

    Attributes:
        kind: ``service`` or ``action``.
        name: Absolute.
        type: ``std_srvs/srv/Trigger``.
    """

    robot: RobotId
    skill: Skill
    kind: str
    name: str
    type: str


class OrderBindings:
    """Finds the skill behind a service or an action, and its arguments in a request."""

    def __init__(self, context: ApiContext) -> None:
        self._context = context

    def all(self, caller: ApiCaller) -> Iterator[BoundSkill]:
        """Go through everything that somebody may call."""
        rooms = self._context.kernel.rooms
        for robot in self._context.visible(caller):
            for skill in rooms.profiles[robot].skills.values():
                sent = skill.sent
                if sent.endpoint:
                    name = absolute(sent.endpoint)
                    yield BoundSkill(robot, skill, sent.place[0], name, sent.type)

    def stops(self, caller: ApiCaller, service: str) -> RobotId | None:
        """Return the robot that a service stops, of those that somebody may see."""
        name = absolute(service)
        found = self._with_stop_service(caller)
        return next((robot for robot, topics in found if topics.stop_service == name), None)

    def stop_services(self, caller: ApiCaller) -> dict[str, str]:
        """Return the services that stop robots which somebody may see, and their types."""
        found = (topics for _, topics in self._with_stop_service(caller))
        return {topics.stop_service: topics.stop_service_type for topics in found}

    def _with_stop_service(self, caller: ApiCaller) -> Iterator[tuple[RobotId, GraphTopics]]:
        linker = self._context.kernel.rooms.linker
        for robot in self._context.visible(caller):
            topics = linker.graph_topics(robot)
            if topics is not None and topics.stop_service:
                yield robot, topics

    def releases(self, robot: RobotId, request: Mapping[str, Any]) -> bool:
        """Whether a call of the service that stops a robot says that it may go on."""
        topics = self._context.kernel.rooms.linker.graph_topics(robot)
        wanted = {} if topics is None else topics.releases_by
        given = dict(flat(request))
        return bool(wanted) and all(given.get(field) == how for field, how in wanted.items())

    def find(
        self, caller: ApiCaller, kind: str, name: str, type_name: str, request: object
    ) -> tuple[BoundSkill, dict[str, float | str]]:
        """Return the skill that a call stands for, and the arguments, in the profile's units.

        Raises:
            NotFound: None of those that somebody may use is bound to it.
            NotUnderstood: It is of another type, or what is asked for is not what a skill does.
        """
        wanted = absolute(name.partition("#")[0])
        found = [one for one in self.all(caller) if (one.kind, one.name) == (kind, wanted)]
        if not found:
            raise NotFound(said("There is no {name} here that you may call.", name=wanted))
        if type_name and plain_type(type_name) != plain_type(found[0].type):
            raise NotUnderstood(
                said("{name} is of the type {type}.", name=wanted, type=found[0].type)
            )
        fields = _fields(request)
        wrong: NotUnderstood | None = None
        for one in found:
            try:
                return one, self._arguments(one, fields)
            except NotUnderstood as why:
                wrong = wrong or why
        assert wrong is not None  # noqa: S101 - there is one at least
        raise wrong

    def _arguments(self, bound: BoundSkill, fields: Mapping[str, Any]) -> dict[str, float | str]:
        vocabulary = self._context.kernel.rooms.vocabulary
        compiled = vocabulary.compiled_skill(bound.robot, bound.skill.id)
        if compiled is None:
            raise NotFound(said("There is no {name} here that you may call.", name=bound.name))
        parameters = {one.name: one for one in compiled.parameters}
        arguments: dict[str, float | str] = {}
        left, meanings = dict(fields), dict[str, list[_Meant]]()
        for field, value in bound.skill.sent.values.items():
            if not isinstance(value, str) or value[:1] != "$":
                _check_literal(field, value, left.pop(field, value))
                continue
            name, dot, part = value[1:].partition(".")
            _put_heading(field, left)
            if dot:
                meanings.setdefault(name, []).append(_Meant(field, part, left.pop(field, None)))
            elif field in left:
                _take(arguments, name, field, _given(field, parameters[name], left.pop(field)))
        for name, meant in meanings.items():
            _take_choice(arguments, name, bound.skill.parameters[name].means, meant)
        for field, value in left.items():
            _check_literal(field, 0, value)
        return arguments


class _Meant(NamedTuple):
    """A field that a choice decides: which part of what the choice means, and what was given."""

    field: str
    part: str
    given: object


class _Heading(float):
    """An angle about z, of an orientation; a whole turn more is the same."""


def _put_heading(field: str, left: dict[str, Any]) -> None:
    """Put the angle in the place of an orientation that was given by its x, y, z and w.

    Raises:
        NotUnderstood: It is not upright, or no orientation.
    """
    inside = {axis: f"{field}.{axis}" for axis in "xyzw" if f"{field}.{axis}" in left}
    if not inside:
        return
    x, y, z, w = (left.pop(inside[axis]) if axis in inside else 0.0 for axis in "xyzw")
    if not all(map(is_finite_number, (x, y, z, w))) or not (z or w) or x or y:
        raise NotUnderstood(said("{field} must be an upright orientation here.", field=field[:80]))
    left[field] = _Heading(remainder(2 * atan2(z, w), tau))


def _take(arguments: dict[str, float | str], name: str, field: str, given: float | str) -> None:
    """Take in an argument.

    Raises:
        NotUnderstood: Another field says that it is another.
    """
    if arguments.setdefault(name, given) != given:
        raise NotUnderstood(
            said("{field} differs from what it goes together with.", field=field[:80])
        )


def _take_choice(
    arguments: dict[str, float | str],
    name: str,
    means: Mapping[str, Mapping[str, Meaning]],
    meant: list[_Meant],
) -> None:
    """Take in the choice that means what was given; nothing, if nothing was.

    Raises:
        NotUnderstood: None does, or several do, or another field says that it is another.
    """
    if any(one.given is not None for one in meant):
        _take(arguments, name, meant[0].field, _choice(means, meant))


def _choice(means: Mapping[str, Mapping[str, Meaning]], meant: list[_Meant]) -> str:
    """Return the choice that means what was given; what was left out is zero, as ROS has it.

    Raises:
        NotUnderstood: None does, or several do.
    """
    fields = ", ".join(one.field[:80] for one in meant)
    found = [
        choice
        for choice, meaning in means.items()
        if all(_is_meant(meaning[one.part], one.given) for one in meant)
    ]
    if len(found) == 1:
        return found[0]
    if not found:
        told = ", ".join(means)
        raise NotUnderstood(
            said("{fields} stands for none of these: {choices}.", fields=fields, choices=told)
        )
    raise NotUnderstood(
        said(
            "{fields} stands for each of these: {choices}. Give it as an order, or in a chat.",
            fields=fields,
            choices=", ".join(found),
        )
    )


def _is_meant(meaning: Meaning, given: object) -> bool:
    if isinstance(meaning, tuple):
        if given is None:
            return not any(meaning)
        return (
            isinstance(given, list)
            and len(given) == len(meaning)
            and all(map(_is_meant, meaning, given))
        )
    if given is None:
        return not meaning
    if isinstance(meaning, bool | str) or not is_finite_number(given):
        return type(given) is type(meaning) and given == meaning
    if isinstance(given, _Heading):
        return abs(remainder(given - meaning, tau)) < HEADING_RAD
    return isclose(given, meaning, rel_tol=NEAR, abs_tol=NEAR)


def _fields(request: object) -> dict[str, Any]:
    """Return a request by its dotted fields.

    Raises:
        NotUnderstood: It is not told by the names of its fields.
    """
    if request is None or request == []:
        return {}
    if isinstance(request, list) and len(request) == 1:
        request = request[0]
    if not isinstance(request, dict):
        raise NotUnderstood(said("Give the arguments by the names of their fields."))
    return dict(flat(request))


def _given(field: str, parameter: CompiledParameter, value: object) -> float | str:
    """Return a field's value as the skill's parameter is given: in the profile's unit."""
    if not parameter.is_number:
        if isinstance(value, str):
            return value
        raise NotUnderstood(said("{field} must be text.", field=field[:80]))
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise NotUnderstood(said("{field} is no finite number.", field=field[:80]))
    try:
        return round(parameter.unit.from_si(float(value)), 9)
    except OverflowError:
        raise NotUnderstood(said("{field} is no finite number.", field=field[:80])) from None


def _check_literal(field: str, wanted: object, given: object) -> None:
    if given == wanted or (not wanted and not given):
        return
    raise NotUnderstood(said("{field} must be {value} here.", field=field[:80], value=str(wanted)))
