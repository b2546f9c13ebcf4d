"""What people read about their times and turns, besides what the organiser says."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosic.core.i18n import joined, said, said_n
from rosic.core.language.suggestions import OR
from rosic.core.local_time import MONTHS, WEEKDAYS, LocalTime, weekday_of
from rosic.core.time_units import MINUTE_NS, SECOND_NS
from rosic.organiser.calendar_messages import length, moment

if TYPE_CHECKING:
    from rosic.core.slot import BookedSlot
    from rosic.organiser.timezones import Zone

# Why a robot comes to rest, as it stands in the outcome of the order that this ends.
CANCEL = "/cancel booking"

OVER = said("your time is over")
BEGUN = said("somebody else's time has begun")

NO_TIMES = said("You have no times booked.")
WHICH_DAY = said("Which day? Say it as tomorrow, mon or 2027-02-01.")
CALENDAR_FILE = said(
    "Your times, for the calendar on your phone: open the file. A change in there changes nothing "
    "here."
)
ONE_TIME = said("One booking is moved to one time. To have it again and again, book it so.")
NOT_WAITING = said("You are not waiting for any robot.")


# ---- moments in full ----


def full_day(local: LocalTime) -> str:
    """Return ``Tue 24 Nov 2026``."""
    weekday, month = WEEKDAYS[weekday_of(local.day_number)], MONTHS[local.month - 1]
    return joined(" ", (weekday, local.day, month, local.year))


def span(slot: BookedSlot, zone: Zone) -> str:
    """Return ``on Tue 24 Nov 2026 from 14:00 to 15:00``; how long, if the clocks do not say so."""
    start, end = zone.local(slot.start_ns), zone.local(slot.end_ns)
    days = end.day_number - start.day_number
    midnight = days == 1 and end.minute_of_day == 0
    if days and not midnight:
        first, last = full_day(start), full_day(end)
        given = said(
            "from {first} {time_text} to {last} {time_text2}",
            first=first,
            time_text=start.time_text(),
            last=last,
            time_text2=end.time_text(),
        )
    else:
        until = "24:00" if midnight else end.time_text()
        given = said(
            "on {full_day} from {time_text} to {until}",
            full_day=full_day(start),
            time_text=start.time_text(),
            until=until,
        )
    took_ns = slot.end_ns - slot.start_ns
    changed = abs(end.minutes_since(start) * MINUTE_NS - took_ns) > MINUTE_NS
    return joined(", ", (given, length(took_ns // SECOND_NS))) if changed else given


def soon(slot: BookedSlot, now_ns: int, zone: Zone) -> str:
    """Return ``tomorrow 14:00 to 15:00``, or ``now, until 15:00``."""
    start, end = zone.local(slot.start_ns), zone.local(slot.end_ns)
    if slot.start_ns <= now_ns:
        return said("now, until {moment}", moment=moment(slot.end_ns, now_ns, zone))
    same_day = start.day_number == end.day_number
    until = end.time_text() if same_day else moment(slot.end_ns, now_ns, zone)
    return said("{moment} to {until}", moment=moment(slot.start_ns, now_ns, zone), until=until)


def _sentences(*several: str) -> str:
    return joined(" ", (one for one in several if one))


# ---- booking ----


def right_ends_before(shown: str, at: str) -> str:
    """Somebody books what they will have no right to."""
    return said(
        "Your right to {shown} ends {at}, before that time. Nothing was booked. Ask for more of it "
        "first.",
        shown=shown,
        at=at,
    )


def right_ends_within(shown: str, at: str) -> str:
    """Somebody books longer than they have the right."""
    return said("But your right to {shown} ends {at}.", shown=shown, at=at)


def booked(shown: str, slot: BookedSlot, zone: Zone, *notes: str) -> str:
    """One time is booked."""
    return _sentences(
        said(
            "{shown} is yours {span} ({name}).", shown=shown, span=span(slot, zone), name=zone.name
        ),
        *notes,
    )


def booked_series(shown: str, slots: tuple[BookedSlot, ...], zone: Zone, *notes: str) -> str:
    """Several times are booked."""
    if len(slots) == 1:
        return booked(shown, slots[0], zone, *notes)
    first, last = span(slots[0], zone), full_day(zone.local(slots[-1].start_ns))
    given = said(
        "{shown} is yours {slots} times: first {first}, last on {last} ({name}).",
        shown=shown,
        slots=len(slots),
        first=first,
        last=last,
        name=zone.name,
    )
    return _sentences(given, *notes)


def left_out(times: int) -> str:
    """Some times of a series were somebody else's."""
    if not times:
        return ""
    return said_n(
        "One of these times is taken and was left out.",
        "{n} of these times are taken and were left out.",
        times,
    )


