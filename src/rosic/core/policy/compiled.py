"""Roles and grants, spread out over the robots and skills there are.

One table for each combination of role, robots and limits that somebody holds, shared by all of
them. A right that ends looks into a second edition of it in which nothing is ``plain``.
"""

from __future__ import annotations

from contextlib import suppress
from typing import TYPE_CHECKING, TypeAlias
from weakref import WeakValueDictionary

import msgspec

from rosic.core.policy.limits import Limit, LimitMismatch, LimitRule, fit_limits, parse_limit
from rosic.core.policy.roles import (
    ASSURANCES,
    Assurance,
    Grant,
    RoleRules,
    StepRequired,
    chains,
    priority_of,
)
from rosic.core.policy.scope import FLEET, GRANT, Fleet, Scope, words_given, words_meant
from rosic.core.rate_limit import RateLimit, parse_rate
from rosic.core.robot.profile import RobotId

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping

    from rosic.core.policy.limits import Convert
    from rosic.core.policy.roles import SkillPrecondition


def kinds_of(fleet: Fleet, care: Mapping[RobotId, Mapping[str, object]]) -> dict[RobotId, int]:
    """Number the robots so that those with the same skills and the same care have one number.

    By what a skill is carried out is nothing to rights.
    """
    met: dict[str, int] = {}
    kinds = {FLEET: -1}
    for robot, skills in fleet.skills.items():
        plain = {name: skill.unbound for name, skill in skills.items()}
        mine = repr((plain, care.get(robot, {})))
        kinds[robot] = met.setdefault(mine, len(met))
    return kinds


# ---- roles and grants ----

NEVER_NS = 2**63 - 1
FOR_GOOD_NS = NEVER_NS - 1  # only what has no end holds then


class RightReason(msgspec.Struct, frozen=True, gc=False):
    """One reason why a right exists.

    Attributes:
        via: The granted role and the roles it includes, down to the one with the scope; empty for
            a scope that was granted itself.
        scope: That scope.
        limits: All must hold.
        priority: Of the granted role; 0 for a bare scope.
        assurance: The least the conversation must be worth.
        rates: Roles whose rate it counts against.
    """

    via: tuple[str, ...]
    scope: str
    limits: tuple[Limit, ...]
    priority: int
    assurance: Assurance
    rates: tuple[str, ...] = ()

    def serves(self, other: RightReason) -> bool:
        """Whether whoever has this one gains nothing by the other, which is of the same grant."""
        return (
            self.assurance <= other.assurance
            and set(self.limits) <= set(other.limits)
            and set(self.rates) <= set(other.rates)
        )


class Right(msgspec.Struct, frozen=True, gc=False):
    """A skill of a robot that a role or a grant gives.

    Attributes:
        plain: Nothing else has to be asked about it: no end, limit, assurance or care.
        ways: Every reason that adds something, at least one.
    """

    plain: bool
    ways: tuple[RightReason, ...]


class Precondition(msgspec.Struct, frozen=True, gc=False):
    """What a skill wants besides the right to it."""

    needs: tuple[StepRequired, ...]
    assurance: Assurance


NO_CAUTION = Precondition((), Assurance.PROVIDER_READABLE)

Rows: TypeAlias = dict[RobotId, dict[str, Right]]


class GrantTable(msgspec.Struct, frozen=True, eq=False, weakref=True):
    """What a grant gives, whoever holds it and until whenever.

    Attributes:
        seen: Robots in it.
        giving: Those on which it gives the right to give.
    """

    rows: Rows
    seen: frozenset[RobotId]
    giving: tuple[RobotId, ...]
    priority: int


class HeldGrant(msgspec.Struct, frozen=True, eq=False, weakref=True):
    """A grant in somebody's hands.

    Attributes:
        until_ns: Wall clock; `NEVER_NS` without an end.
    """

    grant: Grant
    until_ns: int
    table: GrantTable
    rows: Rows

    @property
    def priority(self) -> int:
        """Who may take over from whom."""
        return self.table.priority

    @property
    def seen(self) -> frozenset[RobotId]:
        """Return the robots it shows."""
        return self.table.seen

    @property
    def giving(self) -> tuple[RobotId, ...]:
        """Return the robots on which it gives the right to give."""
        return self.table.giving


class _Link(msgspec.Struct, frozen=True, eq=False):
    """A way of a role before it is spread out over robots."""

    via: tuple[str, ...]
    scopes: tuple[Scope, ...]
    limits: tuple[tuple[LimitRule, ...], ...]
    assurance: Assurance
    rates: tuple[str, ...] = ()


