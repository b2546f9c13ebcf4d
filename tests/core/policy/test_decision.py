"""What a refusal knows, what it keeps to itself, and in which order the rules are asked."""

from __future__ import annotations

import random
from typing import Any, TypeAlias

import msgspec
import pytest

from rosic.core.policy.evaluate import RULES, decide
from rosic.core.policy.explain import PolicyTexts, explain
from rosic.core.policy.permissions import Permissions
from rosic.core.policy.query import (
    Allow,
    Decision,
    Deny,
    PolicyCode,
    PolicyKey,
    PolicyRule,
    PolicyState,
    Query,
)
from rosic.core.policy.roles import (
    DEFAULT_ROLES,
    Assurance,
    Grant,
    Role,
    RoleRules,
    SkillPrecondition,
    StepRequired,
)
from rosic.core.policy.scope import Scope
from rosic.core.slot import BookedSlot
from tests.core.policy import product, worlds
from tests.core.policy.product import CONVERT
from tests.core.policy.test_rights import FLEET_HERE
from tests.core.policy.worlds import NOW

Data: TypeAlias = Any

ROLES = {
    **DEFAULT_ROLES,
    "junior": Role(includes=("operator",), limits=("force <= 20 N",), priority=5),
    "quiet": Role(scopes=("omni:*",), assurance="e2ee-verified"),
    "keeper": Role(scopes=("kuka1:grant",)),
}
PEOPLE = {
    "adm": (Grant(role="admin"),),
    "kim": (Grant(role="keeper"),),
    "jun": (Grant(role="junior", robots=("kuka1",)),),
    "opa": (Grant(role="operator"),),
    "sen": (Grant(role="senior"),),
    "qui": (Grant(role="quiet"), Grant(role="viewer")),
    "old": (Grant(role="operator", expires_ns=NOW - 9), Grant(role="viewer", expires_ns=NOW - 3)),
    "was": (Grant(role="operator", expires_ns=NOW - 9), Grant(role="viewer")),
}
CARE = (SkillPrecondition(scopes=("kuka1:grasp",), confirm=True, step_up=True, second_person=True),)
BOOK = RoleRules(roles=ROLES, care=CARE, preempt=("kuka1",))
RIGHTS = Permissions.draw_up(1, BOOK, FLEET_HERE, PEOPLE, CONVERT)


def asked(who: str, robot: str, skill: str, ask: Data = None, **state: Data) -> Decision:
    base: dict[str, Data] = {
        "rights": RIGHTS,
        "key": PolicyKey(id="k", principal=who),
        "now_ns": NOW,
        "locked": frozenset(),
        "stopped": False,
        "holder": None,
        "slots": "none",
        "slot": None,
    }
    question = Query(principal=who, key="k", robot=robot, skill=skill, **(ask or {}))
    return decide(PolicyState(**{**base, **state}), question)


def denied(who: str, robot: str, skill: str, ask: Data = None, **state: Data) -> Deny:
    decision = asked(who, robot, skill, ask, **state)
    assert isinstance(decision, Deny)
    return decision


def allowed(who: str, robot: str, skill: str, ask: Data = None, **state: Data) -> Allow:
    decision = asked(who, robot, skill, ask, **state)
    assert isinstance(decision, Allow)
    return decision


def a_slot(who: str, start: int = NOW - 1, end: int = NOW + 9) -> BookedSlot:
    return BookedSlot(
        id="s", principal=who, robot="kuka1", start_ns=start, end_ns=end, made_ns=0, by=who
    )


FORCE = {"arguments": {"force": 30.0, "hand": "left"}}
SOFT = {"arguments": {"force": 20.0, "hand": "left"}}


def test_a_refusal_says_who_can_help_and_what_it_takes() -> None:
    no = denied("qui", "kuka1", "grasp")
    assert (no.code, no.rule) == (PolicyCode.NOT_GRANTED, PolicyRule.RIGHT)
    assert no.who == ("adm", "kim")
    assert no.roles == ("junior", "operator", "senior", "admin")


