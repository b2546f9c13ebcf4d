"""What people read about times: why not, who has it, when instead."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosic.core.civil import DAY_NS, MINUTE_NS, MONTHS, WEEKDAYS, Local, weekday_of

if TYPE_CHECKING:
    from rosic.core.slot import Pattern
    from rosic.organiser.zones import Zone

_CODES = ("MO", "TU", "WE", "TH", "FR", "SA", "SU")
_A_QUARTER = 84  # days


# ---- times and lengths ----


def moment(at_ns: int, now_ns: int, zone: Zone) -> str:
    """Return a time as it is said today: ``15:00``, ``tomorrow 15:00``, ``Tue 24 Nov 15:00``."""
    return clock_and_day(zone.local(at_ns), zone.local(now_ns))


def clock_and_day(local: Local, now: Local) -> str:
    """Return what a wall clock shows, with the day if it is not today's."""
    days = local.day_number - now.day_number
    clock = local.time_text()
    if days in {0, 1}:
        return f"tomorrow {clock}" if days else clock
    return f"{day(local, now)} {clock}"


def day(local: Local, now: Local) -> str:
    """Return ``Tue 24 Nov``, and the year if it is another one."""
    weekday, month = WEEKDAYS[weekday_of(local.day_number)], MONTHS[local.month - 1]
    year = "" if local.year == now.year else f" {local.year}"
    return f"{weekday} {local.day} {month}{year}"


def length(seconds: int) -> str:
    """Return ``1 h 30 min``; what is shorter than a minute, in seconds."""
    days, rest = divmod(seconds, DAY_NS // 1_000_000_000)
    hours, rest = divmod(rest, 3600)
    parts = ((days, "days" if days > 1 else "day"), (hours, "h"), (rest // 60, "min"))
    said = " ".join(f"{number} {unit}" for number, unit in parts if number)
    return said or f"{rest} s"


def bookable(robot: str, at_ns: int, seconds: int, zone: Zone) -> str:
    """Return the line that books this, on the next full minute."""
    return bookable_at(robot, zone.local(-(-at_ns // MINUTE_NS) * MINUTE_NS), seconds)


def bookable_at(robot: str, local: Local, seconds: int) -> str:
    """Return the line that books this."""
    return f"book {robot} {local.date_text()} {local.time_text()} {length(seconds)}"


# ---- somebody has it ----


def taken(shown: str, name: str, span: tuple[str, str], free: str) -> str:
    """A booking overlaps another."""
    return f"{shown} is taken by {name} from {span[0]} to {span[1]}. It is free from {free} on."


def taken_by_yourself(shown: str, span: tuple[str, str], free: str) -> str:
    """A booking overlaps one's own."""
    return f"{shown} is yours already from {span[0]} to {span[1]}. It is free from {free} on."


def series_taken(shown: str, name: str, first: str, counts: tuple[int, int]) -> str:
    """Some occurrences overlap what is booked."""
    several, of_all = counts
    which = f"{several} of these {of_all} times are" if several > 1 else "One of these times is"
    return f"{which} taken: {shown} is {name}'s at {first}. Nothing was booked."


def held_now(shown: str, name: str, until: str, free: str) -> str:
    """It is somebody else's slot."""
    when = "You can have it then." if free == until else f"You can have it at {free}."
    return f"{shown} is taken by {name} until {until}. {when}"


def needs_slot(shown: str, free: str, own: str) -> str:
    """The robot moves only in a slot, and this is nobody's.

    Args:
        shown: The robot's title.
        free: Empty: now.
        own: The person's next slot; empty: none.
    """
    if own:
        return f"{shown} has to be booked, and your time begins at {own}. Nothing was done."
    when = f"It is free from {free} on." if free else "It is free now."
    return f"{shown} has to be booked first. {when} Nothing was done."


def needs_slot_held(shown: str, name: str, until: str, after: str) -> str:
    """The robot moves only in a slot, and this is somebody else's."""
    return f"{shown} is booked by {name} until {until}. {after} Nothing was done."


def yours_at(own: str) -> str:
    """The person's next slot."""
    return f"Your time begins at {own}."


def free_at(free: str) -> str:
    """When a slot could begin."""
    return f"You can book it from {free} on."


# ---- not bookable ----


def not_positive() -> str:
    """Zero or less."""
    return "A time has to be longer than nothing. Nothing was booked."


def too_short(shortest_s: int) -> str:
    """Shorter than the limit."""
    return f"The shortest time is {length(shortest_s)}. Nothing was booked."


def too_long(longest_s: int) -> str:
    """Longer than the limit."""
    return f"One time may be at most {length(longest_s)}. Nothing was booked."


def over(began: str, now: str) -> str:
    """In the past."""
    return (
        f"That time is over: it would have begun at {began}, and it is {now}. Nothing was booked."
    )


def too_far(last: str) -> str:
    """Further ahead than the limit."""
    return f"Times can be booked until {last}. Nothing was booked."


def too_many(most: int) -> str:
    """A person's share is used up."""
    return f"One person may have {most} times booked, and that many are. Nothing was booked."


def calendar_full() -> str:
    """The bound on all slots."""
    return "The calendar is full. The operator of this place can make room. Nothing was booked."


def no_end() -> str:
    """A rule without an end."""
    return "Until when? A time that comes again needs a last day, or how many times."


def too_often(most: int) -> str:
    """A rule with more occurrences than the limit."""
    return f"That is more than {most} times, which is the most at once. Nothing was booked."


def never_comes() -> str:
    """A rule without an occurrence."""
    return "That never comes between its first and its last day. Nothing was booked."


def overlaps_itself() -> str:
    """Occurrences longer than the time between them."""
    return "These times would overlap each other. Nothing was booked."


# ---- clocks that change ----


def skipped(local: Local, zone: Zone, possible: Local) -> str:
    """The wall clock never shows this."""
    return (
        f"On {day(local, local)} the clocks in {zone.name} go forward, and there is no "
        f"{local.time_text()}. The next possible time is {possible.time_text()}. "
        "Nothing was booked."
    )


def comes_twice(local: Local, zone: Zone) -> str:
    """The wall clock shows this twice."""
    return (
        f"On {day(local, local)} the clocks in {zone.name} go back, and {local.time_text()} comes "
        "twice. This is the first one."
    )


# ---- cancelling ----


def no_such_time() -> str:
    """An id of no slot: cancelled before, perhaps."""
    return "There is no such time any more. Nothing has changed."


def already_over() -> str:
    """A slot of the past."""
    return "That time is over already. Nothing has changed."


def not_yours(shown: str, name: str) -> str:
    """Somebody else's slot."""
    return f"That time with {shown} is {name}'s. They can cancel it, or an admin. It stays."


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
    last = Local.at(pattern.first.day_number + _A_QUARTER).date_text()
    clock = pattern.first.time_text()
    return f"book {robot} {often} {named} {clock} {length(pattern.length_s)} until {last}"
