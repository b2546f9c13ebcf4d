"""What a message of a topic means for the skill that streams to it."""

from __future__ import annotations

from math import nan

import pytest
from msgspec.structs import replace

from rosic.config.profiles import load_profile, shipped_profiles
from rosic.errors import NotUnderstood
from rosic.gateway.live_topics import LiveTopic, bound_topics, live_topic
from rosic.robots.ros2.profile import ros2_profile

OMNI = ros2_profile(load_profile(shipped_profiles()["omni"]))
TWIST = {
    "linear": {"x": 0.3, "y": -0.1, "z": 0.0},
    "angular": {"x": 0, "y": 0.0, "z": 0.5},
}


def topic(**message: float | str) -> LiveTopic:
    """Return omni's, with other fields in its binding."""
    drive = OMNI.skills["drive"]
    assert drive.topic is not None
    bound = replace(drive.topic, message=drive.topic.message | message)
    robot = replace(OMNI, skills={"drive": replace(drive, topic=bound)})
    found = live_topic([robot], "/omni/cmd_vel")
    assert found is not None
    return found


@pytest.mark.parametrize("name", ["/omni/cmd_vel", "omni/cmd_vel"])
@pytest.mark.parametrize("kind", ["", "geometry_msgs/msg/Twist", "geometry_msgs/Twist"])
def test_a_message_is_turned_into_parameters(name: str, kind: str) -> None:
    found = live_topic([OMNI], name, kind)
    assert found is not None
    assert (found.robot, found.skill) == ("omni", "drive")
    assert found.values(TWIST) == {"linear": 0.3, "lateral": -0.1, "angular": 0.5}
    assert found.values({"linear.x": 0.3, "angular.z": -1}) == {"linear": 0.3, "angular": -1}
    assert found.values({}) == {}


@pytest.mark.parametrize("name", ["/omni/odom", "/omni/cmd_vel2", "/cmd_vel", ""])
def test_what_no_skill_streams_to_is_none(name: str) -> None:
    assert live_topic([OMNI], name) is None


def test_another_type_is_said() -> None:
    with pytest.raises(NotUnderstood, match="/omni/cmd_vel is of the type geometry_msgs/msg/Twist"):
        live_topic([OMNI], "/omni/cmd_vel", "geometry_msgs/msg/TwistStamped")


@pytest.mark.parametrize(
    ("field", "value"),
    [
        *(("something.else", value) for value in (0.1, nan, "x", [1], True)),
        *(("linear.z", value) for value in (nan, "x", [1], True)),
        ("angular.x", nan),
    ],
)
def test_what_the_skill_does_not_send_has_to_be_zero(field: str, value: object) -> None:
    assert topic().values({"linear.x": 0.3, field: 0}) == {"linear": 0.3}
    with pytest.raises(NotUnderstood, match=f"{field} must be 0: omni is not driven by it here"):
        topic().values({"linear.x": 0.3, field: value})


@pytest.mark.parametrize("field", ["linear.z", "angular.x", "angular.y"])
def test_what_is_out_of_the_plane_of_a_base_is_left_out_and_told(field: str) -> None:
    message = {"linear.x": 0.3, "angular.z": 0.9, field: 0.9}
    assert topic().values(message) == {"linear": 0.3, "angular": 0.9}
    assert topic().ignored(message) == (field,)
    assert topic().ignored(TWIST) == ()


def test_what_might_change_the_way_is_refused_all_the_same() -> None:
    flies = topic(**{"linear.z": "$lateral"})
    assert flies.ignored({"angular.x": 0.9}) == ()
    with pytest.raises(NotUnderstood, match=r"angular\.x must be 0"):
        flies.values({"linear.x": 0.3, "angular.x": 0.9})
    drive = OMNI.skills["drive"]
    assert drive.topic is not None
    bound = replace(drive.topic, message={"linear.x": "$linear", "angular.z": "$angular"})
    narrow = replace(OMNI, skills={"drive": replace(drive, topic=bound)})
    base = live_topic([narrow], "/omni/cmd_vel")
    assert base is not None
    with pytest.raises(NotUnderstood, match=r"linear\.y must be 0"):
        base.values({"linear.x": 0.3, "linear.y": 0.3})


@pytest.mark.parametrize("value", [nan, 10**400, "0.3", True, None, [0.3]])
def test_what_is_no_number_is_said(value: object) -> None:
    with pytest.raises(NotUnderstood, match=r"linear\.x is no finite number"):
        topic().values({"linear.x": value})


def test_two_fields_of_one_parameter_agree() -> None:
    both = topic(**{"linear.z": "$linear"})
    assert both.values({"linear.x": 0.3, "linear.z": 0.3}) == {"linear": 0.3}
    with pytest.raises(NotUnderstood, match="differs from what it goes together with"):
        both.values({"linear.x": 0.3, "linear.z": 0.2})


def test_what_is_always_the_same_stays_so() -> None:
    fixed = topic(**{"linear.z": 0.25})
    assert fixed.values({"linear.z": 0.25, "linear.x": 0.1}) == {"linear": 0.1}
    for message in ({"linear.z": 0.2}, {"linear.x": 0.1}):
        with pytest.raises(NotUnderstood, match=r"linear.z must be 0.25"):
            fixed.values(message)


def test_the_header_of_a_message_is_ours() -> None:
    stamped = topic(**{"header.frame_id": "base"})
    header = {"stamp": {"sec": 7, "nanosec": 1}, "frame_id": "map"}
    assert stamped.values({"header": header, "linear.x": 0.1}) == {"linear": 0.1}


def test_what_is_nested_without_end_is_refused() -> None:
    message: dict[str, object] = {"x": 1.0}
    for _ in range(10_000):
        message = {"linear": message}
    with pytest.raises(NotUnderstood):
        topic().values(message)


def test_every_topic_that_moves_a_robot_is_known() -> None:
    assert bound_topics([OMNI]) == {"/omni/cmd_vel": ("omni", "drive")}