def test_a_right_that_ended_says_when() -> None:
    no = denied("was", "kuka1", "home")
    assert (no.code, no.when_ns) == (PolicyCode.RIGHT_ENDED, NOW - 9)
    over = denied("old", "kuka1", "home")
    assert (over.code, over.when_ns) == (PolicyCode.NO_SUCH_ROBOT, NOW - 3)


def test_a_broken_limit_is_named_with_what_made_it() -> None:
    no = denied("jun", "kuka1", "grasp", FORCE)
    assert no.code is PolicyCode.OVER_LIMIT
    assert no.limit is not None
    assert no.limit.said == "force <= 20 N"
    assert no.way is not None
    assert no.way.via == ("junior", "operator")
    assert allowed("jun", "kuka1", "grasp", SOFT).priority == 5
    assert [limit.said for limit in allowed("jun", "kuka1", "grasp").unchecked] == ["force <= 20 N"]


@pytest.mark.parametrize("first", [0, 1])
def test_of_several_broken_limits_that_of_the_highest_priority_is_named(first: int) -> None:
    roles = {
        **ROLES,
        "soft": Role(includes=("operator",), limits=("force <= 10 N",), priority=1),
        "hard": Role(includes=("operator",), limits=("force <= 20 N",), priority=5),
    }
    grants = (Grant(role="soft"), Grant(role="hard"))
    people = {"two": (grants[first], grants[1 - first])}
    rights = Permissions.draw_up(1, RoleRules(roles=roles), FLEET_HERE, people, CONVERT)
    no = denied("two", "kuka1", "grasp", FORCE, rights=rights)
    assert no.code is PolicyCode.OVER_LIMIT
    assert no.limit is not None
    assert no.limit.said == "force <= 20 N"
    assert no.way is not None
    assert no.way.priority == 5


def test_a_weak_channel_says_what_it_would_take() -> None:
    no = denied("qui", "omni", "move")
    assert (no.code, no.channel) == (PolicyCode.CHANNEL_TOO_WEAK, Assurance.E2EE_VERIFIED)
    for channel in (Assurance.E2EE_VERIFIED, Assurance.LOCAL):
        allowed("qui", "omni", "move", {"channel": channel})


@pytest.mark.parametrize(
    ("who", "state", "code", "holder", "when_ns"),
    [
        ("opa", {"slots": "required", "next_free_ns": 7}, PolicyCode.SLOT_NEEDED, None, 7),
        (
            "opa",
            {"slots": "respected", "slot": a_slot("sen")},
            PolicyCode.SLOT_TAKEN,
            "sen",
            NOW + 9,
        ),
        (
            "opa",
            {"slots": "required", "slot": a_slot("adm"), "next_free_ns": 7},
            PolicyCode.SLOT_TAKEN,
            "adm",
            7,
        ),
        ("opa", {"holder": "sen", "holder_until_ns": 8}, PolicyCode.ROBOT_TAKEN, "sen", 8),
        ("opa", {"holder": "opa", "stopped": True}, PolicyCode.ROBOT_STOPPED, None, None),
    ],
)
def test_a_robot_that_is_not_free_says_whose_it_is_and_until_when(
    who: str, state: Data, code: PolicyCode, holder: str | None, when_ns: int | None
) -> None:
    no = denied(who, "kuka1", "home", **state)
    assert (no.code, no.holder, no.when_ns) == (code, holder, when_ns)


def test_a_senior_takes_over_where_the_rulebook_says_so() -> None:
    yes = allowed("sen", "kuka1", "home", slots="required", slot=a_slot("opa"), holder="jun")
    assert yes.preempts == ("opa", "jun")
    assert allowed("sen", "kuka1", "home", holder="sen").preempts == ()
    assert denied("sen", "kuka1", "home", holder="adm").code is PolicyCode.ROBOT_TAKEN
    assert denied("sen", "omni", "move", holder="opa").code is PolicyCode.ROBOT_TAKEN


def test_what_only_observes_needs_no_slot_no_lease_and_no_running_robot() -> None:
    busy = {"slots": "required", "holder": "sen", "stopped": True}
    for skill in ("read", "look", "resume"):
        assert allowed("opa", "kuka1", skill, **busy).preempts == ()