class Tables:
    """Spreads grants out, each kind of grant once. What it remembers changes no answer."""

    __slots__ = (
        "_giving",
        "_holdings",
        "_kinds",
        "_links",
        "_named",
        "_rows",
        "_shared",
        "_together",
        "care",
        "convert",
        "fleet",
        "preempt",
        "rates",
        "rulebook",
    )

    def __init__(self, rulebook: RoleRules, fleet: Fleet, convert: Convert) -> None:
        self.rulebook = rulebook
        self.fleet = fleet
        self.preempt = frozenset(r for said in rulebook.preempt for r in fleet.robots(said))
        self.care = _spread_care(rulebook.care, fleet)
        self.rates = _read_rates(rulebook)
        self.convert = convert
        self._named: dict[tuple[Scope, RobotId], frozenset[str]] = {}
        self._links: dict[str, tuple[_Link, ...]] = {}
        self._kinds = kinds_of(fleet, self.care)
        self._rows: dict[tuple[str, bool, int, tuple[frozenset[str], ...]], dict[str, Right]] = {}
        self._giving: dict[tuple[RobotId, str], tuple[str, ...]] = {}
        self._together: dict[tuple[frozenset[RobotId], ...], frozenset[RobotId]] = {}
        # Weak: what the last holder gave back is forgotten.
        self._shared: WeakValueDictionary[Grant, GrantTable] = WeakValueDictionary()
        self._holdings: WeakValueDictionary[Grant, HeldGrant] = WeakValueDictionary()

    def holding(self, grant: Grant) -> HeldGrant:
        """Return a grant spread out. What is nobody's own is the same object for all of them."""
        anybodys = not grant.id and grant.expires_ns is None
        held = self._holdings.get(grant) if anybodys else None
        if held is None:
            until_ns = NEVER_NS if grant.expires_ns is None else grant.expires_ns
            # Same table for everybody whose right ends, whenever that is.
            kind = msgspec.structs.replace(
                grant, id="", expires_ns=None if grant.expires_ns is None else 0
            )
            table = self._shared.get(kind)
            if table is None:
                table = self._shared[kind] = self._table(kind)
            held = HeldGrant(grant, until_ns, table, table.rows)
            if anybodys:
                self._holdings[grant] = held
        return held

    def named(self, scope: Scope, robot: RobotId) -> frozenset[str]:
        """Return which words of a robot a scope gives; whoever has any of them may read it."""
        key = (scope, robot)
        found = self._named.get(key)
        if found is None:
            found = words_given(scope, robot, self.fleet)
            if len(self._named) < _MOST_NAMED:
                self._named[key] = found
        return found

    def together(self, seen: tuple[frozenset[RobotId], ...]) -> frozenset[RobotId]:
        """Return all robots of some tables; joined once, and not for each message of somebody."""
        joined = self._together.get(seen)
        if joined is None:
            if len(self._together) >= _MOST_TOGETHER:
                self._together.clear()
            joined = self._together[seen] = frozenset().union(*seen)
        return joined

    def roles_giving(self, robot: RobotId, skill: str) -> tuple[str, ...]:
        """Return the roles that give a right, the least of them first."""
        if skill not in self.fleet.words(robot):
            return ()
        known = self._giving.get((robot, skill))
        if known is None:
            known = self._giving[robot, skill] = tuple(self._roles_giving(robot, skill))
        return known

    def _roles_giving(self, robot: RobotId, skill: str) -> list[str]:
        roles = self.rulebook.roles
        rows = {name: self._role_row(name, robot, ends=False) for name in roles}
        giving = [
            (priority_of(roles, name), len(row), name) for name, row in rows.items() if skill in row
        ]
        return [name for _, _, name in sorted(giving)]

    def _table(self, kind: Grant) -> GrantTable:
        ends = kind.expires_ns is not None
        whole = not kind.scopes and not kind.limits
        links = (*self._links_of(kind.role), *_bare(kind.scopes))
        limits = _read_limits((kind.limits,)) if kind.limits else ()
        if limits is None:
            links, limits = (), ()
        priority = priority_of(self.rulebook.roles, kind.role)
        rows: Rows = {}
        for robot in self._reach(kind.robots):
            if whole:
                row = self._role_row(kind.role, robot, ends=ends)
            else:
                row = self._row(links, limits, robot, _Edition(priority, ends))
            if row:
                rows[robot] = row
        return GrantTable(
            rows,
            frozenset(robot for robot in rows if robot != FLEET),
            tuple(robot for robot, row in rows.items() if GRANT in row),
            priority,
        )

    def _reach(self, robots: tuple[str, ...]) -> Iterable[RobotId]:
        if not robots:
            return (*self.fleet.skills, FLEET)
        return dict.fromkeys(robot for said in robots for robot in self.fleet.robots(said))

    def _role_row(self, role: str, robot: RobotId, *, ends: bool) -> dict[str, Right]:
        """Return what a role alone gives on a robot: one row for all robots that are alike."""
        links = self._links_of(role)
        scopes = [scope for link in links for scope in link.scopes]
        scopes += [r.scope for link in links for level in link.limits for r in level if r.scope]
        words = tuple([self.named(scope, robot) for scope in scopes])
        key = (role, ends, self._kinds[robot], words)
        row = self._rows.get(key)
        if row is None:
            edition = _Edition(priority_of(self.rulebook.roles, role), ends)
            row = self._rows[key] = self._row(links, (), robot, edition)
        return row

    def _links_of(self, role: str) -> tuple[_Link, ...]:
        links = self._links.get(role)
        if links is None:
            links = self._links[role] = tuple(
                _Link(
                    chain.via, _read_scopes(chain.last.scopes), limits, chain.assurance, chain.rates
                )
                for chain in chains(self.rulebook.roles, role)
                # What cannot be read takes the right away rather than set it free.
                if (limits := _read_limits(chain.limits)) is not None
                and all(rated in self.rates for rated in chain.rates)
            )
        return links

    def _row(
        self,
        links: tuple[_Link, ...],
        limits: tuple[tuple[LimitRule, ...], ...],
        robot: RobotId,
        edition: _Edition,
    ) -> dict[str, Right]:
        """Return one robot's share of a table."""
        ways: dict[str, list[RightReason]] = {}
        for link in links:
            for scope in link.scopes:
                for word in sorted(self.named(scope, robot)):
                    fitted = self._fitted((*link.limits, *limits), robot, word)
                    if fitted is not None:
                        way = RightReason(
                            link.via,
                            f"{scope.robot}:{scope.skill}",
                            fitted,
                            edition.priority,
                            link.assurance,
                            link.rates,
                        )
                        _add(ways.setdefault(word, []), way)
        care = self.care.get(robot, {})
        return {
            word: Right(not edition.ends and word not in care and _free(found), tuple(found))
            for word, found in ways.items()
        }

    def _fitted(
        self, limits: tuple[tuple[LimitRule, ...], ...], robot: RobotId, word: str
    ) -> tuple[Limit, ...] | None:
        """Return what limits mean for a skill; None if nobody may use it under them."""
        skill = self.fleet.skills.get(robot, {}).get(word)
        if skill is None or not limits:
            return ()
        try:
            fitted = [
                limit
                for level in limits
                for limit in fit_limits(
                    self._touching(level, robot, word), word, skill, self.convert
                )
            ]
        except LimitMismatch:
            return None
        return tuple(dict.fromkeys(fitted))

    def _touching(
        self, rules: Iterable[LimitRule], robot: RobotId, word: str
    ) -> Iterator[LimitRule]:
        """Return the limits that speak of a skill."""
        for rule in rules:
            if rule.scope is None or word in self.named(rule.scope, robot):
                yield rule


