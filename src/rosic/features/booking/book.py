"""``/book kuka1 tomorrow 14:00 1h``, ``/book kuka1 every tue 14:00 1h until 2027-02-01``.

Also ``/rebook kuka1 tomorrow 15:00``, and ``/cancel booking``.
"""

from __future__ import annotations

import re
from contextlib import suppress
from typing import TYPE_CHECKING

from msgspec.structs import replace

from rosic.core.i18n import joined, said
from rosic.core.language.ast import Misunderstood
from rosic.core.language.compiled import fold
from rosic.core.language.sanitise import echo
from rosic.core.language.syntax_errors import LONGEST_OFFER
from rosic.core.language.time_parser import EXAMPLES, RequestedTime, read_when
from rosic.core.message import Button
from rosic.core.robot.profile import Slots
from rosic.core.slot import SLOT, BookedSlot, Pattern, read_fact
from rosic.core.time_units import MINUTE_NS, SECOND_NS
from rosic.errors import NotUnderstood, OutOfBounds, Refusal
from rosic.features.booking import messages as words
from rosic.features.booking.context import decided
from rosic.features.booking.messages import CANCEL
from rosic.gateway.commands import Reply
from rosic.gateway.robot_argument import RobotArgument
from rosic.organiser.calendar_conflicts import SlotTaken
from rosic.organiser.calendar_messages import length, moment, no_such_time
from rosic.organiser.recurrence import occasion, occasions

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rosic.core.identity import PrincipalId
    from rosic.core.records import Fact
    from rosic.core.robot.profile import RobotId
    from rosic.features.booking.context import BookingContext
    from rosic.gateway.commands import CommandContext
    from rosic.gateway.transactions import UnitOfWork
    from rosic.organiser.timezones import Zone


# ---- cancel ----

# ``/cancel booking``: my times as buttons; of a time that comes again, this one or all of them.

MOST_LISTED = 8

# Said by buttons, with an id after them.
ONLY, ALL, FROM = "only", "all", "from"
BOOKINGS = frozenset(
    {"booking", "bookings", "time", "times", "slot", "slots"}
    | {"buchung", "buchungen", "termin", "termine", "zeit", "zeiten"}
)
_ID = re.compile(r"[0-9a-f]{8,}\Z")