def test_needs_fall_away_one_by_one_and_nobody_agrees_with_themselves() -> None:
    def needs(**state: Data) -> tuple[StepRequired, ...]:
        return allowed("opa", "kuka1", "grasp", **state).needs

    every = (StepRequired.CONFIRMATION, StepRequired.STEP_UP, StepRequired.SECOND_PERSON)
    assert needs() == every
    assert needs(confirmed=True) == every[1:]
    assert needs(confirmed=True, stepped_up=True) == every[2:]
    both: dict[str, Data] = {"confirmed": True, "stepped_up": True}
    assert needs(**both, second="jun") == ()
    assert needs(**both, second="opa") == needs(**both, second="qui") == every[2:]
    assert needs(**both, second="jun", locked={"jun"}) == every[2:]
    assert allowed("opa", "kuka1", "grasp", **both, second="jun").care == every


def test_a_locked_person_may_only_stop() -> None:
    assert denied("opa", "kuka1", "read", locked={"opa"}).code is PolicyCode.LOCKED
    assert denied("opa", "kuka1", "read", locked={"opa"}).who == ("adm",)
    allowed("opa", "kuka1", "stop", locked={"opa"}, stopped=True, holder="sen", slots="required")
    assert denied("jun", "omni", "stop").code is PolicyCode.NO_SUCH_ROBOT


def test_the_key_is_asked_first_and_narrows() -> None:
    gone = PolicyKey(id="k", principal="opa", revoked=True, expires_ns=NOW)
    assert denied("opa", "kuka1", "stop", key=gone).code is PolicyCode.KEY_REVOKED
    assert denied("opa", "kuka1", "read", key=None).code is PolicyCode.KEY_UNKNOWN
    other = PolicyKey(id="other", principal="opa")
    assert denied("opa", "kuka1", "read", key=other).code is PolicyCode.KEY_UNKNOWN
    over = PolicyKey(id="k", principal="opa", expires_ns=NOW)
    assert denied("opa", "kuka1", "read", key=over).when_ns == NOW
    narrow = PolicyKey(id="k", principal="opa", scopes=(Scope("kuka1", "home"),))
    allowed("opa", "kuka1", "home", key=narrow)
    assert denied("opa", "kuka1", "grasp", key=narrow).code is PolicyCode.KEY_TOO_NARROW
    assert denied("opa", "omni", "move", key=narrow).code is PolicyCode.NO_SUCH_ROBOT


def test_what_may_not_be_seen_is_refused_as_what_does_not_exist() -> None:
    """In random worlds: whatever is asked about a hidden robot, and however it stands."""
    lot = random.Random(3)  # noqa: S311
    hidden = 0
    for _ in range(200):
        world = worlds.a_world(lot)
        rights = product.rights_of(world)
        for _ in range(20):
            case = worlds.a_case(lot, world)
            here = decide(product.state_of(rights, case), product.ask_of(case))
            if isinstance(here, Deny) and here.code is PolicyCode.NO_SUCH_ROBOT:
                hidden += 1
                nowhere = {**case, "robot": "never_was"}
                there = decide(product.state_of(rights, nowhere), product.ask_of(nowhere))
                assert there == msgspec.structs.replace(here, ask=product.ask_of(nowhere))
                lines = [line.replace(case["robot"], "never_was") for line in explain(here)]
                assert lines == list(explain(there))
    assert hidden > 500


def test_rules_are_reported_in_the_order_in_which_they_are_asked() -> None:
    assert allowed("opa", "kuka1", "home").rules == RULES == tuple(PolicyRule)
    assert allowed("opa", "kuka1", "read").rules == (*RULES[:7], PolicyRule.CARE)
    assert allowed("opa", "kuka1", "stop").rules == RULES[:3]
    assert denied("qui", "kuka1", "grasp").rules == RULES[:5]
    # Everything is wrong at once: the first rule speaks, and so on as each is put right.
    wrong: dict[str, Data] = {
        "key": None,
        "locked": {"jun"},
        "stopped": True,
        "slots": "required",
        "holder": "adm",
    }
    right: dict[str, Data] = {
        "key": PolicyKey(id="k", principal="jun"),
        "locked": (),
        "stopped": False,
        "slots": "none",
        "holder": None,
    }
    met = []
    for name in wrong:
        met.append(denied("jun", "kuka1", "home", **wrong).rule)
        wrong[name] = right[name]
    assert met == [
        PolicyRule.KEY,
        PolicyRule.LOCK,
        PolicyRule.STOPPED,
        PolicyRule.SLOT,
        PolicyRule.LEASE,
    ]


