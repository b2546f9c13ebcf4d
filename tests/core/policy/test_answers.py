"""What a snapshot of rights answers at the moment in which a right ends, and who can help."""

from __future__ import annotations

import pytest

from rosic.core.policy import compiled
from rosic.core.policy.evaluate import decide
from rosic.core.policy.permissions import MOST_NAMED, Permissions
from rosic.core.policy.query import Allow, Deny, PolicyCode, PolicyKey, PolicyState, Query
from rosic.core.policy.roles import DEFAULT_ROLES, Assurance, Grant, Role, RoleRules
from rosic.core.policy.scope import FLEET, GRANT, Scope
from tests.core.policy.product import CONVERT
from tests.core.policy.test_rights import FLEET_HERE, rights
from tests.core.policy.worlds import NOW

ENDS_NOW = Grant(role="operator", expires_ns=NOW)
ENDS_NEXT = Grant(role="operator", expires_ns=NOW + 1)
FOR_GOOD = Grant(role="operator")
HIGH = Role(scopes=("kuka1:*",), priority=50)
LOW = Role(scopes=("kuka1:*",), priority=7)
RATED = Role(scopes=("*:*",), rate="3/min")
TWICE = Role(includes=("rated",), rate="5/min")


def free_state(snapshot: Permissions, key: PolicyKey) -> PolicyState:
    """Nobody is locked, nothing is stopped or taken, and there are no slots."""
    return PolicyState(
        rights=snapshot,
        key=key,
        now_ns=NOW,
        locked=frozenset(),
        stopped=False,
        holder=None,
        slots="none",
        slot=None,
    )


@pytest.mark.parametrize(("grant", "held"), [(ENDS_NOW, False), (ENDS_NEXT, True)])
def test_every_answer_knows_the_moment_in_which_a_right_ends(grant: Grant, *, held: bool) -> None:
    snapshot = rights({"p": (grant,)})
    assert snapshot.holds("p", "kuka1", "grasp", NOW) is held
    assert snapshot.sees("p", "kuka1", NOW) is held
    assert ("kuka1" in snapshot.visible("p", NOW)) is held
    assert (snapshot.priority("p", "kuka1", NOW) > 0) is held
    assert snapshot.ended_ns("p", NOW) == (None if held else NOW)


@pytest.mark.parametrize(("grant", "held"), [(ENDS_NOW, False), (ENDS_NEXT, True)])
def test_of_several_rights_each_counts_until_its_own_end(grant: Grant, *, held: bool) -> None:
    viewer = Grant(role="viewer", robots=("omni",))
    snapshot = rights({"p": (viewer, grant)})
    assert snapshot.visible("p", NOW) >= {"omni"}
    assert ("kuka1" in snapshot.visible("p", NOW)) is held
    assert snapshot.sees("p", "kuka1", NOW) is held
    assert snapshot.ended_ns("p", NOW) is None


def test_the_priority_on_a_robot_is_the_highest_of_the_rights_on_that_robot() -> None:
    roles = {"high": HIGH, "low": LOW}
    both = (Grant(role="low"), Grant(role="high"), Grant(role="viewer", robots=("omni",)))
    snapshot = rights({"p": both, "late": (Grant(role="high", expires_ns=NOW), both[0])}, roles)
    assert snapshot.priority("p", "kuka1", NOW) == 50
    assert snapshot.priority("late", "kuka1", NOW) == 7, "the higher right has ended"
    assert snapshot.priority("p", "omni", NOW) == snapshot.role_priority("viewer")
    assert snapshot.priority("p", "unknown", NOW) == 0
    assert snapshot.priority("nobody", "kuka1", NOW) == 0
    assert snapshot.role_priority("unknown") == 0


def test_when_somebody_may_move_a_robot_no_more_is_when_the_last_such_right_ends() -> None:
    looks = Grant(role="viewer", expires_ns=NOW + 100)
    snapshot = rights(
        {"both": (ENDS_NEXT, looks), "good": (ENDS_NEXT, FOR_GOOD), "looks": (looks,)}
    )
    assert snapshot.moves_until_ns("both", "kuka1") == NOW + 1, "looking moves nothing"
    assert snapshot.moves_until_ns("good", "kuka1") is None
    assert snapshot.moves_until_ns("looks", "kuka1") == 0
    assert snapshot.moves_until_ns("nobody", "kuka1") == 0