class CancelBookingCommand:
    """The handler who takes times back."""

    def __init__(self, times: BookingContext) -> None:
        self._times = times
        self._naming = RobotArgument(times)

    async def cancel(self, asked: CommandContext) -> Reply:
        """List what can be cancelled, ask, or cancel.

        Raises:
            Refusal: Why not; nothing has changed.
        """
        first, _, rest = asked.rest.strip().partition(" ")
        if fold(first) in BOOKINGS:
            asked = replace(asked, rest=rest)
        folded = fold(asked.rest).split()
        if not folded or folded[0] == FROM or folded in ([ALL], [ONLY]):
            return self._list(asked, _page(folded))
        typed = asked.rest.strip()
        if folded[0] in {ALL, ONLY}:
            if _ID.match(folded[1]):
                return await (self._all if folded[0] == ALL else self._one)(asked, folded[1])
            typed = typed.partition(" ")[2].strip()
        if self._times.calendar.slot(folded[0]) is None:  # a name, typed: which of those times?
            robots, name, rest = self._naming.at_head(asked, typed)
            if robots:
                return self._list(asked, _page(fold(rest).split()), robots, name)
            if not _ID.match(folded[0]):
                raise NotUnderstood(
                    words.nothing_so_called(echo(typed)), offers=("cancel booking",)
                )
        return await self._ask_or_cancel(asked, folded[0])

    def _list(
        self, asked: CommandContext, begin: int, robots: tuple[RobotId, ...] = (), name: str = ""
    ) -> Reply:
        times, principal = self._times, asked.caller.principal
        zone, now_ns = times.sides.zone_of(principal), times.clock.wall_ns()
        entries: dict[str, list[BookedSlot]] = {}
        for slot in times.upcoming(principal):
            if not robots or slot.robot in robots:
                entries.setdefault(slot.series or slot.id, []).append(slot)
        if not entries:
            return Reply(none_of(times, robots))
        page = list(entries.values())[begin : begin + MOST_LISTED]
        lines, buttons = [words.which_to_cancel(zone)], []
        for slots in page:
            line = words.mine(times.shown(slots[0].robot), slots[0], now_ns, zone)
            lines.append(
                joined("", (line, words.again(len(slots) - 1))) if len(slots) > 1 else line
            )
            buttons.append((Button(line, f"{CANCEL} {slots[0].id}"),))
        left = len(entries) - begin - len(page)
        if left > 0:
            lines.append(words.and_more(left))
            more = " ".join((CANCEL, *name.split(), FROM, str(begin + len(page))))
            buttons.append((Button(said("More"), more),))
        return Reply(joined("\n", lines), tuple(buttons))

    async def _ask_or_cancel(self, asked: CommandContext, slot_id: str) -> Reply:
        times, principal = self._times, asked.caller.principal
        slot = seen(times, principal, times.calendar.slot(slot_id))
        if not slot.series:
            return await self._one(asked, slot_id)
        left = self._left_of(slot)
        if len(left) == 1 and left[0] is slot:
            return await self._all(asked, slot.series)
        zone, now_ns = times.sides.zone_of(principal), times.clock.wall_ns()
        shown = times.shown(slot.robot)
        row = (
            Button(said("This one"), f"{CANCEL} {ONLY} {slot.id}"),
            Button(said("All of them"), f"{CANCEL} {ALL} {slot.series}"),
        )
        when = words.soon(slot, now_ns, zone)
        return Reply(words.this_or_all(shown, when, len(left)), (row,))

    async def _one(self, asked: CommandContext, slot_id: str) -> Reply:
        times, by = self._times, asked.caller.principal
        async with times.changes.turn() as turn:
            slot = seen(times, by, times.calendar.slot(slot_id))
            anybodys = times.sides.may_cancel_any(by, slot.robot)
            facts = times.calendar.cancel(slot_id, by, anybodys=anybodys)
            now_ns = times.clock.wall_ns()
            await turn.write(decided("cancel", by, now_ns, facts))
        self._tell_owner(by, (slot,))
        shown, zone = times.shown(slot.robot), times.sides.zone_of(by)
        if slot.start_ns < now_ns:
            return Reply(words.given_back(shown, slot, now_ns, zone))
        return Reply(words.cancelled(shown, slot, zone))

    async def _all(self, asked: CommandContext, series_id: str) -> Reply:
        times, by = self._times, asked.caller.principal
        async with times.changes.turn() as turn:
            series = times.calendar.series(series_id)
            if series is None or not may_know(times, by, series.principal, series.robot):
                raise NotUnderstood(no_such_time(), offers=("cancel booking",))
            anybodys = times.sides.may_cancel_any(by, series.robot)
            facts = times.calendar.cancel_series(series_id, by, anybodys=anybodys)
            slots = self._slots(facts)
            if not slots:
                raise NotUnderstood(no_such_time(), offers=("cancel booking",))
            await turn.write(decided("cancel", by, times.clock.wall_ns(), facts))
        self._tell_owner(by, slots)
        zone = times.sides.zone_of(by)
        return Reply(words.cancelled_series(times.shown(series.robot), slots, zone))

    # ---- whose ----

    def _left_of(self, slot: BookedSlot) -> list[BookedSlot]:
        return [s for s in self._times.upcoming(slot.principal) if s.series == slot.series]

    def _slots(self, facts: Sequence[Fact]) -> tuple[BookedSlot, ...]:
        found = (self._times.calendar.slot(fact.key) for fact in facts)
        return tuple(slot for slot in found if slot is not None)

    def _tell_owner(self, by: PrincipalId, slots: tuple[BookedSlot, ...]) -> None:
        owner, times = slots[0].principal, self._times
        if owner != by:
            name, zone = times.calendar.name_of(by), times.sides.zone_of(owner)
            shown = times.shown(slots[0].robot)
            times.reach.tell((owner,), words.cancelled_by(shown, name, slots, zone))


def _page(typed: list[str]) -> int:
    """Return where a page of the list begins, as the button for more of it says."""
    at = typed[1] if len(typed) > 1 and typed[0] == FROM else "0"
    return int(at[:6]) if at.isdecimal() else 0


# ---- book ----

