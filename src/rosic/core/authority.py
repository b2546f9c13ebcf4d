"""Who may do what: scopes, roles, and the policy as one immutable value.

A policy is replaced, never changed; its ``epoch`` grows with every replacement. Looking a right
up costs the same whatever the number of people, robots and skills.
"""

from __future__ import annotations

import re
from fnmatch import translate
from typing import TYPE_CHECKING

import msgspec

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from rosic.core.identity import PrincipalId
    from rosic.core.robot import RobotId

READ = "read"
RESUME = "resume"

SCOPE = re.compile(r"[a-z0-9_*?-]+:[a-z0-9_*?-]+\Z")


class Scope(msgspec.Struct, frozen=True):
    """``robot:skill`` with wildcards: ``kuka1:grasp``, ``crazyflie-*:*``, ``*:read``."""

    robot: str
    skill: str

    @classmethod
    def parse(cls, text: str) -> Scope:
        """Read a scope.

        Raises:
            ValueError: Not of the form ``robot:skill``.
        """
        if not SCOPE.match(text):
            raise ValueError(f"{text!r} is not a scope: write robot:skill, for example omni:move")
        robot, _, skill = text.partition(":")
        return cls(robot, skill)


class Role(msgspec.Struct, frozen=True):
    """A name for a set of scopes."""

    name: str
    scopes: tuple[Scope, ...]


# A viewer reads; an operator moves, and may undo a stop; an admin does everything.
DEFAULT_ROLES: dict[str, tuple[str, ...]] = {
    "viewer": ("*:read",),
    "operator": ("*:*",),
    "admin": ("*:*", "fleet:*"),
}


def rights_of(
    scopes: Iterable[Scope], skills: Mapping[RobotId, Iterable[str]]
) -> dict[RobotId, frozenset[str]]:
    """Expand wildcards against the robots and skills that exist.

    Whoever has any right on a robot may read it: a person who moves a robot has to see it.
    """
    table: dict[RobotId, set[str]] = {}
    for scope in scopes:
        robot_matches = re.compile(translate(scope.robot)).match
        skill_matches = re.compile(translate(scope.skill)).match
        for robot, names in skills.items():
            if robot_matches(robot):
                found = {name for name in (*names, READ, RESUME) if skill_matches(name)}
                if found:
                    table.setdefault(robot, {READ}).update(found)
    return {robot: frozenset(names) for robot, names in table.items()}


NOBODY: frozenset[RobotId] = frozenset()


class Policy:
    """Roles expanded against the fleet, and who has which. Immutable by convention: no setters.

    Attributes:
        epoch: Grows with every replacement.
    """

    __slots__ = ("_holders", "_may", "_rights", "_visible", "epoch")

    def __init__(
        self,
        *,
        epoch: int,
        roles: Iterable[Role],
        skills: Mapping[RobotId, Iterable[str]],
        people: Mapping[PrincipalId, tuple[str, ...]],
    ) -> None:
        self.epoch = epoch
        self._rights = {role.name: rights_of(role.scopes, skills) for role in roles}
        # People with the same roles share one entry: what they may, and what they see.
        tables = {names: self._joined(names) for names in set(people.values())}
        seen = {names: frozenset(table) for names, table in tables.items()}
        self._may = {principal: tables[names] for principal, names in people.items()}
        self._visible = {principal: seen[names] for principal, names in people.items()}
        self._holders = dict(people)

    def _joined(self, names: tuple[str, ...]) -> dict[RobotId, frozenset[str]]:
        """Return what several roles give together; a name that is no role gives nothing."""
        joined: dict[RobotId, frozenset[str]] = {}
        for name in names:
            for robot, skills in self._rights.get(name, {}).items():
                joined[robot] = joined.get(robot, frozenset()) | skills
        return joined

    def allows(self, principal: PrincipalId, robot: RobotId, skill: str) -> bool:
        """Whether any role of the principal gives ``robot:skill``."""
        rights = self._may.get(principal)
        return rights is not None and skill in rights.get(robot, ())

    def visible(self, principal: PrincipalId) -> frozenset[RobotId]:
        """Return the robots that the principal may see, and therefore stop."""
        return self._visible.get(principal, NOBODY)

    def who_can(self, robot: RobotId, skill: str) -> tuple[PrincipalId, ...]:
        """Return who has a right themselves; for refusals only, it looks at everybody."""
        return tuple(p for p in self._holders if self.allows(p, robot, skill))

    def roles_giving(self, robot: RobotId, skill: str) -> tuple[str, ...]:
        """Return the names of roles that would give a right, the narrowest first."""
        giving = [
            (sum(map(len, rights.values())), name)
            for name, rights in self._rights.items()
            if skill in rights.get(robot, ())
        ]
        return tuple(name for _, name in sorted(giving, key=lambda found: found[0]))

    def with_role(self, name: str) -> tuple[PrincipalId, ...]:
        """Return who has a role."""
        return tuple(p for p, names in self._holders.items() if name in names)
