"""What nobody has said is taken within one's own limits: a default above them is lowered.

Only what a profile proposes is lowered, and that is said. A value that somebody has given is
refused when it is above their limits, and never changed.
"""

from __future__ import annotations

from math import floor
from typing import TYPE_CHECKING

from msgspec.structs import replace

from rosic.core.asking import Code, Denied
from rosic.core.language.binding import place
from rosic.core.order import Request, Spoken
from rosic.core.roles import Assurance
from rosic.core.saying import joined, said
from rosic.organiser.grounds import Grounds
from rosic.organiser.refusing import bound_of

if TYPE_CHECKING:
    from collections.abc import Collection, Mapping

    from rosic.contracts.clock import Clock
    from rosic.core.identity import Caller, CommandId
    from rosic.core.language import Do
    from rosic.core.language.compiled import CompiledParameter, CompiledSkill
    from rosic.core.limits import Limit
    from rosic.core.order import Permit
    from rosic.core.robot import RobotId
    from rosic.core.skill import Argument
    from rosic.errors import OutOfBounds
    from rosic.pipeline.requesting import Requesting
    from rosic.pipeline.rooms import Rooms
    from rosic.pipeline.said import Said

# What a chat is worth is asked when the order is admitted; here only limits matter.
ANYWHERE = Grounds(channel=Assurance.LOCAL)
WHOLE = 1e-6


class Lowering:
    """Brings what was left open within somebody's limits."""

    def __init__(self, rooms: Rooms, requesting: Requesting, clock: Clock) -> None:
        self._rooms = rooms
        self._requesting = requesting
        self._clock = clock

    def admit(
        self, said: Said, line: Do, cid: CommandId, why: OutOfBounds
    ) -> tuple[Do, list[Request], tuple[Permit, ...]]:
        """Admit a line with its defaults within its author's limits; `Said.note` says so.

        Args:
            said: The message.
            line: As it was said.
            cid: Of the line.
            why: Why it was refused as it was.

        Returns:
            The line as it is carried out, and what becomes of it.

        Raises:
            OutOfBounds: Nothing of it was left open, or that does not help.
            Refusal: Why not; as `Organiser.admit`.
        """
        line, said.note = self.of(said.caller, line)
        if not said.note:
            raise why
        requests = self._requesting.requests(said, line, cid, self._clock.monotonic_ns())
        complete = self._rooms.container.complete
        permits = self._rooms.organiser.admit(
            said.caller, requests, lambda one: complete(one).arguments, said.grounds
        )
        return line, requests, permits

    def of(self, caller: Caller, line: Do) -> tuple[Do, str]:
        """Return the same; the line as it is, and nothing to say, where nothing is lowered.

        Raises:
            NotUnderstood, OutOfBounds: It cannot be carried out as it was said.
        """
        values: dict[str, float] = {}
        notes: dict[str, None] = {}
        for robot, skill in zip(line.robots, line.skills, strict=True):
            compiled, given = place(
                self._rooms.vocabulary, robot, skill, line.spoken, group=line.group
            )
            request = Request(b"", robot, skill, line.spoken, line.text, 0, 0, 0, 0, line.group)
            arguments = self._rooms.container.complete(request).arguments
            found, limits = self.within(caller, robot, compiled, arguments, given)
            for name, value in found.items():
                number = compiled.by_name[name].unit.from_si(value)
                values[name] = min(values.get(name, number), number)
            notes.update(dict.fromkeys(self._said(caller, limit) for limit in limits))
        if not values:
            return line, ""
        more = tuple(Spoken(name, float(f"{n:.8g}"), "") for name, n in values.items())
        return replace(line, spoken=(*line.spoken, *more)), joined(", ", notes)

    def within(
        self,
        caller: Caller,
        robot: RobotId,
        compiled: CompiledSkill,
        arguments: Mapping[str, Argument],
        given: Collection[str],
    ) -> tuple[dict[str, float], list[Limit]]:
        """Return what becomes of values that nobody gave, SI, and by which limits."""
        organiser = self._rooms.organiser
        skill = compiled.skill.id
        decision = organiser.decision(caller, robot, skill, arguments, ANYWHERE)
        if not isinstance(decision, Denied) or decision.code is not Code.OVER_LIMIT:
            return {}, []
        lowered: dict[str, float] = {}
        limits: list[Limit] = []
        for limit in decision.way.limits if decision.way is not None else ():
            value, parameter = arguments.get(limit.parameter), compiled.by_name[limit.parameter]
            if limit.parameter in given or not isinstance(value, int | float):
                continue
            if not limit.min <= value <= limit.max:
                lowered[limit.parameter] = _within(parameter, float(value), limit)
                limits.append(limit)
        return lowered, limits

    def _said(self, caller: Caller, limit: Limit) -> str:
        bound = bound_of(limit.said)
        if any(own in limit.said for own in self._rooms.organiser.own_limits(caller.principal)):
            return said("as much as your own setting allows ({limit})", limit=bound)
        return said("as much as your limit allows ({limit})", limit=bound)


def _within(parameter: CompiledParameter, value: float, limit: Limit) -> float:
    """Return a value within a limit, SI, as somebody would write it: a limit has some slack."""
    number = parameter.unit.from_si(min(max(value, limit.min), limit.max))
    number = floor(number + WHOLE) if parameter.integer else float(f"{number:.8g}")
    return parameter.unit.to_si(number)
