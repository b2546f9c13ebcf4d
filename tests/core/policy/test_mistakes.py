"""One clear sentence for each mistake in roles, grants and care."""

from __future__ import annotations

import pytest

from rosic.core.policy.roles import DEFAULT_ROLES, Grant, Role, RoleRules, SkillPrecondition
from rosic.core.policy.validation import grant_mistakes, rulebook_mistakes
from tests.core.policy.product import CONVERT
from tests.core.policy.test_rights import FLEET_HERE

JUNIOR = Role(includes=("operator",), limits=("force <= 20 N", "omni:* speed <= 0.2 m/s"))


def said(book: RoleRules) -> list[tuple[str, str]]:
    found = rulebook_mistakes(book, FLEET_HERE, CONVERT)
    assert all(type(text) is not str for m in found for text in m[1:] if text), "said, not written"
    return [(".".join(map(str, m.place)), f"{m.sentence} {m.hint}".strip()) for m in found]


def test_the_default_roles_and_a_good_junior_are_without_mistake() -> None:
    book = RoleRules(
        roles={**DEFAULT_ROLES, "junior": JUNIOR},
        care=(
            SkillPrecondition(scopes=("arms:grasp", "*:*"), step_up=True),
            SkillPrecondition(scopes=("kuka1:resume", "omni:move"), assurance="local"),
        ),
        preempt=("*", "arms", "omni"),
    )
    assert said(book) == []


@pytest.mark.parametrize(
    ("role", "place", "sentence"),
    [
        (Role(scopes=("abb*:*",)), "scopes.0", "No robot matches 'abb*'. Known here: kuka1, omni."),
        (
            Role(scopes=("kuka2:*",)),
            "scopes.0",
            "No robot or group is called 'kuka2'. Did you mean kuka1?",
        ),
        (
            Role(scopes=("kuka1:grsap",)),
            "scopes.0",
            "kuka1 has no skill 'grsap'. Did you mean grasp?",
        ),
        (
            Role(scopes=("*:fly",)),
            "scopes.0",
            (
                "No robot of '*' has a skill 'fly'. "
                "Known here: ask, files, grant, grasp, help, home, look, move, places, read, "
                "resume, share, strategy."
            ),
        ),
        (
            Role(scopes=("kuka1",)),
            "scopes.0",
            "'kuka1' is no right: write robot, colon and skill, for example omni:move.",
        ),
        (
            Role(includes=("operater",)),
            "includes.0",
            ("No role is called 'operater'. Did you mean operator?"),
        ),
        (Role(), "", "The role r gives nothing. Give it scopes, or includes."),
        (
            Role(includes=("operator",), assurance="secret"),
            "assurance",
            (
                "'secret' is no assurance of a channel. "
                "Known: provider-readable, e2ee-unverified, e2ee-verified, local."
            ),
        ),
        (
            Role(includes=("operator",), limits=("sped <= 2 m/s",)),
            "limits.0",
            (
                "No skill given here has a parameter 'sped', so 'sped <= 2 m/s' limits nothing. "
                "Did you mean speed?"
            ),
        ),
        (
            Role(scopes=("kuka1:*",), limits=("speed <= 2 m/s",)),
            "limits.0",
            (
                "No skill given here has a parameter 'speed', so 'speed <= 2 m/s' limits nothing. "
                "Known here: force, hand."
            ),
        ),
        (
            Role(scopes=("kuka1:*",), limits=("force <= 2 m",)),
            "limits.0",
            (
                "On kuka1, 'force <= 2 m' does not fit force of grasp: 'm' does not fit, "
                "it is given in N."
            ),
        ),
        (
            Role(scopes=("kuka1:*",), limits=("force <= 2 N",)),
            "limits.0",
            "On kuka1, 'force <= 2 N' leaves nothing of force of grasp, which goes from 5 to 40 N.",
        ),
        (
            Role(scopes=("kuka1:*",), limits=("force <= 10 N", "force >= 20 N")),
            "limits",
            (
                "On kuka1, 'force <= 10 N and force >= 20 N' leaves nothing of force of grasp, "
                "which goes from 5 to 40 N."
            ),
        ),
        (
            Role(scopes=("kuka1:*",), limits=("hand <= 2",)),
            "limits.0",
            "On kuka1, hand of grasp is a word, so 'hand <= 2' cannot limit it.",
        ),
        (
            Role(scopes=("kuka1:*",), limits=("gently",)),
            "limits.0",
            "'gently' is not a limit: write for example speed <= 0.2 m/s.",
        ),
    ],
)
def test_a_mistake_in_a_role_is_one_sentence_in_its_place(
    role: Role, place: str, sentence: str
) -> None:
    found = said(RoleRules(roles={**DEFAULT_ROLES, "r": role}))
    assert found == [(f"role.r.{place}".strip("."), sentence)]


