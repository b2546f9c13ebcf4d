"""What people read about times: why not, who has it, when instead."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosic.core.i18n import joined, said, said_n
from rosic.core.local_time import MONTHS, WEEKDAYS, LocalTime, weekday_of
from rosic.core.time_units import DAY_NS, HOUR_S, MINUTE_NS, SECOND_NS

if TYPE_CHECKING:
    from rosic.core.slot import Pattern
    from rosic.organiser.timezones import Zone

_CODES = ("MO", "TU", "WE", "TH", "FR", "SA", "SU")
_A_QUARTER = 84  # days


# ---- times and lengths ----


def moment(at_ns: int, now_ns: int, zone: Zone) -> str:
    """Return a time as it is said today: ``15:00``, ``tomorrow 15:00``, ``Tue 24 Nov 15:00``."""
    return clock_and_day(zone.local(at_ns), zone.local(now_ns))


def clock_and_day(local: LocalTime, now: LocalTime) -> str:
    """Return what a wall clock shows, with the day if it is not today's."""
    days = local.day_number - now.day_number
    clock = local.time_text()
    if days in {0, 1}:
        return said("tomorrow {clock}", clock=clock) if days else clock
    return joined(" ", (day(local, now), clock))


def day(local: LocalTime, now: LocalTime) -> str:
    """Return ``Tue 24 Nov``, and the year if it is another one."""
    weekday, month = WEEKDAYS[weekday_of(local.day_number)], MONTHS[local.month - 1]
    year = "" if local.year == now.year else f" {local.year}"
    return joined("", (weekday, " ", local.day, " ", month, year))


