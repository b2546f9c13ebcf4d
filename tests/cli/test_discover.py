"""Drafting a profile from what is on a ROS 2 graph. The graph itself is met in tests/real."""

from __future__ import annotations

import os
from dataclasses import replace
from typing import TYPE_CHECKING

import pytest

from rosic.app.setup.discovery import left_out, robots_in
from rosic.app.setup.profile_draft import JOINTS, LOCATED, SeenRobot, drafted, robot_id
from rosic.app.setup.profile_draft_nav2 import FOLLOW, GRIP, NAVIGATE, ArmDraft, MapPose
from rosic.cli.robots import write_drafts
from rosic.config.profiles import read_profile
from rosic.robots.ros2.client.graph import GraphSnapshot, GraphTopic, OfferedEndpoint
from rosic.robots.ros2.profile import Ros2Profile, ros2_profile
from tests.cli.running import SOURCE, cold_rosic

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path


MOVE = "rosic_interfaces/action/Move"
SEEN = SeenRobot(
    namespace="/omni",
    heard={
        "/omni/cmd_vel": "geometry_msgs/msg/Twist",
        "/omni/to_robot_topic": "std_msgs/msg/String",
    },
    said={
        "/omni/odom": "nav_msgs/msg/Odometry",
        "/omni/battery": "sensor_msgs/msg/BatteryState",
        "/omni/camera": "sensor_msgs/msg/CompressedImage",
        "/omni/from_robot_topic": "std_msgs/msg/String",
    },
    services={"/omni/stop": "std_srvs/srv/Trigger", "/omni/dock": "std_srvs/srv/Trigger"},
    actions={"/omni/move": MOVE, "/omni/dance": "acme_msgs/action/Dance"},
)


def fields(kind: str) -> Mapping[str, str] | None:
    known = {"distance_m": "double", "speed_m_s": "float", "joint": "int32", "direction": "string"}
    return FOREIGN_GOAL if kind == FETCH else known if kind == MOVE else None


FETCH = "foreign_msgs/action/Fetch"
FOREIGN_GOAL = {
    "pace": "float",
    "reach_m": "double",
    "careful": "boolean",
    "label": "string",
    "via": "geometry_msgs/Point",
}
FOREIGN_RESULT = {"code": "uint8", "status": "string", "reached": "boolean", "remark": "string"}


def answers(kind: str) -> Mapping[str, str] | None:
    told = {"success": "boolean", "message": "string"}
    return FOREIGN_RESULT if kind == FETCH else told if kind == MOVE else None


def profile_of(text: str, folder: Path) -> Ros2Profile:
    path = folder / "draft.yaml"
    path.write_text(text)
    read = read_profile(path)
    assert read.errors == []
    assert read.profile is not None
    return ros2_profile(read.profile)


def test_a_draft_is_a_profile_with_careful_bounds(tmp_path: Path) -> None:
    text = drafted(SEEN, fields, answers)

    profile = profile_of(text, tmp_path)
    assert profile.id == "omni"
    assert profile.link.namespace == "/omni"
    assert profile.link.dialogue
    assert profile.stop is not None
    assert (profile.stop.service, profile.stop.zero) == ("/omni/stop", "/omni/cmd_vel")
    assert profile.at_rest is not None
    assert "linear.z" in str(profile.at_rest), "it may be one that flies"
    assert set(profile.telemetry) == {"battery", "x", "y"}
    assert profile.camera is not None
    assert set(profile.skills) == {"move", "dance", "dock", "drive"}
    move = profile.skills["move"].parameters
    assert {name: (p.unit, p.max) for name, p in move.items()} == {
        "distance": ("m", 1),
        "speed": ("m/s", 0.2),
        "joint": ("", 10),
    }
    assert profile.watchdog_s is not None
    assert profile.pose is not None
    assert profile.pose.topic == "/omni/odom"
    assert [(alert.when, alert.tell.value) for alert in profile.alerts] == [
        ("offline", "operators")
    ]
    assert "--try omni" in text


