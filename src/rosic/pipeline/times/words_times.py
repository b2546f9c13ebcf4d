"""What people read about their times and turns, besides what the organiser says."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosic.core.civil import MINUTE_NS, MONTHS, WEEKDAYS, Local, weekday_of
from rosic.core.saying import said
from rosic.organiser.words_calendar import length, moment

if TYPE_CHECKING:
    from rosic.core.slot import Slot
    from rosic.organiser.zones import Zone

# Why a robot comes to rest, as it stands in the outcome of the order that this ends.
OVER = "your time is over"
BEGUN = "somebody else's time has begun"

NO_TIMES = "You have no times booked."
WHICH_DAY = "Which day? Say it as tomorrow, mon or 2027-02-01."
CALENDAR_FILE = said(
    "Your times, for the calendar on your phone: open the file. A change in there changes nothing "
    "here."
)
NOT_WAITING = "You are not waiting for any robot."


# ---- moments in full ----


def full_day(local: Local) -> str:
    """Return ``Tue 24 Nov 2026``."""
    weekday, month = WEEKDAYS[weekday_of(local.day_number)], MONTHS[local.month - 1]
    return f"{weekday} {local.day} {month} {local.year}"


def span(slot: Slot, zone: Zone) -> str:
    """Return ``on Tue 24 Nov 2026 from 14:00 to 15:00``; how long, if the clocks do not say so."""
    start, end = zone.local(slot.start_ns), zone.local(slot.end_ns)
    days = end.day_number - start.day_number
    midnight = days == 1 and end.minute_of_day == 0
    if days and not midnight:
        first, last = full_day(start), full_day(end)
        said = f"from {first} {start.time_text()} to {last} {end.time_text()}"
    else:
        until = "24:00" if midnight else end.time_text()
        said = f"on {full_day(start)} from {start.time_text()} to {until}"
    took_ns = slot.end_ns - slot.start_ns
    changed = abs(end.minutes_since(start) * MINUTE_NS - took_ns) > MINUTE_NS
    return f"{said}, {length(took_ns // 1_000_000_000)}" if changed else said


def soon(slot: Slot, now_ns: int, zone: Zone) -> str:
    """Return ``tomorrow 14:00 to 15:00``, or ``now, until 15:00``."""
    start, end = zone.local(slot.start_ns), zone.local(slot.end_ns)
    if slot.start_ns <= now_ns:
        return f"now, until {moment(slot.end_ns, now_ns, zone)}"
    same_day = start.day_number == end.day_number
    until = end.time_text() if same_day else moment(slot.end_ns, now_ns, zone)
    return f"{moment(slot.start_ns, now_ns, zone)} to {until}"


def _sentences(*said: str) -> str:
    return " ".join(one for one in said if one)


# ---- booking ----


def booked(shown: str, slot: Slot, zone: Zone, note: str = "") -> str:
    """One time is booked."""
    return _sentences(f"{shown} is yours {span(slot, zone)} ({zone.name}).", note)


def booked_series(shown: str, slots: tuple[Slot, ...], zone: Zone, *notes: str) -> str:
    """Several times are booked."""
    if len(slots) == 1:
        return booked(shown, slots[0], zone, _sentences(*notes))
    first, last = span(slots[0], zone), full_day(zone.local(slots[-1].start_ns))
    said = f"{shown} is yours {len(slots)} times: first {first}, last on {last} ({zone.name})."
    return _sentences(said, *notes)


def left_out(times: int) -> str:
    """Some times of a series were somebody else's."""
    if not times:
        return ""
    several = f"{times} of these times are taken and were" if times > 1 else ""
    return f"{several or 'One of these times is taken and was'} left out."


def moved(start: Local, zone: Zone) -> str:
    """One time of a series would begin when the clocks show nothing."""
    return (
        f"On {full_day(start)} the clocks in {zone.name} go forward, and it begins at "
        f"{start.time_text()}."
    )


def whoever_first(shown: str) -> str:
    """Slots mean nothing for this robot."""
    return f"{shown} needs no booking: whoever comes first has it."


def not_booked(shown: str) -> str:
    """Nor can it be booked."""
    return f"{whoever_first(shown)} Nothing was booked."


# ---- which robot ----


def which_robot() -> str:
    """None was named."""
    return "Which robot?"


def only_a_name() -> str:
    """More was said than the robot to wait for."""
    return "Say only which robot you wait for; to have it at a time, book it."


def which_of(group: str) -> str:
    """A group was named where one robot is meant."""
    return f"{group} is several robots. Which one?"


# ---- seeing ----


def mine(shown: str, slot: Slot, now_ns: int, zone: Zone) -> str:
    """One line of one's own times."""
    return f"{shown}: {soon(slot, now_ns, zone)}"


def my_times(zone: Zone) -> str:
    """Above one's own times."""
    return f"Your times ({zone.name}):"


def and_more(times: int) -> str:
    """Below a list that is cut."""
    return f"and {times} more"


def in_queue(shown: str, place: int) -> str:
    """One line about a queue."""
    return f"You are number {place} in the queue for {shown}."


def day_of(shown: str, day: Local, zone: Zone) -> str:
    """Above a robot's day."""
    return f"{shown} on {full_day(day)} ({zone.name}):"


def day_line(slot: Slot, who: str, day: Local, zone: Zone) -> str:
    """One line of a robot's day; what lies outside of the day is cut off."""
    start, end = zone.local(slot.start_ns), zone.local(slot.end_ns)
    since = start.time_text() if start.day_number == day.day_number else "00:00"
    until = end.time_text() if end.day_number == day.day_number else "24:00"
    return f"{since} to {until} {who}"


