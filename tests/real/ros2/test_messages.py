from __future__ import annotations

import math
from typing import TYPE_CHECKING

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rosic.robots.ros2.client.rclpy_import import load_ros
from rosic.robots.ros2.errors import BadName, BadValue
from rosic.robots.ros2.messages.coerce import clean_text
from rosic.robots.ros2.messages.decode import compile_path, plain
from rosic.robots.ros2.messages.encode import to_message
from rosic.robots.ros2.messages.names import parse_type_name
from rosic.robots.ros2.messages.types import TypeRegistry
from tests.real.ros2.conftest import TYPES

if TYPE_CHECKING:
    from rosic.robots.ros2.client.rclpy_import import RosObject

TWIST = "geometry_msgs/msg/Twist"
ODOMETRY = "nav_msgs/msg/Odometry"
JOINTS = "sensor_msgs/msg/JointState"


def make(name: str, /, **values: object) -> RosObject:
    return to_message(TypeRegistry(TYPES).message(name), values)


def wire(message: RosObject) -> RosObject:
    """What arrives at the other end of a topic."""
    serialization = load_ros().serialization
    return serialization.deserialize_message(
        serialization.serialize_message(message), type(message)
    )


def read(message: RosObject, path: str) -> object:
    cls: RosObject = type(message)
    return compile_path(cls, path)(message)


# ---- into a message ----


def test_whole_numbers_become_floats_where_a_float_is_wanted() -> None:
    message = wire(make(TWIST, linear={"x": 1}, **{"angular.z": -2}))
    assert (message.linear.x, message.angular.z) == (1.0, -2.0)
    assert type(message.linear.x) is float
    assert message.linear.y == 0.0


@pytest.mark.parametrize(
    ("value", "reason"),
    [
        (True, "must be a number, not yes or no"),
        ("1.0", "must be a number, not text"),
        (None, "must be a number, not nothing"),
        ([1.0], "must be a number, not a list"),
        (math.nan, "must be a finite number"),
        (math.inf, "must be a finite number"),
        (-math.inf, "must be a finite number"),
        (10**400, "is too large"),
        (2**53 + 1, "is too large to be exact"),
        (1j, "must be a number, not a complex"),
    ],
)
def test_a_velocity_is_a_finite_number_or_nothing(value: object, reason: str) -> None:
    with pytest.raises(BadValue) as caught:
        make(TWIST, **{"linear.x": value})
    assert str(caught.value) == f"geometry_msgs/msg/Twist: linear.x {reason}."


@pytest.mark.parametrize(
    ("name", "value", "reason"),
    [
        ("std_msgs/msg/Int32", 2**31, "must be between -2147483648 and 2147483647"),
        ("std_msgs/msg/Int32", -(2**31) - 1, "must be between -2147483648 and 2147483647"),
        ("std_msgs/msg/Int32", 2**40, "must be between -2147483648 and 2147483647"),
        ("std_msgs/msg/Int32", 1.0, "must be a whole number, not a number"),
        ("std_msgs/msg/Int32", True, "must be a whole number, not yes or no"),
        ("std_msgs/msg/Int32", "7", "must be a whole number, not text"),
        ("std_msgs/msg/UInt8", 256, "must be between 0 and 255"),
        ("std_msgs/msg/UInt8", -1, "must be between 0 and 255"),
        ("std_msgs/msg/Byte", 256, "must be one byte"),
        ("std_msgs/msg/Float32", 1e39, "is too large for single precision"),
        ("std_msgs/msg/String", 5, "must be text, not a whole number"),
        ("std_msgs/msg/String", b"x", "must be text, not bytes"),
        ("std_msgs/msg/String", "a\0b", "holds a null character"),
        ("std_msgs/msg/String", "a\ud800b", "holds a lone surrogate"),
        ("std_msgs/msg/String", "x" * 65_537, "is longer than 65536 bytes"),
    ],
)
def test_what_a_field_cannot_hold_is_refused(name: str, value: object, reason: str) -> None:
    with pytest.raises(BadValue) as caught:
        make(name, data=value)
    assert str(caught.value) == f"{name}: data {reason}."


