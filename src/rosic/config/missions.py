"""Missions: their files, and what is wrong with them, with its line."""

from __future__ import annotations

import re
from math import isfinite
from typing import TYPE_CHECKING, Final

import msgspec
from msgspec import inspect

from rosic.config.profile_fields import NAMED
from rosic.config.validation import SourceValidator
from rosic.config.yaml_source import read_yaml
from rosic.contracts.file_rules import (
    Field,
    FieldForm,
    NumberBounds,
    Place,
    Rules,
    ValidationFinding,
    nearest,
)
from rosic.core.alerts.condition import seconds
from rosic.core.fleet.mission import InvalidMission, Late, Mission, MissionPart, lay_out
from rosic.core.fleet.task import PRIORITIES, STEPS_AT_MOST
from rosic.core.fleet.template import QUANTITIES_AT_MOST, filled, names_in, shown
from rosic.core.language import Do, LineContext, Vocabulary, bind, understand
from rosic.core.language.command import NO_COMMANDS
from rosic.core.policy.roles import DEFAULT_ROLES, RoleRules
from rosic.core.time_units import DAY_S
from rosic.errors import ConfigurationError, Refusal

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping, Sequence
    from pathlib import Path

    from rosic.config.source_map import SourceMap
    from rosic.core.fleet.template import Quantity
    from rosic.core.language import UnitTable
    from rosic.core.policy.roles import Role, SkillPrecondition
    from rosic.core.robot.profile import Profile, RobotId


# ---- mission validation ----

# What is wrong with the parts of a mission, looked at with the robots that are to do them.

# ---- parts of a mission ----

ANY: Final = "any"
LONGEST_S: Final = float(DAY_S)


class MissionCheck:
    """Collects what is wrong with the parts of a mission.

    Args:
        vocabulary: What the robots understand.
        units: In which lengths of time are written.
        quantities: What the mission leaves open.
    """

    def __init__(
        self, vocabulary: Vocabulary, units: UnitTable, quantities: Mapping[str, Quantity]
    ) -> None:
        self._vocabulary = vocabulary
        self._units = units
        self._quantities = quantities
        self._tries = _tries(quantities)

    def part(self, part: MissionPart, place: Place) -> Iterator[ValidationFinding]:
        """Find what is wrong with a part and those in it."""
        said = [key for key in ("steps", "sequence", "together", "mission") if getattr(part, key)]
        if len(said) != 1:
            yield ValidationFinding(
                place,
                "A part has exactly one of steps, sequence, together and mission.",
                "Put others beside it, in a list.",
            )
            return
        for key in ("sequence", "together"):
            for index, other in enumerate(getattr(part, key)):
                yield from self.part(other, (*place, key, index))
        if part.values:
            yield from self._handed_on(part, place)
        if part.steps:
            yield from self._task(part, place)
        elif part.deadline:
            yield ValidationFinding(
                (*place, "deadline"),
                "Only a part with steps has a deadline of its own.",
                "Give one to each of its parts, or one to the mission.",
            )

    def deadline(self, said: str, late: Late, place: Place) -> Iterator[ValidationFinding]:
        """Find what is wrong with a deadline, and with what happens then."""
        if said and not self._is_length(said):
            yield ValidationFinding(
                (*place, "deadline"), f"{said!r} is no length of time.", "Write for example 20 min."
            )
        if not said and late is Late.CANCEL:
            yield ValidationFinding(
                (*place, "late"),
                "Without a deadline nothing is late.",
                "Write for example deadline: 20 min.",
            )

    def _handed_on(self, part: MissionPart, place: Place) -> Iterator[ValidationFinding]:
        if not part.mission:
            yield ValidationFinding(
                (*place, "with"),
                "Only another mission is given values.",
                "Write them into the steps.",
            )
        for name, text in part.values.items():
            yield from self._unknown(text, (*place, "with", name))

    def _unknown(self, text: str, place: Place) -> Iterator[ValidationFinding]:
        for name in names_in(text):
            if name not in self._quantities:
                hint = nearest(name, self._quantities) or "Write it under parameters."
                yield ValidationFinding(place, f"There is no parameter {name!r}.", hint)

    def _task(self, part: MissionPart, place: Place) -> Iterator[ValidationFinding]:
        robots = self._robots(part.on)
        if not robots:
            names = (*self._vocabulary.names, ANY)
            hint = nearest(part.on, names) if part.on else "Name a robot, a group, or any."
            what = f"No robot and no group is called {part.on!r}." if part.on else "Who does this?"
            yield ValidationFinding((*place, "on") if part.on else place, what, hint)
            return
        if len(part.steps) > STEPS_AT_MOST:
            yield ValidationFinding((*place, "steps"), f"A task has at most {STEPS_AT_MOST} steps.")
        for index, step in enumerate(part.steps):
            yield from self._step(part.on, robots, step, (*place, "steps", index))
        if part.within and not self._is_length(part.within):
            yield ValidationFinding(
                (*place, "within"),
                f"{part.within!r} is no length of time.",
                "Write for example 5 min.",
            )
        yield from self.deadline(part.deadline, part.late, place)

    def _step(
        self, on: str, robots: Sequence[RobotId], step: str, place: Place
    ) -> Iterator[ValidationFinding]:
        """Find a step that nobody can do, with the least, the most or the usual of each value."""
        unknown = list(self._unknown(step, place))
        if unknown:
            yield from unknown
            return
        used = set(names_in(step))
        for texts in self._tries:
            why = self._why_nobody(robots, filled(step, texts))
            if why:
                said = ", ".join(f"{name}={texts[name]}" for name in texts if name in used)
                given = f" with {said}" if said else ""
                yield ValidationFinding(place, f"Nobody of {on} can do this{given}: {why}")
                return

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
                    f"{robot} {step}", self._vocabulary, LineContext(robot, frozenset({robot}))
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

    def _is_length(self, said: str) -> bool:
        try:
            return 0 < seconds(said, self._units) <= LONGEST_S
        except ValueError:
            return False


