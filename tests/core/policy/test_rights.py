"""Snapshots of rights: what roles give, what is shared, what changes."""

from __future__ import annotations

import random
from typing import TYPE_CHECKING

import pytest

from rosic.core.policy.evaluate import decide
from rosic.core.policy.permissions import Permissions
from rosic.core.policy.query import Allow
from rosic.core.policy.roles import (
    DEFAULT_ROLES,
    Grant,
    Role,
    RoleRules,
    SkillPrecondition,
    chains,
    loops,
    priority_of,
)
from rosic.core.policy.scope import FLEET, GRANT, Fleet, Scope
from rosic.core.robot.skill import Skill
from rosic.robots.ros2.profile import Ros2Skill, TopicBinding
from tests.core.policy import product, worlds
from tests.core.policy.product import CONVERT, a_skill
from tests.core.policy.worlds import NOW, SKILLS

if TYPE_CHECKING:
    from collections.abc import Iterator

FLEET_HERE = Fleet(
    {
        "kuka1": {name: a_skill(name, SKILLS[name]) for name in ("grasp", "home", "look")},
        "omni": {name: a_skill(name, SKILLS[name]) for name in ("move", "look")},
    },
    {"arms": ("kuka1",)},
)


def rights(
    people: dict[str, tuple[Grant, ...]],
    roles: dict[str, Role] | None = None,
    care: tuple[SkillPrecondition, ...] = (),
) -> Permissions:
    book = RoleRules(roles={**DEFAULT_ROLES, **(roles or {})}, care=care)
    return Permissions.draw_up(1, book, FLEET_HERE, people, CONVERT)


@pytest.mark.parametrize(
    ("role", "robot", "skill", "given"),
    [
        ("viewer", "kuka1", "read", True),
        ("viewer", "kuka1", "look", True),
        ("viewer", "kuka1", "grasp", False),
        ("viewer", "kuka1", "resume", False),
        ("operator", "kuka1", "grasp", True),
        ("operator", "kuka1", "resume", True),
        ("operator", "kuka1", GRANT, False),
        ("operator", FLEET, "invite", False),
        ("senior", "omni", "move", True),
        ("admin", "omni", GRANT, True),
        ("admin", FLEET, "invite", True),
        ("admin", FLEET, GRANT, True),
        ("nobody", "omni", "read", False),
    ],
)
def test_what_the_default_roles_give(role: str, robot: str, skill: str, *, given: bool) -> None:
    held = rights({"p": (Grant(role=role),)})
    assert (held.may("p", robot, skill) is not None) is given


def test_priorities_rise_from_viewer_to_admin() -> None:
    said = [priority_of(DEFAULT_ROLES, role) for role in ("viewer", "operator", "senior", "admin")]
    assert said == sorted(set(said))


def test_a_right_without_anything_to_ask_is_plain_and_any_other_is_not() -> None:
    careful = SkillPrecondition(scopes=("kuka1:home",), confirm=True)
    junior = Role(includes=("operator",), limits=("force <= 20 N",))
    quiet = Role(includes=("operator",), assurance="local")
    held = rights(
        {
            "plain": (Grant(role="operator"),),
            "timed": (Grant(role="operator", expires_ns=NOW),),
            "junior": (Grant(role="junior"),),
            "quiet": (Grant(role="quiet"),),
            "both": (Grant(role="junior"), Grant(role="operator")),
        },
        {"junior": junior, "quiet": quiet},
        (careful,),
    )
    plain = {who: getattr(held.may(who, "kuka1", "grasp"), "plain", None) for who in held.people()}
    assert plain == {"plain": True, "timed": False, "junior": False, "quiet": False, "both": True}
    assert not getattr(held.may("plain", "kuka1", "home"), "plain", None), "it must be confirmed"
    assert getattr(held.may("junior", "kuka1", "look"), "plain", None), "it has no force"


def test_what_is_plain_is_allowed_and_what_is_not_there_is_not() -> None:
    lot = random.Random(5)  # noqa: S311
    plain = absent = 0
    for _ in range(150):
        world = worlds.a_world(lot)
        held = product.rights_of(world)
        for _ in range(30):
            case = worlds.a_case(lot, world) | {
                "locked": [],
                "stopped": False,
                "holder": None,
                "slots": "none",
            }
            case["key"] = {"owner": case["who"], "revoked": False, "ends": None, "scopes": []}
            right = held.may(case["who"], case["robot"], case["skill"])
            decision = decide(product.state_of(held, case), product.ask_of(case))
            if right is not None and right.plain:
                plain += 1
                assert isinstance(decision, Allow)
                assert not decision.needs
            elif right is None and case["skill"] != "stop":
                absent += 1
                assert not isinstance(decision, Allow)
    assert plain > 200
    assert absent > 200


def test_a_right_ends_just_at_its_time() -> None:
    held = rights({"p": (Grant(role="viewer", expires_ns=NOW, robots=("arms",)),)})
    assert held.visible("p", NOW - 1) == {"kuka1"}
    assert held.visible("p", NOW) == frozenset()
    assert held.sees("p", "kuka1", NOW - 1)
    assert not held.sees("p", "kuka1", NOW)
    assert held.ended_ns("p", NOW) == NOW
    assert held.ended_ns("p", NOW - 1) is None


