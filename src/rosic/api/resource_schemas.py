"""What is sent and received of telemetry, times, people, alarms, files and the past."""

from __future__ import annotations

from typing import Annotated

import msgspec

from rosic.api.schemas import Name


class SampleOut(msgspec.Struct, frozen=True):
    """One value, and when it was reported."""

    at: str
    value: float


class TelemetryOut(msgspec.Struct, frozen=True):
    """How a value was in the last minutes, the oldest first.

    Attributes:
        unit: Of the values; empty: they have none.
        names: What of this robot may be asked for.
    """

    robot: str
    name: str
    unit: str
    names: tuple[str, ...]
    samples: tuple[SampleOut, ...]


class BookingOut(msgspec.Struct, frozen=True):
    """A time in which a robot is somebody's.

    Attributes:
        who: Name of whose it is.
        own: It is the caller's.
        series: Id of what it comes again with; empty: it was booked alone.
    """

    id: str
    robot: str
    who: str
    own: bool
    start: str
    end: str
    series: str


class BookingIn(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A time that somebody would like, for themselves.

    Attributes:
        start: RFC 3339, a full minute.
        minutes: How long.
    """

    robot: Name
    start: Annotated[str, msgspec.Meta(min_length=16, max_length=40)]
    minutes: Annotated[int, msgspec.Meta(ge=1, le=10_080)]


class BookingMoveIn(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Another time for a booking.

    Attributes:
        start: RFC 3339, a full minute; of one that has begun, its own.
        minutes: How long from there on.
    """

    start: Annotated[str, msgspec.Meta(min_length=16, max_length=40)]
    minutes: Annotated[int, msgspec.Meta(ge=1, le=10_080)]


class PersonOut(msgspec.Struct, frozen=True):
    """Somebody who is known here.

    Attributes:
        kind: ``person`` or ``program``.
        locked: They are shut out for now.
        named: Their roles in the language of whoever asks.
        accounts: By which they speak: ``matrix:@ada:example.org``. Somebody with several is one
            person; a program has none.
    """

    id: str
    name: str
    kind: str
    roles: tuple[str, ...]
    locked: bool
    named: tuple[str, ...]
    accounts: tuple[str, ...]


class HealthFindingOut(msgspec.Struct, frozen=True):
    """Something that was looked at.

    Attributes:
        about: ``data``, ``disk``, a messenger's name, a robot's id.
        verdict: ``good``, ``look`` (at this) or ``not-measured``.
    """

    about: str
    verdict: str
    text: str


class AlertOut(msgspec.Struct, frozen=True):
    """An alarm that is open.

    Attributes:
        text: What it says, in the language of whoever asks.
        measured: What is measured now.
        seen_by: Name of who has seen it; empty: nobody yet.
    """

    robot: str
    name: str
    text: str
    at: str
    measured: str
    seen_by: str


class FileOut(msgspec.Struct, frozen=True):
    """A file of the caller's."""

    id: str
    name: str
    size: int
    media_type: str
    sha256: str
    at: str


class HistoryEntryOut(msgspec.Struct, frozen=True):
    """Something that was asked before, or a robot that was stopped.

    Attributes:
        kind: ``claimed``, ``refused``, ``resumed`` or ``stopped``.
        outcome: How it ended, or why it was refused; empty while it goes on.
        asked: In words: ``omni: move, 0.50 m left``; empty where they were erased.
        came: What came of it, as it was told.
    """

    at: str
    who: str
    kind: str
    robot: str
    skill: str
    outcome: str
    ended: str | None
    asked: str = ""
    came: str = ""
