from __future__ import annotations

import re

import msgspec
import pytest

from rosic.app.features import command_table
from rosic.core.language import (
    SAY,
    LanguageReader,
    Misunderstood,
    UnitTable,
    Use,
    Vocabulary,
    VocabularyHolder,
    skills_of,
)
from rosic.core.robot.profile import Link, Profile
from rosic.core.robot.skill import Parameter, Skill
from tests.core.language.fleet import echo, kuka, omni, profiles


def robot(name: str = "r1", **changes: object) -> Profile:
    return msgspec.structs.replace(Profile(id=name, link=Link(kind="memory")), **changes)


def skill(**changes: object) -> dict[str, Skill]:
    return {"dig": msgspec.structs.replace(Skill(id="dig"), **changes)}


def test_names_lead_to_robots(vocabulary: Vocabulary) -> None:
    for name in ("kuka1", "KUKA1", "KUKA iiwa", "kuka iiwa"):
        assert vocabulary.robot(name) == kuka()
    assert vocabulary.robot("rover") == omni()
    assert vocabulary.robot("crazyflies") is None
    assert vocabulary.robot("nobody") is None
    assert vocabulary.members("crazyflies") == ("cf1", "cf2", "cf3")
    assert vocabulary.members("omni") == ()
    assert vocabulary.names == (*[p.id for p in profiles()], "crazyflies")


@pytest.mark.parametrize(
    "spoken", ["move_joint", "move joint", "Move Joint", "move-joint", "movejoint"]
)
def test_a_skill_is_found_however_it_is_written(vocabulary: Vocabulary, spoken: str) -> None:
    found = vocabulary.skill("kuka1", spoken)
    assert found is not None
    assert found.id == "move_joint"


def test_a_skill_is_found_by_title_and_words(vocabulary: Vocabulary) -> None:
    for spoken in ("grasp", "grab", "grasp the object"):
        found = vocabulary.skill("kuka1", spoken)
        assert found is not None
        assert found.id == "grasp"
    assert vocabulary.skill("omni", "grasp") is None
    assert vocabulary.skill("nobody", "grasp") is None


def test_a_robot_with_a_dialogue_can_be_spoken_to() -> None:
    assert skills_of(echo()) == {"say": SAY}
    assert "say" not in skills_of(omni())


@pytest.mark.parametrize(
    ("fleet", "sentence"),
    [
        ([robot("a1"), robot("a1")], 'two robots are called "a1"'),
        ([robot("a1"), robot("b1", groups=("a1",))], "both a group and a name for a1"),
        ([robot("a1", words=("b1",)), robot("b1")], '"b1" means both a1 and b1'),
        ([robot("a1", words=("x",)), robot("b1", words=("X",))], '"x" means both a1 and b1'),
        ([robot("status")], 'robot status cannot be called "status"'),
        ([robot("r1", groups=("all",))], 'a group of r1 cannot be called "all"'),
        ([robot("halt")], 'robot halt cannot be called "halt"'),
        ([robot(words=("7",))], 'robot r1 cannot be called "7"'),
        ([robot(words=("please",))], 'robot r1 cannot be called "please"'),
        ([robot(words=(" ",))], "robot r1 has an empty name"),
        ([robot(skills=skill(words=("help",)))], "skill 'dig' cannot be called \"help\""),
        ([robot(skills=skill(words=("стоп",)))], "skill 'dig' cannot be called \"стоп\""),
        ([robot(skills=skill(words=("stop digging",)))], 'cannot be called "stop digging"'),
        (
            [robot(skills=skill(words=("r2",))), robot("r2")],
            '"r2" is both a skill of r1 and a name',
        ),
        (
            [robot(skills=skill() | {"burrow": Skill(id="burrow", words=("dig",))})],
            '"dig" means both dig and burrow',
        ),
        (
            [robot(skills=skill(parameters={"depth": Parameter(unit="metr", min=0, max=1)}))],
            (
                "robot r1, skill 'dig': parameter 'depth': \"metr\" is not a known unit. "
                "Did you mean m?"
            ),
        ),
        (
            [robot(skills=skill(parameters={"how": Parameter(choices={"fast": (), "7": ()})}))],
            '"7" cannot be a choice',
        ),
        (
            [
                robot(
                    skills=skill(parameters={"how": Parameter(choices={"a1": ("x",), "b": ("x",)})})
                )
            ],
            '"x" is both "a1" and "b"',
        ),
    ],
)
def test_what_would_be_misunderstood_is_refused(
    units: UnitTable, fleet: list[Profile], sentence: str
) -> None:
    with pytest.raises(ValueError, match=re.escape(sentence)):
        Vocabulary.build(fleet, units, command_table())


def test_a_title_that_two_robots_share_names_neither(units: UnitTable) -> None:
    twins = Vocabulary.build(
        [robot("a1", title="Arm"), robot("b1", title="Arm")], units, command_table()
    )

    assert twins.robot("arm") is None
    assert twins.robot("a1") is not None


def test_a_title_that_means_something_else_is_left_out(units: UnitTable) -> None:
    built = Vocabulary.build(
        [robot("a1", title="Status"), robot("b1", title="Dig", skills=skill(title="Stop it"))],
        units,
        command_table(),
    )

    assert built.robot("status") is None
    assert built.robot("dig") is None
    assert built.skill("b1", "stop it") is None


def test_robots_that_are_alike_share_their_skills(vocabulary: Vocabulary) -> None:
    first, second = vocabulary.robots["cf1"], vocabulary.robots["cf2"]

    assert first.skills["takeoff"] is second.skills["takeoff"]


def test_a_replaced_vocabulary_counts_at_once(units: UnitTable) -> None:
    before = Vocabulary.build([robot("omni")], units, command_table())
    after = Vocabulary.build([robot("omni"), robot("digger")], units, command_table())
    holder = VocabularyHolder(before)
    reader, everybody = LanguageReader(holder), frozenset({"omni", "digger"})
    assert isinstance(reader.lines("use digger", "", everybody)[0], Misunderstood)
    told: list[Vocabulary] = []
    holder.replaced.connect(lambda: told.append(holder.current))

    holder.replace(after)

    assert told == [after]
    assert tuple(before.profiles) == ("omni",)
    assert reader.lines("use digger", "", everybody) == (Use("digger"),)
