"""``/slots``: my times, a robot's day, and the file for the calendar on somebody's phone."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosic.core.i18n import joined, said
from rosic.core.language.compiled import fold
from rosic.core.language.time_parser import RequestedTime, read_when
from rosic.core.local_time import LocalTime
from rosic.core.message import Attachment, Button
from rosic.core.robot.profile import RobotId, Slots
from rosic.core.time_units import HOUR_S, MINUTES_A_DAY, SECOND_NS
from rosic.errors import NotUnderstood
from rosic.features.booking import messages as words
from rosic.gateway.commands import Reply
from rosic.gateway.robot_argument import RobotArgument
from rosic.organiser.calendar_messages import bookable
from rosic.organiser.ical import icalendar

if TYPE_CHECKING:
    from rosic.core.identity import PrincipalId
    from rosic.core.slot import BookedSlot
    from rosic.features.booking.context import BookingContext
    from rosic.gateway.commands import CommandContext
    from rosic.organiser.timezones import Zone
    from rosic.organiser.wait_queue import TurnOffer


# ---- ``/slots`` ----

MOST_LINES = 20
FILE = "ics"
FILE_NAME = "my-times.ics"
MEDIA = "text/calendar"
_ENDS = ".,;:!?"


class SlotListing:
    """The handler who shows times."""

    def __init__(self, times: BookingContext) -> None:
        self._times = times
        self._naming = RobotArgument(times)

    async def show(self, asked: CommandContext) -> Reply:
        """Show one's own times, a robot's day, or the calendar file.

        Raises:
            Refusal: No such robot or day.
        """
        text = asked.rest.strip().rstrip(_ENDS)
        if not text:
            return self._mine(asked)
        if fold(text) == FILE and not self._naming.calls(asked, text):
            return self._file(asked)
        robot, rest = self._naming.robot(asked, "slots", text, nameless=self._is_day(asked, text))
        return self._day(asked, robot, self._which_day(asked, robot, rest))

    # ---- mine ----

    def _mine(self, asked: CommandContext) -> Reply:
        times, principal = self._times, asked.caller.principal
        zone, now_ns = times.sides.zone_of(principal), times.clock.wall_ns()
        slots = times.upcoming(principal)
        lines = [words.my_times(zone)] if slots else [words.NO_TIMES]
        lines += [words.mine(times.shown(s.robot), s, now_ns, zone) for s in slots[:MOST_LINES]]
        if len(slots) > MOST_LINES:
            lines.append(words.and_more(len(slots) - MOST_LINES))
        waiting = times.waiting
        for robot in sorted(waiting.waits_for(principal)):
            lines.append(words.in_queue(times.shown(robot), waiting.place(principal, robot)))
        buttons = ((Button(said("Cancel one"), words.CANCEL),),) if slots else ()
        return Reply(joined("\n", lines), buttons)

    def _file(self, asked: CommandContext) -> Reply:
        """Return the calendar as a file; where none can be sent, as its text, to be copied."""
        times, principal = self._times, asked.caller.principal
        name = times.calendar.name_of(principal)
        slots = times.upcoming(principal)
        content = icalendar(slots, name, lambda slot: times.shown(slot.robot))
        if len(content) > asked.messenger.file_bytes:
            return Reply(content.decode())
        return Reply(words.CALENDAR_FILE, attachment=Attachment(FILE_NAME, MEDIA, content))

    # ---- a robot's day ----

    def _is_day(self, asked: CommandContext, text: str) -> bool:
        return self._read_day(asked, text) is not None

    def _which_day(self, asked: CommandContext, robot: RobotId, text: str) -> LocalTime:
        day = self._read_day(asked, text or "today")
        if day is None:
            raise NotUnderstood(words.WHICH_DAY, offers=(f"slots {robot} tomorrow",))
        return day

    def _read_day(self, asked: CommandContext, text: str) -> LocalTime | None:
        """Read a day alone: with the last minute of it said, it is a time like any other."""
        zone = self._times.sides.zone_of(asked.caller.principal)
        when = read_when(f"{text} 23:59 1 min", self._times.clock.wall_ns(), zone.local)
        if not isinstance(when, RequestedTime) or when.rrule or when.start_ns is not None:
            return None
        day = LocalTime.at(when.start.day_number)
        try:
            day.later(MINUTES_A_DAY)
        except ValueError:  # the last one there is
            return None
        return day

    def _day(self, asked: CommandContext, robot: RobotId, day: LocalTime) -> Reply:
        times, principal = self._times, asked.caller.principal
        shown, zone = times.shown(robot), times.sides.zone_of(principal)
        if times.vocabulary.profiles[robot].slots is Slots.NONE:
            return Reply(words.whoever_first(shown))
        from_ns = zone.instant(day).start_ns
        to_ns = zone.instant(day.later(MINUTES_A_DAY)).start_ns
        slots = times.calendar.on(robot, from_ns, to_ns)
        lines = [words.day_of(shown, day, zone) if slots else words.day_free(shown, day, zone)]
        for slot in slots[:MOST_LINES]:
            mine = slot.principal == principal
            who = "" if mine else times.calendar.name_of(slot.principal)
            lines.append(words.day_line(slot, who, day, zone))
        if len(slots) > MOST_LINES:
            lines.append(words.and_more(len(slots) - MOST_LINES))
        elif slots:
            lines.append(words.otherwise_free())
        return Reply(joined("\n", lines), self._buttons(principal, robot, day, zone))

    def _buttons(
        self, principal: PrincipalId, robot: RobotId, day: LocalTime, zone: Zone
    ) -> tuple[tuple[Button, ...], ...]:
        """Return the first free hour of the day, if there is one, and the day after."""
        times, after = self._times, day.later(MINUTES_A_DAY)
        from_ns = max(zone.instant(day).start_ns, times.clock.wall_ns())
        free_ns = times.calendar.next_free(robot, from_ns, HOUR_S)
        row = [Button(said("Next day"), f"/slots {robot} {after.date_text()}")]
        may = times.sides.may_book(principal, robot) is None
        if may and free_ns < zone.instant(after).start_ns:
            line = bookable(robot, free_ns, HOUR_S, zone)
            row.insert(0, Button(said("Book {at} for 1 h", at=line.split()[3]), f"/{line}"))
        return (tuple(row),)


# ---- availability ----

SHORTEST_TURN_S = 300
"""A gap shorter than the first warning before its end is nobody's turn."""


