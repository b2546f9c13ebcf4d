"""The robots that come with ROSIC: what can be said to them, and that ROS knows what they name."""

from __future__ import annotations

import importlib
import re
from math import pi
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

from rosic.app.features import command_table
from rosic.cli.init import KINDS
from rosic.config.profiles import (
    find_profile,
    fleet_findings,
    known_units,
    load_profile,
    read_profile,
    shipped_profiles,
)
from rosic.core.language import Do, LineContext, Vocabulary, bind, understand
from rosic.core.robot.profile import LinkLoss
from rosic.errors import ConfigurationError
from rosic.robots.ros2.profile import Ros2Profile, ros2_profile

if TYPE_CHECKING:
    from rosic.robots.ros2.profile import ActionBinding

ROBOTS = ("cf1", "cf2", "cf3", "kuka1", "omni", "picker", "rover", "talker", "yumi")
ACTIONS = Path(__file__).parents[2] / "src/rosic/robots/ros2/interfaces/rosic_interfaces/action"


@pytest.fixture(scope="module")
def fleet() -> dict[str, Ros2Profile]:
    return {name: ros2_profile(load_profile(path)) for name, path in shipped_profiles().items()}


@pytest.fixture(scope="module")
def vocabulary(fleet: dict[str, Ros2Profile]) -> Vocabulary:
    return Vocabulary.build(fleet.values(), known_units(), command_table())


def actions(fleet: dict[str, Ros2Profile]) -> list[ActionBinding]:
    skills = [skill for profile in fleet.values() for skill in profile.skills.values()]
    return [skill.action for skill in skills if skill.action is not None]


@pytest.mark.parametrize("name", ROBOTS)
def test_a_profile_is_good_and_named_like_its_file(name: str) -> None:
    read = read_profile(shipped_profiles()[name])
    assert [str(error) for error in read.errors + read.advice] == []
    assert read.profile is not None
    assert read.profile.id == name
    assert {skill.id for skill in read.profile.skills.values()} == set(read.profile.skills)


def test_no_other_profile_ships() -> None:
    assert tuple(shipped_profiles()) == ROBOTS


def test_the_page_about_profiles_lists_them_with_their_skills(
    fleet: dict[str, Ros2Profile],
) -> None:
    page = (Path(__file__).parents[2] / "docs/robots/profiles.md").read_text(encoding="utf-8")
    table = page.partition("## Profiles that ship")[2]
    listed: dict[str, list[str]] = {}
    for names, skills in re.findall(r"^\| (`.*`) \|[^|]*\| (.*) \|$", table, re.MULTILINE):
        for name in re.findall(r"`(\w+)`", names):
            listed[name] = skills.split(", ")
    shipped = {name: list(profile.skills) for name, profile in fleet.items()}
    crazyflies = [n for n, profile in fleet.items() if "crazyflies" in profile.groups]
    assert listed.pop("crazyflies", None) in (None, shipped[crazyflies[0]])
    assert listed == shipped


def test_a_newcomer_is_told_what_each_of_them_is() -> None:
    assert set(KINDS) == set(ROBOTS)


def test_all_of_them_can_be_used_together(fleet: dict[str, Ros2Profile]) -> None:
    assert list(fleet_findings(list(fleet.values()), known_units())) == []


def test_the_three_drones_differ_by_their_number_only() -> None:
    texts = {shipped_profiles()[f"cf{n}"].read_text() for n in (1, 2, 3)}
    assert len(texts) == 3
    assert (
        len({re.sub(r"(?<=cf)[123]|(?<=Crazyflie )[123]|(?<=drone )[123]", "N", t) for t in texts})
        == 1
    )


def test_a_robot_runs_in_process_from_the_same_file(fleet: dict[str, Ros2Profile]) -> None:
    simulated = ros2_profile(load_profile(shipped_profiles()["omni"], link="simulated"))
    assert (simulated.link.kind, simulated.link.model) == ("simulated", "omni")
    assert simulated.skills == fleet["omni"].skills
    models = {name: profile.link.model for name, profile in fleet.items()}
    assert models == {
        "cf1": "crazyflie",
        "cf2": "crazyflie",
        "cf3": "crazyflie",
        "kuka1": "kuka",
        "omni": "omni",
        "picker": "",
        "rover": "",
        "talker": "",
        "yumi": "yumi",
    }


