"""Slots as an iCalendar file (RFC 5545), for the calendar on somebody's phone.

Every slot is an event of its own in UTC, so that it needs no zone rules to be read.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosic.core.language.sanitise import clean
from rosic.core.local_time import date_of
from rosic.core.time_units import DAY_NS, MINUTE_NS, SECOND_NS

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator

    from rosic.core.slot import BookedSlot

PRODUCT = "-//ROSIC//Slots//EN"
LONGEST_LINE = 75  # octets, its end not counted

_CONTINUED = 0b1100_0000
_CONTINUES = 0b1000_0000
_ESCAPES = str.maketrans({"\\": "\\\\", ";": "\\;", ",": "\\,", "\n": "\\n"})


def icalendar(
    slots: Iterable[BookedSlot], name: str, title_of: Callable[[BookedSlot], str]
) -> bytes:
    """Return the file.

    Two exports of the same slots are the same bytes; what a phone knows already it recognises by
    the id of the slot.

    Args:
        slots: Of a person or of a robot.
        name: How the whole calendar is called.
        title_of: How one slot is called: for a person the robot, for a robot the person.
    """
    return b"".join(_folded(line) for line in _lines(slots, name, title_of))


def _lines(
    slots: Iterable[BookedSlot], name: str, title_of: Callable[[BookedSlot], str]
) -> Iterator[str]:
    yield "BEGIN:VCALENDAR"
    yield "VERSION:2.0"
    yield f"PRODID:{PRODUCT}"
    yield "CALSCALE:GREGORIAN"
    yield f"X-WR-CALNAME:{_escaped(name)}"
    for slot in slots:
        yield "BEGIN:VEVENT"
        yield f"UID:{slot.id}@rosic"
        yield f"DTSTAMP:{_utc(slot.made_ns)}"
        yield f"DTSTART:{_utc(slot.start_ns)}"
        yield f"DTEND:{_utc(_after_start(slot))}"
        yield f"SUMMARY:{_escaped(title_of(slot))}"
        yield "TRANSP:OPAQUE"
        yield "END:VEVENT"
    yield "END:VCALENDAR"


def _after_start(slot: BookedSlot) -> int:
    """Return the end, which has to be another second than the start (RFC 5545, 3.8.2.2)."""
    return max(slot.end_ns, slot.start_ns + SECOND_NS)


def _utc(at_ns: int) -> str:
    """Return ``20261124T130000Z``, seconds cut off."""
    day, rest = divmod(at_ns, DAY_NS)
    minutes, rest = divmod(rest, MINUTE_NS)
    year, month, date = date_of(day)
    hour, minute = divmod(minutes, 60)
    return f"{year:04}{month:02}{date:02}T{hour:02}{minute:02}{rest // SECOND_NS:02}Z"


def _escaped(text: str) -> str:
    """Return a text value: no control characters, and nothing that ends it."""
    return clean(text).translate(_ESCAPES)


def _folded(line: str) -> bytes:
    """Return a line cut into pieces of at most 75 octets, never inside a character."""
    rest, pieces, room = line.encode(), [], LONGEST_LINE
    while len(rest) > room:
        cut = room
        while rest[cut] & _CONTINUED == _CONTINUES:
            cut -= 1
        pieces.append(rest[:cut])
        rest, room = rest[cut:], LONGEST_LINE - 1  # the space that continues it counts
    return b"\r\n ".join([*pieces, rest]) + b"\r\n"
