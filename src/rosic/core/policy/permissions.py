"""Who holds which right: an immutable snapshot, drawn up once, asked for each order.

What people share is kept once: everybody with the same role on the same robots looks into the
same table, whenever their rights end. Changing one person's grants makes a new snapshot that
shares everything else with the old one; whoever still holds the old one sees it unchanged.
"""

from __future__ import annotations

from itertools import chain, islice
from typing import TYPE_CHECKING

from rosic.core.language.compiled import skills_of
from rosic.core.policy.compiled import NEVER_NS, NO_CAUTION, Tables
from rosic.core.policy.roles import priority_of
from rosic.core.policy.scope import FLEET, GRANT, RESUME, Fleet
from rosic.core.policy.validation import given_by, grant_mistakes, rulebook_mistakes

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator, Mapping

    from rosic.core.identity import PrincipalId
    from rosic.core.policy.compiled import HeldGrant, Precondition, Right, RightReason
    from rosic.core.policy.limits import Convert
    from rosic.core.policy.roles import Grant, RoleRules
    from rosic.core.policy.scope import Scope
    from rosic.core.policy.validation import RoleMistake
    from rosic.core.rate_limit import RateLimit
    from rosic.core.robot.profile import Profile, RobotId

NOTHING: frozenset[str] = frozenset()
MOST_NAMED = 3  # whoever is refused hears of so many people who can help
MOST_LOOKED_AT = 1_000


def fleet_of(profiles: Iterable[Profile]) -> Fleet:
    """Return the robots there are, as rights see them."""
    groups: dict[str, list[str]] = {}
    skills = {}
    for profile in profiles:
        skills[profile.id] = skills_of(profile)
        for group in profile.groups:
            groups.setdefault(group, []).append(profile.id)
    return Fleet(skills=skills, groups={name: tuple(some) for name, some in groups.items()})