def day_free(shown: str, day: Local, zone: Zone) -> str:
    """Nobody has it that day."""
    return f"{shown} is free all day on {full_day(day)} ({zone.name})."


def otherwise_free() -> str:
    """Below a robot's day."""
    return "Otherwise it is free."


# ---- cancelling ----


def which_to_cancel(zone: Zone) -> str:
    """Above a list with buttons."""
    return f"Which one is to be cancelled ({zone.name})?"


def again(times: int) -> str:
    """After a time that comes again."""
    return f" (and {times} more like it)"


def this_or_all(shown: str, when: str, times: int) -> str:
    """The time is one of several."""
    return f"{shown}, {when}, is one of {times} times. Cancel this one, or all of them?"


def cancelled(shown: str, slot: Slot, zone: Zone) -> str:
    """A time to come is cancelled."""
    return f"Cancelled: {shown} {span(slot, zone)} ({zone.name})."


def given_back(shown: str, slot: Slot, now_ns: int, zone: Zone) -> str:
    """A time that had begun ends now."""
    until = moment(slot.end_ns, now_ns, zone)
    return f"{shown} is given back. The time was booked until {until}."


def cancelled_series(shown: str, slots: tuple[Slot, ...], zone: Zone) -> str:
    """All that is to come of a series is cancelled."""
    if len(slots) == 1:
        return cancelled(shown, slots[0], zone)
    first, last = span(slots[0], zone), full_day(zone.local(slots[-1].start_ns))
    return f"Cancelled: {shown}, {len(slots)} times, first {first}, last on {last} ({zone.name})."


def cancelled_by(shown: str, name: str, slots: tuple[Slot, ...], zone: Zone) -> str:
    """Told to the owner when somebody else cancels."""
    if len(slots) == 1:
        when = span(slots[0], zone)
        return f"{name} cancelled your time with {shown} {when} ({zone.name})."
    return (
        f"{name} cancelled {len(slots)} of your times with {shown}, first "
        f"{span(slots[0], zone)} ({zone.name})."
    )


# ---- waiting ----


def joined(place: str) -> str:
    """After one's place in the queue."""
    return f"{place} I tell you when it is your turn."


def left_queue(shown: str) -> str:
    """One's place is given up."""
    return f"You no longer wait for {shown}."


def not_in_queue(shown: str) -> str:
    """There was no place to give up."""
    return f"You are not waiting for {shown}."


def yours_already(shown: str, until: str) -> str:
    """Waiting for what one has."""
    return f"{shown} is yours already{f', until {until}' if until else ''}. You need not wait."


def turn_taken(shown: str, until: str) -> str:
    """The turn is theirs now."""
    return f"{shown} is yours now{f', until {until}' if until else ''}."


def taken_meanwhile(shown: str, place: int) -> str:
    """The robot was not free any more."""
    return f"{shown} was taken meanwhile. You stay number {place} in the queue."


def no_right_any_more(shown: str) -> str:
    """Who waits may not move the robot any more."""
    return f"You may not move {shown} any more, so you no longer wait for it."


def kept(shown: str) -> str:
    """The owner wants an unused time after all."""
    return f"{shown} stays yours."


def not_yours_now(shown: str) -> str:
    """Keeping what is not one's own."""
    return f"{shown} is not yours now. Nothing has changed."


# ---- told by the keeper ----


def begins(shown: str, until: str) -> str:
    """A slot starts."""
    return f"It is your time: {shown} is yours until {until}."


def begins_taken(shown: str, name: str) -> str:
    """A slot starts, and a senior has the robot and may keep it."""
    return f"It is your time with {shown}, but {name} has it now, and goes before. Ask {name}."


def ends_soon(shown: str, left_s: int, at: str) -> str:
    """Some minutes before the end."""
    return f"Your time with {shown} ends in {length(left_s)}, at {at}."


def ended(shown: str, *, at_rest: bool) -> str:
    """A slot is over, and its owner still had the robot."""
    return _sentences(f"Your time with {shown} is over.", rest(at_rest=at_rest))


def taken_over(shown: str, name: str, *, at_rest: bool) -> str:
    """Somebody else's slot has begun while one had the robot without a slot."""
    return _sentences(f"{shown} is booked by {name} from now on.", rest(at_rest=at_rest))


def rest(*, at_rest: bool) -> str:
    """What was measured."""
    if at_rest:
        return "It is at rest."
    return (
        "It has not confirmed that it is at rest, so it stays stopped. If it moves, use its own "
        "stop button."
    )


def no_answer(shown: str) -> str:
    """It could not even be asked to come to rest."""
    return (
        f"Your time with {shown} is over, but it does not answer. Look at it. If it moves, use "
        "its own stop button."
    )


def wait_for_rest(shown: str) -> str:
    """The next one cannot begin."""
    return (
        f"It is your time with {shown}, but it has not confirmed that it is at rest, so it stays "
        "stopped. Look at it; somebody who may resume it can do so then. If it moves, use its own "
        "stop button."
    )


def unused(shown: str, idle_s: float, left_s: float) -> str:
    """Before an unused slot is released."""
    return (
        f"Somebody waits for {shown}, and you have not used it for {length(int(idle_s))}. Use it, "
        f"or tap, within {left_s:.0f} s to keep it."
    )


def released(shown: str, until: str) -> str:
    """An unused slot was released."""
    return (
        f"{shown} was not used and somebody waits for it, so it was given back. It was yours until "
        f"{until}."
    )
