"""What a scope reaches: robots by name, pattern or group, and the words that may follow them."""

from __future__ import annotations

import re
from fnmatch import fnmatchcase, translate
from typing import TYPE_CHECKING

import msgspec

from rosic.core.i18n import said
from rosic.core.robot.profile import RobotId
from rosic.core.robot.skill import Skill, SkillClass

if TYPE_CHECKING:
    from collections.abc import Iterable


# ---- scopes ----

READ = "read"
RESUME = "resume"
FILES = "files"
"""The right to put files into a robot's inbox, and to fetch those it gives."""
PLACES = "places"
"""The right to keep places under names for a robot, for everybody who may send it there."""
SHARE = "share"
"""The right to share data in a robot's name: its own, and nobody else's."""
ASK = "ask"
"""Of itself: to ask for help. Of another: to speak to it."""
HELP = "help"
"""The right to accept a robot's request for help."""
STRATEGY = "strategy"
"""The right to change a robot's strategy."""
AMONG = (SHARE, ASK, HELP, STRATEGY)
"""What robots may be to each other (Algorithm 5); people who help or adjust hold the same."""

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
            raise ValueError(
                said(
                    "{text!r} is no right: write robot, colon and skill, for example omni:move",
                    text=text,
                )
            )
        robot, _, skill = text.partition(":")
        return cls(robot, skill)


GRANT = "grant"
"""The right to give rights on a robot. No wildcard stands for it; ``fleet:grant`` is all of it."""
NO_SKILLS = (READ, RESUME, FILES, PLACES, *AMONG, GRANT)
"""What every robot has besides its skills."""
FLEET = "fleet"
"""Stands where a robot would: rights about the place itself. No wildcard stands for it."""
FLEET_VERBS = (GRANT, "archive", "assign", "invite", "lock", "people", "policy", "slots")


class Fleet(msgspec.Struct, frozen=True):
    """The robots there are, as rights see them.

    Attributes:
        skills: Robot to its skills by id.
        groups: Plain name to robots.
        verbs: What may be said after ``fleet:``.
    """

    skills: dict[RobotId, dict[str, Skill]]
    groups: dict[str, tuple[RobotId, ...]] = {}
    verbs: tuple[str, ...] = FLEET_VERBS

    def words(self, robot: RobotId) -> tuple[str, ...]:
        """Return every word that can stand after a robot in a scope; nothing if unknown."""
        if robot == FLEET:
            return self.verbs
        skills = self.skills.get(robot)
        return () if skills is None else (*skills, *NO_SKILLS)

    def means(self, pattern: str, robot: RobotId) -> bool:
        """Whether ``robots`` would return this one; asked of one, it looks at no other."""
        if FLEET in (pattern, robot):
            return pattern == robot
        if pattern in self.skills:
            return pattern == robot
        if pattern in self.groups:
            return robot in self.groups[pattern] and robot in self.skills
        return robot in self.skills and fnmatchcase(robot, pattern)

    def robots(self, pattern: str) -> tuple[RobotId, ...]:
        """Return whom a pattern, a robot's name or a group's plain name means."""
        if pattern == FLEET:
            return (FLEET,)
        if pattern in self.skills:
            return (pattern,)
        if pattern in self.groups:
            return tuple(robot for robot in self.groups[pattern] if robot in self.skills)
        matches = re.compile(translate(pattern)).match
        return tuple(robot for robot in self.skills if matches(robot))


def words_given(scope: Scope, robot: RobotId, fleet: Fleet) -> frozenset[str]:
    """Return which words of a robot a scope gives.

    ``read`` gives everything that only observes. Whoever has any right on a robot may read it: a
    person who moves a robot has to see it.
    """
    if scope.robot == FLEET:
        verbs = _matching(scope.skill, fleet.verbs)
        if robot == FLEET:
            return frozenset({READ, *verbs} if verbs else ())
        # Whoever may give rights on the whole may give them on each robot.
        return frozenset({READ, GRANT} if GRANT in verbs else ())
    if robot == FLEET or not fleet.means(scope.robot, robot):
        return frozenset()
    found = _matching(scope.skill, fleet.words(robot))
    if scope.skill != GRANT:
        found.discard(GRANT)
    if READ in found:
        skills = fleet.skills[robot]
        found |= {name for name, skill in skills.items() if skill.kind is SkillClass.OBSERVE}
    return frozenset({READ, *found} if found else ())


def words_meant(scope: Scope, robot: RobotId, fleet: Fleet) -> frozenset[str]:
    """Return which words of a robot a scope of care means: a wildcard, only its own skills."""
    if not fleet.means(scope.robot, robot):
        return frozenset()
    if scope.skill in fleet.words(robot):
        return frozenset({scope.skill})
    own = fleet.verbs if robot == FLEET else fleet.skills[robot]
    return frozenset(_matching(scope.skill, own))


def _matching(pattern: str, words: Iterable[str]) -> set[str]:
    matches = re.compile(translate(pattern)).match
    return {word for word in words if matches(word)}
