"""Roles, grants and care as they are said: in the configuration, by an admin, in the record.

All of them are texts and numbers, so that the same value stands in a file, in a fact and in an
answer. `rosic.core.policy.permissions` draws up from them what is asked for each order.
"""

from __future__ import annotations

import enum
from collections.abc import Mapping
from typing import TYPE_CHECKING, TypeAlias

import msgspec

if TYPE_CHECKING:
    from collections.abc import Iterator

DEEPEST = 8  # roles that include roles that include roles: nobody understands more


class Assurance(enum.IntEnum):
    """Who else could read or write in a conversation; a greater one is worth every smaller one.

    ``PROVIDER_READABLE``: whoever runs the platform can read along and could write in a person's
    name. ``E2EE_UNVERIFIED``: it is encrypted from end to end, but whose the other end is nobody
    has seen: the platform could have put itself there. ``E2EE_VERIFIED``: only the two ends can,
    and their keys were compared; the platform sees nothing. ``LOCAL``: no network lies between;
    whoever sits there has the machine itself in their hands, and no cipher would keep them from
    anything.
    """

    PROVIDER_READABLE = 0
    E2EE_UNVERIFIED = 1
    E2EE_VERIFIED = 2
    LOCAL = 3

    @property
    def said(self) -> str:
        """As it is written in a file."""
        return self.name.lower().replace("_", "-")


ASSURANCES: dict[str, Assurance] = {level.said: level for level in Assurance}


class StepRequired(enum.Enum):
    """What must come before a permitted order is carried out."""

    __hash__ = object.__hash__  # Enum hashes the name, in Python, every time

    CONFIRMATION = "confirmation"
    STEP_UP = "step-up"
    SECOND_PERSON = "second person"


class Role(
    msgspec.Struct, frozen=True, kw_only=True, omit_defaults=True, forbid_unknown_fields=True
):
    """A name for rights.

    Attributes:
        scopes: ``robot:skill``; a robot may be a pattern or the plain name of a group. ``*`` never
            stands for ``grant``, the right to give rights.
        includes: Other roles; everything they give, under the limits of this one as well.
        limits: Hold for everything the role gives, also through roles it includes.
        assurance: The least a conversation must be worth; empty: any.
        priority: Who may take a robot over from whom; None: the highest of the included roles.
        rate: How much everybody together may do under it, also under roles that include it:
            ``30/min burst 5``; empty: any.
    """

    scopes: tuple[str, ...] = ()
    includes: tuple[str, ...] = ()
    limits: tuple[str, ...] = ()
    assurance: str = ""
    priority: int | None = None
    rate: str = ""


class Grant(
    msgspec.Struct, frozen=True, kw_only=True, omit_defaults=True, forbid_unknown_fields=True
):
    """One right that a person was given: a role, or bare scopes. Ids only; it may be recorded.

    Attributes:
        id: Of the fact that holds it; empty for what the configuration says.
        role: Name of a role; one that is unknown gives nothing.
        scopes: Given besides, or instead.
        robots: Only on these robots, patterns or groups; empty: wherever the role reaches.
        limits: Besides the role's.
        expires_ns: Wall clock; the right ends just before. None: until it is taken away.
    """

    id: str = ""
    role: str = ""
    scopes: tuple[str, ...] = ()
    robots: tuple[str, ...] = ()
    limits: tuple[str, ...] = ()
    expires_ns: int | None = None


class SkillPrecondition(
    msgspec.Struct, frozen=True, kw_only=True, omit_defaults=True, forbid_unknown_fields=True
):
    """Skills that want more than the right to them, whoever asks.

    Attributes:
        scopes: Skills. A wildcard stands for the robot's own skills. ``resume`` may be named where
            nothing but an assurance is wanted; other rights are never asked about.
        confirm: A button has to be tapped first.
        step_up: A second factor was shown lately.
        second_person: Somebody else who may do the same has agreed.
        assurance: The least a conversation must be worth; empty: any.
    """

    scopes: tuple[str, ...]
    confirm: bool = False
    step_up: bool = False
    second_person: bool = False
    assurance: str = ""

    @property
    def needs(self) -> tuple[StepRequired, ...]:
        """What it asks for, in the order in which a person meets it."""
        said = zip(StepRequired, (self.confirm, self.step_up, self.second_person), strict=True)
        return tuple(need for need, wanted in said if wanted)