def test_when_the_last_right_ended_is_said_of_whoever_had_one() -> None:
    earlier = Grant(role="viewer", expires_ns=NOW - 5)
    snapshot = rights({"p": (earlier, ENDS_NOW), "q": (ENDS_NOW, earlier)})
    assert snapshot.ended_ns("p", NOW) == snapshot.ended_ns("q", NOW) == NOW
    assert snapshot.ended_ns("p", NOW - 1) is None
    assert snapshot.ended_ns("nobody", NOW) is None


def test_whoever_can_give_rights_is_named_up_to_three_and_never_oneself() -> None:
    admins = {f"a{number}": (Grant(role="admin"),) for number in range(5)}
    late = {"late": (Grant(role="admin", expires_ns=NOW),)}
    snapshot = rights({**late, **admins, "p": (FOR_GOOD,)})
    assert snapshot.givers("kuka1", NOW) == ("a0", "a1", "a2")
    assert len(snapshot.givers(FLEET, NOW)) == MOST_NAMED
    assert snapshot.givers("kuka1", NOW, besides="a1") == ("a0", "a2", "a3")
    assert snapshot.givers("kuka1", NOW - 1)[0] == "late"
    assert snapshot.givers("unknown", NOW) == ()


def test_whoever_has_every_right_sees_the_robots_and_nothing_else() -> None:
    assert rights({"a": (Grant(role="admin"),)}).visible("a", NOW) == {"kuka1", "omni"}


def test_a_grant_whose_limit_cannot_be_read_gives_nothing() -> None:
    snapshot = rights({"p": (Grant(role="operator", limits=("fast",)),)})
    assert snapshot.visible("p", NOW) == frozenset()
    assert not snapshot.holds("p", "kuka1", "home", NOW)


def test_who_can_give_rights_follows_every_change_of_grants() -> None:
    here = Grant(scopes=("kuka1:grant",))
    snapshot = rights({"a": (Grant(role="admin"),), "b": (here,)})
    taken = snapshot.with_grants(2, "b", ())
    assert taken.givers("kuka1", NOW) == ("a",)
    assert snapshot.givers("kuka1", NOW) == ("a", "b"), "the old snapshot is as it was"
    given = taken.with_grants(3, "c", (here,))
    assert given.givers("kuka1", NOW) == ("a", "c")
    again = given.with_grants(4, "c", (here, FOR_GOOD))
    assert again.givers("kuka1", NOW) == ("a", "c")
    assert again.with_grants(5, "a", ()).givers("kuka1", NOW) == ("c",)
    assert (given.epoch, given.policy) == (3, 3)
    assert not given.with_grants(4, "c", ()).people().get("c")


def test_who_gives_rights_stays_so_while_another_stops() -> None:
    here = Grant(scopes=("kuka1:grant",))
    snapshot = rights(dict.fromkeys("abc", (here,)))
    assert snapshot.with_grants(2, "b", ()).givers("kuka1", NOW) == ("a", "c")


def test_whoever_can_resume_is_named_up_to_three_those_who_give_rights_first() -> None:
    people = {f"o{number}": (FOR_GOOD,) for number in range(4)}
    snapshot = rights({**people, "late": (ENDS_NOW,), "a": (Grant(role="admin"),)})
    assert snapshot.resumers("kuka1", NOW) == ("a", "o0", "o1"), "each once"
    assert snapshot.resumers("kuka1", NOW, besides="a") == ("o0", "o1", "o2")
    assert snapshot.resumers("unknown", NOW) == ()
    assert rights({"late": (ENDS_NOW,)}).resumers("kuka1", NOW) == ()