def test_a_draft_says_what_it_cannot_know_of_a_foreign_action(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    seen = SEEN._replace(actions={"/omni/fetch": FETCH})
    text = drafted(seen, fields, answers)

    action = profile_of(text, tmp_path).skills["fetch"].action
    assert action is not None
    assert action.message == "remark", "else a failure would come without its reason"
    said = [
        (
            "Whatever it answers reads as done: /omni/fetch. code (uint8) or status (string) or "
            "reached (boolean) looks like it: write success: code and good: the number that "
            "means success; or success: status and good: the word that means success; or "
            "success: reached."
        ),
        (
            "Without a unit, from 0 to 1, as nothing tells better: pace of /omni/fetch. Write "
            "unit, min and max."
        ),
        (
            "Left as it is when nothing is said of it: label (string), via (geometry_msgs/Point) "
            "of /omni/fetch. Write what it has to be under goal."
        ),
    ]
    for line in said:
        assert f"# {line}\n" in text
    write_drafts(tmp_path / "robots", {"omni": text})
    printed = capsys.readouterr().out
    assert all(f"  look at: {line}\n" in printed for line in said)


def test_yes_or_no_of_a_goal_is_drafted_as_a_choice_that_is_off(tmp_path: Path) -> None:
    seen = SEEN._replace(actions={"/omni/fetch": FETCH})
    skill = profile_of(drafted(seen, fields, answers), tmp_path).skills["fetch"]
    assert skill.action is not None
    assert skill.action.goal["careful"] == "$careful.value"
    careful = skill.parameters["careful"]
    assert careful.means == {"off": {"value": False}, "on": {"value": True}}
    assert careful.default == "off"


def test_a_draft_of_an_action_that_tells_success_says_nothing_more() -> None:
    assert "Whatever it answers" not in drafted(SEEN, fields, answers)


@pytest.mark.parametrize("begun", [False, True])
def test_a_robot_that_a_profile_reaches_is_not_drafted_under_another_id(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], *, begun: bool
) -> None:
    first = SEEN._replace(said={}) if begun else SEEN  # somebody has yet to add how it rests
    path = tmp_path / "omni.yaml"
    path.write_text(drafted(first, fields, answers))
    assert bool(read_profile(path).errors) == begun
    apart = SEEN._replace(
        namespace="/other",
        heard={"/other/cmd_vel": "geometry_msgs/msg/Twist"},
        said={"/other/odom": "nav_msgs/msg/Odometry"},
        services={},
        actions={},
    )
    drafts = {"lab_omni": drafted(SEEN._replace(namespace="/lab/omni"), fields, answers)}

    assert write_drafts(tmp_path, drafts | {"other": drafted(apart, fields, answers)}) == 1

    assert {one.name for one in tmp_path.iterdir()} == {"omni.yaml", "other.yaml"}
    said = capsys.readouterr()
    assert f"Not drafted again: {path} reaches the robot lab_omni already, by the " in said.err
    assert f"Written: {tmp_path / 'other.yaml'}" in said.out


def test_a_robot_without_velocities_states_no_watchdog(tmp_path: Path) -> None:
    text = drafted(SEEN._replace(heard={}), fields, answers)

    assert "watchdog" not in text
    assert "drive" not in profile_of(text, tmp_path).skills


def test_what_cannot_be_guessed_is_missing_and_the_check_says_so(tmp_path: Path) -> None:
    path = tmp_path / "draft.yaml"
    path.write_text(drafted(SEEN._replace(said={}), fields, answers))

    sentences = " ".join(str(error) for error in read_profile(path).errors)

    assert "at_rest" in sentences


def test_names_become_ids() -> None:
    assert robot_id("/Omni-2") == "omni_2"
    assert robot_id("/2nd") == "robot_2nd"
    assert len(robot_id("/" + "x" * 80)) == 32