def length(seconds: int) -> str:
    """Return ``1 h 30 min``; what is shorter than a minute, in seconds."""
    days, rest = divmod(seconds, DAY_NS // SECOND_NS)
    hours, rest = divmod(rest, HOUR_S)
    minutes = rest // 60
    parts = (
        said_n("{n} day", "{n} days", days) if days else "",
        said("{hours} h", hours=hours) if hours else "",
        said("{minutes} min", minutes=minutes) if minutes else "",
    )
    return joined(" ", filter(None, parts)) or said("{seconds} s", seconds=rest)


def bookable(robot: str, at_ns: int, seconds: int, zone: Zone) -> str:
    """Return the line that books this, on the next full minute."""
    return f"book {robot} {moment_typed(at_ns, seconds, zone)}"


def moment_typed(at_ns: int, seconds: int, zone: Zone) -> str:
    """Return how the next full minute is typed, and how long from there."""
    return _typed(zone.local(-(-at_ns // MINUTE_NS) * MINUTE_NS), seconds)


def bookable_at(robot: str, local: LocalTime, seconds: int) -> str:
    """Return the line that books this."""
    return f"book {robot} {_typed(local, seconds)}"


def _typed(local: LocalTime, seconds: int) -> str:
    return f"{local.date_text()} {local.time_text()} {length(seconds)}"


# ---- somebody has it ----


def taken(shown: str, name: str, span: tuple[str, str], free: str) -> str:
    """A booking overlaps another."""
    return said(
        "{shown} is taken by {name} from {begin} to {end}. It is free from {free} on.",
        shown=shown,
        name=name,
        begin=span[0],
        end=span[1],
        free=free,
    )


def taken_by_yourself(shown: str, span: tuple[str, str], free: str) -> str:
    """A booking overlaps one's own."""
    return said(
        "{shown} is yours already from {begin} to {end}. It is free from {free} on.",
        shown=shown,
        begin=span[0],
        end=span[1],
        free=free,
    )


def series_taken(shown: str, name: str, first: str, counts: tuple[int, int]) -> str:
    """Some occurrences overlap what is booked."""
    several, of_all = counts
    return said_n(
        "One of these times is taken: {shown} is {name}'s at {first}. Nothing was booked.",
        "{n} of these {of_all} times are taken: {shown} is {name}'s at {first}. "
        "Nothing was booked.",
        several,
        of_all=of_all,
        shown=shown,
        name=name,
        first=first,
    )


def held_now(shown: str, name: str, until: str, free: str) -> str:
    """It is somebody else's slot."""
    when = (
        said("You can have it then.")
        if free == until
        else said("You can have it at {free}.", free=free)
    )
    return said(
        "{shown} is taken by {name} until {until}. {when}",
        shown=shown,
        name=name,
        until=until,
        when=when,
    )


def needs_slot(shown: str, free: str, own: str) -> str:
    """The robot moves only in a slot, and this is nobody's.

    Args:
        shown: The robot's title.
        free: Empty: now.
        own: The person's next slot; empty: none.
    """
    if own:
        return said(
            "{shown} has to be booked, and your time begins at {own}. Nothing was done.",
            shown=shown,
            own=own,
        )
    when = said("It is free from {free} on.", free=free) if free else said("It is free now.")
    return said("{shown} has to be booked first. {when} Nothing was done.", shown=shown, when=when)


def needs_slot_held(shown: str, name: str, until: str, after: str) -> str:
    """The robot moves only in a slot, and this is somebody else's."""
    return said(
        "{shown} is booked by {name} until {until}. {after} Nothing was done.",
        shown=shown,
        name=name,
        until=until,
        after=after,
    )


def yours_at(own: str) -> str:
    """The person's next slot."""
    return said("Your time begins at {own}.", own=own)


def free_at(free: str) -> str:
    """When a slot could begin."""
    return said("You can book it from {free} on.", free=free)


# ---- not bookable ----


def not_positive() -> str:
    """Zero or less."""
    return said("A time has to be longer than nothing. Nothing was booked.")


def too_short(shortest_s: int) -> str:
    """Shorter than the limit."""
    return said("The shortest time is {length}. Nothing was booked.", length=length(shortest_s))


def too_long(longest_s: int) -> str:
    """Longer than the limit."""
    return said("One time may be at most {length}. Nothing was booked.", length=length(longest_s))


def begun() -> str:
    """Its start cannot be another one any more."""
    return said(
        "That time has begun: its end can be moved to a later moment than now, its start cannot. "
        "Nothing has changed."
    )


def over(began: str, now: str) -> str:
    """In the past."""
    return said(
        "That time is over: it would have begun at {began}, and it is {now}. Nothing was booked.",
        began=began,
        now=now,
    )


def too_far(last: str) -> str:
    """Further ahead than the limit."""
    return said("Times can be booked until {last}. Nothing was booked.", last=last)


def too_many(most: int) -> str:
    """A person's share is used up."""
    return said(
        "One person may have {most} times booked, and that many are. Nothing was booked.", most=most
    )


def calendar_full() -> str:
    """The bound on all slots."""
    return said(
        "The calendar is full. The operator of this place can make room. Nothing was booked."
    )


def no_end() -> str:
    """A rule without an end."""
    return said("Until when? A time that comes again needs a last day, or how many times.")


def too_often(most: int) -> str:
    """A rule with more occurrences than the limit."""
    return said(
        "That is more than {most} times, which is the most at once. Nothing was booked.", most=most
    )


def never_comes() -> str:
    """A rule without an occurrence."""
    return said("That never comes between its first and its last day. Nothing was booked.")


def overlaps_itself() -> str:
    """Occurrences longer than the time between them."""
    return said("These times would overlap each other. Nothing was booked.")


# ---- clocks that change ----


def skipped(local: LocalTime, zone: Zone, possible: LocalTime) -> str:
    """The wall clock never shows this."""
    return said(
        "On {day} the clocks in {name} go forward, and there is no {time_text}. The "
        "next possible time is {time_text2}. Nothing was booked.",
        day=day(local, local),
        name=zone.name,
        time_text=local.time_text(),
        time_text2=possible.time_text(),
    )


def comes_twice(local: LocalTime, zone: Zone) -> str:
    """The wall clock shows this twice."""
    return said(
        "On {day} the clocks in {name} go back, and {time_text} comes twice. This is "
        "the first one.",
        day=day(local, local),
        name=zone.name,
        time_text=local.time_text(),
    )


# ---- cancelling ----


def no_such_time() -> str:
    """An id of no slot: cancelled before, perhaps."""
    return said("There is no such time any more. Nothing has changed.")


def already_over() -> str:
    """A slot of the past."""
    return said("That time is over already. Nothing has changed.")


def not_yours(shown: str, name: str) -> str:
    """Somebody else's slot."""
    return said(
        "That time with {shown} is {name}'s. They can cancel it, or an admin. It stays.",
        shown=shown,
        name=name,
    )


# ---- patterns ----


def pattern_typed(robot: str, pattern: Pattern) -> str:
    """Return the line that books a pattern for twelve weeks, or nothing for a rule of one's own."""
    days = [part[6:].split(",") for part in pattern.rrule.split(";") if part.startswith("BYDAY=")]
    other = "INTERVAL=2" in pattern.rrule
    if "FREQ=WEEKLY" in pattern.rrule and days and set(days[0]) <= set(_CODES):
        named = " and ".join(WEEKDAYS[_CODES.index(code)] for code in days[0])
    elif pattern.rrule == "FREQ=DAILY":
        named = "day"
    else:
        return ""
    often = "every other" if other else "every"
    last = LocalTime.at(pattern.first.day_number + _A_QUARTER).date_text()
    clock = pattern.first.time_text()
    return f"book {robot} {often} {named} {clock} {length(pattern.length_s)} until {last}"