def test_the_limits_of_a_right_are_those_of_each_way_to_it_that_has_not_ended() -> None:
    weak, strong = ("force <= 20 N",), ("force >= 1 N", "force <= 30 N")
    lasting = Grant(role="operator", limits=strong)
    some = {
        end: (Grant(role="operator", limits=weak, expires_ns=end), lasting)
        for end in (NOW, NOW + 1)
    }
    for end, held in ((NOW, (strong,)), (NOW + 1, (weak, strong))):
        said = rights({"p": some[end]}).limits("p", "kuka1", "grasp", NOW)
        assert [" and ".join(way) for way in said] == [" and ".join(way) for way in held]
    free = rights({"p": (*some[NOW], FOR_GOOD)})
    assert free.limits("p", "kuka1", "grasp", NOW) == (), "by one of the ways there is none"
    assert rights({"p": (ENDS_NOW,)}).limits("p", "kuka1", "grasp", NOW) == ()
    assert rights({}).limits("p", "kuka1", "grasp", NOW) == ()


def test_what_was_agreed_to_outlives_a_slot_and_no_change_of_rights() -> None:
    snapshot = rights({"p": (FOR_GOOD,)})
    later = snapshot.later()
    assert (later.epoch, later.policy) == (snapshot.epoch + 1, snapshot.policy)
    assert later.with_grants(9, "p", ()).policy == 9
    assert later.grants("p") == (FOR_GOOD,)


def test_an_order_counts_against_the_rates_of_the_way_with_the_fewest() -> None:
    roles = {"rated": RATED, "twice": TWICE}
    snapshot = rights(
        {
            "one": (Grant(role="rated"),),
            "two": (Grant(role="twice"),),
            "both": (Grant(role="twice"), Grant(role="rated")),
            "free": (Grant(role="rated"), FOR_GOOD),
            "late": (Grant(role="rated"), ENDS_NOW),
        },
        roles,
    )
    counted = {who: snapshot.rated(who, "kuka1", "grasp", NOW) for who in snapshot.people()}
    assert counted == {
        "one": ("rated",),
        "two": counted["two"],
        "both": ("rated",),
        "free": (),
        "late": ("rated",),
    }
    assert set(counted["two"]) == {"rated", "twice"}
    assert set(snapshot.rates) == {"rated", "twice"}


def test_mistakes_in_a_grant_and_in_rules_are_found() -> None:
    snapshot = rights({"p": (FOR_GOOD,)})
    assert snapshot.mistakes(FOR_GOOD) == []
    assert snapshot.mistakes(Grant(role="nobody knows it"))
    assert snapshot.rule_mistakes(snapshot.rulebook) == []
    loop = RoleRules(roles={**DEFAULT_ROLES, "a": Role(includes=("a",))})
    assert snapshot.rule_mistakes(loop)
    assert snapshot.given_by(snapshot.rulebook, "operator")["kuka1"] >= {"grasp", "home"}
    assert snapshot.fleet is FLEET_HERE
    assert snapshot.roles_giving("kuka1", "grasp")[0] == "operator"


def test_what_actuates_needs_the_robot_and_what_is_unknown_does_not() -> None:
    snapshot = rights({})
    assert snapshot.actuates("kuka1", "grasp")
    assert not snapshot.actuates("kuka1", "look")
    assert not snapshot.actuates("kuka1", "unknown")
    assert not snapshot.actuates("unknown", "grasp")
    assert not snapshot.may_take_over("kuka1")
    assert snapshot.covers((), "kuka1", "grasp")
    assert snapshot.covers((Scope("kuka1", "look"), Scope("kuka1", "grasp")), "kuka1", "grasp")
    assert not snapshot.covers((Scope("kuka1", "look"),), "kuka1", "grasp")


def test_the_plainest_of_several_rights_counts_wherever_it_stands() -> None:
    junior = Role(includes=("operator",), limits=("force <= 20 N",))
    both = (Grant(role="junior"), FOR_GOOD)
    snapshot = rights({"p": both, "q": both[::-1], "j": both[:1]}, {"junior": junior})
    found = {who: snapshot.may(who, "kuka1", "grasp") for who in "pqj"}
    assert {who: right is not None and right.plain for who, right in found.items()} == {
        "p": True,
        "q": True,
        "j": False,
    }