def test_what_neither_moves_nor_tells_is_no_robot() -> None:
    found = GraphSnapshot(
        nodes=("/omni/base", "/map_server"),
        topics=(
            GraphTopic("/omni/cmd_vel", ("geometry_msgs/msg/Twist",), 0, 1),
            GraphTopic("/omni/odom", ("nav_msgs/msg/Odometry",), 1, 0),
            GraphTopic("/map/map", ("nav_msgs/msg/OccupancyGrid",), 1, 0),
        ),
        services=(OfferedEndpoint("/map/load", ("std_srvs/srv/Trigger",)),),
        actions=(OfferedEndpoint("/kuka1/grasp", (MOVE,)),),
        complete=True,
    )

    robots = robots_in(found)

    assert [robot.namespace for robot in robots] == ["/kuka1", "/omni"]
    assert robots[1].heard == {"/omni/cmd_vel": "geometry_msgs/msg/Twist"}
    assert robots[1].said == {"/omni/odom": "nav_msgs/msg/Odometry"}


TWIST, ODOMETRY = "geometry_msgs/msg/Twist", "nav_msgs/msg/Odometry"


def graph_of(*bases: str, publishers: int = 1) -> GraphSnapshot:
    """Return a graph of bases: what stands before ``odom``, ``cmd_vel`` and ``stop``."""
    heard = [GraphTopic(f"{base}cmd_vel", (TWIST,), 0, 1) for base in bases]
    said = [GraphTopic(f"{base}odom", (ODOMETRY,), publishers, 0) for base in bases]
    stops = tuple(OfferedEndpoint(f"{base}stop", ("std_srvs/srv/Trigger",)) for base in bases)
    return GraphSnapshot((), (*heard, *said), stops, (), complete=True)


def test_robots_that_live_below_one_name_are_drafted_apart(tmp_path: Path) -> None:
    robots = robots_in(graph_of("/lab/omni/", "/lab/rover/"))

    assert [robot.namespace for robot in robots] == ["/lab/omni", "/lab/rover"]
    profile = profile_of(drafted(robots[1], fields, answers), tmp_path)
    assert (profile.id, profile.link.namespace) == ("lab_rover", "/lab/rover")
    assert profile.stop is not None
    assert (profile.stop.service, profile.stop.zero) == ("/lab/rover/stop", "/lab/rover/cmd_vel")
    assert not any(robot.mixed for robot in robots)


def agv(name: str) -> tuple[GraphTopic, ...]:
    return (
        GraphTopic(f"/site4/{name}/drive/velocity_cmd", (TWIST,), 0, 1),
        GraphTopic(f"/site4/{name}/wheel_odometry", (ODOMETRY,), 1, 0),
    )


def test_robots_are_seen_by_what_their_topics_carry_not_by_their_names() -> None:
    charger = GraphTopic("/charger/state", ("std_msgs/msg/String",), 1, 0)
    one = GraphSnapshot((), (*agv("agv_07"), charger), (), (), complete=True)
    robots = robots_in(one)
    assert [robot.namespace for robot in robots] == ["/site4"]
    assert list(robots[0].heard) == ["/site4/agv_07/drive/velocity_cmd"]
    assert left_out(one, robots) == ["/charger"]

    two = robots_in(replace(one, topics=(*agv("agv_07"), *agv("agv_08"))))
    assert [robot.namespace for robot in two] == ["/site4/agv_07", "/site4/agv_08"]


def test_a_filter_of_odometry_is_no_robot_beside_the_one_it_is_about() -> None:
    found = graph_of("/")
    filtered = GraphTopic("/odometry/filtered", (ODOMETRY,), 1, 0)
    [robot] = robots_in(replace(found, topics=(*found.topics, filtered)))
    assert robot.namespace == ""
    assert "/odometry/filtered" in robot.said


def test_a_base_and_the_arm_on_it_are_one_robot() -> None:
    found = graph_of("/lab/base/")
    arm = GraphTopic("/lab/arm/joint_states", (JOINTS,), 1, 0)
    [robot] = robots_in(replace(found, topics=(*found.topics, arm)))
    assert (robot.namespace, robot.mixed) == ("/lab", "")


