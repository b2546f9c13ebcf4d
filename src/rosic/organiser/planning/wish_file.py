"""Wishes and opening hours as people write them: CSV, JSON, and times on the place's clock."""

from __future__ import annotations

import csv
import json
import re
from datetime import UTC, datetime
from typing import TYPE_CHECKING, NamedTuple

from rosic.core.local_time import LAST_YEAR, LocalTime
from rosic.core.time_units import DAY_NS, MINUTE_NS, MINUTES_A_DAY, SECOND_NS
from rosic.organiser.planning.problem import PRIORITIES, Wish

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator, Mapping

    from rosic.core.identity import PrincipalId
    from rosic.core.robot.profile import RobotId
    from rosic.organiser.planning.problem import Span
    from rosic.organiser.timezones import Zone

NEEDED = ("person", "robots", "length", "earliest", "latest")
MOST_CHARACTERS = 1_000_000
MOST_WISHES = 2_000
LONGEST_MIN = 7 * MINUTES_A_DAY
WIDEST_DAYS = 62
# A day of the first and of the last year is left out: no zone shows another year there.
YEARS = range(1971, LAST_YEAR)

_DAY = re.compile(r"\d{4}-\d\d-\d\d")
_LENGTH = re.compile(r"(?:(\d{1,3}) ?h)? ?(?:(\d{1,5}) ?(?:min|m)?)?", re.ASCII)


class WishNames(NamedTuple):
    """What the words in a list of wishes stand for.

    Attributes:
        robots: From each name that may be written (a robot, a group) to its robots.
        zone: In which times without an offset are meant.
        people: From names to principals; None takes names as ids.
    """

    robots: Mapping[str, tuple[RobotId, ...]]
    zone: Zone
    people: Mapping[str, PrincipalId] | None = None


class ReadWishes(NamedTuple):
    """The wishes and opening hours that were read.

    Attributes:
        complaints: One sentence for each line that is wrong: ``week.csv:7: ...``. Such a line
            gives no wish.
    """

    wishes: tuple[Wish, ...]
    complaints: tuple[str, ...]


def wishes_from_csv(text: str, file: str, names: WishNames) -> ReadWishes:
    """Read a table with a heading: person, robots, length, earliest, latest, priority.

    Cells are apart by commas, or by semicolons as spreadsheets write them in some countries.
    """
    return _read(_csv_rows, text.removeprefix("\ufeff"), file, names)


def wishes_from_json(text: str, file: str, names: WishNames) -> ReadWishes:
    """Read a list of objects with the same names as the columns of the table."""
    return _read(_json_rows, text, file, names)


def opening_hours(
    days: Iterable[int], opens_min: int, closes_min: int, zone: Zone
) -> tuple[Span, ...]:
    """Return when a place is open.

    When the clocks change, an opening may be an hour longer or shorter.

    Args:
        days: Their numbers (``LocalTime.day_number``), on the place's calendar.
        opens_min: Minutes after midnight, as the clock on the wall shows them.
        closes_min: Later than that; beyond 24 h means the day after.
        zone: Of the place.
    """
    return tuple(
        (
            zone.instant(LocalTime.at(day, opens_min)).start_ns,
            zone.instant(LocalTime.at(day, closes_min)).start_ns,
        )
        for day in days
    )


class _Wrong(ValueError):
    """A line, or the rest of a file, that cannot be read.

    Attributes:
        line: Where, when it is not the line being read.
    """

    def __init__(self, sentence: str, line: int = 0) -> None:
        super().__init__(sentence)
        self.line = line


def _read(
    rows: Callable[[str], Iterator[tuple[int, Mapping[str, object]]]],
    text: str,
    file: str,
    names: WishNames,
) -> ReadWishes:
    if len(text) > MOST_CHARACTERS:
        return ReadWishes((), (f"{file}:1: This is longer than {MOST_CHARACTERS} characters.",))
    wishes: list[Wish] = []
    complaints: list[str] = []
    try:
        for line, row in rows(text):
            if len(wishes) == MOST_WISHES:
                more = f"{file}:{line}: Only {MOST_WISHES} wishes are planned at a time."
                return ReadWishes(tuple(wishes), (*complaints, more))
            try:
                wishes.append(_wish(f"{file}:{line}", row, names))
            except _Wrong as wrong:
                complaints.append(f"{file}:{line}: {wrong}")
    except _Wrong as wrong:
        complaints.append(f"{file}:{wrong.line}: {wrong}")
    return ReadWishes(tuple(wishes), tuple(complaints))


def _csv_rows(text: str) -> Iterator[tuple[int, Mapping[str, object]]]:
    lines = text.splitlines()
    heading = lines[0] if lines else ""
    table = csv.reader(lines, delimiter=";" if ";" in heading else ",", strict=True)
    columns: list[str] = []
    try:
        for cells in table:
            if not columns:
                columns = [cell.strip().lower() for cell in cells]
                _check_heading(columns)
            elif any(cell.strip() for cell in cells):
                yield table.line_num, dict(zip(columns, cells, strict=False))
    except csv.Error as error:
        raise _Wrong(f"This is not a table: {error}.", table.line_num) from error
    if not columns:
        raise _Wrong(f"The first line names the columns: {', '.join(NEEDED)}.", 1)


def _check_heading(columns: list[str]) -> None:
    missing = [name for name in NEEDED if name not in columns]
    if missing:
        raise _Wrong(f"There is no column {missing[0]}. The first line names them.", 1)