def test_a_change_is_whole_and_leaves_the_old_snapshot_alone() -> None:
    old = rights({"p": (Grant(role="viewer"),), "q": (Grant(role="admin"),)})
    new = old.with_grants(2, "p", (Grant(role="admin", robots=("omni",)),))
    gone = new.with_grants(3, "q", ())
    assert [r.epoch for r in (old, new, gone)] == [1, 2, 3]
    assert old.may("p", "omni", "move") is None
    assert new.may("p", "omni", "move") is not None
    assert new.may("p", "kuka1", "read") is None
    assert old.givers("omni", NOW) == ("q",)
    assert new.givers("omni", NOW) == ("q", "p")
    assert gone.givers("omni", NOW) == ("p",)
    assert gone.people() == {"p": (Grant(role="admin", robots=("omni",)),)}
    assert new.grants("q") == old.grants("q") == (Grant(role="admin"),)


def test_people_with_the_same_grants_share_a_table_whenever_theirs_end() -> None:
    held = rights(
        {f"p{n}": (Grant(id=f"g{n}", role="operator", expires_ns=NOW + n),) for n in range(50)}
    )
    rows = {id(held._people[f"p{n}"][0].rows) for n in range(50)}
    assert len(rows) == 1
    kept = held._tables
    assert len(kept._shared) == 1
    for n in range(50):
        held = held.with_grants(n + 2, f"p{n}", ())
    assert len(kept._shared) == 0, "nobody holds it any more"


def test_what_cannot_be_understood_gives_nothing() -> None:
    odd = {
        "misspelt": Role(scopes=("no scope",)),
        "unlimited": Role(scopes=("*:*",), limits=("fast",)),
        "unfit": Role(scopes=("*:*",), limits=("force <= 3 m",)),
        "secret": Role(scopes=("*:*",), assurance="very"),
    }
    held = rights({name: (Grant(role=name),) for name in odd}, odd)
    assert held.may("misspelt", "kuka1", "read") is None
    assert held.may("unlimited", "kuka1", "read") is None
    assert held.may("unfit", "kuka1", "grasp") is None
    assert held.may("unfit", "kuka1", "home") is not None
    secret = held.may("secret", "kuka1", "home")
    assert secret is not None
    assert not secret.plain


def test_loops_are_found_and_named_once() -> None:
    roles = {
        "a": Role(includes=("b", "d")),
        "b": Role(includes=("c",)),
        "c": Role(includes=("a",), scopes=("*:read",)),
        "d": Role(includes=("d",)),
        "e": Role(includes=("a",)),
    }
    assert set(loops(roles)) == {("a", "b", "c", "a"), ("d", "d")}
    assert {chain.via for chain in chains(roles, "a")} == {
        ("a",),
        ("a", "b"),
        ("a", "b", "c"),
        ("a", "d"),
    }


def test_many_ways_to_one_role_are_walked_once() -> None:
    layers = {
        f"r{n}{side}": Role(includes=(f"r{n + 1}a", f"r{n + 1}b"), scopes=("*:read",))
        for n in range(7)
        for side in "ab"
    }
    assert len(list(chains(layers, "r0a"))) == 13


def test_a_key_reaches_only_what_its_scopes_say() -> None:
    held = rights({})
    scopes = tuple(map(Scope.parse, ("arms:grasp", "fleet:invite")))
    assert held.covers((), "omni", "move")
    assert held.covers(scopes, "kuka1", "grasp")
    assert held.covers(scopes, "kuka1", "read")
    assert held.covers(scopes, FLEET, "invite")
    assert not held.covers(scopes, "kuka1", "home")
    assert not held.covers(scopes, "omni", "read")


PATTERNS = ("kuka1", "omni", "kuka*", "*", "k?ka1", "[ko]*", "arms", "fleet", "nobody", "")


@pytest.mark.parametrize("said", PATTERNS)
def test_one_robot_is_meant_by_a_scope_if_it_is_among_all_that_are(said: str) -> None:
    for robot in ("kuka1", "omni", "other", FLEET):
        assert FLEET_HERE.means(said, robot) == (robot in FLEET_HERE.robots(said))


class Walked(dict[str, dict[str, Skill]]):
    """Counts how often somebody goes through all robots."""

    times = 0

    def __iter__(self) -> Iterator[str]:
        self.times += 1
        return super().__iter__()


def bound(name: str, topic: str) -> Skill:
    plain = a_skill(name, SKILLS[name])
    kept = {field: getattr(plain, field) for field in Skill.__struct_fields__}
    return Ros2Skill(**kept, topic=TopicBinding(name=topic, type="std_msgs/msg/Empty"))


def test_rights_on_many_robots_are_drawn_up_without_comparing_each_with_each() -> None:
    skills = Walked({f"r{n}": {"move": bound("move", f"/r{n}/move")} for n in range(300)})
    book = RoleRules(roles=DEFAULT_ROLES)
    held = Permissions.draw_up(1, book, Fleet(skills), {"p": (Grant(role="operator"),)}, CONVERT)
    assert skills.times < 20
    assert held.visible("p", NOW) == set(skills)
    # What differs only in how it is carried out is the same right.
    assert held.may("p", "r7", "move") is held.may("p", "r8", "move") is not None


def test_what_somebody_sees_by_several_grants_is_joined_once() -> None:
    held = rights(
        {
            "p": (
                Grant(role="viewer", robots=("omni",)),
                Grant(role="operator", id="g1", robots=("kuka1",), expires_ns=NOW + 10),
            ),
            "q": (
                Grant(role="viewer", robots=("omni",)),
                Grant(role="admin", id="g2", robots=("omni",)),
            ),
        }
    )
    assert held.visible("p", NOW) == {"omni", "kuka1"}
    assert held.visible("p", NOW) is held.visible("p", NOW)
    assert held.visible("q", NOW) == {"omni"}, "not what somebody else sees"
    assert held.visible("p", NOW + 10) == {"omni"}, "what has ended is not remembered"
    held = held.with_grants(2, "p", (Grant(role="viewer", robots=("kuka1",)),))
    assert held.visible("p", NOW) == {"kuka1"}