@pytest.mark.parametrize(
    ("values", "reason"),
    [
        ({"liner.x": 1.0}, "it has no field 'liner'; did you mean linear?"),
        ({"linear.xx": 1.0}, "linear has no field 'xx'; did you mean x?"),
        ({"linear": 5}, "linear must be a set of fields, not a whole number."),
        ({"linear.x.y": 1.0}, "linear.x must be a number, not a set of fields."),
        ({"linear": {"x": 1.0}, "linear.x": 2.0}, "linear is given twice."),
        ({"linear.x": 2.0, "linear": {"x": 1.0}}, "linear is given twice."),
        ({"": 1.0}, "it has no field ''; it has angular, linear."),
        ({"_linear": {}}, "it has no field '_linear'; did you mean linear?"),
        ({"__class__": int}, "it has no field '__class__'; it has angular, linear."),
    ],
)
def test_a_field_that_is_not_there_names_its_neighbour(
    values: dict[str, object], reason: str
) -> None:
    with pytest.raises(BadValue) as caught:
        make(TWIST, **values)
    assert str(caught.value) == f"geometry_msgs/msg/Twist: {reason}"


@pytest.mark.parametrize(
    ("values", "reason"),
    [
        ({"position": [0.0, math.nan]}, "position.1 must be a finite number."),
        ({"position": "0.0"}, "position must be a list, not text."),
        ({"position": 1.0}, "position must be a list, not a number."),
        ({"position": [0.0] * 65_537}, "position must have at most 65536 entries, not 65537."),
        ({"name": ["a", 2]}, "name.1 must be text, not a whole number."),
        ({"header.stamp.nanosec": -1}, "header.stamp.nanosec must be between 0 and 4294967295."),
    ],
)
def test_a_list_is_checked_entry_by_entry(values: dict[str, object], reason: str) -> None:
    with pytest.raises(BadValue) as caught:
        make(JOINTS, **values)
    assert str(caught.value) == f"sensor_msgs/msg/JointState: {reason}"


def test_a_fixed_array_has_its_length() -> None:
    with pytest.raises(BadValue, match=r"pose\.covariance must have 36 entries, not 35"):
        make(ODOMETRY, **{"pose.covariance": [0.0] * 35})
    message = wire(make(ODOMETRY, **{"pose.covariance": list(range(36))}))
    assert read(message, "pose.covariance") == [float(index) for index in range(36)]


def test_bytes_fill_lists_of_bytes() -> None:
    image = wire(make("sensor_msgs/msg/CompressedImage", format="jpeg", data=b"\xff\xd8\x00"))
    assert read(image, "data") == b"\xff\xd8\x00"
    uuid = wire(make("unique_identifier_msgs/msg/UUID", uuid=bytes(range(16))))
    assert read(uuid, "uuid") == bytes(range(16))
    assert read(wire(make("std_msgs/msg/Byte", data=7)), "data") == 7


@given(st.floats(allow_nan=False, allow_infinity=False))
def test_every_finite_number_arrives_as_it_was(value: float) -> None:
    assert wire(make(TWIST, **{"angular.y": value})).angular.y == value


@given(st.integers(min_value=-(2**31), max_value=2**31 - 1))
def test_every_whole_number_in_range_arrives_as_it_was(value: int) -> None:
    assert wire(make("std_msgs/msg/Int32", data=value)).data == value


@given(st.text(alphabet=st.characters(codec=None), max_size=200))
def test_cleaned_text_always_arrives(text: str) -> None:
    cleaned = clean_text(text)
    assert wire(make("std_msgs/msg/String", data=cleaned)).data == cleaned


@given(
    st.recursive(
        st.none() | st.booleans() | st.integers() | st.floats() | st.text() | st.binary(),
        lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(), inner, max_size=3),
        max_leaves=8,
    ),
    st.sampled_from(["linear", "linear.x", "angular", "x", "linear.x.y", "..", "header"]),
)
def test_whatever_comes_is_taken_or_refused(value: object, path: str) -> None:
    try:
        message = make(TWIST, **{path: value})
    except BadValue:
        return
    numbers = [message.linear.x, message.linear.y, message.linear.z]
    assert all(type(number) is float and math.isfinite(number) for number in numbers)


# ---- out of a message ----


def test_a_path_leads_to_a_plain_value() -> None:
    message = make(ODOMETRY, **{"pose.pose.position.x": 0.5, "child_frame_id": "base"})
    assert read(message, "pose.pose.position.x") == 0.5
    assert read(message, "child_frame_id") == "base"
    assert read(message, "pose.covariance.35") == 0.0
    assert read(message, "pose.covariance[35]") == 0.0
    assert read(message, "pose.pose.position") == {"x": 0.5, "y": 0.0, "z": 0.0}
    whole = plain(message)
    assert isinstance(whole, dict)
    assert set(whole) == {"header", "child_frame_id", "pose", "twist"}