SAID: list[tuple[str, dict[str, dict[str, Any]]]] = [
    ("omni move forward 0.5 m", {"omni": {"direction": "forward", "distance": 0.5, "speed": 0.25}}),
    ("omni move 50 cm backwards", {"omni": {"direction": "back", "distance": 0.5, "speed": 0.25}}),
    (
        "omni move fwd 1 m speed=0.5",
        {"omni": {"direction": "forward", "distance": 1.0, "speed": 0.5}},
    ),
    ("omni rotate right 90", {"omni": {"direction": "right", "angle": pi / 2}}),
    ("omni go to x=1 y=-2", {"omni": {"x": 1.0, "y": -2.0, "yaw": 0.0}}),
    ("omni arm reach", {"omni": {"pose": "reach"}}),
    (
        "omni drive linear=0.2 duration=2",
        {"omni": {"linear": 0.2, "lateral": 0.0, "angular": 0.0, "duration": 2.0}},
    ),
    ("kuka1 grasp", {"kuka1": {"force": 15.0}}),
    ("kuka grab force=20", {"kuka1": {"force": 20.0}}),
    ("kuka1 move joint 3 45 deg", {"kuka1": {"joint": 3, "angle": pi / 4}}),
    ("kuka1 release", {"kuka1": {}}),
    ("yumi hand over", {"yumi": {}}),
    ("crazyflies takeoff 1 m", {name: {"height": 1.0} for name in ("cf1", "cf2", "cf3")}),
    ("crazyflies take off", {name: {"height": 0.5} for name in ("cf1", "cf2", "cf3")}),
    (
        "crazyflies formation triangle 80 cm",
        {name: {"shape": "triangle", "spacing": 0.8} for name in ("cf1", "cf2", "cf3")},
    ),
    ("drone 2 go to x=1 y=0 z=1", {"cf2": {"x": 1.0, "y": 0.0, "z": 1.0}}),
    ("cf1 land", {"cf1": {}}),
    ("cf2 follow cf1", {"cf2": {"leader": "cf1", "distance": 1.2, "bearing": 0.0}}),
    (
        "drone 2 keep behind drone 1 150 cm bearing=-45 deg",
        {"cf2": {"leader": "cf1", "distance": 1.5, "bearing": -pi / 4}},
    ),
    ("rover go to the dock", {"rover": {"place": "dock"}}),
    ("rover goto x=1 y=2 yaw=90", {"rover": {"x": 1.0, "y": 2.0, "yaw": pi / 2}}),
    ("picker go to ready 50 %", {"picker": {"pose": "ready", "speed": 0.5}}),
    ("picker joint elbow 45 deg", {"picker": {"joint": "elbow_joint", "angle": pi / 4}}),
    ("picker grip 20 N", {"picker": {"force": 20.0}}),
    ("picker open", {"picker": {}}),
    ("talker say good morning", {"talker": {"text": "good morning"}}),
]


@pytest.mark.parametrize(("said", "meant"), SAID, ids=[said for said, _ in SAID])
def test_what_people_say_is_understood(
    said: str, meant: dict[str, dict[str, Any]], vocabulary: Vocabulary
) -> None:
    [line] = understand(said, vocabulary, LineContext("", frozenset(ROBOTS)))
    assert isinstance(line, Do), line
    found = {
        robot: bind(vocabulary, robot, skill, line.spoken)
        for robot, skill in zip(line.robots, line.skills, strict=True)
    }
    assert found == {robot: pytest.approx(arguments) for robot, arguments in meant.items()}


def test_an_action_takes_exactly_what_a_profile_sends(fleet: dict[str, Ros2Profile]) -> None:
    own = [action for action in actions(fleet) if action.type.startswith("rosic_interfaces/")]
    assert (len(own), len(actions(fleet))) == (25, 31)
    for action in own:
        name = action.type.rpartition("/")[2]
        goal, result, feedback = (ACTIONS / f"{name}.action").read_text().split("---\n")
        assert {*action.goal, action.start} <= fields(goal), action.name
        # Speed may be left to the robot, and a place need not have every coordinate.
        left_out = {"speed_m_s", "speed_rad_s", "yaw_rad", "z_m"}
        assert fields(goal) - {*action.goal, action.start} <= left_out, action.name
        assert {action.success, action.message} <= fields(result)
        assert {action.fraction, action.stage} <= fields(feedback)


def fields(part: str) -> set[str]:
    lines = [line.split("#")[0].split() for line in part.splitlines()]
    return {words[1] for words in lines if words}


def test_ros_has_every_type_and_field_that_is_read(fleet: dict[str, Ros2Profile]) -> None:
    pytest.importorskip("nav_msgs.msg", reason="ROS 2 messages: pip install 'rosic[ros2]'")
    for profile in fleet.values():
        for described in profile.telemetry.values():
            assert has_field(described.type, described.field)
        if profile.at_rest is not None:
            for path in profile.at_rest.field.split(","):
                assert has_field(profile.at_rest.type, path.strip())
        for skill in profile.skills.values():
            for path in skill.topic.message if skill.topic is not None else ():
                assert has_field(skill.topic.type if skill.topic else "", path)
    assert not has_field("nav_msgs/msg/Odometry", "twist.linear.x")


def has_field(type_name: str, path: str) -> bool:
    package, kind, name = type_name.split("/")
    here: Any = getattr(importlib.import_module(f"{package}.{kind}"), name)()
    for step in path.split("."):
        if not hasattr(here, step):
            return False
        here = getattr(here, step)
    return True


def test_a_drone_rests_on_the_ground_and_lands_without_a_link(
    fleet: dict[str, Ros2Profile],
) -> None:
    for name in ("cf1", "cf2", "cf3"):
        profile = fleet[name]
        assert profile.link_loss is LinkLoss.LAND
        assert profile.at_rest is not None
        assert "pose.pose.position.z" in profile.at_rest.field


@pytest.mark.parametrize(
    ("wanted", "found"),
    [
        ("omni", shipped_profiles()["omni"]),
        ("omni.yaml", Path("/etc/rosic/omni.yaml")),
        ("robots/mine.yml", Path("/etc/rosic/robots/mine.yml")),
        ("/srv/mine.yaml", Path("/srv/mine.yaml")),
    ],
)
def test_a_name_ships_and_a_path_is_a_file(wanted: str, found: Path) -> None:
    assert find_profile(wanted, Path("/etc/rosic")) == found


def test_a_name_that_does_not_ship_is_answered_with_one_that_does() -> None:
    with pytest.raises(ConfigurationError, match="Did you mean kuka1"):
        find_profile("kuka", Path())
