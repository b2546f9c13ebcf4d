"""What a profile says of a robot on a ROS 2 graph, besides what every robot has."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

import msgspec

from rosic.core.robot.profile import Files, Link, Profile, Telemetry
from rosic.core.robot.skill import DURATION, Argument, Sent, Skill
from rosic.errors import ConfigurationError
from rosic.robots.ros2.joints import Joints

# One message of these keeps a robot moving until something else is said.
VELOCITIES: Final = frozenset({"geometry_msgs/msg/Twist", "geometry_msgs/msg/TwistStamped"})

LIVE_HZ: Final = 500.0
"""Samples at 200 Hz come in no even step: at twice that none has to wait."""
LIVE_MOST_HZ: Final = 2_000.0

# ---- how a skill is carried out ----


class TopicBinding(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Publish a message. Nothing acknowledges a topic.

    Attributes:
        message: Dotted field to a value; ``$name`` takes a parameter (SI), ``$name.x`` a number
            that a choice stands for; else it is literal.
        stream_hz: Greater than 0 sends a bounded stream for ``$duration`` seconds that ends in
            zero; allowed only when the profile states the robot's own ``watchdog_s``.
        live_hz: Driven live, each sample is sent when it comes, at most so often; and the newest
            again ``stream_hz`` times a second.
    """

    name: str
    type: str
    message: dict[str, float | int | str | bool] = {}
    stream_hz: float = 0.0
    live_hz: float = LIVE_HZ

    def __post_init__(self) -> None:
        if self.stream_hz > 0 and not self.stream_hz <= self.live_hz <= LIVE_MOST_HZ:
            raise ValueError(f"live_hz must be at least stream_hz and at most {LIVE_MOST_HZ:g}")

    @property
    def keeps_moving(self) -> bool:
        """Whether one message keeps a robot moving until something else is said."""
        return self.stream_hz > 0 or self.type in VELOCITIES