def moved(start: LocalTime, zone: Zone) -> str:
    """One time of a series would begin when the clocks show nothing."""
    return said(
        "On {full_day} the clocks in {name} go forward, and it begins at {time_text}.",
        full_day=full_day(start),
        name=zone.name,
        time_text=start.time_text(),
    )


def whoever_first(shown: str) -> str:
    """Slots mean nothing for this robot."""
    return said("{shown} needs no booking: whoever comes first has it.", shown=shown)


def not_booked(shown: str) -> str:
    """Nor can it be booked."""
    return said("{whoever_first} Nothing was booked.", whoever_first=whoever_first(shown))


# ---- which robot ----


def nothing_so_called(name: str) -> str:
    """Return that what is to be cancelled is neither a robot nor a time."""
    return said("I know no robot and no time called {name}. Nothing has changed.", name=name)


def only_a_name() -> str:
    """More was said than the robot to wait for."""
    return said("Say only which robot you wait for; to have it at a time, book it.")


# ---- seeing ----


def mine(shown: str, slot: BookedSlot, now_ns: int, zone: Zone) -> str:
    """One line of one's own times."""
    return joined(": ", (shown, soon(slot, now_ns, zone)))


def my_times(zone: Zone) -> str:
    """Above one's own times."""
    return said("Your times ({name}):", name=zone.name)


def and_more(times: int) -> str:
    """Below a list that is cut."""
    return said("and {times} more", times=times)


def in_queue(shown: str, place: int) -> str:
    """One line about a queue."""
    return said("You are number {place} in the queue for {shown}.", place=place, shown=shown)


def day_of(shown: str, day: LocalTime, zone: Zone) -> str:
    """Above a robot's day."""
    return said(
        "{shown} on {full_day} ({name}):", shown=shown, full_day=full_day(day), name=zone.name
    )


def day_line(slot: BookedSlot, who: str, day: LocalTime, zone: Zone) -> str:
    """One line of a robot's day; what lies outside of the day is cut off. Empty: the reader's."""
    start, end = zone.local(slot.start_ns), zone.local(slot.end_ns)
    since = start.time_text() if start.day_number == day.day_number else "00:00"
    until = end.time_text() if end.day_number == day.day_number else "24:00"
    if not who:
        return said("{since} to {until} you", since=since, until=until)
    return said("{since} to {until} {who}", since=since, until=until, who=who)


def day_free(shown: str, day: LocalTime, zone: Zone) -> str:
    """Nobody has it that day."""
    return said(
        "{shown} is free all day on {full_day} ({name}).",
        shown=shown,
        full_day=full_day(day),
        name=zone.name,
    )


def otherwise_free() -> str:
    """Below a robot's day."""
    return said("Otherwise it is free.")


# ---- cancelling ----


def no_times_with(shown: tuple[str, ...]) -> str:
    """There is nothing to cancel of these."""
    return said("You have no time booked with {shown}.", shown=joined(OR, shown))


def which_to_cancel(zone: Zone) -> str:
    """Above a list with buttons."""
    return said("Which one is to be cancelled ({name})?", name=zone.name)


def again(times: int) -> str:
    """After a time that comes again."""
    return said(" (and {times} more like it)", times=times)


def this_or_all(shown: str, when: str, times: int) -> str:
    """The time is one of several."""
    return said(
        "{shown}, {when}, is one of {times} times. Cancel this one, or all of them?",
        shown=shown,
        when=when,
        times=times,
    )


def cancelled(shown: str, slot: BookedSlot, zone: Zone) -> str:
    """A time to come is cancelled."""
    return said(
        "Cancelled: {shown} {span} ({name}).", shown=shown, span=span(slot, zone), name=zone.name
    )