def test_drawn_up_anew_it_says_the_same() -> None:
    snapshot = rights({"a": (Grant(role="admin"),), "p": (FOR_GOOD, ENDS_NOW)})
    anew = Permissions.draw_up(7, snapshot.rulebook, snapshot.fleet, snapshot.people(), CONVERT)
    assert (anew.epoch, anew.policy) == (7, 7)
    assert anew.people() == snapshot.people()
    assert anew.givers("kuka1", NOW) == ("a",)
    assert anew.may("a", FLEET, GRANT)


SOFT = Role(includes=("operator",), limits=("force <= 20 N",))
NEAR = Role(includes=("operator",), assurance="local")


def ways(roles: dict[str, Role], includes: tuple[str, ...]) -> list[tuple[str, ...]]:
    """Return by which ways a role that includes others gives a skill."""
    snapshot = rights({"p": (Grant(role="all"),)}, {**roles, "all": Role(includes=includes)})
    right = snapshot.may("p", "kuka1", "grasp")
    return [] if right is None else [way.via for way in right.ways]


@pytest.mark.parametrize("includes", [("soft", "near"), ("near", "soft")])
def test_every_way_that_allows_something_of_its_own_is_kept(includes: tuple[str, ...]) -> None:
    """Whoever is at the robot may grasp hard, whoever writes from elsewhere only softly."""
    roles = {"soft": SOFT, "near": NEAR, "all": Role(includes=includes)}
    snapshot = rights({"p": (Grant(role="all"),)}, roles)
    key = PolicyKey(id="k", principal="p")
    found = {
        (force, channel): isinstance(
            decide(
                free_state(snapshot, key),
                Query(
                    principal="p",
                    key="k",
                    robot="kuka1",
                    skill="grasp",
                    channel=channel,
                    arguments={"force": force, "hand": "left"},
                ),
            ),
            Allow,
        )
        for force in (10.0, 30.0)
        for channel in (Assurance.PROVIDER_READABLE, Assurance.LOCAL)
    }
    assert found == {
        (10.0, Assurance.PROVIDER_READABLE): True,
        (10.0, Assurance.LOCAL): True,
        (30.0, Assurance.PROVIDER_READABLE): False,
        (30.0, Assurance.LOCAL): True,
    }


def test_a_way_that_allows_nothing_of_its_own_is_not_kept() -> None:
    roles = {"soft": SOFT, "near": NEAR, "twin": SOFT}
    assert ways(roles, ("soft", "twin")) == [("all", "soft", "operator")]
    assert ways(roles, ("soft", "near", "operator")) == [("all", "operator")]
    assert ways(roles, ("operator", "near", "soft")) == [("all", "operator")]


def test_what_is_worked_out_once_is_remembered_within_bounds() -> None:
    snapshot = rights({"p": (FOR_GOOD,), "q": (FOR_GOOD,)})
    kept = snapshot._tables
    assert snapshot._people["p"][0] is snapshot._people["q"][0]
    assert snapshot.roles_giving("omni", "move") is snapshot.roles_giving("omni", "move")
    assert snapshot.roles_giving("omni", "unknown") == ()
    scope = Scope("omni", "move")
    assert kept.named(scope, "omni") is kept.named(scope, "omni")
    others = (Scope(f"r{number}", "move") for number in range(compiled._MOST_NAMED))
    kept._named.update({(other, "omni"): frozenset() for other in others})
    full = len(kept._named)
    assert kept.named(Scope("*", "move"), "omni") == {"move", "read"}
    assert len(kept._named) == full


def test_of_rights_that_have_ended_the_last_is_named() -> None:
    ended = [Grant(id=f"g{ago}", role="operator", expires_ns=NOW - ago) for ago in (9, 3, 5)]
    snapshot = rights({"p": (*ended, Grant(role="viewer"))})
    key = PolicyKey(id="k", principal="p")
    no = decide(
        free_state(snapshot, key),
        Query(principal="p", key="k", robot="kuka1", skill="home"),
    )
    assert isinstance(no, Deny)
    assert (no.code, no.when_ns, no.grant) == (PolicyCode.RIGHT_ENDED, NOW - 3, ended[1])
