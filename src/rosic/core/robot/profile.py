"""A robot is one file: what it is, how it is reached, what it can do, how it stops."""

from __future__ import annotations

import enum
import re
from typing import TypeAlias

import msgspec

from rosic.core.robot.alert_config import AlertConfig
from rosic.core.robot.geography import GeographicFrame
from rosic.core.robot.joints import Joints
from rosic.core.robot.skill import MOTION, ServiceBinding, Skill, TopicBinding
from rosic.core.robot.strategy import Strategy
from rosic.core.robot.view import Pose, ViewKind

RobotId: TypeAlias = str

QUEUE_AT_MOST = 10_000
ROBOT_ID = re.compile(r"[a-z][a-z0-9_]{0,31}\Z")


class Busy(enum.Enum):
    """What happens to an order for a robot that is at work."""

    __hash__ = object.__hash__  # Enum hashes the name, in Python, every time

    REFUSE = "refuse"
    QUEUE = "queue"
    REPLACE = "replace"


class LinkLoss(enum.Enum):
    """What the robot itself does when it hears nothing more; ROSIC only says so."""

    __hash__ = object.__hash__  # Enum hashes the name, in Python, every time

    HOLD = "hold"
    LAND = "land"
    RETURN = "return"
    CONTINUE = "continue"


