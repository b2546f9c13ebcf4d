"""Missions: their files, and what is wrong with them, with its line."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import msgspec
from msgspec import inspect

from rosic.app.profile_forms import NAMED
from rosic.app.shape import Bounds, Finding, Rules, Walker
from rosic.app.source import Place, nearest
from rosic.app.yaml_file import read_yaml
from rosic.core.condition import seconds
from rosic.core.fleet.mission import Mission, Part, Wrong, lay_out
from rosic.core.fleet.task import PRIORITIES, STEPS_AT_MOST
from rosic.core.language import Context, Do, Vocabulary, bind, understand
from rosic.errors import ConfigurationError, Refusal

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Sequence
    from pathlib import Path

    from rosic.app.source import Source
    from rosic.core.language import UnitTable
    from rosic.core.robot import Profile, RobotId

ANY: Final = "any"
LONGEST_S: Final = 86_400.0
_RULES: Final = Rules(
    bounds={(Part, "priority"): Bounds(*PRIORITIES), (Part, "battery"): Bounds(0, 100)},
    forms={(Mission, "name"): NAMED},
    hidden=frozenset(),
    checks={},
)


class Missions:
    """The missions of a configuration: read one after another, then looked at together.

    Attributes:
        errors: Everything that is wrong.
    """

    def __init__(self, robots: Sequence[Profile], units: UnitTable) -> None:
        self.errors: list[ConfigurationError] = []
        self._units = units
        self._vocabulary = Vocabulary.build(robots, units)
        self._read: list[tuple[Source, Mission]] = []

    def read(self, path: Path) -> None:
        """Read one file."""
        try:
            source = read_yaml(path)
        except ConfigurationError as error:
            self.errors.append(error)
            return
        walker = Walker(source, _RULES)
        walker.check(source.data, inspect.type_info(Mission), ())
        self.errors += walker.errors
        if not walker.errors:
            self._read.append((source, msgspec.convert(source.data, Mission)))

    def found(self) -> tuple[Mission, ...]:
        """Look at all of them together, and return them."""
        known: dict[str, Mission] = {}
        for source, mission in self._read:
            if mission.name in known:
                self._note(source, [Finding(("name",), f"Two missions are called {mission.name}.")])
            known[mission.name] = mission
        for source, mission in self._read:
            self._note(source, self._findings(mission, known))
        return tuple(known.values())

    def _note(self, source: Source, findings: Iterable[Finding]) -> None:
        self.errors += [source.error(*finding) for finding in findings]

    def _findings(self, mission: Mission, known: dict[str, Mission]) -> Iterator[Finding]:
        if not mission.do:
            yield Finding(("do",), "This mission does nothing.", "Give it a part with steps.")
        wrong = [
            finding
            for index, part in enumerate(mission.do)
            for finding in self._part(part, ("do", index))
        ]
        yield from wrong
        if not wrong:
            try:
                lay_out(mission, known)
            except Wrong as fault:
                yield Finding(fault.place, fault.sentence)

    def _part(self, part: Part, place: Place) -> Iterator[Finding]:
        said = [key for key in ("steps", "sequence", "together", "mission") if getattr(part, key)]
        if len(said) != 1:
            yield Finding(
                place,
                "A part has exactly one of steps, sequence, together and mission.",
                "Put others beside it, in a list.",
            )
            return
        for key in ("sequence", "together"):
            for index, other in enumerate(getattr(part, key)):
                yield from self._part(other, (*place, key, index))
        if part.steps:
            yield from self._task(part, place)

    def _task(self, part: Part, place: Place) -> Iterator[Finding]:
        robots = self._robots(part.on)
        if not robots:
            names = (*self._vocabulary.names, ANY)
            hint = nearest(part.on, names) if part.on else "Name a robot, a group, or any."
            what = f"No robot and no group is called {part.on!r}." if part.on else "Who does this?"
            yield Finding((*place, "on") if part.on else place, what, hint)
            return
        if len(part.steps) > STEPS_AT_MOST:
            yield Finding((*place, "steps"), f"A task has at most {STEPS_AT_MOST} steps.")
        for index, step in enumerate(part.steps):
            why = self._why_nobody(robots, step)
            if why:
                yield Finding((*place, "steps", index), f"Nobody of {part.on} can do this: {why}")
        if part.within and not self._within(part.within):
            yield Finding((*place, "within"), f"{part.within!r} is no length of time.",
                          "Write for example 5 min.")  # fmt: skip

    def _robots(self, name: str) -> tuple[RobotId, ...]:
        profile = self._vocabulary.robot(name)
        if name == ANY:
            return tuple(self._vocabulary.profiles)
        return (profile.id,) if profile is not None else self._vocabulary.members(name)

    def _why_nobody(self, robots: Sequence[RobotId], step: str) -> str:
        """Return why no robot can do a step; empty if one can."""
        why = ""
        for robot in robots:
            try:
                lines = understand(
                    f"{robot} {step}", self._vocabulary, Context(robot, frozenset({robot}))
                )
                if len(lines) != 1 or not isinstance(lines[0], Do):
                    why = why or f"{step!r} is not one thing that {robot} can do."
                    continue
                bind(self._vocabulary, robot, lines[0].skills[0], lines[0].spoken)
            except Refusal as refusal:
                why = why or str(refusal)
            else:
                return ""
        return why

    def _within(self, said: str) -> bool:
        try:
            return 0 < seconds(said, self._units) <= LONGEST_S
        except ValueError:
            return False
