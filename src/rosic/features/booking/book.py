"""``/book kuka1 tomorrow 14:00 1h``, ``/book kuka1 every tue 14:00 1h until 2027-02-01``."""

from __future__ import annotations

from contextlib import suppress
from typing import TYPE_CHECKING

from rosic.core.i18n import said
from rosic.core.language.ast import Misunderstood
from rosic.core.language.compiled import fold
from rosic.core.language.syntax_errors import LONGEST_OFFER
from rosic.core.language.time_parser import RequestedTime, read_when
from rosic.core.message import Button
from rosic.core.robot.profile import Slots
from rosic.core.slot import SLOT, BookedSlot, Pattern, read_fact
from rosic.core.time_units import MINUTE_NS, SECOND_NS
from rosic.errors import NotUnderstood, OutOfBounds, Refusal
from rosic.features.booking import messages as words
from rosic.features.booking.context import decided
from rosic.gateway.commands import Reply
from rosic.gateway.robot_argument import RobotArgument
from rosic.organiser.calendar_conflicts import SlotTaken
from rosic.organiser.calendar_messages import moment
from rosic.organiser.recurrence import occasion, occasions

if TYPE_CHECKING:
    from rosic.core.identity import PrincipalId
    from rosic.core.records import Fact
    from rosic.core.robot.profile import RobotId
    from rosic.features.booking.context import BookingContext
    from rosic.gateway.commands import CommandContext
    from rosic.gateway.transactions import UnitOfWork
    from rosic.organiser.timezones import Zone

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
                taken.offers = taken.offers or self._instead(taken, principal, when, rest)
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

    def _check_right(
        self, principal: PrincipalId, robot: RobotId, start_ns: int, length_s: int
    ) -> str:
        """See that a time begins while there still is a right to it.

        Returns:
            That the right ends before the time does, if so.

        Raises:
            OutOfBounds: The right ends sooner than it begins.
        """
        times = self._times
        ends_ns = times.sides.right_ends_ns(principal, robot)
        if ends_ns is None or start_ns + length_s * SECOND_NS <= ends_ns + TO_THE_MINUTE_NS:
            return ""
        zone, shown = times.sides.zone_of(principal), times.shown(robot)
        at = moment(ends_ns, times.clock.wall_ns(), zone)
        if start_ns >= ends_ns:
            raise OutOfBounds(words.right_ends_before(shown, at), offers=(f"ask {robot}",))
        return words.right_ends_within(shown, at)

    async def _once(
        self, turn: UnitOfWork, principal: PrincipalId, robot: RobotId, when: RequestedTime
    ) -> Reply:
        times = self._times
        zone = times.sides.zone_of(principal)
        found = occasion(robot, when, zone)
        late = self._check_right(principal, robot, found.start_ns, found.length_s)
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
        late = self._check_right(principal, robot, last_ns, pattern.length_s)
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
