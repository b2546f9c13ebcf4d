"""A robot is one file: what it is, how it is reached, what it can do, how it stops."""

from __future__ import annotations

import enum
import re
from collections.abc import Mapping
from typing import TypeAlias

import msgspec

from rosic.core.robot.alert_config import AlertConfig
from rosic.core.robot.geography import GeographicFrame
from rosic.core.robot.skill import MOTION, Skill, Strategy
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

    An adapter derives its own from it, with what it needs to reach a robot.

    Attributes:
        kind: Name of a robot adapter.
        heartbeat_s: A robot whose telemetry is older than this is offline.
    """

    kind: str
    heartbeat_s: float = 3.0

    @property
    def dialogue(self) -> bool:
        """Whether people may say whatever they like to the robot: the paper's text link."""
        return False

    @property
    def among(self) -> bool:
        """Whether the robot's own nodes speak with other robots."""
        return False

    @property
    def namespace(self) -> str:
        """Under what it is reached; what one of two robots with the same is told, both hear."""
        return ""


class Slots(enum.Enum):
    """What booked times mean for a robot.

    ``none``: nothing. ``respected``: in somebody's time nobody else moves it. ``required``: it
    moves only in a time of one's own.
    """

    __hash__ = object.__hash__  # Enum hashes the name, in Python, every time

    NONE = "none"
    RESPECTED = "respected"
    REQUIRED = "required"


class Telemetry(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """One value the robot reports; only the newest is kept.

    An adapter derives its own from it, with where the value comes from.

    Attributes:
        full: What a share, with the unit ``%``, is reported as when it is whole: 100 for a battery
            that says 0 to 100, against the definition of its message.
    """

    unit: str = ""
    alert_below: float | None = None
    full: float = 1.0


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
    deliver: object = None

    @property
    def carries(self) -> bool:
        """Whether the content itself goes to the robot's side, not only word of it."""
        return False

    @property
    def takes(self) -> bool:
        """Whether it takes any."""
        return bool(self.inbox) or self.deliver is not None


class Profile(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Everything ROSIC knows about one robot.

    The adapter of its kind of link derives its own from it. Whether there is a stop, a camera, a
    map is known here; what is said of them is the adapter's business.

    Attributes:
        id: Lower case, as people type it.
        groups: Plain names under which several robots are commanded together.
        slots: What booked times mean: nothing, others wait, or nobody moves it without one.
        watchdog_s: The robot's own time-out for velocities; without it no skill may stream.
        go_to: Skill that goes to a place, and its two parameters in m: ``goto x y``. With a
            frame, a location that somebody sends asks whether the robot is to go there.
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
    stop: object = None
    link_loss: LinkLoss = LinkLoss.HOLD
    busy: Busy = Busy.REFUSE
    queue_length: int = 16
    slots: Slots = Slots.RESPECTED
    watchdog_s: float | None = None
    at_rest: object = None
    rest_timeout_s: float = 5.0
    unstoppable: bool = False
    skills: Mapping[str, Skill] = {}
    telemetry: Mapping[str, Telemetry] = {}
    camera: object = None
    map: object = None
    pose: object = None
    path: object = None
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
            if skill.streams and self.watchdog_s is None:
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
    def stops(self) -> bool:
        """Whether something here stops it, as its profile says."""
        return self.stop is not None

    @property
    def measures_rest(self) -> bool:
        """Whether its rest is measured, as its profile says."""
        return self.at_rest is not None

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
        ages_s: Since each of them was heard; one that is not named is of now.
        no_number: What it reports and has no value, as what it says is no number (NaN).
        pose: Where it is; None unless the profile names a ``pose`` and it is fresh.
    """

    online: bool | None = None
    age_s: float | None = None
    doing: str = ""
    at_rest: bool | None = None
    holds: bool | None = None
    doubt: str = ""
    values: dict[str, float | str] = {}
    ages_s: dict[str, float] = {}
    no_number: tuple[str, ...] = ()
    pose: Pose | None = None

    @property
    def moves(self) -> bool:
        """Whether it is known to move; a drone that hovers does not."""
        return self.at_rest is False and not self.holds
