"""A slot: one person's time with one robot. A series: slots that come again.

Both are facts. Every slot of a series is written down on its own when it is booked: what a person
was promised does not move because a rule is worked out again by another version of a library.
"""

from __future__ import annotations

from typing import Literal, TypeAlias, TypeVar

import msgspec

from rosic.core.identity import PrincipalId
from rosic.core.local_time import LocalTime, day_number
from rosic.core.records import Fact
from rosic.core.robot.profile import RobotId
from rosic.core.time_units import DAY_NS

SlotId: TypeAlias = str
SeriesId: TypeAlias = str

SlotRule: TypeAlias = Literal["none", "respected", "required"]
"""What slots mean for a robot. none: nothing. respected: during somebody's slot nobody else may
move it, free time is everybody's. required: only in a slot of one's own."""

SLOT = "slot"
SERIES = "series"

# A day from the ends of the calendar, so that every zone can show it.
_FIRST_NS = DAY_NS
_LAST_NS = day_number(2199, 12, 31) * DAY_NS

T = TypeVar("T", bound=msgspec.Struct)


class BookedSlot(msgspec.Struct, frozen=True, gc=False, kw_only=True):
    """From ``start_ns`` until just before ``end_ns`` a robot is somebody's.

    Attributes:
        start_ns: Wall clock, UTC.
        end_ns: Wall clock, UTC; after the start.
        series: Empty when it was booked alone.
        made_ns: When it was booked.
        by: Who booked it; mostly the person themselves.
    """

    id: SlotId
    principal: PrincipalId
    robot: RobotId
    start_ns: int
    end_ns: int
    series: SeriesId = ""
    made_ns: int
    by: PrincipalId

    def __post_init__(self) -> None:
        if not _FIRST_NS <= self.start_ns < self.end_ns <= _LAST_NS:
            raise ValueError("a slot ends after it starts")

    def covers(self, now_ns: int) -> bool:
        """Whether it is now."""
        return self.start_ns <= now_ns < self.end_ns

    def fact(self) -> Fact:
        """Return it as it is written down."""
        return Fact(kind=SLOT, key=self.id, body=msgspec.msgpack.encode(self))

    def no_more(self) -> Fact:
        """Return what is written down when it is cancelled or forgotten."""
        return Fact(kind=SLOT, key=self.id, body=b"")


class Pattern(msgspec.Struct, frozen=True):
    """When a series comes: on the wall clock of a zone, so that 14:00 stays 14:00 over summer time.

    Attributes:
        first: The first start, or where the counting of the rule begins.
        length_s: Of each occurrence, in real seconds.
        rrule: RFC 5545, without ``RRULE:`` and without a start; a floating ``UNTIL``.
        zone: IANA name.
    """

    first: LocalTime
    length_s: int
    rrule: str
    zone: str


class Series(msgspec.Struct, frozen=True, kw_only=True):
    """Slots booked together. They carry its id.

    Attributes:
        made_ns: When it was booked.
        by: Who booked it.
    """

    id: SeriesId
    principal: PrincipalId
    robot: RobotId
    pattern: Pattern
    made_ns: int
    by: PrincipalId

    def fact(self) -> Fact:
        """Return it as it is written down."""
        return Fact(kind=SERIES, key=self.id, body=msgspec.msgpack.encode(self))

    def no_more(self) -> Fact:
        """Return what is written down when all of it is cancelled."""
        return Fact(kind=SERIES, key=self.id, body=b"")


def read_fact(fact: Fact, kind: type[T]) -> T:
    """Read the body of a fact.

    Raises:
        ValueError: It was written by something else, or the disk has changed it.
    """
    return msgspec.msgpack.decode(fact.body, type=kind)
