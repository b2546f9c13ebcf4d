"""The forms and bounds of what a profile says, for the check and for the published schema."""

from __future__ import annotations

from typing import Final

from rosic.contracts.file_rules import Field, FieldForm, NumberBounds
from rosic.core.robot.alert_config import AlertConfig
from rosic.core.robot.benchmark import Benchmark, ErrorBound
from rosic.core.robot.geography import GeographicFrame
from rosic.core.robot.joints import Joints
from rosic.core.robot.profile import (
    AtRest,
    Camera,
    Deliver,
    Files,
    Link,
    MapSource,
    PathSource,
    PoseSource,
    Profile,
    ReceiptSource,
    StopBinding,
    Telemetry,
)
from rosic.core.robot.skill import (
    COST_MAX,
    ActionBinding,
    Parameter,
    ParametersBinding,
    ServiceBinding,
    Skill,
    TopicBinding,
    Trajectory,
)
from rosic.core.robot.strategy import Strategy
from rosic.core.time_units import DAY_S, HOUR_S

_NAME = r"[a-z][a-z0-9_]{0,31}"
_GRAPH_NAME = r"/[A-Za-z_][A-Za-z0-9_]*(/[A-Za-z_][A-Za-z0-9_]*)*"
_FIELD_PATH = r"[a-z][a-z0-9_]*(\.[a-z0-9_]+|\[[0-9]+\])*"


def _ros_type(kind: str, example: str) -> FieldForm:
    return FieldForm(
        rf"[a-z][a-z0-9_]*/{kind}/[A-Z][A-Za-z0-9]*",
        f"a ROS {'message' if kind == 'msg' else 'service' if kind == 'srv' else kind} type",
        f"Write package/{kind}/Type, for example {example}.",
    )


NAMED = FieldForm(
    _NAME, "a name", "Use small letters, digits and _, a letter first, at most 32 characters."
)
WORD = FieldForm(
    r"[^\sA-Z,;=:]{1,32}( [^\sA-Z,;=:]{1,32}){0,3}",
    "a word people type",
    "Use at most four words in small letters, each of at most 32 characters.",
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

_FOLDER = FieldForm(
    r"/[^\x00-\x1f\x7f]{1,500}",
    "a folder's full path",
    "Begin with a slash: /srv/omni/inbox.",
    empty=True,
)
_SORT = FieldForm(
    "png|jpeg|pdf|pgm|zip|gzip|mcap|db3|yaml|json|csv|text",
    "a kind of file",
    "Use png, jpeg, pdf, pgm, zip, gzip, mcap, db3, yaml, json, csv or text.",
)
_LINE = FieldForm(
    r"[^\x00-\x1f\x7f]{1,120}", "a line of text", "Use 1 to 120 characters of one line."
)
_LENGTH = FieldForm(
    r" *\d+(\.\d+)? *[a-z]+ *", "a length of time", "Write a number and a unit: 10 s, 2 min."
)

FORMS: Final[dict[Field, FieldForm]] = {
    (AlertConfig, "name"): NAMED,
    (AlertConfig, "when"): _LINE,
    (AlertConfig, "clear"): _LINE._replace(empty=True),
    (AlertConfig, "lasting"): _LENGTH,
    (AlertConfig, "say"): _LINE._replace(empty=True),
    (AlertConfig, "escalate_after"): _LENGTH._replace(empty=True),
    (AlertConfig, "run"): _LINE._replace(empty=True),
    (AlertConfig, "author"): _LINE._replace(empty=True),
    (AlertConfig, "run_every"): _LENGTH,
    (Benchmark, "per_s"): NAMED,
    (Benchmark, "battery"): NAMED,
    (Benchmark, "errors"): NAMED,
    (ErrorBound, "measured"): FieldForm(
        rf"{_NAME}|pose\.(x|y|yaw)",
        "something that is measured",
        "Write a fact that the robot reports, as distance_m, or pose.x, pose.y, pose.yaw.",
    ),
    (Profile, "id"): NAMED,
    (Profile, "groups"): NAMED,
    (Profile, "words"): WORD,
    (Profile, "go_to"): FieldForm(
        rf"{_NAME} {_NAME} {_NAME}",
        "a skill and two of its parameters",
        "Write the skill, then what it calls x and y: goto x y.",
        empty=True,
    ),
    (Profile, "skills"): NAMED,
    (Profile, "telemetry"): NAMED,
    (Skill, "words"): WORD,
    (Skill, "parameters"): NAMED,
    (Parameter, "choices"): WORD,
    (Parameter, "means"): WORD._replace(empty=True),
    (Profile, "strategies"): NAMED,
    (Strategy, "parameters"): NAMED,
    (Link, "kind"): NAMED,
    (Link, "namespace"): _GRAPH._replace(pattern=rf"/|{_GRAPH_NAME}", empty=True),
    (StopBinding, "service"): _GRAPH_OR_NONE,
    (StopBinding, "type"): _SERVICE,
    (StopBinding, "request"): _PATH,
    (StopBinding, "zero"): _GRAPH_OR_NONE,
    (StopBinding, "zero_type"): _MESSAGE,
    (AtRest, "topic"): _GRAPH,
    (AtRest, "type"): _MESSAGE,
    (AtRest, "field"): _PATHS,
    (AtRest, "stop_only"): _PATHS._replace(empty=True),
    (Telemetry, "topic"): _GRAPH_OR_NONE,
    (Telemetry, "type"): _MESSAGE._replace(empty=True),
    (Telemetry, "field"): _PATH_OR_NONE,
    (Camera, "topic"): _GRAPH,
    (Files, "accept"): _SORT,
    (Files, "inbox"): _FOLDER,
    (Files, "outbox"): _FOLDER,
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
    (ActionBinding, "success"): _PATH_OR_NONE,
    (ActionBinding, "message"): _PATH_OR_NONE,
    (ParametersBinding, "node"): _GRAPH,
}

BOUNDS: Final[dict[Field, NumberBounds]] = {
    (GeographicFrame, "latitude"): NumberBounds(-85, 85),
    (GeographicFrame, "longitude"): NumberBounds(-180, 180),
    (GeographicFrame, "heading_deg"): NumberBounds(-360, 360),
    (Profile, "queue_length"): NumberBounds(1, 10_000),
    (Profile, "watchdog_s"): NumberBounds(0.05, 5),
    (Profile, "rest_timeout_s"): NumberBounds(0.1, 120),
    (Link, "heartbeat_s"): NumberBounds(0.1, HOUR_S),
    (Files, "max_mb"): NumberBounds(0.001, 2_000),
    (ReceiptSource, "within_s"): NumberBounds(0.1, 600),
    (Benchmark, "late"): NumberBounds(1.01, 1000),
    (Telemetry, "full"): NumberBounds(1, 1000),
    (AtRest, "below"): NumberBounds(1e-6, 10),
    (AtRest, "within_s"): NumberBounds(0.1, 60),
    (Skill, "lifetime_s"): NumberBounds(0.1, HOUR_S),
    (Skill, "cost"): NumberBounds(1, COST_MAX),
    (TopicBinding, "stream_hz"): NumberBounds(0, 100),
    (ServiceBinding, "timeout_s"): NumberBounds(0.05, 600),
    (ActionBinding, "timeout_s"): NumberBounds(0.05, DAY_S),
    (ParametersBinding, "timeout_s"): NumberBounds(0.05, 600),
}

HIDDEN: Final[frozenset[Field]] = frozenset({(Skill, "id")})