# A viewer reads; an operator moves, and may undo a stop; a senior may take over where that is
# allowed at all; an admin does everything and gives rights.
DEFAULT_ROLES: dict[str, Role] = {
    "viewer": Role(scopes=("*:read",)),
    "operator": Role(scopes=("*:*",), priority=10),
    "senior": Role(includes=("operator",), priority=20),
    "admin": Role(scopes=("*:*", "fleet:*"), includes=("senior",), priority=30),
}


class RoleRules(msgspec.Struct, frozen=True, kw_only=True):
    """What is the rule here, whoever the people are.

    Attributes:
        roles: `DEFAULT_ROLES`, and those of the place beside or instead of them.
        preempt: Robots, patterns or groups on which a higher priority may take over.
    """

    roles: Mapping[str, Role]
    care: tuple[SkillPrecondition, ...] = ()
    preempt: tuple[str, ...] = ()


class RoleChain(msgspec.Struct, frozen=True):
    """One way from a granted role down to a role it includes.

    Attributes:
        via: Names, the granted role first.
        last: The role at the end; its scopes count.
        limits: Texts of every role on the way, each role's own together.
        assurance: The highest that any role on the way asks for.
        rates: Roles on the way that have a rate.
    """

    via: tuple[str, ...]
    last: Role
    limits: tuple[tuple[str, ...], ...]
    assurance: Assurance
    rates: tuple[str, ...] = ()


_Step: TypeAlias = tuple[tuple[str, ...], tuple[tuple[str, ...], ...], Assurance]


def chains(roles: Mapping[str, Role], name: str) -> Iterator[RoleChain]:
    """Walk down from a role. What is unknown, in a loop or too deep gives nothing.

    Two ways to the same role that ask for the same are walked once.
    """
    met: set[tuple[str, frozenset[tuple[str, ...]], Assurance, tuple[str, ...]]] = set()
    walk: list[_Step] = [((name,), (), Assurance.PROVIDER_READABLE)] if name in roles else []
    while walk:
        via, limits, least = walk.pop()
        role = roles[via[-1]]
        limits = (*limits, role.limits) if role.limits else limits
        # An assurance that cannot be read asks for the highest: nothing is given by mistake.
        asked = ASSURANCES.get(role.assurance, Assurance.LOCAL) if role.assurance else least
        least = max(least, asked)
        rates = tuple([each for each in via if roles[each].rate])
        mark = (via[-1], frozenset(limits), least, rates)
        if mark in met:
            continue
        met.add(mark)
        yield RoleChain(via, role, limits, least, rates)
        if len(via) < DEEPEST:
            walk += [
                ((*via, inner), limits, least)
                for inner in reversed(role.includes)
                if inner in roles and inner not in via
            ]


def priority_of(roles: Mapping[str, Role], name: str) -> int:
    """Return a role's priority: its own, or the highest of those it includes, or 0."""
    met: set[str] = set()
    highest = 0
    walk = [name]
    while walk:
        here = walk.pop()
        role = roles.get(here)
        if role is None or here in met:
            continue
        met.add(here)
        if role.priority is None:
            walk += role.includes
        else:
            highest = max(highest, role.priority)
    return highest


def loops(roles: Mapping[str, Role]) -> Iterator[tuple[str, ...]]:
    """Find roles that include themselves: each loop once, its first name again at the end."""
    done: set[str] = set()
    for name in roles:
        yield from _loops(roles, name, done)


def _loops(roles: Mapping[str, Role], name: str, done: set[str]) -> Iterator[tuple[str, ...]]:
    """Walk from one role; ``done`` holds what led to no new loop."""
    path: list[str] = []
    walk: list[tuple[str, int]] = [(name, 0)]
    while walk:
        here, depth = walk.pop()
        del path[depth:]
        if here in path:
            yield (*path[path.index(here) :], here)
            continue
        if here in done or here not in roles:
            continue
        done.add(here)
        path.append(here)
        walk += [(inner, depth + 1) for inner in reversed(roles[here].includes)]
