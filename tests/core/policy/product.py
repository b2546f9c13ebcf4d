"""From the oracle's plain dictionaries to the product's types, and its answers back again."""

from __future__ import annotations

from typing import Any, TypeAlias

from rosic.core.language.numbers import Unit, UnitTable
from rosic.core.policy.evaluate import decide
from rosic.core.policy.limits import unit_converter
from rosic.core.policy.permissions import Permissions
from rosic.core.policy.query import Allow, PolicyKey, PolicyState, Query
from rosic.core.policy.roles import (
    Assurance,
    Grant,
    Role,
    RoleRules,
    SkillPrecondition,
    StepRequired,
)
from rosic.core.policy.scope import Fleet, Scope
from rosic.core.robot.skill import Parameter, Skill, SkillClass
from rosic.core.slot import BookedSlot

Data: TypeAlias = Any  # dictionaries, lists and numbers, as the oracle takes them

UNITS = UnitTable(
    exact={
        "m": Unit("m", "length", 1.0),
        "cm": Unit("cm", "length", 0.01),
        "N": Unit("N", "force", 1.0),
        "kN": Unit("kN", "force", 1000.0),
        "m/s": Unit("m/s", "speed", 1.0),
        "cm/s": Unit("cm/s", "speed", 0.01),
    },
    forgiving={},
)
CONVERT = unit_converter(UNITS)
NEEDS = {
    StepRequired.CONFIRMATION: "confirm",
    StepRequired.STEP_UP: "step_up",
    StepRequired.SECOND_PERSON: "second_person",
}


def texts(scopes: Data) -> tuple[str, ...]:
    return tuple(f"{robot}:{skill}" for robot, skill in scopes)


def a_limit(limit: Data) -> str:
    """Write a limit; some of them in another unit than SI."""
    scope, parameter, sign, number, unit = limit
    before = f"{scope[0]}:{scope[1]} " if scope else ""
    if unit in {"m", "m/s"} and int(number * 10) % 2:
        number, unit = number * 100, f"c{unit}"
    return f"{before}{parameter} {sign} {number:g} {unit}"


def a_parameter(known: Data) -> Parameter:
    low, high, unit = known
    if unit == "word":
        return Parameter(text=True)
    if unit == "m":
        return Parameter(min=low * 100, max=high * 100, unit="cm")
    return Parameter(min=low, max=high, unit=unit)


def a_skill(name: str, said: Data) -> Skill:
    return Skill(
        id=name,
        kind=SkillClass(said["class"]),
        parameters={n: a_parameter(known) for n, known in said["parameters"].items()},
    )


def a_role(said: Data) -> Role:
    return Role(
        scopes=texts(said["scopes"]),
        includes=tuple(said["includes"]),
        limits=tuple(map(a_limit, said["limits"])),
        assurance=Assurance(said["assurance"]).said if said["assurance"] else "",
        priority=said["priority"],
    )


def a_grant(said: Data) -> Grant:
    return Grant(
        role=said["role"],
        scopes=texts(said["scopes"]),
        robots=tuple(said["robots"]),
        limits=tuple(map(a_limit, said["limits"])),
        expires_ns=said["ends"],
    )


def a_rulebook(world: Data) -> RoleRules:
    return RoleRules(
        roles={name: a_role(said) for name, said in world["roles"].items()},
        care=tuple(
            SkillPrecondition(
                scopes=texts(said["scopes"]),
                confirm=said["confirm"],
                step_up=said["step_up"],
                second_person=said["second_person"],
                assurance=Assurance(said["assurance"]).said if said["assurance"] else "",
            )
            for said in world["care"]
        ),
        preempt=tuple(world["preempt"]),
    )


def a_fleet(world: Data) -> Fleet:
    return Fleet(
        skills={
            robot: {name: a_skill(name, said) for name, said in skills.items()}
            for robot, skills in world["robots"].items()
        },
        groups={name: tuple(robots) for name, robots in world["groups"].items()},
        verbs=tuple(world["verbs"]),
    )


def rights_of(world: Data, epoch: int = 1) -> Permissions:
    people = {who: tuple(map(a_grant, grants)) for who, grants in world["people"].items()}
    return Permissions.draw_up(epoch, a_rulebook(world), a_fleet(world), people, CONVERT)


def a_key(said: Data) -> PolicyKey | None:
    if said is None:
        return None
    return PolicyKey(
        id="k",
        principal=said["owner"],
        expires_ns=said["ends"],
        revoked=said["revoked"],
        scopes=tuple(Scope(*scope) for scope in said["scopes"]),
    )


def a_slot(said: Data, robot: str) -> BookedSlot | None:
    if said is None:
        return None
    return BookedSlot(
        id="s",
        principal=said["owner"],
        robot=robot,
        start_ns=said["start"],
        end_ns=said["end"],
        made_ns=0,
        by=said["owner"],
    )


def state_of(rights: Permissions, case: Data) -> PolicyState:
    return PolicyState(
        rights=rights,
        key=a_key(case["key"]),
        now_ns=case["now"],
        locked=frozenset(case["locked"]),
        stopped=case["stopped"],
        holder=case["holder"],
        holder_until_ns=case["until"],
        slots=case["slots"],
        slot=a_slot(case["slot"], case["robot"]),
        next_free_ns=case["next"],
        stepped_up=case["stepped_up"],
        confirmed=case["confirmed"],
        second=case["second"],
    )


def ask_of(case: Data) -> Query:
    return Query(
        principal=case["who"],
        key="k",
        robot=case["robot"],
        skill=case["skill"],
        arguments=case["arguments"],
        channel=Assurance(case["channel"]),
    )


def answer(rights: Permissions, case: Data) -> Data:
    """Decide, and say it as the oracle does."""
    decision = decide(state_of(rights, case), ask_of(case))
    if isinstance(decision, Allow):
        needs = [NEEDS[need] for need in decision.needs]
        return needs, list(decision.preempts), decision.priority
    return decision.code.value