class _Edition(msgspec.Struct, frozen=True):
    priority: int
    ends: bool


_MOST_TOGETHER = 256
_MOST_NAMED = 65_536  # scopes of keys come and go; this is a memory, not a record


def _bare(scopes: tuple[str, ...]) -> tuple[_Link, ...]:
    read = _read_scopes(scopes)
    return (_Link((), read, (), Assurance.PROVIDER_READABLE),) if read else ()


def _read_scopes(texts: Iterable[str]) -> tuple[Scope, ...]:
    """Read scopes; what is none gives nothing."""
    return tuple(scope for text in texts if (scope := _read_scope(text)) is not None)


def _read_scope(text: str) -> Scope | None:
    try:
        return Scope.parse(text)
    except ValueError:
        return None


def _read_limits(
    levels: Iterable[tuple[str, ...]],
) -> tuple[tuple[LimitRule, ...], ...] | None:
    try:
        return tuple(tuple(map(parse_limit, texts)) for texts in levels)
    except ValueError:
        return None


def _read_rates(rulebook: RoleRules) -> dict[str, RateLimit]:
    found: dict[str, RateLimit] = {}
    for name, role in rulebook.roles.items():
        if role.rate:
            with suppress(ValueError):
                found[name] = parse_rate(role.rate)
    return found


def _add(ways: list[RightReason], way: RightReason) -> None:
    """Keep a way if it adds something, and drop what it makes needless."""
    if any(kept.serves(way) for kept in ways):
        return
    ways[:] = [kept for kept in ways if not way.serves(kept)]
    ways.append(way)


def _free(ways: list[RightReason]) -> bool:
    return any(not way.limits and way.assurance is min(Assurance) for way in ways)


def _spread_care(
    said: Iterable[SkillPrecondition], fleet: Fleet
) -> dict[RobotId, dict[str, Precondition]]:
    table: dict[RobotId, dict[str, Precondition]] = {}
    for care in said:
        least = ASSURANCES.get(care.assurance, max(Assurance)) if care.assurance else min(Assurance)
        for scope in _read_scopes(care.scopes):
            for robot in fleet.robots(scope.robot):
                row = table.setdefault(robot, {})
                for word in words_meant(scope, robot, fleet):
                    before = row.get(word, NO_CAUTION)
                    needs = tuple(n for n in StepRequired if n in (*before.needs, *care.needs))
                    row[word] = Precondition(needs, max(before.assurance, least))
    return table
