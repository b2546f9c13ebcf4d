"""A mission: tasks one after another and side by side, written down once and started often."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, NamedTuple

import msgspec

if TYPE_CHECKING:
    from collections.abc import Mapping

TASKS_AT_MOST: Final = 200
DEEPEST: Final = 16
"""Missions that include missions that include missions: nobody understands more."""
INCLUDED_AT_MOST: Final = 200
"""Also of those that hold no task: laying a mission out never takes long."""


class Part(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """One part of a mission: steps for one robot, or other parts.

    Attributes:
        on: A robot, a group, or ``any``: who carries out the steps.
        steps: What it is asked, one after another, without its name.
        sequence: Parts, one after another.
        together: Parts that begin side by side; what follows waits for all of them.
        mission: Another mission, as if its parts stood here.
        priority: 0 to 9; higher goes first.
        within: How long one step may take before another robot takes over: ``5 min``.
        battery: At least so many percent before it begins; 0 asks nothing.
        localised: Only a robot that knows where it is.
        once: A step that may have been carried out is not repeated by itself.
    """

    on: str = ""
    steps: tuple[str, ...] = ()
    sequence: tuple[Part, ...] = ()
    together: tuple[Part, ...] = ()
    mission: str = ""
    priority: int = 1
    within: str = ""
    battery: float = 0.0
    localised: bool = False
    once: bool = False


class Mission(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A mission as its file says it.

    Attributes:
        name: As people type it.
        title: As people read it; empty for the name.
        do: Parts, one after another.
    """

    name: str
    do: tuple[Part, ...]
    title: str = ""

    @property
    def shown(self) -> str:
        """What people read."""
        return self.title or self.name


class Leaf(NamedTuple):
    """One task of a mission.

    Attributes:
        after: The tasks that have to be done first, by their place in the list.
    """

    part: Part
    after: tuple[int, ...]


class Wrong(ValueError):
    """A mission that cannot be carried out.

    Attributes:
        place: Where in the file of the mission that was laid out.
    """

    def __init__(self, place: tuple[str | int, ...], sentence: str) -> None:
        super().__init__(sentence)
        self.place = place
        self.sentence = sentence


def lay_out(mission: Mission, missions: Mapping[str, Mission]) -> list[Leaf]:
    """Return the tasks of a mission, each after those it waits for.

    Args:
        mission: Which.
        missions: All there are, by name.

    Raises:
        Wrong: It goes round in a circle, names a mission that there is not, or is too large.
    """
    layout = _Layout(missions)
    layout.row(mission.do, (), ("do",), (mission.name,))
    return layout.leaves


class _Layout:
    def __init__(self, missions: Mapping[str, Mission]) -> None:
        self.leaves: list[Leaf] = []
        self._missions = missions
        self._included_ever = 0

    def row(
        self, parts: tuple[Part, ...], after: tuple[int, ...], place: tuple[str | int, ...],
        within: tuple[str, ...],
    ) -> tuple[int, ...]:  # fmt: skip
        """Lay parts out one after another; return what has to be done for all to be done."""
        for index, part in enumerate(parts):
            after = self.part(part, after, (*place, index), within)
        return after

    def part(
        self, part: Part, after: tuple[int, ...], place: tuple[str | int, ...],
        within: tuple[str, ...],
    ) -> tuple[int, ...]:  # fmt: skip
        """Lay one part out."""
        if part.steps:
            return self._task(part, after, place)
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
        self, part: Part, after: tuple[int, ...], place: tuple[str | int, ...]
    ) -> tuple[int, ...]:
        if len(self.leaves) >= TASKS_AT_MOST:
            raise Wrong(place, f"This mission has more than {TASKS_AT_MOST} tasks.")
        self.leaves.append(Leaf(part, after))
        return (len(self.leaves) - 1,)

    def _included(
        self, part: Part, after: tuple[int, ...], place: tuple[str | int, ...],
        within: tuple[str, ...],
    ) -> tuple[int, ...]:  # fmt: skip
        other = self._missions.get(part.mission)
        if part.mission in within:
            way = " -> ".join((*within[within.index(part.mission) :], part.mission))
            raise Wrong(place, f"This mission goes round in a circle: {way}.")
        if other is None:
            raise Wrong(place, f"No mission is called {part.mission!r}.")
        if len(within) > DEEPEST:
            raise Wrong(place, f"This mission includes missions more than {DEEPEST} deep.")
        self._included_ever += 1
        if self._included_ever > INCLUDED_AT_MOST:
            raise Wrong(place, f"This mission includes more than {INCLUDED_AT_MOST} missions.")
        # What is wrong inside another mission is said where that one is included.
        try:
            return self.row(other.do, after, ("do",), (*within, part.mission))
        except Wrong as wrong:
            raise Wrong(place, wrong.sentence) from wrong
