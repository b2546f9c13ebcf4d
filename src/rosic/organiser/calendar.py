"""Who has which robot when: Algorithm 3 of the paper, without its chat.

What decides returns the facts to be written and changes nothing; `apply` makes a fact so, now and
at the next start. The caller lets nothing else change in between.
"""

from __future__ import annotations

from collections.abc import Callable
from hashlib import blake2b
from itertools import chain, count, islice
from typing import TYPE_CHECKING, NamedTuple, TypeAlias

import msgspec

from rosic.core.identity import RECORD_ID_BYTES
from rosic.core.slot import BookedSlot, Pattern, Series, SeriesId, SlotId
from rosic.core.time_units import DAY_NS, DAY_S, SECOND_NS
from rosic.errors import Expired, NotPermitted, NotUnderstood, OutOfBounds, TooManyRequests
from rosic.organiser import calendar_messages as words
from rosic.organiser.calendar_conflicts import OutsideSlot, SlotConflict, SlotTaken
from rosic.organiser.calendar_index import CalendarIndex
from rosic.organiser.recurrence import SeriesLimits, occasions
from rosic.organiser.timezones import UNIVERSAL, zone_named

if TYPE_CHECKING:
    from rosic.contracts.clock import Clock
    from rosic.core.identity import PrincipalId
    from rosic.core.records import Fact
    from rosic.core.robot.profile import RobotId
    from rosic.core.slot import SlotRule
    from rosic.errors import Refusal
    from rosic.organiser.timezones import Zone

Named: TypeAlias = Callable[[str], str]


class CalendarNames(NamedTuple):
    """What is called how in sentences about times.

    Attributes:
        name_of: A principal's name.
        shown_of: A robot's title.
        zone_of: The IANA zone in which a principal reads times.
    """

    name_of: Named
    shown_of: Named
    zone_of: Named