def test_a_list_is_read_whole_or_by_entry() -> None:
    message = make(JOINTS, name=["a", "b"], velocity=[0.25, -1])
    assert read(message, "velocity") == [0.25, -1.0]
    assert read(message, "velocity.1") == -1.0
    assert read(message, "name.0") == "a"
    with pytest.raises(BadValue, match=r"velocity\.2 is not there: the list has 2 entries"):
        read(message, "velocity.2")


def test_what_a_robot_does_not_measure_is_still_read() -> None:
    message = wire(make("sensor_msgs/msg/BatteryState"))
    message.percentage = math.nan
    value = read(message, "percentage")
    assert isinstance(value, float)
    assert math.isnan(value)


@pytest.mark.parametrize(
    ("name", "path", "shape"),
    [
        (JOINTS, "velocity", "list"),
        (JOINTS, "velocity.0", "number"),
        (JOINTS, "name.0", "text"),
        (JOINTS, "header", "record"),
        (JOINTS, "", "record"),
        ("sensor_msgs/msg/BatteryState", "present", "truth"),
        ("sensor_msgs/msg/CompressedImage", "data", "bytes"),
        ("std_msgs/msg/Int32", "data", "number"),
    ],
)
def test_a_path_is_known_before_anything_arrives(name: str, path: str, shape: str) -> None:
    assert compile_path(TypeRegistry(TYPES).message(name), path).shape == shape


@pytest.mark.parametrize(
    ("path", "sentence"),
    [
        ("velocty", "velocty: sensor_msgs/msg/JointState has no velocty; did you mean velocity?"),
        (
            "header.stamp.secs",
            "header.stamp.secs: builtin_interfaces/msg/Time has no secs; did you mean sec?",
        ),
        ("velocity.x", "velocity.x: x stands below a list, which needs an entry first, such as 0."),
        ("velocity.0.x", "velocity.0.x: nothing lies below a plain value, so x is too much."),
        ("header.", "'header.' is not a path to a field; one looks like pose.pose.position.x."),
        ("__class__", "'__class__' is not a path to a field; one looks like pose.pose.position.x."),
        (
            "velocity.-1",
            "'velocity.-1' is not a path to a field; one looks like pose.pose.position.x.",
        ),
    ],
)
def test_a_path_that_leads_nowhere_says_where_it_should(path: str, sentence: str) -> None:
    with pytest.raises(BadName) as caught:
        compile_path(TypeRegistry(TYPES).message(JOINTS), path)
    assert str(caught.value) == sentence


def test_an_entry_beyond_a_fixed_array_is_refused_at_once() -> None:
    with pytest.raises(BadName, match="the list has only 36 entries"):
        compile_path(TypeRegistry(TYPES).message(ODOMETRY), "pose.covariance.36")


# ---- names and text ----


@pytest.mark.parametrize(
    "name",
    [
        "",
        "Twist",
        "geometry_msgs/Twist",
        "geometry_msgs.msg.Twist",
        "geometry_msgs/msg/twist",
        "os/path/Join",
        "../msg/Twist",
        "geometry_msgs/msg/Twist\n",
        "os.system/msg/Twist",
        "geometry__msgs/msg/Twist",
        "a" * 300 + "/msg/Twist",
    ],
)
def test_only_names_of_types_are_names_of_types(name: str) -> None:
    with pytest.raises(BadName, match="is not the name of a ROS type"):
        TypeRegistry([name])


@pytest.mark.parametrize(
    ("name", "sentence"),
    [
        ("geometry_msgs/msg/Twits", "geometry_msgs has no msg named Twits; did you mean Twist?"),
        ("nobody_msgs/msg/Twist", "The ROS package nobody_msgs is not installed here"),
    ],
)
def test_a_type_that_is_not_installed_says_so(name: str, sentence: str) -> None:
    with pytest.raises(BadName) as caught:
        TypeRegistry([name]).message(name)
    assert str(caught.value).startswith(sentence)


def test_a_type_of_another_kind_is_refused() -> None:
    types = TypeRegistry(TYPES)
    with pytest.raises(BadName, match="one of kind srv is needed here"):
        types.service(TWIST)
    types.message(TWIST)
    with pytest.raises(BadName, match="one of kind srv is needed here"):
        types.service(TWIST)
    assert str(parse_type_name(TWIST)) == TWIST


def test_text_from_a_chat_is_made_fit_for_ros() -> None:
    assert clean_text("go\tto\x00 the\x1b[2J door\u202e!\nnow \ud83d") == (
        "go to  the [2J door!\nnow \N{REPLACEMENT CHARACTER}"
    )
    assert clean_text("größer 東 🤖") == "größer 東 🤖"
    assert clean_text("東" * 10, max_bytes=8) == "東東"
    assert len(clean_text("x" * 100_000)) == 4096
