"""What nobody has said is taken within one's own limits: a default above them is lowered.

Only what a profile proposes is lowered, and that is said. A value that somebody has given is
refused when it is above their limits, and never changed.
"""

from __future__ import annotations

from contextlib import suppress
from math import ceil, floor
from typing import TYPE_CHECKING, NamedTuple

from msgspec.structs import replace

from rosic.core.i18n import joined, said
from rosic.core.language import Do
from rosic.core.language.arguments import bind, place
from rosic.core.order import SpokenValue
from rosic.core.policy.limits import limit_in_words
from rosic.core.policy.query import AuthContext, Deny, PolicyCode
from rosic.core.policy.roles import Assurance
from rosic.errors import Refusal
from rosic.organiser.refusals import bound_of, within_limits

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Iterable, Mapping, Sequence

    from rosic.contracts.clock import Clock
    from rosic.core.identity import Caller, CommandId, PrincipalId
    from rosic.core.language import Line, VocabularyHolder
    from rosic.core.language.compiled import CompiledParameter, CompiledSkill
    from rosic.core.language.numbers import Unit, UnitTable
    from rosic.core.order import Permit, Request
    from rosic.core.policy.limits import Limit
    from rosic.core.robot.profile import RobotId
    from rosic.core.robot.skill import Argument
    from rosic.errors import OutOfBounds
    from rosic.gateway.components import Components
    from rosic.gateway.message_context import MessageContext
    from rosic.gateway.requests import RequestFactory
    from rosic.organiser.organiser import Organiser

# What a chat is worth is asked when the order is admitted; here only limits matter.
ANYWHERE = AuthContext(channel=Assurance.LOCAL)
WHOLE = 1e-6


class ArgumentClamping:
    """Brings what a line leaves open within somebody's limits, and admits nothing."""

    def __init__(self, vocabularies: VocabularyHolder, organiser: Organiser) -> None:
        self._vocabularies = vocabularies
        self._organiser = organiser

    def of(self, caller: Caller, line: Do) -> tuple[Do, str]:
        """Return the same; the line as it is, and nothing to say, where nothing is lowered.

        Raises:
            NotUnderstood, OutOfBounds: It cannot be carried out as it was said.
        """
        vocabulary = self._vocabularies.current
        open_at: dict[str, list[_Open]] = {}
        notes: dict[str, None] = {}
        for robot, skill in zip(line.robots, line.skills, strict=True):
            compiled, given = place(vocabulary, robot, skill, line.spoken, group=line.group)
            arguments = bind(vocabulary, robot, skill, line.spoken, group=line.group)
            found, limits = self.within(caller, robot, compiled, arguments, given)
            for parameter in compiled.numbers:
                usual = arguments.get(parameter.name)
                if isinstance(usual, int | float):
                    here = _Open(parameter.unit, usual, found.get(parameter.name, usual))
                    open_at.setdefault(parameter.name, []).append(here)
            notes.update(dict.fromkeys(self._said(caller, limit) for limit in limits))
        if not notes:
            return line, ""
        units = vocabulary.units
        changed = {name: of for name, of in open_at.items() if any(o.value != o.usual for o in of)}
        more = [_for_all(name, each, units) for name, each in changed.items()]
        changes = tuple(spoken for spoken in more if spoken is not None)
        if len(changes) < len(more):
            return line, ""
        return replace(line, spoken=(*line.spoken, *changes)), joined(", ", notes)

    def within(
        self,
        caller: Caller,
        robot: RobotId,
        compiled: CompiledSkill,
        arguments: Mapping[str, Argument],
        given: Collection[str],
    ) -> tuple[dict[str, float], list[Limit]]:
        """Return what becomes of values that nobody gave, SI, and by which limits."""
        organiser = self._organiser
        skill = compiled.skill.id
        decision = organiser.decision(caller, robot, skill, arguments, ANYWHERE)
        if not isinstance(decision, Deny) or decision.code is not PolicyCode.OVER_LIMIT:
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

    def may(
        self,
        principal: PrincipalId,
        robot: RobotId,
        skill: str,
        arguments: Mapping[str, Argument],
    ) -> bool:
        """Whether values, SI, are within somebody's limits now, so that they may be proposed."""
        organiser = self._organiser
        widest = organiser.rights.widest(principal, robot, skill, organiser.wall_ns())
        return widest is not None and all(
            low <= value <= high
            for name, (low, high) in widest.items()
            if isinstance(value := arguments.get(name, low), int | float)
        )

    def offered(
        self, caller: Caller, offers: Iterable[str], lines: Callable[[str], Sequence[Line]]
    ) -> tuple[str, ...]:
        """Return offers without those that would be refused for being above somebody's limits.

        Where none would be left, the first of them is offered with as much as is theirs.

        Args:
            caller: To whom they are made.
            offers: As typed.
            lines: Reads one.
        """
        kept: list[str] = []
        instead: list[str] = []
        for offer in offers:
            denied = self._over_limit(caller, lines(offer))
            if denied is None:
                kept.append(offer)
            elif not instead:
                profile = self._vocabularies.current.profiles[denied.ask.robot]
                instead.extend(within_limits(denied, profile.skills))
        return tuple(kept or instead)

    def _over_limit(self, caller: Caller, lines: Sequence[Line]) -> Deny | None:
        for line in lines:
            if not isinstance(line, Do):
                continue
            with suppress(Refusal):  # what cannot be as it is said is refused for that
                vocabulary, clamped = self._vocabularies.current, self.of(caller, line)[0]
                for robot, skill in zip(clamped.robots, clamped.skills, strict=True):
                    arguments = bind(vocabulary, robot, skill, clamped.spoken, group=clamped.group)
                    decision = self._organiser.decision(
                        caller, robot, skill.id, arguments, ANYWHERE
                    )
                    if isinstance(decision, Deny) and decision.code is PolicyCode.OVER_LIMIT:
                        return decision
        return None

    def _said(self, caller: Caller, limit: Limit) -> str:
        bound = bound_of(limit.said)
        if any(own in limit.said for own in self._organiser.own_limits(caller.principal)):
            return said("as much as your own setting allows ({limit})", limit=limit_in_words(bound))
        return said("as much as your limit allows ({limit})", limit=limit_in_words(bound))


