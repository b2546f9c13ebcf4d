"""What the clocks on the walls of a place show, and when that is. The one home of zone data."""

from __future__ import annotations

from datetime import UTC, datetime, timedelta, tzinfo
from functools import lru_cache
from typing import Literal
from zoneinfo import ZoneInfo, ZoneInfoNotFoundError, available_timezones

import msgspec

from rosic.core.i18n import said
from rosic.core.language.sanitise import quote
from rosic.core.language.suggestions import did_you_mean, listed
from rosic.core.local_time import LocalTime
from rosic.core.time_units import MINUTE_NS
from rosic.errors import OutOfBounds

UNIVERSAL = "UTC"

_EPOCH = datetime(1970, 1, 1, tzinfo=UTC)
_MINUTE = timedelta(minutes=1)
_LONGEST_NAME = 64


class LocalInstant(msgspec.Struct, frozen=True):
    """When a wall clock shows something.

    Attributes:
        start_ns: UTC. What comes twice is taken the first time; what is skipped when the clocks go
            forward is where the clocks would be had they not (RFC 5545, 3.3.5).
        kind: How often the clock shows it: once, twice or never.
        possible: What the clock shows first after the time that it skips; else the time itself.
    """

    start_ns: int
    kind: Literal["once", "twice", "never"]
    possible: LocalTime


class Zone:
    """The rules of one place.

    Attributes:
        name: IANA, such as ``Europe/Vienna``.
    """

    __slots__ = ("_rules", "name")

    def __init__(self, name: str, rules: tzinfo) -> None:
        self.name = name
        self._rules = rules

    def local(self, at_ns: int) -> LocalTime:
        """Return what the wall clock shows, seconds cut off."""
        shown = (_EPOCH + at_ns // MINUTE_NS * _MINUTE).astimezone(self._rules)
        return _local(shown)

    def instant(self, local: LocalTime) -> LocalInstant:
        """Return when the wall clock shows this."""
        first, second = (self._utc_minute(local, fold) for fold in (0, 1))
        if self.local(first * MINUTE_NS) != local:
            return LocalInstant(first * MINUTE_NS, "never", self._after_gap(second, first))
        return LocalInstant(first * MINUTE_NS, "once" if first == second else "twice", local)

    def _utc_minute(self, local: LocalTime, fold: int) -> int:
        wall = datetime(
            local.year,
            local.month,
            local.day,
            local.hour,
            local.minute,
            tzinfo=self._rules,
            fold=fold,
        )
        return (wall - _EPOCH) // _MINUTE

    def _after_gap(self, before: int, after: int) -> LocalTime:
        """Search, between two minutes, for the one in which the clocks go forward."""
        old = self._offset(before)
        while after - before > 1:
            middle = (before + after) // 2
            before, after = (middle, after) if self._offset(middle) == old else (before, middle)
        return self.local(after * MINUTE_NS)

    def _offset(self, minute: int) -> timedelta | None:
        return (_EPOCH + minute * _MINUTE).astimezone(self._rules).utcoffset()


def _local(shown: datetime) -> LocalTime:
    return LocalTime(shown.year, shown.month, shown.day, shown.hour, shown.minute)


@lru_cache(maxsize=1024)
def zone_named(name: str) -> Zone:
    """Return the rules of a zone. UTC needs no data.

    Raises:
        OutOfBounds: There is no such zone, or this machine has no zone data. Nothing has changed.
    """
    if name == UNIVERSAL:
        return Zone(name, UTC)
    try:
        rules = ZoneInfo(name) if len(name) <= _LONGEST_NAME else None
    except (ZoneInfoNotFoundError, ValueError, OSError):
        rules = None
    if rules is None:
        raise no_such_zone(name, known_zones())
    return Zone(name, rules)


@lru_cache(maxsize=1)
def known_zones() -> frozenset[str]:
    """Return every zone this machine has rules for; reads some hundred files once."""
    return frozenset(available_timezones())


def no_such_zone(name: str, known: frozenset[str]) -> OutOfBounds:
    """Return the refusal of a zone: what may have been meant, or what the machine lacks."""
    if not known - {UNIVERSAL}:
        return OutOfBounds(
            said(
                "This computer knows no time zones, only UTC. Its owner can install them: the "
                "system package tzdata, or pip install tzdata."
            )
        )
    given = name.casefold().replace(" ", "_")
    ways = {zone: {zone.casefold(), _city(zone)} for zone in sorted(known)}
    close = tuple(zone for zone, names in ways.items() if given in names)[:3]
    if not close:
        guesses = {_city(zone) for zone in known if _city(zone)[:1] == _city(given)[:1]}
        cities = did_you_mean(_city(given), sorted(guesses))
        close = tuple(zone for zone, names in ways.items() if names & set(cities))[:3]
    if not close:
        return OutOfBounds(
            said(
                "I know no time zone {quote}. Write it as Europe/Vienna or UTC.", quote=quote(name)
            )
        )
    return OutOfBounds(
        said(
            "I know no time zone {quote}. Did you mean {listed}?",
            quote=quote(name),
            listed=listed(close),
        )
    )


def _city(zone: str) -> str:
    return zone.casefold().rpartition("/")[2]