TO_THE_MINUTE_NS = MINUTE_NS
"""Whoever has a right for two hours and books two hours means the same."""
WHERE_FREE = ("where", "free")
"""Said after a time that comes again: what is taken is left out."""


class BookCommand:
    """The handler who books."""

    def __init__(self, times: BookingContext) -> None:
        self._times = times
        self._naming = RobotArgument(times)

    async def book(self, asked: CommandContext) -> Reply:
        """Book one time, or one that comes again.

        Raises:
            Refusal: Why not, and mostly when instead; nothing was booked.
        """
        times, principal = self._times, asked.caller.principal
        text, where_free = _without_where_free(asked.rest)
        robot, rest = self._naming.robot(asked, "book", text, nameless=self._is_time(asked, text))
        self._check(principal, robot)
        zone = times.sides.zone_of(principal)
        when = read_when(rest, times.clock.wall_ns(), zone.local)
        if isinstance(when, Misunderstood):
            offers = tuple(f"book {robot} {offer}" for offer in when.offers)
            raise NotUnderstood(when.sentence, offers=offers)
        async with times.changes.turn() as turn:
            self._check(principal, robot)  # the right may have ended while others had their turn
            if not when.rrule:
                return await self._once(turn, principal, robot, when)
            if where_free:
                return await self._series(turn, principal, robot, when, skip_taken=True)
            try:
                return await self._series(turn, principal, robot, when)
            except SlotTaken as taken:
                if not taken.offers:
                    taken.offering(self._instead(taken, principal, when, rest))
                raise

    def _is_time(self, asked: CommandContext, text: str) -> bool:
        """Whether a line without a name is a time all the same."""
        zone = self._times.sides.zone_of(asked.caller.principal)
        return isinstance(read_when(text, self._times.clock.wall_ns(), zone.local), RequestedTime)

    def _check(self, principal: PrincipalId, robot: RobotId) -> None:
        refusal = self._times.sides.may_book(principal, robot)
        if refusal is not None:
            raise refusal
        if self._times.vocabulary.profiles[robot].slots is Slots.NONE:
            shown = self._times.shown(robot)
            raise OutOfBounds(words.not_booked(shown), offers=(f"wait {robot}",))

    async def _once(
        self, turn: UnitOfWork, principal: PrincipalId, robot: RobotId, when: RequestedTime
    ) -> Reply:
        times = self._times
        zone = times.sides.zone_of(principal)
        found = occasion(robot, when, zone)
        late = check_right(times, principal, robot, (found.start_ns, found.length_s))
        facts = times.calendar.book(principal, robot, found.start_ns, found.length_s, principal)
        (slot,) = await self._write(turn, principal, facts)
        button = Button(said("Cancel it"), f"{words.CANCEL} {slot.id}")
        return Reply(words.booked(times.shown(robot), slot, zone, found.note, late), ((button,),))

    async def _series(
        self,
        turn: UnitOfWork,
        principal: PrincipalId,
        robot: RobotId,
        when: RequestedTime,
        *,
        skip_taken: bool = False,
    ) -> Reply:
        times = self._times
        zone = times.sides.zone_of(principal)
        pattern = _pattern(when, zone)
        calendar, now_ns = times.calendar, times.clock.wall_ns()
        facts = calendar.book_series(principal, robot, pattern, principal, skip_taken=skip_taken)
        last_ns = max(slot.start_ns for slot in map(_slot_of, facts) if slot is not None)
        late = check_right(times, principal, robot, (last_ns, pattern.length_s))
        slots = await self._write(turn, principal, facts)
        every = len(occasions(pattern, now_ns, calendar.limits))
        notes = words.left_out(every - len(slots)), _moved(slots, when, zone), late
        given = words.booked_series(times.shown(robot), slots, zone, *notes)
        return Reply(
            given, ((Button(said("Cancel all of them"), f"{words.CANCEL} all {slots[0].series}"),),)
        )

    async def _write(
        self, turn: UnitOfWork, principal: PrincipalId, facts: tuple[Fact, ...]
    ) -> tuple[BookedSlot, ...]:
        times = self._times
        await turn.write(decided("book", principal, times.clock.wall_ns(), facts))
        found = (times.calendar.slot(fact.key) for fact in facts)
        return tuple(slot for slot in found if slot is not None)

    def _instead(
        self, taken: SlotTaken, principal: PrincipalId, when: RequestedTime, rest: str
    ) -> tuple[str, ...]:
        """Offer the times of a series that nobody has; else to see the first day that is taken."""
        zone, robot = self._times.sides.zone_of(principal), taken.slot.robot
        offer = f"book {robot} {rest} {' '.join(WHERE_FREE)}"
        day = (f"slots {robot} {zone.local(taken.slot.start_ns).date_text()}",)
        if len(offer) > LONGEST_OFFER:
            return day
        with suppress(Refusal):
            pattern = _pattern(when, zone)
            self._times.calendar.book_series(principal, robot, pattern, principal, skip_taken=True)
            return (offer, *day)
        return day


