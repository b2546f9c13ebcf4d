"""Three people, two robots, three roles, four slots, and every order in which rights end."""

from __future__ import annotations

from itertools import permutations, product
from typing import TYPE_CHECKING, Any

import pytest

from tests.core.policy import oracle
from tests.core.policy import product as real
from tests.core.policy.worlds import NOW, SKILLS

if TYPE_CHECKING:
    from rosic.core.policy.permissions import Permissions

PEOPLE = ("ada", "ben", "cyd")
ROBOTS = ("kuka1", "omni")
ROLES: dict[str, Any] = {
    "viewer": {"scopes": [("*", "read")], "includes": [], "priority": None},
    "junior": {"scopes": [("kuka1", "*"), ("omni", "home")], "includes": ["viewer"], "priority": 1},
    "senior": {"scopes": [("*", "*")], "includes": ["junior"], "priority": 2},
}
ASKED = ("read", "home", "grasp")
# Nobody's; the first person's; the last one's; the first one's, but over.
SLOTS: tuple[Any, ...] = (
    None,
    {"owner": "ada", "start": NOW - 5, "end": NOW + 5},
    {"owner": "cyd", "start": NOW, "end": NOW + 1},
    {"owner": "ada", "start": NOW - 5, "end": NOW},
)
RULES = ("none", "respected", "required")
# What can end: each person's grant, and each person's key.
ENDS = tuple(product(("grant", "key"), PEOPLE))


def a_world(roles: tuple[str, ...], gone: frozenset[Any]) -> dict[str, Any]:
    grant: Any = {"scopes": [], "robots": [], "limits": [], "ends": None}
    return {
        "robots": {robot: {name: SKILLS[name] for name in ("home", "grasp")} for robot in ROBOTS},
        "groups": {},
        "verbs": ("grant",),
        "roles": {name: {"limits": [], "assurance": 0, **role} for name, role in ROLES.items()},
        "care": [],
        "preempt": ["kuka1"],
        "people": {
            who: [] if ("grant", who) in gone else [{**grant, "role": role}]
            for who, role in zip(PEOPLE, roles, strict=True)
        },
    }


def a_case(who: str, robot: str, skill: str, gone: frozenset[Any]) -> dict[str, Any]:
    key = {"owner": who, "revoked": ("key", who) in gone, "ends": None, "scopes": []}
    return {
        "who": who,
        "robot": robot,
        "skill": skill,
        "arguments": None,
        "channel": 0,
        "now": NOW,
        "key": key,
        "locked": [],
        "stopped": False,
        "holder": "ben",
        "until": None,
        "next": None,
        "stepped_up": False,
        "confirmed": False,
        "second": None,
    }


def seen(rights: Permissions) -> tuple[Any, ...]:
    """Return all that a snapshot says about everybody."""
    return tuple(
        (rights.may(who, robot, skill), rights.priority(who, robot, NOW), rights.grants(who))
        for who, robot, skill in product(PEOPLE, ROBOTS, ASKED)
    )


@pytest.mark.parametrize("roles", tuple(product(ROLES, repeat=3)), ids="-".join)
def test_rights_end_alike_in_every_order(roles: tuple[str, ...]) -> None:
    whole = real.rights_of(a_world(roles, frozenset()))
    after: dict[frozenset[Any], tuple[Any, ...]] = {}
    for order in permutations(ENDS):
        rights, gone = whole, frozenset[Any]()
        for kind, who in order:
            gone |= {(kind, who)}
            if kind == "grant":
                rights = rights.with_grants(len(gone), who, ())
            if gone not in after:
                agree(a_world(roles, gone), rights, gone)
                after[gone] = seen(rights)
            elif kind == "grant":
                assert seen(rights) == after[gone], f"{order} ends otherwise at {gone}"
    assert len(after) == 2 ** len(ENDS) - 1
    assert seen(whole) == seen(real.rights_of(a_world(roles, frozenset()))), "the old one changed"


def agree(world: dict[str, Any], rights: Permissions, gone: frozenset[Any]) -> None:
    for who, robot, skill, slot, rule in product(PEOPLE, ROBOTS, ASKED, SLOTS, RULES):
        case = {**a_case(who, robot, skill, gone), "slot": slot, "slots": rule}
        assert real.answer(rights, case) == oracle.judge(world, case), (case, world)
