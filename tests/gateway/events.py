"""What happens in a history, as it is written down; and how robots take orders in it."""

from __future__ import annotations

import enum
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from rosic.core.message import MessageValidity
    from rosic.core.records import Record


class Mode(enum.Enum):
    """How a robot takes the next orders."""

    WELL = "well"
    OFFLINE = "offline"
    LOST_BEFORE = "lost before it acted"
    LOST_AFTER = "lost after it acted"
    BREAKS = "something unforeseen after it acted"


# ---- the log ----


class Said(NamedTuple):
    """A message left a person's hands for the first time. ``base`` is the id of each line."""

    who: str
    text: str
    base: tuple[bytes, ...]
    sent_ns: int
    standing: MessageValidity
    message: str
    private: bool


class Acted(NamedTuple):
    """A robot moved."""

    robot: str
    cid: bytes
    n: int
    fence: int
    generation: int
    wall_ns: int
    lifetime_s: float
    actuates: bool
    overlaps: bool


class Latched(NamedTuple):
    """A stop reached a robot's gate."""

    robot: str
    generation: int


class Kept(NamedTuple):
    """The stop file says this of a robot from now on."""

    robot: str
    generation: int
    latched: bool


class Unlatched(NamedTuple):
    """A robot's gate let go."""

    robot: str


class Written(NamedTuple):
    """Records reached the disk together."""

    records: tuple[Record, ...]


class Revoked(NamedTuple):
    """Somebody's access ended."""

    who: str


class Started(NamedTuple):
    """A gateway began; what its gates knew then: n, fence, generation, and whether stopped."""

    gates: dict[str, tuple[int, int, int, bool]]


class Steered(NamedTuple):
    """A robot was given velocities, or zero, by a live order."""

    robot: str
    cid: bytes
    moving: bool
    at_ns: int


class StopSent(NamedTuple):
    """Somebody has sent a stop of these robots, and nobody has read it yet."""

    who: str
    robots: tuple[str, ...]


class Sampled(NamedTuple):
    """A hand at its controls has sent a velocity."""

    who: str
    at_ns: int


Event = (
    Said
    | Acted
    | Latched
    | Kept
    | Unlatched
    | Written
    | Revoked
    | Started
    | Steered
    | Sampled
    | StopSent
)