def test_a_loop_is_refused_with_its_name() -> None:
    roles = {"a": Role(includes=("b",)), "b": Role(includes=("a",), scopes=("*:read",))}
    assert said(RoleRules(roles=roles)) == [
        (
            "role.a.includes",
            "The role a includes itself: a includes b includes a. Take one of these includes out.",
        )
    ]


def test_roles_that_lie_too_deep_are_refused() -> None:
    roles = {f"r{n}": Role(includes=(f"r{n + 1}",)) for n in range(9)}
    roles["r9"] = Role(scopes=("*:read",))
    assert (
        "role.r0.includes",
        ("The role r0 includes roles more than 8 deep. Include the inner ones directly."),
    ) in said(RoleRules(roles=roles))


@pytest.mark.parametrize(
    ("care", "sentence"),
    [
        (
            SkillPrecondition(scopes=("kuka1:grasp",)),
            ("This asks for nothing. Set confirm, step_up or second_person."),
        ),
        (SkillPrecondition(scopes=("omni:grasp",), confirm=True), "omni has no skill 'grasp'."),
        (
            SkillPrecondition(scopes=("omni:r*",), confirm=True),
            ("'omni:r*' touches no skill. A wildcard stands for a robot's own skills alone."),
        ),
        (
            SkillPrecondition(scopes=("omni:move",), assurance="no"),
            "'no' is no assurance of a channel.",
        ),
    ],
)
def test_a_mistake_in_care_is_one_sentence(care: SkillPrecondition, sentence: str) -> None:
    (found,) = said(RoleRules(roles=DEFAULT_ROLES, care=(care,)))
    assert found[0].startswith("care.0")
    assert found[1].startswith(sentence)


@pytest.mark.parametrize(
    ("grant", "sentence"),
    [
        (Grant(), "This gives nothing."),
        (Grant(role="opera"), "No role is called 'opera'."),
        (Grant(role="operator", robots=("cf*",)), "No robot matches 'cf*'."),
        (Grant(scopes=("cf1:takeoff",)), "No robot or group is called 'cf1'."),
        (Grant(role="operator", robots=("arms",), limits=("speed <= 1 m/s",)), "No skill given"),
        (Grant(role="omnis", robots=("arms",)), "The role omnis gives nothing on arms."),
        (Grant(role="operator", limits=("force <= 1 kN",)), ""),
        (Grant(scopes=("kuka1:grasp",), expires_ns=5), ""),
    ],
)
def test_a_mistake_in_a_grant_is_one_sentence(grant: Grant, sentence: str) -> None:
    book = RoleRules(roles={**DEFAULT_ROLES, "omnis": Role(scopes=("omni:*",))})
    found = [mistake.sentence for mistake in grant_mistakes(grant, book, FLEET_HERE, CONVERT)]
    assert len(found) == bool(sentence)
    assert not found or found[0].startswith(sentence)


def test_preemption_names_robots() -> None:
    found = said(RoleRules(roles=DEFAULT_ROLES, preempt=("arm",)))
    assert found == [("preempt.0", "No robot or group is called 'arm'. Did you mean arms?")]
