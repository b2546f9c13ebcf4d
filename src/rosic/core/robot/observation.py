"""What is seen of robots by whoever records or watches them: what was asked beside what moved.

Times are those of the wall clock, in ns. What a person may not see is left out before any of these
is made; whoever asked for something is an id here, and never a name.
"""

from __future__ import annotations

from typing import Final, TypeAlias

import msgspec

from rosic.core.identity import PrincipalId
from rosic.core.robot.profile import Presence, Profile, RobotId
from rosic.core.robot.view import Drawing, OccupancyMap, ViewKind

TURN: Final = "turn"
"""The stage of an order that was under way when somebody began to look; else see `OrderStage`."""


class OrderObservation(msgspec.Struct, frozen=True, kw_only=True):
    """A step in the life of an order.

    Attributes:
        order: The id of the command, in hexadecimal: the same in every step.
        n: The robot's order number.
        stage: As `OrderStage` and `OrderEnding` name it, or `TURN`.
        over: It is the last step; ``stage`` says how it ended.
        by: Who asked; empty where the reader may not know.
        words: The order as it reads; empty where the reader may not know, as are the arguments.
        arguments: SI.
        facts: Measured by the robot's side, SI, the unit in the name.
    """

    at_ns: int
    robot: RobotId
    order: str
    n: int
    skill: str
    stage: str
    over: bool = False
    by: PrincipalId = ""
    words: str = ""
    arguments: dict[str, float | str] = {}
    fraction: float | None = None
    note: str = ""
    facts: dict[str, float] = {}
    code: str = ""


class PresenceObservation(msgspec.Struct, frozen=True, kw_only=True):
    """How a robot was at a moment.

    Attributes:
        presence: What its side had said by then.
        stopped: A stop holds it.
    """

    at_ns: int
    robot: RobotId
    presence: Presence
    stopped: bool = False


class NoticeObservation(msgspec.Struct, frozen=True, kw_only=True):
    """Something that happened to a robot: a stop, a resume, an alarm; or to the recording itself.

    Attributes:
        text: In the record's own English.
        grave: It matters to whoever looks for what went wrong.
    """

    at_ns: int
    robot: RobotId
    text: str
    grave: bool = False


class ViewObservation(msgspec.Struct, frozen=True, kw_only=True):
    """A map as the robot's side published it, or a frame of its camera as a finished picture."""

    at_ns: int
    robot: RobotId
    content: OccupancyMap | Drawing


Observation: TypeAlias = (
    OrderObservation | PresenceObservation | NoticeObservation | ViewObservation
)


class RecordedRobot(msgspec.Struct, frozen=True):
    """What whoever reads a recording has to know of a robot.

    Attributes:
        shown: As people read it.
        units: Of its telemetry, by name.
        sights: What it shows to whoever looks.
    """

    id: RobotId
    shown: str
    units: dict[str, str] = {}
    sights: tuple[ViewKind, ...] = ()


def recorded_robot(profile: Profile) -> RecordedRobot:
    """Return what a recording says of a robot."""
    units = {name: value.unit for name, value in profile.telemetry.items()}
    sights = tuple(sight for sight in ViewKind if profile.offers(sight))
    return RecordedRobot(profile.id, profile.shown, units, sights)