# ---- move ----

TO = frozenset({"to", "auf", "nach"})


class MoveBookingCommand:
    """The handler who moves times: the new one and the old one in one change, or neither."""

    def __init__(self, times: BookingContext) -> None:
        self._times = times
        self._naming = RobotArgument(times)

    async def rebook(self, asked: CommandContext) -> Reply:
        """List what can be moved, ask to when, or move.

        Raises:
            Refusal: Why not; the time is what it was.
        """
        typed = asked.rest.strip()
        known, _, rest = typed.partition(" ")
        if not _ID.match(known):
            robots, _, rest = self._naming.at_head(asked, typed)
            if typed and not robots:
                raise NotUnderstood(words.nothing_so_called(echo(typed)), offers=("rebook",))
            own = self._times.upcoming(asked.caller.principal)
            slots = [slot for slot in own if not robots or slot.robot in robots]
            if not slots:
                return Reply(none_of(self._times, robots))
            if len(slots) > 1 or not rest:
                return self._list(asked, slots, rest)
            known = slots[0].id
        first, _, after = rest.strip().partition(" ")
        return await self._move(asked, known, after if fold(first) in TO else rest)

    def _list(self, asked: CommandContext, slots: Sequence[BookedSlot], rest: str) -> Reply:
        times = self._times
        zone, now_ns = times.sides.zone_of(asked.caller.principal), times.clock.wall_ns()
        lines, buttons = [words.which_to_move(zone)], []
        for slot in slots[:MOST_LISTED]:
            lines.append(words.mine(times.shown(slot.robot), slot, now_ns, zone))
            buttons.append((Button(lines[-1], f"{words.MOVE} {slot.id} {rest}".strip()),))
        if len(slots) > MOST_LISTED:
            lines.append(words.and_more(len(slots) - MOST_LISTED))
        return Reply(joined("\n", lines), tuple(buttons))

    async def _move(self, asked: CommandContext, slot_id: str, rest: str) -> Reply:
        times, by = self._times, asked.caller.principal
        zone, named = times.sides.zone_of(by), f"{words.MOVE[1:]} {slot_id}"
        when = self._read(seen(times, by, times.calendar.slot(slot_id)), rest, zone)
        if isinstance(when, Misunderstood):
            offers = (offer for offer in when.offers if not offer.startswith("every"))
            raise NotUnderstood(when.sentence, offers=tuple(f"{named} {each}" for each in offers))
        async with times.changes.turn() as turn:
            slot = seen(times, by, times.calendar.slot(slot_id))
            if (barred := times.sides.may_book(slot.principal, slot.robot)) is not None:
                raise barred
            try:
                found = occasion(slot.robot, when, zone)
                anybodys = times.sides.may_cancel_any(by, slot.robot)
                facts = times.calendar.move(
                    slot_id, found.start_ns, found.length_s, by, anybodys=anybodys
                )
            except Refusal as refusal:
                refusal.offering(_moving(refusal.offers, f"book {slot.robot} ", named))
                raise
            late = check_right(times, slot.principal, slot.robot, (found.start_ns, found.length_s))
            await turn.write(decided("move", by, times.clock.wall_ns(), facts))
        return self._moved(by, seen(times, by, times.calendar.slot(slot_id)), (found.note, late))

    def _read(self, slot: BookedSlot, rest: str, zone: Zone) -> RequestedTime | Misunderstood:
        """Read to when; where nothing says how long, it is as long as it was."""
        now_ns, seconds = self._times.clock.wall_ns(), (slot.end_ns - slot.start_ns) // SECOND_NS
        when = read_when(rest, now_ns, zone.local)
        if isinstance(when, Misunderstood):
            as_long = read_when(f"{rest} {length(seconds)}", now_ns, zone.local)
            when = as_long if isinstance(as_long, RequestedTime) else when
        if isinstance(when, RequestedTime) and when.rrule:
            return Misunderstood(words.ONE_TIME, EXAMPLES)
        return when

    def _moved(self, by: PrincipalId, slot: BookedSlot, notes: tuple[str, ...]) -> Reply:
        times, shown = self._times, self._times.shown(slot.robot)
        zone, owner = times.sides.zone_of(by), slot.principal
        button = Button(said("Cancel it"), f"{CANCEL} {ONLY} {slot.id}")
        if owner == by:
            return Reply(words.moved_to(shown, slot, zone, *notes), ((button,),))
        told = words.moved_by(shown, times.calendar.name_of(by), slot, times.sides.zone_of(owner))
        times.reach.tell((owner,), told)
        name = times.calendar.name_of(owner)
        return Reply(words.moved_for(shown, name, slot, zone, *notes), ((button,),))