@pytest.mark.parametrize(
    ("found", "why"),
    [
        (graph_of("/lab/", publishers=2), "/lab/odom is published by more than one node"),
        (graph_of("/lab/", "/lab/b_"), "/lab/cmd_vel and /lab/b_cmd_vel move one each"),
    ],
)
def test_robots_that_cannot_be_told_apart_are_said_to_be_mixed(
    found: GraphSnapshot, why: str
) -> None:
    [robot] = robots_in(found)
    assert drafted(robot, fields, answers).startswith(
        f"# More than one robot seems to live in /lab, as {why}: this draft mixes them. "
        "Give each a namespace of its own and draft again.\n"
    )


def test_a_robot_alone_on_its_graph_keeps_its_controllers(tmp_path: Path) -> None:
    found = GraphSnapshot(
        nodes=(),
        topics=(GraphTopic("/joint_states", (JOINTS,), 1, 0),),
        services=(),
        actions=(
            OfferedEndpoint("/arm_controller/follow_joint_trajectory", (FOLLOW,)),
            OfferedEndpoint("/gripper/gripper_cmd", (GRIP,)),
        ),
        complete=True,
    )

    [robot] = robots_in(found)
    limbs = ArmDraft("/joint_states", {"base": 0.5, "elbow": -1.0})
    limbed = robot._replace(limbs={"/arm_controller/follow_joint_trajectory": limbs})
    text = drafted(limbed, fields, answers)

    profile = profile_of(text, tmp_path)
    assert (profile.id, profile.link.namespace) == ("robot", "/")
    assert set(profile.skills) == {"pose", "joint", "gripper"}
    assert profile.joints is not None
    elbow = profile.joints.limits["elbow"]
    assert (elbow.min, elbow.max, elbow.speed) == (-1.3, -0.7, 0.2)
    assert "write those of your arm" in text


def test_what_nav2_is_made_of_inside_is_left_out(tmp_path: Path) -> None:
    actions = {
        "/rover/navigate_to_pose": NAVIGATE,
        "/rover/follow_path": "nav2_msgs/action/FollowPath",
        "/rover/spin": "nav2_msgs/action/Spin",
    }
    said = {"/rover/odom": "nav_msgs/msg/Odometry", "/rover/amcl_pose": LOCATED}
    heard = {"/rover/cmd_vel": "geometry_msgs/msg/TwistStamped"}
    seen = SeenRobot("/rover", heard, said, {}, actions, stand=MapPose(1.2345, 2.0, 0.5))

    profile = profile_of(drafted(seen, fields, answers), tmp_path)

    assert set(profile.skills) == {"goto", "visit", "drive"}
    drive = profile.skills["drive"].topic
    assert drive is not None
    assert drive.type == "geometry_msgs/msg/TwistStamped"
    assert set(drive.message) == {"twist.linear.x", "twist.angular.z"}
    assert profile.skills["visit"].parameters["place"].means == {
        "here": {"x": 1.234, "y": 2.0, "yaw": 0.5}
    }
    assert profile.stop is not None
    assert profile.stop.zero_type == "geometry_msgs/msg/TwistStamped"
    assert profile.pose is not None


@pytest.mark.parametrize("command", [("robot", "discover"), ("sim", "--ros2", "omni")])
def test_without_ros_it_says_how_to_get_it(tmp_path: Path, command: tuple[str, ...]) -> None:
    absent = tmp_path / "rclpy"
    absent.mkdir()
    (absent / "__init__.py").write_text("raise ImportError(\"No module named 'rclpy'\")")

    ran = cold_rosic(*command, env={"PYTHONPATH": f"{SOURCE}{os.pathsep}{tmp_path}"})

    assert ran.status == 2
    assert ran.err.startswith("rosic: ROS 2 cannot be used by this Python")
    assert "pip install 'rosic[ros2]' (in a checkout: " in ran.err
    assert len(ran.err.splitlines()) == 1