def _json_rows(text: str) -> Iterator[tuple[int, Mapping[str, object]]]:
    """Take the list apart one by one, so that each wish has a line of its own."""
    decoder = json.JSONDecoder()
    at = _past(text, 0, " \t\r\n")
    if text[at : at + 1] != "[":
        raise _Wrong("A list of wishes begins with [.", 1)
    at = _past(text, at + 1, " \t\r\n")
    while text[at : at + 1] != "]":
        line = text.count("\n", 0, at) + 1
        try:
            row, at = decoder.raw_decode(text, at)
        except json.JSONDecodeError as error:
            raise _Wrong(f"This is not JSON: {error.msg}.", error.lineno) from error
        except (RecursionError, ValueError) as error:  # too deep, or a number too long to read
            raise _Wrong("This is not a wish.", line) from error
        yield line, row if isinstance(row, dict) else {}
        at = _past(text, at, " \t\r\n,")


def _past(text: str, at: int, blanks: str) -> int:
    while at < len(text) and text[at] in blanks:
        at += 1
    return at


def _wish(where: str, row: Mapping[str, object], names: WishNames) -> Wish:
    earliest_ns = _moment(_text(row, "earliest"), names.zone, to_end_of_day=False)
    latest_ns = _moment(_text(row, "latest"), names.zone, to_end_of_day=True)
    if latest_ns <= earliest_ns:
        raise _Wrong("The window ends before it begins.")
    if latest_ns - earliest_ns > WIDEST_DAYS * DAY_NS:
        raise _Wrong(f"A window may be {WIDEST_DAYS} days wide at most.")
    length_s = _length_s(_text(row, "length"))
    if length_s * SECOND_NS > latest_ns - earliest_ns:
        raise _Wrong(f"The window is shorter than {_text(row, 'length')}.")
    return Wish(
        id=where,
        principal=_person(_text(row, "person"), names),
        robots=_robots(row, names),
        length_s=length_s,
        earliest_ns=earliest_ns,
        latest_ns=latest_ns,
        priority=_priority(row),
    )


def _text(row: Mapping[str, object], name: str) -> str:
    value = row.get(name)
    if isinstance(value, int) and not isinstance(value, bool):
        value = str(value)
    if not isinstance(value, str) or not value.strip():
        raise _Wrong(f"The {name} is missing.")
    return value.strip()


def _person(name: str, names: WishNames) -> PrincipalId:
    if names.people is None:
        return name
    if name not in names.people:
        raise _Wrong(f'I know nobody called "{name}".')
    return names.people[name]


def _robots(row: Mapping[str, object], names: WishNames) -> tuple[RobotId, ...]:
    value = row.get("robots")
    if isinstance(value, list) and all(isinstance(name, str) for name in value):
        value = " ".join(value)
    written = _text({"robots": value}, "robots").split()
    for name in written:
        if name not in names.robots:
            raise _Wrong(f'I know no robot called "{name}".')
    return tuple(dict.fromkeys(robot for name in written for robot in names.robots[name]))


def _priority(row: Mapping[str, object]) -> int:
    if row.get("priority") in (None, ""):
        return PRIORITIES[0]
    text = _text(row, "priority")
    if not (text.isascii() and text.isdigit() and len(text) == 1 and int(text) in PRIORITIES):
        raise _Wrong(f"A priority is a number from {PRIORITIES[0]} to {PRIORITIES[-1]}.")
    return int(text)


def length_of(text: str) -> int | None:
    """Return a length in seconds: ``90``, ``1h``, ``1 h 30 min``; None if it is none."""
    found = _LENGTH.fullmatch(text)
    minutes = int(found[1] or 0) * 60 + int(found[2] or 0) if found else 0
    return minutes * 60 if 0 < minutes <= LONGEST_MIN else None


def _length_s(text: str) -> int:
    length_s = length_of(text)
    if length_s is None:
        raise _Wrong(f'"{text}" is not a length: write 90 or 1 h 30 min, up to 7 days.')
    return length_s


def _moment(text: str, zone: Zone, *, to_end_of_day: bool) -> int:
    try:
        at = datetime.fromisoformat(text)
    except ValueError as error:
        raise _Wrong(f'"{text}" is not a time: write 2026-11-02 14:00.') from error
    if at.year not in YEARS:
        raise _Wrong(f'"{text}" is too far away.')
    if at.tzinfo:
        return int(at.timestamp()) // 60 * MINUTE_NS
    shown = LocalTime(at.year, at.month, at.day, at.hour, at.minute)
    if to_end_of_day and _DAY.fullmatch(text):
        shown = LocalTime.at(shown.day_number + 1)
    return _placed(shown, zone, text)


def _placed(shown: LocalTime, zone: Zone, text: str) -> int:
    """Return when that is; on the days when the clocks change it may not have one meaning."""
    found = zone.instant(shown)
    if found.kind == "never":
        raise _Wrong(f'"{text}" does not exist: the clocks go forward then.')
    if found.kind == "twice":
        utc = datetime.fromtimestamp(found.start_ns // SECOND_NS, UTC)
        raise _Wrong(
            f'"{text}" comes twice, because the clocks go back. The first is {utc:%H:%M} UTC: '
            f"write {utc:%Y-%m-%d %H:%M}Z for that, or an hour more."
        )
    return found.start_ns
