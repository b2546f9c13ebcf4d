"""``kuka1 grasp for 1h``: which right somebody asks for, where, and for how long."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from hashlib import blake2b
from typing import TYPE_CHECKING, Final

import msgspec

from rosic.authoriser.invitations import InvitedRights
from rosic.core.i18n import joined
from rosic.core.identity import DIGEST_BYTES, PrincipalId
from rosic.core.language import Vocabulary, VocabularyHolder, clean
from rosic.core.language.sanitise import fold_word
from rosic.core.language.suggestions import did_you_mean
from rosic.core.language.time_tokens import length_said
from rosic.core.messages import named_of, spoken
from rosic.core.policy.limits import limit_in_words
from rosic.core.policy.roles import chains
from rosic.core.policy.scope import RESUME
from rosic.core.robot.profile import RobotId
from rosic.core.role_names import role_shown
from rosic.core.time_units import HOUR_S
from rosic.errors import NotUnderstood
from rosic.features.access import messages, request_messages
from rosic.gateway.commands import CommandContext, check_length
from rosic.organiser.access_requests import WantedRight
from rosic.organiser.timezones import Zone

if TYPE_CHECKING:
    from rosic.core.policy.permissions import Permissions
    from rosic.core.robot.skill import Skill

LASTS_S: Final = float(HOUR_S)
LONGEST_LINE: Final = 200
_FOR: Final = "for"
_FOR_ELSEWHERE: Final = frozenset({"für"})


class RequestPlaces(msgspec.Struct, frozen=True, kw_only=True):
    """How robots are named and shown, and where people read times.

    Attributes:
        naming: Returns the robot or the group that is meant, of those the person sees, and the
            rest of the line; refuses what names none.
        shown: Returns a robot's title, or a group's name.
        zone_of: Returns the zone whose clocks somebody reads.
    """

    vocabularies: VocabularyHolder
    naming: Callable[[CommandContext, str], tuple[RobotId, str]]
    shown: Callable[[RobotId], str]
    zone_of: Callable[[PrincipalId], Zone]

    @property
    def vocabulary(self) -> Vocabulary:
        """What can be said now; not to be kept, as it may be replaced."""
        return self.vocabularies.current

    def named(self, robot: RobotId, skill: str) -> str:
        """Return the name of a skill in a sentence."""
        profile = self.vocabulary.profiles.get(robot)
        return skill.replace("_", " ") if profile is None else named_of(profile, skill)

    def given(self, want: WantedRight) -> InvitedRights:
        """Return what somebody would be given; without an end of its own."""
        if want.role:
            return InvitedRights(roles=(want.role,), robots=(want.robot,))
        return InvitedRights(scopes=(f"{want.robot}:{want.skill}",))

    def what(self, given: InvitedRights) -> str:
        """Return it as people read it: ``grasp on KUKA iiwa``."""
        if given.roles:
            [role], [robot] = given.roles, given.robots
            return request_messages.thing(role_shown(role), self.shown(robot))
        robot, _, skill = given.scopes[0].partition(":")
        return request_messages.thing(self.named(robot, skill), self.shown(robot))

    def lacks(
        self, rights: Permissions, principal: PrincipalId, given: InvitedRights, now_ns: int
    ) -> bool:
        """Whether somebody would gain anything by this: it is not theirs, or only with limits."""
        return any(
            not any(
                not way.limits and now_ns < granted.until_ns
                for way, granted in rights.ways(principal, robot, skill)
            )
            for robot, skill in self._rights(rights, given)
        )

    def limits(
        self, rights: Permissions, principal: PrincipalId, given: InvitedRights, now_ns: int
    ) -> str:
        """Return the limits under which somebody has this now; empty without any."""
        found = [
            limit.said
            for robot, skill in self._rights(rights, given)
            for way, granted in rights.ways(principal, robot, skill)
            if now_ns < granted.until_ns
            for limit in way.limits
        ]
        return joined(", ", map(limit_in_words, dict.fromkeys(found)))

    def _rights(self, rights: Permissions, given: InvitedRights) -> list[tuple[RobotId, str]]:
        if given.scopes:
            name, _, skill = given.scopes[0].partition(":")
            return [(robot, skill) for robot in rights.fleet.robots(name)]
        [role], [name] = given.roles, given.robots
        return [
            (robot, skill)
            for robot in rights.fleet.robots(name)
            for skill in _moving(rights, robot)
            if role in rights.roles_giving(robot, skill)
        ]

    def digest(self, rights: Permissions, given: InvitedRights) -> bytes:
        """Return what stands for all that would be given: over which robots, with which limits."""
        roles = rights.rulebook.roles
        met = {name for role in given.roles for chain in chains(roles, role) for name in chain.via}
        held = [(name, roles[name]) for name in sorted(met)]
        where = given.robots or tuple(scope.partition(":")[0] for scope in given.scopes)
        fleet = rights.fleet
        robots = [(r, sorted(fleet.skills[r])) for name in where for r in fleet.robots(name)]
        said = repr((given, held, robots)).encode("utf-8", "replace")
        return blake2b(said, digest_size=DIGEST_BYTES).digest()

    def skill(self, robots: Sequence[RobotId], said: str) -> str | None:
        """Return the skill that all of these robots have under what was said."""
        skills = [self.vocabulary.skill(robot, said) for robot in robots]
        found = {None if skill is None else skill.id for skill in skills}
        return found.pop() if len(found) == 1 else None


def want_of(asked: CommandContext, rights: Permissions, places: RequestPlaces) -> WantedRight:
    """Read what somebody asks for; without a skill it is the least role that moves the robot.

    Raises:
        NotUnderstood: No such robot that they see, no such skill, or no time.
        OutOfBounds: The line is too long.
    """
    said, lasts_s = read_tail(asked.rest)
    name, rest = places.naming(asked, said)
    robots = rights.fleet.robots(name)
    lasts_s = LASTS_S if lasts_s is None else lasts_s
    low = rest.split()
    if not low:
        return WantedRight(robot=name, role=_least_role(rights, name, places), lasts_s=lasts_s)
    for count in range(len(low), 0, -1):
        skill = places.skill(robots, " ".join(low[:count]))
        if skill is not None:
            return WantedRight(robot=name, skill=skill, lasts_s=lasts_s)
    word = low[0].casefold()
    if places.vocabulary.commands.aliases.get(word, word) == RESUME:
        return WantedRight(robot=name, skill=RESUME, lasts_s=lasts_s)
    raise _no_such_skill(name, robots, low[0], places)


def read_tail(text: str) -> tuple[str, float | None]:
    """Return a line without ``for 2h`` at its end, and the seconds; None if it says none.

    Raises:
        NotUnderstood: What stands there is no length of time.
        OutOfBounds: The line is too long.
    """
    line = clean(text).replace("\n", " ").strip()
    check_length(line, LONGEST_LINE)
    raw = line.split()
    low = [_FOR if word in _FOR_ELSEWHERE else word for word in map(_folded, raw)]
    if _FOR not in low:
        return " ".join(raw), None
    at = len(low) - 1 - low[::-1].index(_FOR)
    seconds, used = length_said(low[at + 1 :])
    if not used or used < len(low) - at - 1:
        raise NotUnderstood(messages.no_length(_FOR, " ".join(low[at + 1 :][:1])))
    return " ".join(raw[:at]), seconds


def _folded(word: str) -> str:
    return fold_word(word).casefold()


def _least_role(rights: Permissions, name: str, places: RequestPlaces) -> str:
    """Return the least role under which a robot, or all of a group, does everything it can."""
    moving = [(r, skill) for r in rights.fleet.robots(name) for skill in _moving(rights, r)]
    lists = [rights.roles_giving(robot, skill) for robot, skill in moving]
    for role in lists[0] if lists else ():
        if all(role in roles for roles in lists):
            return role
    spoken_of = dict.fromkeys(spoken(_skill(rights, robot, skill)) for robot, skill in moving)
    raise NotUnderstood(
        request_messages.no_such_right(places.shown(name)),
        offers=tuple(f"/ask {name} {skill}" for skill in list(spoken_of)[:3]),
    )


def _moving(rights: Permissions, robot: RobotId) -> list[str]:
    return [skill for skill in rights.fleet.skills[robot] if rights.actuates(robot, skill)]


def _skill(rights: Permissions, robot: RobotId, skill: str) -> Skill:
    return rights.fleet.skills[robot][skill]


def _no_such_skill(
    name: str, robots: Sequence[RobotId], word: str, places: RequestPlaces
) -> NotUnderstood:
    profiles = [places.vocabulary.profiles[robot] for robot in robots]
    known = {spoken(s): s for profile in profiles for s in profile.skills.values()}
    offers = tuple(f"/ask {name} {skill}" for skill in did_you_mean(word, known))
    return NotUnderstood(request_messages.no_such_skill(places.shown(name), word), offers=offers)