def _tries(quantities: Mapping[str, Quantity]) -> list[dict[str, str]]:
    """Return what to try a step with: all at their least, at their most, and as usual."""
    if not quantities:
        return [{}]
    usual = {n: q.min if q.default is None else q.default for n, q in quantities.items()}
    values = (
        usual,
        {name: quantity.min for name, quantity in quantities.items()},
        {name: quantity.max for name, quantity in quantities.items()},
    )
    return [{name: shown(quantities[name], value) for name, value in v.items()} for v in values]


# ---- parameters of a mission ----

NAME: Final = re.compile(r"[a-z][a-z0-9_]*")
TIMES: Final = frozenset({"in", "at", "on", "every", "now", "next", "today", "tomorrow"})
"""What begins a time when a mission is started later."""


def quantity_findings(mission: Mission, units: UnitTable) -> Iterator[ValidationFinding]:
    """Find what is wrong with each of them."""
    place = ("parameters",)
    if len(mission.parameters) > QUANTITIES_AT_MOST:
        yield ValidationFinding(place, f"A mission has at most {QUANTITIES_AT_MOST} parameters.")
    for name, quantity in mission.parameters.items():
        if not NAME.fullmatch(name):
            yield ValidationFinding(
                (*place, name),
                f"{name!r} is no name for a parameter.",
                "Use small letters, digits and _, a letter first.",
            )
        elif name in TIMES:
            yield ValidationFinding(
                (*place, name), f"{name!r} begins a time here.", "Call it otherwise."
            )
        yield from (
            ValidationFinding((*place, name, *under), sentence, hint)
            for under, sentence, hint in _wrong(quantity, units)
        )