def _moving(offers: tuple[str, ...], booking: str, named: str) -> tuple[str, ...]:
    """Return what is offered to whoever books as what moves a time instead."""
    return tuple(
        f"{named} {one.removeprefix(booking)}" if one.startswith(booking) else one for one in offers
    )


# ---- what all of them ask ----


def none_of(times: BookingContext, robots: tuple[RobotId, ...]) -> str:
    """Return that somebody has no times, or none with some robots."""
    return words.no_times_with(tuple(map(times.shown, robots))) if robots else words.NO_TIMES


def may_know(times: BookingContext, by: PrincipalId, owner: PrincipalId, robot: RobotId) -> bool:
    """Whether somebody may know of a time: their own, or of a robot that they see."""
    return owner == by or robot in times.sides.visible(by)


def seen(times: BookingContext, by: PrincipalId, slot: BookedSlot | None) -> BookedSlot:
    """Return a slot that this person may know of; of others they hear nothing.

    Raises:
        NotUnderstood: There is none, as far as they hear.
    """
    if slot is None or not may_know(times, by, slot.principal, slot.robot):
        raise NotUnderstood(no_such_time(), offers=(CANCEL[1:],))
    return slot


def check_right(
    times: BookingContext, principal: PrincipalId, robot: RobotId, span: tuple[int, int]
) -> str:
    """See that a time begins while there still is a right to it.

    Args:
        times: Everything around it.
        principal: Whose right.
        robot: To what.
        span: When it begins, wall clock in nanoseconds, and how many seconds it is.

    Returns:
        That the right ends before the time does, if so.

    Raises:
        OutOfBounds: The right ends sooner than it begins.
    """
    ends_ns, (start_ns, length_s) = times.sides.right_ends_ns(principal, robot), span
    if ends_ns is None or start_ns + length_s * SECOND_NS <= ends_ns + TO_THE_MINUTE_NS:
        return ""
    zone, shown = times.sides.zone_of(principal), times.shown(robot)
    at = moment(ends_ns, times.clock.wall_ns(), zone)
    if start_ns >= ends_ns:
        raise OutOfBounds(words.right_ends_before(shown, at), offers=(f"ask {robot}",))
    return words.right_ends_within(shown, at)


def _slot_of(fact: Fact) -> BookedSlot | None:
    return read_fact(fact, BookedSlot) if fact.kind == SLOT else None


def _without_where_free(text: str) -> tuple[str, bool]:
    words_said = text.split()
    if tuple(fold(word) for word in words_said[-2:]) == WHERE_FREE:
        return " ".join(words_said[:-2]), True
    return text, False


def _pattern(when: RequestedTime, zone: Zone) -> Pattern:
    return Pattern(when.start, when.length_s, when.rrule, zone.name)


def _moved(slots: tuple[BookedSlot, ...], when: RequestedTime, zone: Zone) -> str:
    """Return what to know about the first time that the clocks skip; mostly nothing."""
    minute = when.start.minute_of_day
    starts = (zone.local(slot.start_ns) for slot in slots)
    odd = next((start for start in starts if start.minute_of_day != minute), None)
    return words.moved(odd, zone) if odd is not None else ""