class LimitClamping(ArgumentClamping):
    """Brings what was left open within somebody's limits, and admits that."""

    def __init__(self, rooms: Components, requesting: RequestFactory, clock: Clock) -> None:
        super().__init__(rooms.vocabularies, rooms.organiser)
        self._rooms = rooms
        self._requesting = requesting
        self._clock = clock

    def admit(
        self, message: MessageContext, line: Do, cid: CommandId, why: OutOfBounds
    ) -> tuple[Do, list[Request], tuple[Permit, ...], str]:
        """Admit a line with its defaults within its author's limits.

        Args:
            message: The message.
            line: As it was said.
            cid: Of the line.
            why: Why it was refused as it was.

        Returns:
            The line as it is carried out, what becomes of it, and what is said beside its orders:
            that a default was lowered.

        Raises:
            OutOfBounds: Nothing of it was left open, or that does not help.
            Refusal: Why not; as `Organiser.admit`.
        """
        line, note = self.of(message.caller, line)
        if not note:
            raise why
        requests = self._requesting.requests(message, line, cid, self._clock.monotonic_ns())
        complete = self._rooms.container.complete
        permits = self._rooms.organiser.admit(
            message.caller, requests, lambda one: complete(one).arguments, message.auth_context
        )
        return line, requests, permits, note


class _Open(NamedTuple):
    """What becomes of one parameter of one robot that nobody gave a value: SI."""

    unit: Unit
    usual: float
    value: float


def _for_all(name: str, robots: list[_Open], units: UnitTable) -> SpokenValue | None:
    """Return a value that is said to all robots of a line; None where no one value fits.

    Where one is lowered, nobody goes further than their own default; where one is raised, no
    further than it has to.
    """
    raised = [one.value for one in robots if one.value > one.usual]
    if raised and any(one.value < one.usual for one in robots):
        return None
    value = max(raised) if raised else min(one.value for one in robots)
    unit = robots[0].unit
    # Without a unit it would be taken in each robot's own.
    word = "" if all(one.unit == unit for one in robots) else unit.symbol
    if word and units.find(word) != unit:
        return None
    return SpokenValue(name, float(f"{unit.from_si(value):.8g}"), word)


def _within(parameter: CompiledParameter, value: float, limit: Limit) -> float:
    """Return a value within a limit, SI, as somebody would write it: a limit has some slack."""
    number = parameter.unit.from_si(min(max(value, limit.min), limit.max))
    if not parameter.integer:
        return parameter.unit.to_si(float(f"{number:.8g}"))
    return parameter.unit.to_si(
        ceil(number - WHOLE) if value < limit.min else floor(number + WHOLE)
    )