class Link(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """How the robot is reached.

    Attributes:
        kind: Name of a robot adapter: ``ros2``, ``simulated``, ``memory``.
        namespace: ROS namespace, for presence: ``/kuka1``; ``/`` for a robot alone on its graph.
        model: For ``simulated``: which machine.
        dialogue: The paper's text link over ``to_robot_topic`` and ``from_robot_topic``.
        among: The robot's own nodes speak with other robots, over ``among/say`` and ``among/hear``.
        heartbeat_s: A robot whose telemetry is older than this is offline.
    """

    kind: str
    namespace: str = ""
    model: str = ""
    dialogue: bool = False
    among: bool = False
    heartbeat_s: float = 3.0


class Slots(enum.Enum):
    """What booked times mean for a robot.

    ``none``: nothing. ``respected``: in somebody's time nobody else moves it. ``required``: it
    moves only in a time of one's own.
    """

    __hash__ = object.__hash__  # Enum hashes the name, in Python, every time

    NONE = "none"
    RESPECTED = "respected"
    REQUIRED = "required"


class StopBinding(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """How the robot is stopped besides cancelling its goals.

    Attributes:
        service, type: A service, ``std_srvs/srv/Trigger`` for one.
        request: Fields of its request, every one that its type has: what a field says when nobody
            says anything, a brake may take for "release". Empty for a service without any.
        zero: A velocity topic that is sent zero, and its type.
        cancel_only: This robot has neither, and holds when all its goals are cancelled.
    """

    service: str = ""
    type: str = "std_srvs/srv/Trigger"
    request: dict[str, float | int | str | bool] = {}
    zero: str = ""
    zero_type: str = "geometry_msgs/msg/Twist"
    cancel_only: bool = False

    def __post_init__(self) -> None:
        if self.cancel_only and (self.service or self.zero):
            raise ValueError("cancel_only means that there is neither a service nor a zero")


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


class Telemetry(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """One value the robot reports; only the newest is kept.

    Attributes:
        full: What a share, with the unit ``%``, is reported as when it is whole: 100 for a battery
            that says 0 to 100, against the definition of its message.
    """

    topic: str = ""
    type: str = ""
    field: str = ""
    unit: str = ""
    alert_below: float | None = None
    full: float = 1.0


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


class Files(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Which files the robot takes from people, and where its own lie.

    Both folders are on the computer that ROSIC runs on, by their full paths; how the robot reaches
    them (it runs there, or mounts them) is the operator's business.

    Attributes:
        accept: Kinds it takes, by what is in them: png, pgm, yaml, zip.
        max_mb: Of one file, in megabytes of a million bytes.
        inbox: Folder into which files for the robot are put; empty: it takes none.
        outbox: Folder out of which its files may be fetched; empty: it gives none.
        deliver: How its side is handed a file, besides the inbox or instead of it.
    """

    accept: tuple[str, ...] = ()
    max_mb: float = 5.0
    inbox: str = ""
    outbox: str = ""
    deliver: Deliver | None = None

    @property
    def takes(self) -> bool:
        """Whether it takes any."""
        return bool(self.inbox) or self.deliver is not None


class Profile(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Everything ROSIC knows about one robot.

    Attributes:
        id: Lower case, as people type it.
        groups: Plain names under which several robots are commanded together.
        slots: What booked times mean: nothing, others wait, or nobody moves it without one.
        watchdog_s: The robot's own time-out for a velocity topic; without it no skill may stream.
        go_to: Skill that goes to a place, and its two parameters in m: ``goto x y``. With a
            frame, a location that somebody sends asks whether the robot is to go there.
        joints: What a trajectory controller moves; skills with a ``trajectory`` need it.
        rest_timeout_s: A stop that is not measured at rest by then is reported as not confirmed.
        unstoppable: Nothing here stops it, or measures that it rests; everybody who commands it is
            told. Without this word, a robot that moves needs both, whatever its link.
        alerts: Rules about what the robot reports: whom to tell, and what to run.
        strategies: Ways to work that it can be told to take on, by name.
    """

    id: RobotId
    link: Link
    title: str = ""
    words: tuple[str, ...] = ()
    groups: tuple[str, ...] = ()
    stop: StopBinding | None = None
    link_loss: LinkLoss = LinkLoss.HOLD
    busy: Busy = Busy.REFUSE
    queue_length: int = 16
    slots: Slots = Slots.RESPECTED
    watchdog_s: float | None = None
    at_rest: AtRest | None = None
    rest_timeout_s: float = 5.0
    unstoppable: bool = False
    joints: Joints | None = None
    skills: dict[str, Skill] = {}
    telemetry: dict[str, Telemetry] = {}
    camera: Camera | None = None
    map: MapSource | None = None
    pose: PoseSource | None = None
    path: PathSource | None = None
    files: Files | None = None
    frame: GeographicFrame | None = None
    go_to: str = ""
    alerts: tuple[AlertConfig, ...] = ()
    strategies: dict[str, Strategy] = {}

    def __post_init__(self) -> None:
        for name in (self.id, *self.groups):
            if not ROBOT_ID.match(name):
                raise ValueError(
                    f"{name!r} is not a name: small letters, digits and _, first a letter, "
                    "at most 32"
                )
        if not 1 <= self.queue_length <= QUEUE_AT_MOST:
            raise ValueError(f"queue_length must be between 1 and {QUEUE_AT_MOST}")
        for name, skill in self.skills.items():
            if skill.topic is not None and skill.topic.stream_hz > 0 and self.watchdog_s is None:
                raise ValueError(
                    f"skill {name!r} streams a velocity, but the profile states no watchdog_s: "
                    "a robot that does not stop by itself may not be streamed to"
                )

    @property
    def shown(self) -> str:
        """What people read."""
        return self.title or self.id

    @property
    def moves(self) -> bool:
        """Whether any of its skills moves it."""
        return any(skill.kind is MOTION for skill in self.skills.values())

    @property
    def replaces(self) -> bool:
        """Whether what it does may have to give way to another order."""
        return self.busy is Busy.REPLACE or any(skill.to_safety for skill in self.skills.values())

    @property
    def benchmarked(self) -> bool:
        """Whether anything is expected of it."""
        return any(skill.benchmark is not None for skill in self.skills.values())

    def offers(self, sight: ViewKind) -> bool:
        """Whether people may look at the robot in this way: opt-in, robot by robot."""
        return (self.camera if sight is ViewKind.PICTURE else self.map) is not None


class Presence(msgspec.Struct, frozen=True, kw_only=True):
    """What the robot side last said of itself.

    Attributes:
        online: None when the link cannot tell.
        age_s: Since the robot was last heard; None if never.
        doing: Skill it is carrying out; empty when none.
        at_rest: None when not measured within its deadline, or not since the last break.
        holds: It keeps its place, if not on the ground; None: that is not told from rest.
        values: Newest telemetry in the profile's units.
        pose: Where it is; None unless the profile names a ``pose`` and it is fresh.
    """

    online: bool | None = None
    age_s: float | None = None
    doing: str = ""
    at_rest: bool | None = None
    holds: bool | None = None
    doubt: str = ""
    values: dict[str, float | str] = {}
    pose: Pose | None = None

    @property
    def moves(self) -> bool:
        """Whether it is known to move; a drone that hovers does not."""
        return self.at_rest is False and not self.holds
