"""The forms and bounds of what a profile says of ROS, and the schema of this kind of link."""

from __future__ import annotations

from typing import Final

from rosic.contracts.adapter import ProfileSchema, no_advice, shares_nothing
from rosic.contracts.file_rules import Field, FieldForm, NumberBounds, Rule, Rules
from rosic.core.time_units import DAY_S
from rosic.robots.ros2.joints import Joints
from rosic.robots.ros2.profile import (
    ActionBinding,
    AnswerFields,
    AtRest,
    Camera,
    Deliver,
    MapSource,
    ParametersBinding,
    PathSource,
    PoseSource,
    ReceiptSource,
    Ros2Files,
    Ros2Link,
    Ros2Profile,
    Ros2Skill,
    Ros2Telemetry,
    ServiceBinding,
    StopBinding,
    TopicBinding,
    Trajectory,
)
from rosic.robots.ros2.profile_checks import (
    advice,
    among,
    delivered,
    fitting_booleans,
    located,
    moved,
    of_one_type,
    reached,
    reaches,
    said_stop,
    stoppable,
    streamed,
    watched,
)

_NAME: Final = r"[a-z][a-z0-9_]{0,31}"
_GRAPH_NAME = r"/[A-Za-z_][A-Za-z0-9_]*(/[A-Za-z_][A-Za-z0-9_]*)*"
_FIELD_PATH = r"[a-z][a-z0-9_]*(\.[a-z0-9_]+|\[[0-9]+\])*"


def _ros_type(kind: str, example: str) -> FieldForm:
    return FieldForm(
        rf"[a-z][a-z0-9_]*/{kind}/[A-Z][A-Za-z0-9]*",
        f"a ROS {'message' if kind == 'msg' else 'service' if kind == 'srv' else kind} type",
        f"Write package/{kind}/Type, for example {example}.",
    )


_GRAPH = FieldForm(_GRAPH_NAME, "a ROS name", "Write it from the root, for example /omni/odom.")
_GRAPH_OR_NONE = _GRAPH._replace(empty=True)
_MESSAGE = _ros_type("msg", "geometry_msgs/msg/Twist")
_SERVICE = _ros_type("srv", "std_srvs/srv/Trigger")
_FRAMES = FieldForm(
    r"sensor_msgs/msg/(Compressed)?Image",
    "a type of camera frames",
    "Write sensor_msgs/msg/CompressedImage or sensor_msgs/msg/Image.",
)
_GRIDS = FieldForm(
    r"nav_msgs/msg/OccupancyGrid", "a type of maps", "Write nav_msgs/msg/OccupancyGrid."
)
_POSES = FieldForm(
    r"nav_msgs/msg/Odometry|geometry_msgs/msg/Pose(WithCovariance)?Stamped",
    "a type that says where a robot is",
    "Write nav_msgs/msg/Odometry, geometry_msgs/msg/PoseStamped or "
    "geometry_msgs/msg/PoseWithCovarianceStamped.",
)
_STATES = FieldForm(
    r"sensor_msgs/msg/JointState",
    "a type that says where joints are",
    "Write sensor_msgs/msg/JointState.",
)
_PLACEHOLDER = FieldForm(
    rf"\$({_NAME})(\.{_NAME})?",
    "a parameter",
    "Write $angle, or $pose.joints for what a choice means.",
)
_WAYS = FieldForm(r"nav_msgs/msg/Path", "a type of planned paths", "Write nav_msgs/msg/Path.")
_ACTION = _ros_type("action", "rosic_interfaces/action/Move")
_PATH = FieldForm(
    _FIELD_PATH, "a field of a message", "Join fields by dots, as in twist.twist.linear.x."
)
_PATHS = _PATH._replace(pattern=rf"{_FIELD_PATH}( *, *{_FIELD_PATH})*")
_PATH_OR_NONE = _PATH._replace(empty=True)