class Calendar(CalendarIndex):
    """The slots of all robots, and what may be booked or moved by whom.

    Attributes:
        limits: What may be booked.
        name_of, shown_of, zone_of: As in `CalendarNames`.
    """

    def __init__(
        self, clock: Clock, names: CalendarNames, limits: SeriesLimits | None = None
    ) -> None:
        self.limits = limits or SeriesLimits()
        super().__init__(clock, self.limits.warnings_s)
        self.name_of, self.shown_of, self.zone_of = names
        self._count = count()

    # ---- booking ----

    def book(
        self, principal: PrincipalId, robot: RobotId, start_ns: int, length_s: int, by: PrincipalId
    ) -> tuple[Fact, ...]:
        """Decide on one slot.

        Args:
            principal: Whose it is to be.
            robot: Which one.
            start_ns: Wall clock, UTC.
            length_s: Any number; what is no length is refused.
            by: Who asks; the sentence is for them, in their zone.

        Raises:
            OutOfBounds: Over, too short, too long, too far ahead.
            TooManyRequests: The person has enough, or the calendar is full.
            SlotTaken: By whom, until when, and when it is free.
        """
        now_ns = self._clock.wall_ns()
        self._check_length(length_s)
        self._check_start(start_ns, now_ns, by)
        self._check_share(principal, 1, now_ns)
        end_ns = start_ns + length_s * SECOND_NS
        other = self._line(robot).overlapping(start_ns, end_ns)
        if other is not None:
            raise self._taken(other, by, end_ns - start_ns, now_ns)
        return (self._slot(principal, robot, (start_ns, end_ns), by, "").fact(),)

    def book_series(
        self,
        principal: PrincipalId,
        robot: RobotId,
        pattern: Pattern,
        by: PrincipalId,
        *,
        skip_taken: bool = False,
    ) -> tuple[Fact, ...]:
        """Decide on a slot that comes again: all of them, or none.

        Args:
            principal: Whose they are to be.
            robot: Which one.
            pattern: Not yet looked at.
            by: Who asks.
            skip_taken: Leave out what somebody has already, instead of refusing.

        Raises:
            NotUnderstood: The rule is malformed, or does not say until when.
            OutOfBounds, TooManyRequests: As `book`; also no such zone, too many occurrences.
            SlotTaken: The first that is taken.
        """
        now_ns = self._clock.wall_ns()
        self._check_length(pattern.length_s)
        try:
            found = occasions(pattern, now_ns, self.limits)
        except NotUnderstood as refusal:
            offer = words.pattern_typed(robot, pattern)
            if offer and not refusal.offers:
                refusal.offering((offer,))
            raise
        self._check_start(found[0].start_ns, now_ns, by)
        self._check_start(found[-1].start_ns, now_ns, by)
        length_ns = pattern.length_s * SECOND_NS
        spans = [(one.start_ns, one.start_ns + length_ns) for one in found]
        others = [self._line(robot).overlapping(*span) for span in spans]
        free = [span for span, other in zip(spans, others, strict=True) if other is None]
        if not free or (len(free) < len(spans) and not skip_taken):
            raise self._series_taken([o for o in others if o is not None], len(spans), by, now_ns)
        self._check_share(principal, len(free), now_ns)
        key = self._new_id(principal, robot, "series", str(spans[0][0]), str(now_ns))
        series = Series(
            id=key, principal=principal, robot=robot, pattern=pattern, made_ns=now_ns, by=by
        )
        slots = (self._slot(principal, robot, span, by, key) for span in free)
        return (series.fact(), *(slot.fact() for slot in slots))

    def _slot(
        self,
        principal: PrincipalId,
        robot: RobotId,
        span: tuple[int, int],
        by: PrincipalId,
        series: SeriesId,
    ) -> BookedSlot:
        made_ns = self._clock.wall_ns()
        key = self._new_id(principal, robot, series, str(span[0]), str(made_ns))
        return BookedSlot(
            id=key,
            principal=principal,
            robot=robot,
            start_ns=span[0],
            end_ns=span[1],
            series=series,
            made_ns=made_ns,
            by=by,
        )

    def _new_id(self, *parts: str) -> str:
        """Return an id that no slot had before, even if the clock stands still."""
        numbered = (*parts, str(next(self._count)))
        return blake2b(ascii(numbered).encode(), digest_size=RECORD_ID_BYTES).hexdigest()

    def _check_length(self, length_s: int) -> None:
        limits = self.limits
        if length_s <= 0:
            raise OutOfBounds(words.not_positive())
        if length_s < limits.shortest_s:
            raise OutOfBounds(words.too_short(limits.shortest_s))
        if length_s > limits.longest_s:
            raise OutOfBounds(words.too_long(limits.longest_s))

    def _check_start(self, start_ns: int, now_ns: int, by: PrincipalId) -> None:
        zone = self.zone(by)
        if start_ns < now_ns - self.limits.grace_s * SECOND_NS:
            now = words.moment(now_ns, now_ns, zone)
            began = words.moment(max(start_ns, DAY_NS), now_ns, zone)
            raise OutOfBounds(words.over(began, now))
        last_ns = now_ns + self.limits.ahead_s * SECOND_NS
        if start_ns > last_ns:
            last = words.day(zone.local(last_ns), zone.local(now_ns))
            raise OutOfBounds(words.too_far(last))

    def _check_share(self, principal: PrincipalId, more: int, now_ns: int) -> None:
        limits = self.limits
        upcoming = [slot.end_ns for slot in self._upcoming(principal, now_ns)]
        if len(upcoming) + more > limits.most_upcoming:
            wait_ns = min(upcoming, default=now_ns) - now_ns
            raise TooManyRequests(
                words.too_many(limits.most_upcoming), retry_after_s=wait_ns / SECOND_NS
            )
        if len(self._slots) + more > limits.most_in_all:
            raise TooManyRequests(words.calendar_full(), retry_after_s=float(DAY_S))

    # ---- moving ----

    def move(
        self,
        slot_id: SlotId,
        start_ns: int,
        length_s: int,
        by: PrincipalId,
        *,
        anybodys: bool = False,
    ) -> tuple[Fact, ...]:
        """Decide on another time for one slot, which stays the same slot: of one series, by one id.

        Of one that has begun, the end alone can be moved.

        Args:
            slot_id: Of one occurrence, if it is of a series.
            start_ns: Wall clock, UTC.
            length_s: As of `book`.
            by: Who asks.
            anybodys: Whether this person may move other people's.

        Raises:
            NotUnderstood: There is none.
            NotPermitted: It is somebody else's.
            Expired: It is over.
            OutOfBounds: As `book`; also its start is to be another, and it has begun.
            SlotTaken: By whom, until when, and when it is free.
        """
        now_ns, slot = self._clock.wall_ns(), self._givable(slot_id, by, anybodys=anybodys)
        self._check_length(length_s)
        end_ns = start_ns + length_s * SECOND_NS
        if slot.start_ns > now_ns:
            self._check_start(start_ns, now_ns, by)
        elif start_ns != slot.start_ns or end_ns <= now_ns:
            raise OutOfBounds(words.begun())
        for other in self._line(slot.robot).between(start_ns, end_ns):
            if other is not slot:
                raise self._taken(other, by, end_ns - start_ns, now_ns)
        return (msgspec.structs.replace(slot, start_ns=start_ns, end_ns=end_ns).fact(),)

    # ---- cancelling ----

    def cancel(
        self, slot_id: SlotId, by: PrincipalId, *, anybodys: bool = False
    ) -> tuple[Fact, ...]:
        """Decide on giving one slot back. One that has begun ends now; what was used stays said.

        Args:
            slot_id: Of one occurrence, if it is of a series.
            by: Who asks.
            anybodys: Whether this person may cancel other people's.

        Raises:
            NotUnderstood: There is none.
            NotPermitted: It is somebody else's.
            Expired: It is over.
        """
        slot = self._givable(slot_id, by, anybodys=anybodys)
        return (_given_back(slot, self._clock.wall_ns()),)

    def _givable(self, slot_id: SlotId, by: PrincipalId, *, anybodys: bool) -> BookedSlot:
        """Return a slot that is not over, and that this person may give back or move."""
        slot = self._slots.get(slot_id)
        if slot is None:
            raise NotUnderstood(words.no_such_time())
        self._check_owner(slot.principal, slot.robot, by, anybodys=anybodys)
        if slot.end_ns <= self._clock.wall_ns():
            raise Expired(words.already_over())
        return slot

    def cancel_series(
        self, series_id: SeriesId, by: PrincipalId, *, anybodys: bool = False
    ) -> tuple[Fact, ...]:
        """Decide on giving back all of a series that is still to come.

        Raises:
            NotUnderstood: There is none.
            NotPermitted: It is somebody else's.
        """
        series = self._series.get(series_id)
        if series is None:
            raise NotUnderstood(words.no_such_time())
        self._check_owner(series.principal, series.robot, by, anybodys=anybodys)
        now_ns = self._clock.wall_ns()
        slots = [s for s in self._upcoming(series.principal, now_ns) if s.series == series_id]
        return (series.no_more(), *(_given_back(slot, now_ns) for slot in slots))

    def end_all(self, principal: PrincipalId) -> tuple[Fact, ...]:
        """Return what takes everything to come away from somebody who is locked or leaves."""
        now_ns = self._clock.wall_ns()
        series = [s.no_more() for s in self._series.values() if s.principal == principal]
        return (*series, *(_given_back(s, now_ns) for s in self._upcoming(principal, now_ns)))

    def outdated(self, before_ns: int, most: int = 1000) -> tuple[Fact, ...]:
        """Return what forgets slots that ended before a time, and series that have no others.

        Not more than ``most`` at a time; nothing is left to forget when nothing is returned.
        """
        old = (s.no_more() for s in self._slots.values() if s.end_ns < before_ns)
        used = {slot.series for slot in self._slots.values() if slot.end_ns >= before_ns}
        done = (series.no_more() for key, series in self._series.items() if key not in used)
        return tuple(islice(chain(old, done), most))

    def _check_owner(
        self, owner: PrincipalId, robot: RobotId, by: PrincipalId, *, anybodys: bool
    ) -> None:
        if owner != by and not anybodys:
            raise NotPermitted(words.not_yours(self.shown_of(robot), self.name_of(owner)))

    # ---- may they, now? ----

    def why_not(
        self, principal: PrincipalId, robot: RobotId, now_ns: int, required: bool
    ) -> SlotConflict | None:
        """Return what keeps somebody from a robot now, by its slots alone; mostly None.

        ``required`` is the robot's rule: only in a slot of one's own, or (``respected``) also when
        it is nobody's. Where slots mean nothing (``none``), this is not asked.
        """
        slot = self.present(robot, now_ns)
        if slot is None and not required:
            return None
        if slot is not None and slot.principal == principal:
            return None
        coming = (s for s in self._upcoming(principal, now_ns) if s.robot == robot)
        return SlotConflict(
            robot=robot,
            now_ns=now_ns,
            required=required,
            slot=slot,
            own=next(coming, None),
            free_ns=self.next_free(
                robot, now_ns, self.limits.useful_s, None if required else principal
            ),
        )

    def outside(
        self, principal: PrincipalId, robot: RobotId, now_ns: int, rule: SlotRule
    ) -> Refusal | None:
        """Return what keeps somebody from a robot now as what they are told; None if nothing."""
        if rule == "none":
            return None
        conflict = self.why_not(principal, robot, now_ns, rule == "required")
        return None if conflict is None else self.refusal(conflict, principal)

    def refusal(self, conflict: SlotConflict, asking: PrincipalId) -> SlotTaken | OutsideSlot:
        """Return a hindrance as what the person is told, in their zone."""
        return conflict.refusal(
            self.shown_of(conflict.robot), self.name_of, self.zone(asking), self.limits.useful_s
        )

    # ---- refusals ----

    def zone(self, principal: PrincipalId) -> Zone:
        """Return the zone in which somebody reads and says times; of nobody, the place's."""
        try:
            return zone_named(self.zone_of(principal))
        except OutOfBounds:
            return zone_named(UNIVERSAL)

    def _taken(self, other: BookedSlot, by: PrincipalId, length_ns: int, now_ns: int) -> SlotTaken:
        zone, shown = self.zone(by), self.shown_of(other.robot)
        length_s = length_ns // SECOND_NS
        free_ns = self.next_free(other.robot, max(other.end_ns, now_ns), length_s)
        span = (
            words.moment(other.start_ns, now_ns, zone),
            words.moment(other.end_ns, now_ns, zone),
        )
        free = words.moment(free_ns, now_ns, zone)
        sentence = (
            words.taken_by_yourself(shown, span, free)
            if other.principal == by
            else words.taken(shown, self.name_of(other.principal), span, free)
        )
        offer = words.bookable(other.robot, free_ns, length_s, zone)
        return SlotTaken(sentence, slot=other, next_free_ns=free_ns, offers=(offer,))

    def _series_taken(
        self, others: list[BookedSlot], of_all: int, by: PrincipalId, now_ns: int
    ) -> SlotTaken:
        first = others[0]
        when = words.moment(first.start_ns, now_ns, self.zone(by))
        name = self.name_of(first.principal)
        sentence = words.series_taken(self.shown_of(first.robot), name, when, (len(others), of_all))
        return SlotTaken(sentence, slot=first, next_free_ns=first.end_ns)


def _given_back(slot: BookedSlot, now_ns: int) -> Fact:
    """Return what ends a slot now, or what takes away one that has not begun."""
    if now_ns <= slot.start_ns:
        return slot.no_more()
    return msgspec.structs.replace(slot, end_ns=now_ns).fact()