NAMES = {"adm": "Ada", "kim": "Kim", "opa": "Opa", "jun": "Jun"}
WORDS = PolicyTexts(
    person=lambda who: NAMES.get(who, who),
    robot={"kuka1": "KUKA iiwa", "omni": "omni"}.get,  # type: ignore[arg-type]
    time=lambda ns: f"{(ns - NOW):+d} ns from now",
)


def test_an_explanation_has_one_line_for_each_rule() -> None:
    assert explain(asked("jun", "kuka1", "grasp", SOFT, stepped_up=True), WORDS) == (
        "ok  key:      their own, and good",
        "ok  lock:     not locked, or it is a stop",
        "ok  sight:    they may see KUKA iiwa",
        "ok  reach:    the key reaches grasp",
        "ok  right:    the role junior which includes operator gives *:*, only on kuka1",
        "ok  channel:  the conversation is provider-readable, which is enough",
        "ok  limits:   within force <= 20 N",
        "ok  stopped:  KUKA iiwa is not stopped",
        "ok  slot:     no slot in the way",
        "ok  lease:    nobody else has it",
        (
            "ok  care:     wants a tap that confirms it, a second factor, a second person who "
            "agrees; still missing: a tap that confirms it, a second person who agrees"
        ),
    )
    assert explain(asked("jun", "kuka1", "grasp", FORCE), WORDS)[-1] == (
        "no  limits:   force <= 20 N is broken (force is 30.0, in SI); Ada or Kim can help"
    )


@pytest.mark.parametrize(
    ("decision", "last"),
    [
        (asked("opa", "kuka1", "home", key=None), "no  key:      none of theirs; Ada can help"),
        (
            asked("opa", "kuka1", "home", locked={"opa"}),
            "no  lock:     locked; only stop is left to them; Ada can help",
        ),
        (
            asked("old", "kuka1", "home"),
            (
                "no  sight:    nothing shows them kuka1; to them there is no such robot; "
                "all their rights ended at -3 ns from now; Ada can help"
            ),
        ),
        (
            asked("qui", "kuka1", "grasp"),
            (
                "no  right:    nothing of theirs gives grasp on KUKA iiwa; it takes the role "
                "junior or operator or senior or admin; Ada or Kim can help"
            ),
        ),
        (
            asked("was", "kuka1", "home"),
            "no  right:    it ended at -9 ns from now; Ada or Kim can help",
        ),
        (
            asked("qui", "omni", "move"),
            (
                "no  channel:  the conversation is provider-readable, it takes e2ee-verified; "
                "Ada can help"
            ),
        ),
        (
            asked("opa", "kuka1", "home", stopped=True),
            "no  stopped:  KUKA iiwa is stopped until it is resumed",
        ),
        (
            asked("opa", "kuka1", "home", slots="required", next_free_ns=NOW + 4),
            "no  slot:     a slot of one's own is needed; free at +4 ns from now",
        ),
        (
            asked("opa", "kuka1", "home", slots="required", slot=a_slot("adm")),
            "no  slot:     the time is Ada's; free at +9 ns from now",
        ),
        (
            asked("opa", "kuka1", "home", holder="adm", holder_until_ns=NOW + 2),
            "no  lease:    Ada has KUKA iiwa until +2 ns from now",
        ),
        (asked("opa", "kuka1", "stop"), "ok  sight:    they may see KUKA iiwa"),
        (asked("opa", "kuka1", "home"), "ok  care:     nothing has to come first"),
    ],
)
def test_the_last_line_says_what_decided(decision: Decision, last: str) -> None:
    assert explain(decision, WORDS)[-1] == last
