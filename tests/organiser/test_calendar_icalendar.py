"""The file, read back by a reader of RFC 5545 that shares no code with what wrote it."""

from __future__ import annotations

import re
from datetime import UTC, datetime

from hypothesis import example, given
from hypothesis import strategies as st

from rosic.core.language.sanitise import clean
from rosic.core.slot import BookedSlot
from rosic.organiser.ical import icalendar
from tests.organiser.booking import HOUR, NOW, S, a_calendar, booked

CONTENT_LINE = re.compile(rb"[A-Z][A-Z0-9-]*:[^\x00-\x08\x0a-\x1f\x7f]*\Z")
UTC_TIME = re.compile(r"\d{8}T\d{6}Z\Z")
ONCE = ("UID", "DTSTAMP", "DTSTART", "DTEND", "SUMMARY")


def read(file: bytes) -> tuple[dict[str, str], list[dict[str, str]]]:
    """Check a file and return the properties of the calendar and of each event."""
    assert file.endswith(b"\r\n")
    lines = file.split(b"\r\n")[:-1]
    assert all(len(line) <= 75 and b"\n" not in line and b"\r" not in line for line in lines)
    for line in lines:
        line.decode()  # no character is cut in two
    unfolded = file.replace(b"\r\n ", b"").split(b"\r\n")[:-1]
    assert all(CONTENT_LINE.match(line) for line in unfolded)
    pairs = [line.decode().split(":", 1) for line in unfolded]
    assert pairs[0] == ["BEGIN", "VCALENDAR"]
    assert pairs[-1] == ["END", "VCALENDAR"]
    calendar: dict[str, str] = {}
    events: list[dict[str, str]] = []
    into = calendar
    for name, value in pairs[1:-1]:
        if name == "BEGIN":
            assert value == "VEVENT"
            assert into is calendar
            into = {}
        elif name == "END":
            assert value == "VEVENT"
            events.append(into)
            into = calendar
        else:
            assert name not in into
            into[name] = value
    assert (calendar["VERSION"], bool(calendar["PRODID"])) == ("2.0", True)
    assert all(set(ONCE) <= set(event) for event in events)
    return calendar, events


def unescaped(value: str) -> str:
    return re.sub(r"\\(.)", lambda m: "\n" if m[1] in "nN" else m[1], value)


def moment(value: str) -> int:
    assert UTC_TIME.match(value)
    found = datetime.strptime(value, "%Y%m%dT%H%M%SZ").replace(tzinfo=UTC)
    return int(found.timestamp()) * S


def robot_of(slot: BookedSlot) -> str:
    return slot.robot


def test_slots_come_back_as_they_are() -> None:
    calendar, _ = a_calendar()
    slots = [booked(calendar, NOW + HOUR), booked(calendar, NOW + 3 * HOUR, 5400, robot="omni")]
    file = icalendar(calendar.of("ann"), "Ann's times", robot_of)
    head, events = read(file)
    assert head["X-WR-CALNAME"] == "Ann's times"
    assert [(moment(e["DTSTART"]), moment(e["DTEND"]), e["SUMMARY"]) for e in events] == [
        (slot.start_ns, slot.end_ns, slot.robot) for slot in slots
    ]
    assert {moment(event["DTSTAMP"]) for event in events} == {NOW}
    assert len({event["UID"] for event in events}) == 2


def test_the_same_slots_are_the_same_file() -> None:
    calendar, clock = a_calendar()
    booked(calendar, NOW + HOUR)
    before = icalendar(calendar.of("ann"), "x", robot_of)
    clock.jump_wall(3600)
    assert icalendar(calendar.of("ann"), "x", robot_of) == before


def test_a_slot_keeps_its_id_when_it_is_cut_short() -> None:
    calendar, clock = a_calendar()
    slot = booked(calendar, NOW)
    (_, (before,)) = read(icalendar(calendar.of("ann"), "x", robot_of))
    clock.jump_wall(0.5)
    for fact in calendar.cancel(slot.id, "ann"):
        calendar.apply(fact)
    (_, (after,)) = read(icalendar(calendar.of("ann"), "x", robot_of))
    assert after["UID"] == before["UID"]
    assert moment(after["DTEND"]) == NOW + S  # an event ends after it starts


def test_nobody_has_an_empty_calendar() -> None:
    assert read(icalendar((), "x", robot_of))[1] == []


@given(st.text(max_size=200))
@example("Grüße; an, alle\\n\n\u202eevil\r\nBEGIN:VEVENT")
@example("ä" * 74 + "😀" * 20)
@example("\ud800\0")
def test_any_name_is_a_line_and_comes_back(name: str) -> None:
    slot = BookedSlot(
        id="s1",
        principal="p1",
        robot="kuka1",
        start_ns=NOW,
        end_ns=NOW + HOUR,
        made_ns=NOW,
        by="p1",
    )
    head, (event,) = read(icalendar([slot], name, lambda _: name))
    assert unescaped(event["SUMMARY"]) == clean(name)
    assert unescaped(head["X-WR-CALNAME"]) == clean(name)