class Permissions:
    """Every right of everybody at one moment. Nothing in it changes; `with_grants` makes another.

    Attributes:
        epoch: Grows with every replacement; the caller counts.
        policy: The epoch in which rules or anybody's rights changed last: what somebody agreed to
            is void after it. Slots and leases come and go under one policy; they are asked for
            again whenever something is to begin.
        rates: Those of roles; mostly there are none.
    """

    __slots__ = ("_givers", "_people", "_tables", "epoch", "policy", "rates")

    def __init__(
        self,
        epoch: int,
        tables: Tables,
        people: dict[PrincipalId, tuple[HeldGrant, ...]],
        givers: dict[RobotId, tuple[PrincipalId, ...]],
        policy: int,
    ) -> None:
        self.epoch = epoch
        self.policy = policy
        self.rates: Mapping[str, RateLimit] = tables.rates
        self._tables = tables
        self._people = people
        self._givers = givers

    @classmethod
    def draw_up(
        cls,
        epoch: int,
        rulebook: RoleRules,
        fleet: Fleet,
        people: Mapping[PrincipalId, tuple[Grant, ...]],
        convert: Convert,
    ) -> Permissions:
        """Work everything out; for a start, and whenever roles or robots have changed.

        Nothing here fails: what cannot be understood gives nothing. `rosic.core.policy.validation`
        says what that is, and whoever changes the rules asks it first.
        """
        tables = Tables(rulebook, fleet, convert)
        held = {who: tuple(map(tables.holding, grants)) for who, grants in people.items()}
        givers: dict[RobotId, list[PrincipalId]] = {}
        for who, holdings in held.items():
            for robot in _giving(holdings):
                givers.setdefault(robot, []).append(who)
        given = {robot: tuple(some) for robot, some in givers.items()}
        return cls(epoch, tables, held, given, epoch)

    def with_grants(
        self, epoch: int, principal: PrincipalId, grants: tuple[Grant, ...]
    ) -> Permissions:
        """Return the snapshot in which one person holds exactly these grants; none: nobody."""
        before = self._people.get(principal, ())
        after = tuple(map(self._tables.holding, grants))
        people = self._people.copy()
        if after:
            people[principal] = after
        else:
            people.pop(principal, None)
        was, now = _giving(before), _giving(after)
        givers = self._givers
        if was != now:
            givers = givers.copy()
            for robot in was - now:
                givers[robot] = tuple(p for p in givers[robot] if p != principal)
            for robot in now - was:
                givers[robot] = (*givers.get(robot, ()), principal)
        return Permissions(epoch, self._tables, people, givers, epoch)

    def later(self) -> Permissions:
        """Return the same rights under the next number: what was admitted is looked at anew."""
        return Permissions(self.epoch + 1, self._tables, self._people, self._givers, self.policy)

    # ---- for each order ----

    def may(self, principal: PrincipalId, robot: RobotId, skill: str) -> Right | None:
        """Look a right up: the fast path.

        Returns:
            None: no role and no grant gives it, at any time. With ``plain`` true: it is theirs
            now, with any arguments, over any channel, and nothing has to be confirmed; the key,
            the lock, the stop, the slot and the lease are not its business. With ``plain``
            false: ask `rosic.core.policy.evaluate.decide`.
        """
        found = None
        for holding in self._people.get(principal, ()):
            row = holding.rows.get(robot)
            if row is not None:
                right = row.get(skill)
                if right is not None:
                    if right.plain:
                        return right
                    found = right
        return found

    def sees(self, principal: PrincipalId, robot: RobotId, now_ns: int) -> bool:
        """Whether somebody may read a robot, and therefore stop it."""
        for holding in self._people.get(principal, ()):
            if robot in holding.rows and now_ns < holding.until_ns:
                return True
        return False

    def visible(self, principal: PrincipalId, now_ns: int) -> frozenset[RobotId]:
        """Return the robots that somebody may read, and therefore stop."""
        holdings = self._people.get(principal, ())
        if len(holdings) == 1:  # nearly everybody
            return holdings[0].table.seen if now_ns < holdings[0].until_ns else NOTHING
        live = [h.seen for h in holdings if now_ns < h.until_ns]
        return live[0] if len(live) == 1 else self._tables.together(tuple(live))

    def ways(
        self, principal: PrincipalId, robot: RobotId, skill: str
    ) -> Iterator[tuple[RightReason, HeldGrant]]:
        """Return everything that gives somebody a right, ended or not, in the order of grants."""
        for holding in self._people.get(principal, ()):
            right = holding.rows.get(robot, {}).get(skill)
            if right is not None:
                for way in right.ways:
                    yield way, holding

    def holds(self, principal: PrincipalId, robot: RobotId, skill: str, now_ns: int) -> bool:
        """Whether somebody has a right now, under whatever limits."""
        return any(now_ns < holding.until_ns for _, holding in self.ways(principal, robot, skill))

    def limits(
        self, principal: PrincipalId, robot: RobotId, skill: str, now_ns: int
    ) -> tuple[tuple[str, ...], ...]:
        """Return the limits of each way in which somebody has a right now; none if one has none."""
        live = [way for way, held in self.ways(principal, robot, skill) if now_ns < held.until_ns]
        if not live or any(not way.limits for way in live):
            return ()
        return tuple(dict.fromkeys(tuple([limit.said for limit in way.limits]) for way in live))

    def widest(
        self, principal: PrincipalId, robot: RobotId, skill: str, now_ns: int
    ) -> dict[str, tuple[float, float]] | None:
        """Return how far somebody may go with each parameter that is limited, SI.

        Over every way in which they have the right now; None: they have it in none.
        """
        live = [way for way, held in self.ways(principal, robot, skill) if now_ns < held.until_ns]
        if not live:
            return None
        limited = [{limit.parameter: limit for limit in way.limits} for way in live]
        names = frozenset(limited[0]).intersection(*limited[1:])
        return {
            name: (min(of[name].min for of in limited), max(of[name].max for of in limited))
            for name in sorted(names)
        }

    def moves_until_ns(self, principal: PrincipalId, robot: RobotId) -> int | None:
        """Return when the last of somebody's rights to move a robot ends; None: one has no end."""
        ends = [
            holding.until_ns
            for holding in self._people.get(principal, ())
            if any(self.actuates(robot, skill) for skill in holding.rows.get(robot, ()))
        ]
        last_ns = max(ends, default=0)
        return None if last_ns >= NEVER_NS else last_ns

    def priority(self, principal: PrincipalId, robot: RobotId, now_ns: int) -> int:
        """Return the highest priority that somebody has on a robot now; 0 without a right."""
        return max(
            (
                holding.priority
                for holding in self._people.get(principal, ())
                if robot in holding.rows and now_ns < holding.until_ns
            ),
            default=0,
        )

    def may_take_over(self, robot: RobotId) -> bool:
        """Whether a higher priority may take this robot over at all."""
        return robot in self._tables.preempt

    def caution(self, robot: RobotId, skill: str) -> Precondition:
        """Return what a skill wants besides the right to it."""
        return self._tables.care.get(robot, {}).get(skill, NO_CAUTION)

    def rated(
        self, principal: PrincipalId, robot: RobotId, skill: str, now_ns: int
    ) -> tuple[str, ...]:
        """Return the roles whose rates an order counts against: those of the way with the fewest.

        Whoever has a right without such a role as well is bound by none.
        """
        live = [
            way.rates
            for way, holding in self.ways(principal, robot, skill)
            if now_ns < holding.until_ns
        ]
        return min(live, key=len, default=())

    def actuates(self, robot: RobotId, skill: str) -> bool:
        """Whether a skill needs the robot for oneself."""
        known = self._tables.fleet.skills.get(robot, {}).get(skill)
        return known is not None and known.actuates

    def covers(self, scopes: tuple[Scope, ...], robot: RobotId, skill: str) -> bool:
        """Whether a key that is narrowed to scopes reaches so far; an unnarrowed one does."""
        if not scopes:
            return True
        return any(skill in self._tables.named(scope, robot) for scope in scopes)

    # ---- for refusals, answers and changes ----

    def grants(self, principal: PrincipalId) -> tuple[Grant, ...]:
        """Return what somebody was given, ended or not."""
        return tuple(holding.grant for holding in self._people.get(principal, ()))

    def people(self) -> dict[PrincipalId, tuple[Grant, ...]]:
        """Return everybody's grants; for lists and for drawing up anew, it walks everybody."""
        return {who: self.grants(who) for who in self._people}

    def ended_ns(self, principal: PrincipalId, now_ns: int) -> int | None:
        """Return when the last of somebody's rights ended; None if one lives or none ever was."""
        ends = [holding.until_ns for holding in self._people.get(principal, ())]
        return max(ends) if ends and max(ends) <= now_ns else None

    def givers(
        self, robot: RobotId, now_ns: int, *, besides: PrincipalId = ""
    ) -> tuple[PrincipalId, ...]:
        """Return up to three people who can give rights on a robot, or on the whole (`FLEET`)."""
        found: list[PrincipalId] = []
        for who in self._givers.get(robot, ()):
            if who != besides and self.holds(who, robot, GRANT, now_ns):
                found.append(who)
                if len(found) == MOST_NAMED:
                    break
        return tuple(found)

    def is_last_giver(
        self, principal: PrincipalId, acts: Callable[[PrincipalId], bool], at_ns: int
    ) -> bool:
        """Whether nobody else who can act gives rights on the whole at a time; walks everybody."""
        return not any(
            who != principal and acts(who) and self.holds(who, FLEET, GRANT, at_ns)
            for who in self._people
        )

    def resumers(
        self, robot: RobotId, now_ns: int, *, besides: PrincipalId = ""
    ) -> tuple[PrincipalId, ...]:
        """Return up to three people who can resume a robot: of those who give rights, then others.

        Looks at no more than a thousand people.
        """
        found: list[PrincipalId] = []
        for who in islice(chain(self._givers.get(robot, ()), self._people), MOST_LOOKED_AT):
            if who != besides and who not in found and self.holds(who, robot, RESUME, now_ns):
                found.append(who)
                if len(found) == MOST_NAMED:
                    break
        return tuple(found)

    def roles_giving(self, robot: RobotId, skill: str) -> tuple[str, ...]:
        """Return the roles that would give a right, the least of them first."""
        return self._tables.roles_giving(robot, skill)

    def role_priority(self, role: str) -> int:
        """Return the priority of a role; 0 for one that is unknown."""
        return priority_of(self._tables.rulebook.roles, role)

    def mistakes(self, grant: Grant) -> list[RoleMistake]:
        """Find what is wrong with a grant that somebody is about to give."""
        tables = self._tables
        return grant_mistakes(grant, tables.rulebook, tables.fleet, tables.convert)

    def rule_mistakes(self, rulebook: RoleRules) -> list[RoleMistake]:
        """Find what is wrong with other rules, for these robots."""
        return rulebook_mistakes(rulebook, self._tables.fleet, self._tables.convert)

    def given_by(self, rulebook: RoleRules, role: str) -> dict[RobotId, frozenset[str]]:
        """Return what a role would give by other rules, without limits."""
        return given_by(rulebook, role, self._tables.fleet)

    @property
    def rulebook(self) -> RoleRules:
        """What it was drawn up from."""
        return self._tables.rulebook

    @property
    def fleet(self) -> Fleet:
        """What it was drawn up for."""
        return self._tables.fleet


class PolicyInForce:
    """The rights that count now: whoever decides by them holds this, and reads it each time (I8).

    Attributes:
        rights: The present snapshot.
        epoch: Its number; what was admitted under another one is admitted once more.
    """

    __slots__ = ("epoch", "rights")

    def __init__(self, rights: Permissions) -> None:
        self.rights, self.epoch = rights, rights.epoch

    def replace(self, rights: Permissions) -> None:
        """Let a snapshot count from now on, for everybody at once."""
        self.rights, self.epoch = rights, rights.epoch


def _giving(holdings: tuple[HeldGrant, ...]) -> set[RobotId]:
    return {robot for holding in holdings for robot in holding.giving}