def _wrong(quantity: Quantity, units: UnitTable) -> Iterator[tuple[tuple[str, ...], str, str]]:
    if quantity.unit and units.find(quantity.unit) is None:
        yield (
            ("unit",),
            f"{quantity.unit!r} is no unit that is known here.",
            nearest(quantity.unit, units.exact, say_all=False)
            or "Write for example m, m/s, deg or s.",
        )
    if not isfinite(quantity.min) or not isfinite(quantity.max) or quantity.min > quantity.max:
        yield ("min",), "min and max have to be finite, and min not above max.", ""
        return
    if quantity.default is not None and not quantity.min <= quantity.default <= quantity.max:
        bounds = f"{quantity.min:g} and {quantity.max:g}"
        sentence = f"The default {quantity.default:g} is not between {bounds}."
        yield ("default",), sentence, "Change the default or its bounds."


def unused_findings(mission: Mission) -> Iterator[ValidationFinding]:
    """Find parameters that change nothing."""
    used = {name for part in mission.do for text in _texts(part) for name in names_in(text)}
    for name in mission.parameters:
        if name not in used:
            yield ValidationFinding(
                ("parameters", name),
                f"No step uses {name!r}.",
                f"Write ${name} in a step, or leave it out.",
            )


def _texts(part: MissionPart) -> Iterator[str]:
    yield from part.steps
    yield from part.values.values()
    for other in (*part.sequence, *part.together):
        yield from _texts(other)


# ---- missions ----

# ---- missions from files ----

MISSION_BOUNDS: Final[dict[Field, NumberBounds]] = {
    (MissionPart, "priority"): NumberBounds(*PRIORITIES),
    (MissionPart, "battery"): NumberBounds(0, 100),
}
MISSION_FORMS: Final[dict[Field, FieldForm]] = {(Mission, "name"): NAMED}
_RULES: Final = Rules(
    bounds=MISSION_BOUNDS,
    forms=MISSION_FORMS,
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
        self._vocabulary = Vocabulary.build(robots, units, NO_COMMANDS)
        self._read: list[tuple[SourceMap, Mission]] = []

    def read(self, path: Path) -> None:
        """Read one file."""
        try:
            source = read_yaml(path)
        except ConfigurationError as error:
            self.errors.append(error)
            return
        walker = SourceValidator(source, _RULES)
        walker.check(source.data, inspect.type_info(Mission), ())
        self.errors += walker.errors
        if not walker.errors:
            self._read.append((source, msgspec.convert(source.data, Mission)))

    def found(self) -> tuple[Mission, ...]:
        """Look at all of them together, and return them."""
        known: dict[str, Mission] = {}
        for source, mission in self._read:
            if mission.name in known:
                self._note(
                    source,
                    [ValidationFinding(("name",), f"Two missions are called {mission.name}.")],
                )
            known[mission.name] = mission
        for source, mission in self._read:
            self._note(source, self._findings(mission, known))
        return tuple(known.values())

    def _note(self, source: SourceMap, findings: Iterable[ValidationFinding]) -> None:
        self.errors += [source.error(*finding) for finding in findings]

    def _findings(self, mission: Mission, known: dict[str, Mission]) -> Iterator[ValidationFinding]:
        if not mission.do:
            yield ValidationFinding(
                ("do",), "This mission does nothing.", "Give it a part with steps."
            )
        checking = MissionCheck(self._vocabulary, self._units, mission.parameters)
        wrong = [
            *quantity_findings(mission, self._units),
            *checking.deadline(mission.deadline, mission.late, ()),
        ]
        if not wrong:  # else a step could be found wrong because of what is wrong above it
            wrong = [f for i, part in enumerate(mission.do) for f in checking.part(part, ("do", i))]
            wrong += unused_findings(mission)
        yield from wrong
        if not wrong:
            try:
                lay_out(mission, known, self._units)
            except InvalidMission as fault:
                yield ValidationFinding(fault.place, fault.sentence)


# ---- the configured policy ----


def rulebook_of(
    roles: dict[str, Role], care: tuple[SkillPrecondition, ...] = (), preempt: tuple[str, ...] = ()
) -> RoleRules:
    """Return the rules of a place: its own roles beside the default ones, or instead of them."""
    return RoleRules(roles={**DEFAULT_ROLES, **roles}, care=care, preempt=preempt)