FORMS: Final[dict[Field, FieldForm]] = {
    (Ros2Link, "namespace"): _GRAPH._replace(pattern=rf"/|{_GRAPH_NAME}", empty=True),
    (StopBinding, "service"): _GRAPH_OR_NONE,
    (StopBinding, "type"): _SERVICE,
    (StopBinding, "request"): _PATH,
    (StopBinding, "release"): _PATH,
    (StopBinding, "zero"): _GRAPH_OR_NONE,
    (StopBinding, "zero_type"): _MESSAGE,
    (AtRest, "topic"): _GRAPH,
    (AtRest, "type"): _MESSAGE,
    (AtRest, "field"): _PATHS,
    (AtRest, "stop_only"): _PATHS._replace(empty=True),
    (Ros2Telemetry, "topic"): _GRAPH_OR_NONE,
    (Ros2Telemetry, "type"): _MESSAGE._replace(empty=True),
    (Ros2Telemetry, "field"): _PATH_OR_NONE,
    (Camera, "topic"): _GRAPH,
    (Deliver, "digest"): _PATH_OR_NONE,
    (ReceiptSource, "topic"): _GRAPH,
    (ReceiptSource, "type"): _MESSAGE,
    (ReceiptSource, "field"): _PATH,
    (Camera, "type"): _FRAMES,
    (MapSource, "topic"): _GRAPH,
    (MapSource, "type"): _GRIDS,
    (PoseSource, "topic"): _GRAPH,
    (PoseSource, "type"): _POSES,
    (PathSource, "topic"): _GRAPH,
    (PathSource, "type"): _WAYS,
    (TopicBinding, "name"): _GRAPH,
    (TopicBinding, "type"): _MESSAGE,
    (TopicBinding, "message"): _PATH,
    (ServiceBinding, "name"): _GRAPH,
    (ServiceBinding, "type"): _SERVICE,
    (ServiceBinding, "request"): _PATH,
    (AnswerFields, "success"): _PATH_OR_NONE,
    (AnswerFields, "message"): _PATH_OR_NONE,
    (AnswerFields, "codes"): FieldForm(r"-?[0-9]{1,10}", "a code", "Write a number: 3."),
    (ActionBinding, "name"): _GRAPH,
    (ActionBinding, "type"): _ACTION,
    (ActionBinding, "goal"): _PATH,
    (ActionBinding, "start"): _PATH_OR_NONE,
    (ActionBinding, "remaining"): _PATH_OR_NONE,
    (Trajectory, "to"): _PLACEHOLDER,
    (Trajectory, "joint"): _PLACEHOLDER._replace(empty=True),
    (Joints, "topic"): _GRAPH,
    (Joints, "type"): _STATES,
    (ActionBinding, "fraction"): _PATH_OR_NONE,
    (ActionBinding, "stage"): _PATH_OR_NONE,
    (ParametersBinding, "node"): _GRAPH,
}

BOUNDS: Final[dict[Field, NumberBounds]] = {
    (ReceiptSource, "within_s"): NumberBounds(0.1, 600),
    (AtRest, "below"): NumberBounds(1e-6, 10),
    (AtRest, "within_s"): NumberBounds(0.1, 60),
    (TopicBinding, "stream_hz"): NumberBounds(0, 100),
    (ServiceBinding, "timeout_s"): NumberBounds(0.05, 600),
    (ActionBinding, "timeout_s"): NumberBounds(0.05, DAY_S),
    (ParametersBinding, "timeout_s"): NumberBounds(0.05, 600),
}

_PARTS: Final[dict[type, tuple[Rule, ...]]] = {
    Ros2Telemetry: (located,),
    Ros2Files: (delivered,),
    Ros2Skill: (streamed, fitting_booleans),
}
_ALONE: Final[tuple[Rule, ...]] = (watched, said_stop, moved)

SCHEMA: Final = ProfileSchema(
    profile=Ros2Profile,
    rules=Rules(
        bounds=BOUNDS,
        forms=FORMS,
        hidden=frozenset(),
        checks=_PARTS | {Ros2Profile: (reached, *_ALONE, stoppable, of_one_type, among)},
    ),
    advice=advice,
    reaches=reaches,
)

# For a link whose robots stand in for those of a graph, from the same file: what it says has to be
# right, and nobody is looked for on a graph.
STAND_IN: Final = SCHEMA._replace(
    rules=SCHEMA.rules._replace(checks=_PARTS | {Ros2Profile: _ALONE}),
    advice=no_advice,
    reaches=shares_nothing,
)