def given_back(shown: str, slot: BookedSlot, now_ns: int, zone: Zone) -> str:
    """A time that had begun ends now."""
    until = moment(slot.end_ns, now_ns, zone)
    return said(
        "{shown} is given back. The time was booked until {until}.", shown=shown, until=until
    )


def cancelled_series(shown: str, slots: tuple[BookedSlot, ...], zone: Zone) -> str:
    """All that is to come of a series is cancelled."""
    if len(slots) == 1:
        return cancelled(shown, slots[0], zone)
    first, last = span(slots[0], zone), full_day(zone.local(slots[-1].start_ns))
    return said(
        "Cancelled: {shown}, {slots} times, first {first}, last on {last} ({name}).",
        shown=shown,
        slots=len(slots),
        first=first,
        last=last,
        name=zone.name,
    )


def cancelled_by(shown: str, name: str, slots: tuple[BookedSlot, ...], zone: Zone) -> str:
    """Told to the owner when somebody else cancels."""
    if len(slots) == 1:
        when = span(slots[0], zone)
        return said(
            "{name} cancelled your time with {shown} {when} ({name2}).",
            name=name,
            shown=shown,
            when=when,
            name2=zone.name,
        )
    return said(
        "{name} cancelled {slots} of your times with {shown}, first {span} ({name2}).",
        name=name,
        slots=len(slots),
        shown=shown,
        span=span(slots[0], zone),
        name2=zone.name,
    )


# ---- moving ----

MOVE = "/rebook"


def which_to_move(zone: Zone) -> str:
    """Above one's own times that can be moved."""
    return said("Which one is to be moved ({name})?", name=zone.name)


def moved_to(shown: str, slot: BookedSlot, zone: Zone, *notes: str) -> str:
    """A time is another one now."""
    return _sentences(
        said(
            "Moved: {shown} is yours {span} ({name}).",
            shown=shown,
            span=span(slot, zone),
            name=zone.name,
        ),
        *notes,
    )


def moved_for(shown: str, owner: str, slot: BookedSlot, zone: Zone, *notes: str) -> str:
    """The same, told to somebody else who moved it."""
    return _sentences(
        said(
            "Moved: {shown} is {owner}'s {span} ({name}).",
            shown=shown,
            owner=owner,
            span=span(slot, zone),
            name=zone.name,
        ),
        *notes,
    )


def moved_by(shown: str, name: str, slot: BookedSlot, zone: Zone) -> str:
    """Told to the owner when somebody else moves it."""
    return said(
        "{name} moved your time with {shown}: it is {span} now ({name2}).",
        name=name,
        shown=shown,
        span=span(slot, zone),
        name2=zone.name,
    )


# ---- waiting ----


def queued(place: str) -> str:
    """After one's place in the queue."""
    return said("{place} I tell you when it is your turn.", place=place)


def left_queue(shown: str) -> str:
    """One's place is given up."""
    return said("You no longer wait for {shown}.", shown=shown)


def not_in_queue(shown: str) -> str:
    """There was no place to give up."""
    return said("You are not waiting for {shown}.", shown=shown)


def yours_already(shown: str, until: str) -> str:
    """Waiting for what one has."""
    if not until:
        return said("{shown} is yours already. You need not wait.", shown=shown)
    return said(
        "{shown} is yours already, until {until}. You need not wait.", shown=shown, until=until
    )


def turn_taken(shown: str, until: str) -> str:
    """The turn is theirs now."""
    if not until:
        return said("{shown} is yours now.", shown=shown)
    return said("{shown} is yours now, until {until}.", shown=shown, until=until)


def taken_meanwhile(shown: str, place: int) -> str:
    """The robot was not free any more."""
    return said(
        "{shown} was taken meanwhile. You stay number {place} in the queue.",
        shown=shown,
        place=place,
    )


def no_right_any_more(shown: str) -> str:
    """Who waits may not move the robot any more."""
    return said("You may not move {shown} any more, so you no longer wait for it.", shown=shown)


def kept(shown: str) -> str:
    """The owner wants an unused time after all."""
    return said("{shown} stays yours.", shown=shown)


def not_yours_now(shown: str) -> str:
    """Keeping what is not one's own."""
    return said("{shown} is not yours now. Nothing has changed.", shown=shown)