class AnswerFields(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What an answer is read by.

    Attributes:
        success: Field that says whether: ``success`` where the answer has it, or a code.
        good: What it says then: true, the number of a code that means success, mostly 0, or a word.
        codes: What other codes mean, in words.
        message: Field that says what.
    """

    success: str = "success"
    good: bool | int | str = True
    codes: dict[str, str] = {}
    message: str = "message"


class ServiceBinding(AnswerFields, frozen=True, kw_only=True):
    """Call a service; its answer is the robot's receipt."""

    name: str
    type: str
    request: dict[str, float | int | str | bool] = {}
    timeout_s: float = 5.0


class Trajectory(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A move of an arm, made of where its joints are and of where they are to go.

    Attributes:
        to: ``$pose.joints``, a pose by the meaning of a choice; or ``$angle``, for one joint.
        joint: ``$joint``: the one that moves while the others stay; empty: all of them.
        speed: Share of every joint's own speed, in (0, 1]; or ``$speed``.
    """

    to: str
    joint: str = ""
    speed: float | str = 0.3

    def __post_init__(self) -> None:
        if isinstance(self.speed, str):
            if self.speed[:1] != "$":
                raise ValueError("speed is a share of the joints' own, or a parameter: $speed")
        elif not 0 < self.speed <= 1:
            raise ValueError("speed is a share of the joints' own: above 0, at most 1")


class ActionBinding(AnswerFields, frozen=True, kw_only=True):
    """Send an action goal. Acceptance is the receipt, feedback the progress, the result the end.

    Attributes:
        timeout_s: Longest time between acceptance and result; then the goal is cancelled.
        start: Goal field of type ``builtin_interfaces/Time`` that takes a common start, or empty.
        remaining: Feedback field that shrinks to zero on the way, instead of ``fraction``.
        trajectory: Makes the goal of a trajectory controller; the profile then has ``joints``.
    """

    name: str
    type: str
    goal: dict[str, float | int | str | bool] = {}
    trajectory: Trajectory | None = None
    timeout_s: float = 120.0
    start: str = ""
    fraction: str = "fraction"
    stage: str = "stage"
    remaining: str = ""


class ParametersBinding(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Set ROS parameters of a node; the node's answer is the receipt, and they are read back."""

    node: str
    values: dict[str, float | int | str | bool]
    timeout_s: float = 5.0


class Ros2Skill(Skill, frozen=True, kw_only=True):
    """One thing a robot can do, and what carries it out: at most one of four."""

    topic: TopicBinding | None = None
    service: ServiceBinding | None = None
    action: ActionBinding | None = None
    set_parameters: ParametersBinding | None = None

    def __post_init__(self) -> None:
        bindings = (self.topic, self.service, self.action, self.set_parameters)
        if sum(binding is not None for binding in bindings) > 1:
            raise ValueError("a skill has at most one of topic, service, action, set_parameters")
        super().__post_init__()

    @property
    def sent(self) -> Sent:
        """What its topic, service, action or parameters are sent."""
        place, values, besides = super().sent[:3]
        if self.topic is not None:
            place, values = ("topic", "message"), self.topic.message
            besides = (DURATION,) if self.topic.keeps_moving else ()
        elif self.service is not None:
            place, values = ("service", "request"), self.service.request
        elif self.action is not None:
            place = ("action", "goal")
            values = self.action.goal | of_trajectory(self.action.trajectory)
        elif self.set_parameters is not None:
            place, values = ("set_parameters", "values"), self.set_parameters.values
        topic, endpoint, kind = "", "", ""
        if self.topic is not None:
            topic, kind = self.topic.name, self.topic.type
        elif (called := self.service or self.action) is not None:
            endpoint, kind = called.name, called.type
        return Sent(place, values, besides, "a topic, service or action", topic, kind, endpoint)

    @property
    def streams(self) -> bool:
        """Whether its topic is sent to again and again."""
        return self.topic is not None and self.topic.stream_hz > 0

    def sets(self, arguments: Mapping[str, Argument]) -> dict[str, float | int | str | bool]:
        """Return the parameters that it sets, each with its node; else as for every robot."""
        if self.set_parameters is None:
            return super().sets(arguments)
        node = self.set_parameters.node
        return {
            f"{node}:{name}": self._setting(value, arguments)
            for name, value in self.set_parameters.values.items()
        }

    def _setting(
        self, value: float | str | bool, arguments: Mapping[str, Argument]
    ) -> float | int | str | bool:
        meaning = self.filled(value, arguments)
        if not isinstance(meaning, tuple):
            return meaning
        return str(arguments[str(value)[1:].partition(".")[0]])  # a row of numbers, by its word


def of_trajectory(trajectory: Trajectory | None) -> dict[str, float | int | str | bool]:
    """Return what a trajectory is made of, by its key in the file."""
    if trajectory is None:
        return {}
    return {"to": trajectory.to, "joint": trajectory.joint, "speed": trajectory.speed}


# ---- how it is stopped, and how its rest is measured ----


class StopBinding(AnswerFields, frozen=True, kw_only=True):
    """How the robot is stopped besides cancelling its goals.

    Attributes:
        service, type: A service, ``std_srvs/srv/Trigger`` for one.
        request: Fields of its request, every one that its type has: what a field says when nobody
            says anything, a brake may take for "release". Empty for a service without any.
        release: For a stop that holds until it is told otherwise: the same fields, as they release
            it. Sent by a resume, and before an order where no stop was meant: what ROSIC itself
            broke off or cancelled, in an earlier run, too. Empty: it holds nothing.
        zero: A velocity topic that is sent zero, and its type.
        cancel_only: This robot has neither, and holds when all its goals are cancelled.
    """

    service: str = ""
    type: str = "std_srvs/srv/Trigger"
    request: dict[str, float | int | str | bool] = {}
    release: dict[str, float | int | str | bool] = {}
    zero: str = ""
    zero_type: str = "geometry_msgs/msg/Twist"
    cancel_only: bool = False

    def __post_init__(self) -> None:
        if self.cancel_only and (self.service or self.zero):
            raise ValueError("cancel_only means that there is neither a service nor a zero")
        if self.release and not self.service:
            raise ValueError("'release' is said to the stop's service, and there is none")
        if self.release and self.release.keys() != self.request.keys():
            raise ValueError("'release' has to say every field that request says")
        if self.release and self.release == self.request:
            raise ValueError("'release' says what request says: that would stop it again")


class AtRest(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """How rest is measured: every number in ``field`` is at most ``below`` in magnitude.

    ``field`` is a dotted path; several, separated by commas, must all hold. ``stop_only`` names
    those of them that count for a stop alone, and not for whether it is ready for an order: the
    height of a drone, which ends a stop on the ground and takes orders where it hovers. What is
    older than ``within_s`` says nothing of now: without it nothing moves, and what is driven by
    velocities is driven no further.
    """

    topic: str
    type: str
    field: str
    below: float
    stop_only: str = ""
    within_s: float = 1.0

    def __post_init__(self) -> None:
        if self.stop_only and not set(self.counting_for_stops) < set(self.fields):
            raise ValueError("what stop_only names has to be some of the fields, and not all")

    @property
    def fields(self) -> tuple[str, ...]:
        """Return every field, in order."""
        return tuple(path.strip() for path in self.field.split(","))

    @property
    def counting_for_stops(self) -> tuple[str, ...]:
        """Return the fields that count for stops alone."""
        return tuple(path.strip() for path in self.stop_only.split(",")) if self.stop_only else ()


# ---- what it reports and shows ----


class Ros2Telemetry(Telemetry, frozen=True, kw_only=True):
    """One value the robot reports, and where; only the newest is kept."""

    topic: str = ""
    type: str = ""
    field: str = ""


class Camera(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Where pictures come from; whoever may read the robot may then ask for them."""

    topic: str
    type: str = "sensor_msgs/msg/CompressedImage"


class MapSource(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Where the map comes from."""

    topic: str
    type: str = "nav_msgs/msg/OccupancyGrid"


class PoseSource(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What says where the robot is: on the map, and on its way."""

    topic: str
    type: str = "nav_msgs/msg/Odometry"


class PathSource(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What says where the robot means to go."""

    topic: str
    type: str = "nav_msgs/msg/Path"


# ---- files ----


class ReceiptSource(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Where the robot's side says which file it has read: its SHA-256, in hexadecimal digits.

    Attributes:
        within_s: Later than this it counts as not said.
    """

    topic: str
    type: str = "std_msgs/msg/String"
    field: str = "data"
    within_s: float = 10.0


class Deliver(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """How the robot's side is handed a file: a topic or a service, one of them.

    In a message or a request stand ``$name``, ``$path`` (in the inbox), ``$sha256``, ``$size``,
    ``$kind``, and for small files ``$text`` or ``$content``.

    Attributes:
        digest: Field of the service's response with the SHA-256 of what it read; empty for none.
        receipt: The same for a topic, on a topic of the robot's own.
    """

    topic: TopicBinding | None = None
    service: ServiceBinding | None = None
    digest: str = ""
    receipt: ReceiptSource | None = None

    @property
    def sent(self) -> dict[str, float | int | str | bool]:
        """What stands in the message or the request."""
        binding = self.topic.message if self.topic is not None else None
        return binding if binding is not None else self.service.request if self.service else {}

    @property
    def carries(self) -> bool:
        """Whether the content itself is in it."""
        return bool({"$text", "$content"} & set(map(str, self.sent.values())))


class Ros2Files(Files, frozen=True, kw_only=True):
    """Which files the robot takes, and how its side is handed them."""

    deliver: Deliver | None = None

    @property
    def carries(self) -> bool:
        """Whether the content itself goes to the robot's side."""
        return self.deliver is not None and self.deliver.carries


# ---- all of it ----


class Ros2Link(Link, frozen=True, kw_only=True):
    """How the robot is reached.

    Attributes:
        kind: Name of a robot adapter: ``ros2``, ``simulated``, ``memory``.
        namespace: ROS namespace, for presence: ``/kuka1``; ``/`` for a robot alone on its graph.
        model: For ``simulated``: which machine.
        dialogue: The paper's text link over ``to_robot_topic`` and ``from_robot_topic``.
        among: The robot's own nodes speak with other robots, over ``among/say`` and ``among/hear``.
    """

    namespace: str = ""
    model: str = ""
    dialogue: bool = False
    among: bool = False


class Ros2Profile(Profile, frozen=True, kw_only=True):
    """Everything ROSIC knows about one robot on a ROS 2 graph.

    Attributes:
        watchdog_s: The robot's own time-out for a velocity topic; without it no skill may stream.
        joints: What a trajectory controller moves; skills with a ``trajectory`` need it.
    """

    link: Ros2Link
    stop: StopBinding | None = None
    at_rest: AtRest | None = None
    joints: Joints | None = None
    skills: Mapping[str, Ros2Skill] = {}
    telemetry: Mapping[str, Ros2Telemetry] = {}
    camera: Camera | None = None
    map: MapSource | None = None
    pose: PoseSource | None = None
    path: PathSource | None = None
    files: Ros2Files | None = None


def ros2_profile(profile: Profile) -> Ros2Profile:
    """Return a profile that is written for this link.

    Raises:
        ConfigurationError: It is written for a link of another kind.
    """
    if isinstance(profile, Ros2Profile):
        return profile
    raise ConfigurationError(
        f"{profile.id}: its profile is written for a link of another kind.",
        hint="Read it with link.kind: ros2.",
    )
