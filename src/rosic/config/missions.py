"""Missions: their files, and what is wrong with them, with its line."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import msgspec
from msgspec import inspect

from rosic.config.mission_validation import MissionCheck, quantity_findings, unused_findings
from rosic.config.profile_fields import NAMED
from rosic.config.validation import SourceValidator
from rosic.config.yaml_source import read_yaml
from rosic.contracts.file_rules import Field, FieldForm, NumberBounds, Rules, ValidationFinding
from rosic.core.fleet.mission import InvalidMission, Mission, MissionPart, lay_out
from rosic.core.fleet.task import PRIORITIES
from rosic.core.language import Vocabulary
from rosic.core.language.command import NO_COMMANDS
from rosic.core.policy.roles import DEFAULT_ROLES, RoleRules
from rosic.errors import ConfigurationError

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Sequence
    from pathlib import Path

    from rosic.config.source_map import SourceMap
    from rosic.core.language import UnitTable
    from rosic.core.policy.roles import Role, SkillPrecondition
    from rosic.core.robot.profile import Profile


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
