"""Scopes, roles and the policy."""

from __future__ import annotations

import pytest

from rosic.core.authority import READ, RESUME, Policy, Role, Scope

SKILLS = {"kuka1": ("grasp", "home"), "omni": ("move",), "cf1": ("takeoff",), "cf2": ("takeoff",)}


def policy(scopes: dict[str, tuple[str, ...]], people: dict[str, tuple[str, ...]]) -> Policy:
    roles = [Role(name, tuple(map(Scope.parse, texts))) for name, texts in scopes.items()]
    return Policy(epoch=1, roles=roles, skills=SKILLS, people=people)


@pytest.mark.parametrize(
    ("scope", "robot", "skill", "allowed"),
    [
        ("kuka1:grasp", "kuka1", "grasp", True),
        ("kuka1:grasp", "kuka1", "home", False),
        ("kuka1:grasp", "omni", "move", False),
        ("cf*:*", "cf2", "takeoff", True),
        ("cf*:*", "kuka1", "home", False),
        ("cf?:takeoff", "cf1", "takeoff", True),
        ("*:read", "omni", READ, True),
        ("*:read", "omni", "move", False),
        ("*:read", "omni", RESUME, False),
        ("omni:*", "omni", RESUME, True),
    ],
)
def test_a_scope_gives_what_it_says(scope: str, robot: str, skill: str, *, allowed: bool) -> None:
    given = policy({"r": (scope,)}, {"p": ("r",)})
    assert given.allows("p", robot, skill) is allowed


def test_whoever_moves_a_robot_sees_it() -> None:
    given = policy({"r": ("kuka1:grasp",)}, {"p": ("r",)})
    assert given.visible("p") == {"kuka1"}
    assert given.allows("p", "kuka1", READ)


def test_roles_add_up_and_unknown_ones_give_nothing() -> None:
    given = policy({"a": ("omni:move",), "b": ("kuka1:*",)}, {"p": ("a", "b", "gone")})
    assert given.visible("p") == {"omni", "kuka1"}
    assert given.allows("p", "omni", "move")
    assert not policy({}, {"p": ("gone",)}).visible("p")


def test_a_stranger_may_nothing() -> None:
    given = policy({"r": ("*:*",)}, {})
    assert not given.allows("p", "omni", "move")
    assert given.visible("p") == frozenset()


def test_the_narrowest_role_is_named_first() -> None:
    given = policy({"all": ("*:*",), "narrow": ("kuka1:grasp",)}, {})
    assert given.roles_giving("kuka1", "grasp") == ("narrow", "all")


@pytest.mark.parametrize(
    "text", ["", "omni", "omni:", ":move", "a:b:c", "Omni:move", "omni move:x"]
)
def test_what_is_no_scope_is_refused(text: str) -> None:
    with pytest.raises(ValueError, match="is not a scope"):
        Scope.parse(text)