class Availability:
    """Looks at slots and leases together.

    Attributes:
        barred: Robots that come to rest, or have not confirmed it: nobody's, whatever slots say.
    """

    def __init__(self, times: BookingContext) -> None:
        self.barred: set[RobotId] = set()
        self._times = times
        self._idle_ns = int(times.lease_idle_s * SECOND_NS)

    def booked(self, robot: RobotId) -> bool:
        """Whether slots mean anything for a robot."""
        profile = self._times.vocabulary.profiles.get(robot)
        return profile is not None and profile.slots is not Slots.NONE

    def holder(self, robot: RobotId) -> PrincipalId | None:
        """Return who has a robot by its lease."""
        now_ns = self._times.clock.monotonic_ns()
        return self._times.sides.lease(robot).holder_at(now_ns, self._idle_ns)

    def lapses_ns(self, robot: RobotId) -> int | None:
        """Return when a lease lapses by itself, monotonic clock; None while it is used, or not."""
        lease = self._times.sides.lease(robot)
        if self.holder(robot) is None or lease.active:
            return None
        return lease.idle_since_ns + self._idle_ns

    def slot(self, robot: RobotId) -> BookedSlot | None:
        """Return the slot that is now, if slots mean anything for the robot."""
        if not self.booked(robot):
            return None
        return self._times.calendar.present(robot, self._times.clock.wall_ns())

    def has(self, principal: PrincipalId, robot: RobotId) -> bool:
        """Whether a robot is somebody's now, by slot or lease."""
        slot = self.slot(robot)
        if slot is not None:
            return slot.principal == principal
        return self.holder(robot) == principal

    def keep(self, offer: TurnOffer) -> None:
        """Let nobody else have a robot while it is offered to somebody."""
        now_ns = self._times.clock.monotonic_ns()
        lease = self._times.sides.lease(offer.robot)
        lease.keep(offer.principal, offer.expires_ns, now_ns, self._idle_ns)

    def give(self, robot: RobotId, principal: PrincipalId) -> None:
        """Let somebody have a robot as if they had just used it."""
        now_ns = self._times.clock.monotonic_ns()
        lease = self._times.sides.lease(robot)
        if not lease.active:
            lease.keep(principal, now_ns + self._idle_ns, now_ns, self._idle_ns)

    def give_up(self, offer: TurnOffer) -> None:
        """Keep it no longer; whoever uses it goes on."""
        if self.is_only_kept(offer):
            self._times.sides.lease(offer.robot).release()

    def is_only_kept(self, offer: TurnOffer) -> bool:
        """Whether somebody has a robot only because it is offered to them."""
        lease = self._times.sides.lease(offer.robot)
        kept = lease.is_kept(offer.expires_ns, self._idle_ns)
        return kept and self.slot(offer.robot) is None and self.holder(offer.robot) is not None

    def free_for(self, robot: RobotId, principal: PrincipalId) -> bool:
        """Whether somebody could have a robot now, for a while."""
        times = self._times
        if robot in self.barred or not times.sides.ready(robot):
            return False
        if self.holder(robot) not in {None, principal}:
            return False
        if not self.booked(robot):
            return True
        now_ns = times.clock.wall_ns()
        return times.calendar.next_free(robot, now_ns, SHORTEST_TURN_S, principal) <= now_ns

    def turn(self, robot: RobotId) -> tuple[int, int]:
        """Return the start (wall clock) and the length in seconds of a turn from now on.

        It ends where the next slot begins, whosever that is; before one, it begins up to a second
        later, so that nothing lies between them.
        """
        times = self._times
        now_ns, usual_s = times.clock.wall_ns(), times.waiting.limits.usual_s
        following = times.calendar.next_of(robot, now_ns)
        if following is None or following.start_ns >= now_ns + usual_s * SECOND_NS:
            return now_ns, usual_s
        length_s = (following.start_ns - now_ns) // SECOND_NS
        return following.start_ns - length_s * SECOND_NS, length_s
