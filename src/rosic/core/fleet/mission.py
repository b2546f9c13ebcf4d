"""A mission: tasks one after another and side by side, written down once and started often."""

from __future__ import annotations

import enum
from typing import TYPE_CHECKING, Final, NamedTuple

import msgspec

from rosic.core.fleet.template import Quantity, filled, no_such, read_value, texts_of
from rosic.errors import Refusal

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rosic.core.language.numbers import UnitTable

TASKS_AT_MOST: Final = 200
DEEPEST: Final = 16
"""Missions that include missions that include missions: nobody understands more."""
INCLUDED_AT_MOST: Final = 200
"""Also of those that hold no task: laying a mission out never takes long."""


class Late(enum.Enum):
    """What happens when something is not done by when it was to be."""

    __hash__ = object.__hash__  # Enum hashes the name, in Python, every time

    SAY = "say"
    CANCEL = "cancel"


class MissionPart(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """One part of a mission: steps for one robot, or other parts.

    Attributes:
        on: A robot, a group, or ``any``: who carries out the steps.
        steps: What it is asked, one after another, without its name.
        sequence: Parts, one after another.
        together: Parts that begin side by side; what follows waits for all of them.
        mission: Another mission, as if its parts stood here.
        values: What that one leaves open: ``{distance: 2 m}``, or ``$name`` of what this one does.
        priority: 0 to 9; higher goes first.
        within: How long one step may take before another robot takes over: ``5 min``.
        battery: At least so many percent before it begins; 0 asks nothing.
        localised: Only a robot that knows where it is.
        once: A step that may have been carried out is not repeated by itself.
        deadline: It is to be done so long after it could begin: ``5 min``.
        late: What happens if it is not: it is said, or the rest of the mission is cancelled, too.
    """

    on: str = ""
    steps: tuple[str, ...] = ()
    sequence: tuple[MissionPart, ...] = ()
    together: tuple[MissionPart, ...] = ()
    mission: str = ""
    values: dict[str, str] = msgspec.field(name="with", default={})
    priority: int = 1
    within: str = ""
    battery: float = 0.0
    localised: bool = False
    once: bool = False
    deadline: str = ""
    late: Late = Late.SAY


class Mission(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A mission as its file says it.

    Attributes:
        name: As people type it.
        title: As people read it; empty for the name.
        do: Parts, one after another.
        parameters: What is said when it is started, by name; a step takes it as ``$name``.
        deadline: All of it is to be done so long after it was started: ``20 min``.
        late: What happens if it is not: it is said, or the rest is cancelled, too.
    """

    name: str
    do: tuple[MissionPart, ...]
    title: str = ""
    parameters: dict[str, Quantity] = {}
    deadline: str = ""
    late: Late = Late.SAY

    @property
    def shown(self) -> str:
        """What people read."""
        return self.title or self.name


class MissionTask(NamedTuple):
    """One task of a mission.

    Attributes:
        after: The tasks that have to be done first, by their place in the list.
        steps: As they are to be done: nothing is left open in them.
    """

    part: MissionPart
    after: tuple[int, ...]
    steps: tuple[str, ...] = ()


class InvalidMission(ValueError):
    """A mission that cannot be carried out.

    Attributes:
        place: Where in the file of the mission that was laid out.
    """

    def __init__(self, place: tuple[str | int, ...], sentence: str) -> None:
        super().__init__(sentence)
        self.place = place
        self.sentence = sentence


def lay_out(
    mission: Mission,
    missions: Mapping[str, Mission],
    units: UnitTable,
    given: Mapping[str, float] | None = None,
) -> list[MissionTask]:
    """Return the tasks of a mission, each after those it waits for.

    Args:
        mission: Which.
        missions: All there are, by name.
        units: In which what it leaves open is said.
        given: What was said for it; None: what it leaves open stays so.

    Raises:
        InvalidMission: It goes round in a circle, names a mission that there is not, or is too
            large.
        NotUnderstood: Something that it leaves open was not said, and has no default.
    """
    layout = _Layout(missions, units)
    texts = {} if given is None else texts_of(mission.parameters, given)
    layout.row(mission.do, (), ("do",), PartPosition((mission.name,), texts))
    return layout.leaves


class PartPosition(NamedTuple):
    """Where a part stands.

    Attributes:
        missions: By name, each including the next.
        texts: What takes the place of what is left open there.
    """

    missions: tuple[str, ...]
    texts: Mapping[str, str]


class _Layout:
    def __init__(self, missions: Mapping[str, Mission], units: UnitTable) -> None:
        self.leaves: list[MissionTask] = []
        self._units = units
        self._missions = missions
        self._included_ever = 0

    def row(
        self,
        parts: tuple[MissionPart, ...],
        after: tuple[int, ...],
        place: tuple[str | int, ...],
        within: PartPosition,
    ) -> tuple[int, ...]:
        """Lay parts out one after another; return what has to be done for all to be done."""
        for index, part in enumerate(parts):
            after = self.part(part, after, (*place, index), within)
        return after

    def part(
        self,
        part: MissionPart,
        after: tuple[int, ...],
        place: tuple[str | int, ...],
        within: PartPosition,
    ) -> tuple[int, ...]:
        """Lay one part out."""
        if part.steps:
            return self._task(part, after, place, within)
        if part.sequence:
            return self.row(part.sequence, after, (*place, "sequence"), within)
        if part.mission:
            return self._included(part, after, (*place, "mission"), within)
        ends: dict[int, None] = {}
        for index, other in enumerate(part.together):
            found = self.part(other, after, (*place, "together", index), within)
            ends.update(dict.fromkeys(found))
        return tuple(ends)

    def _task(
        self,
        part: MissionPart,
        after: tuple[int, ...],
        place: tuple[str | int, ...],
        within: PartPosition,
    ) -> tuple[int, ...]:
        if len(self.leaves) >= TASKS_AT_MOST:
            raise InvalidMission(place, f"This mission has more than {TASKS_AT_MOST} tasks.")
        texts, steps = within.texts, part.steps
        if texts:
            steps = tuple(filled(step, texts) if "$" in step else step for step in steps)
        self.leaves.append(MissionTask(part, after, steps))
        return (len(self.leaves) - 1,)

    def _included(
        self,
        part: MissionPart,
        after: tuple[int, ...],
        place: tuple[str | int, ...],
        within: PartPosition,
    ) -> tuple[int, ...]:
        missions, other = within.missions, self._missions.get(part.mission)
        if part.mission in missions:
            way = " -> ".join((*missions[missions.index(part.mission) :], part.mission))
            raise InvalidMission(place, f"This mission goes round in a circle: {way}.")
        if other is None:
            raise InvalidMission(place, f"No mission is called {part.mission!r}.")
        if len(missions) > DEEPEST:
            raise InvalidMission(place, f"This mission includes missions more than {DEEPEST} deep.")
        self._included_ever += 1
        if self._included_ever > INCLUDED_AT_MOST:
            raise InvalidMission(
                place, f"This mission includes more than {INCLUDED_AT_MOST} missions."
            )
        inner = PartPosition((*missions, part.mission), self._handed_on(part, other, place, within))
        # What is wrong inside another mission is said where that one is included.
        try:
            return self.row(other.do, after, ("do",), inner)
        except InvalidMission as wrong:
            raise InvalidMission(place, wrong.sentence) from wrong

    def _handed_on(
        self, part: MissionPart, other: Mission, place: tuple[str | int, ...], within: PartPosition
    ) -> dict[str, str]:
        """Return what another mission is given for what it leaves open."""
        given: dict[str, float] = {}
        try:
            for name, text in part.values.items():
                if name not in other.parameters:
                    raise InvalidMission((*place[:-1], "with"), no_such(name, other.parameters))
                said = filled(text, within.texts)
                if "$" not in said:  # else nothing is known of it yet
                    given[name] = read_value(name, other.parameters[name], said, self._units)
            texts = texts_of(other.parameters, _assumed(part, other, given))
        except Refusal as refusal:
            raise InvalidMission(place, refusal.sentence) from refusal
        return {
            name: text for name, text in texts.items() if name in given or name not in part.values
        }


def _assumed(part: MissionPart, other: Mission, given: Mapping[str, float]) -> dict[str, float]:
    """Return what is given, and something for what will be given later."""
    later = {name: other.parameters[name].min for name in part.values if name not in given}
    return {**later, **given}
