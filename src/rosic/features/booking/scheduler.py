"""The one task that follows the calendar: starts, warnings, ends, and whose turn it is."""

from __future__ import annotations

import asyncio
import logging
from typing import TYPE_CHECKING

from rosic.core.local_time import MINUTE_NS
from rosic.core.message import Button
from rosic.errors import Refusal
from rosic.features.booking import keeper_messages
from rosic.features.booking.ending import SlotEnd
from rosic.features.booking.idle_release import IdleSlotRelease
from rosic.features.booking.turn_offer import TurnOffers
from rosic.features.booking.vacancy import SECOND_NS, Availability
from rosic.gateway.waking import sleep_or_wake
from rosic.organiser.calendar_messages import moment

if TYPE_CHECKING:
    from rosic.core.identity import PrincipalId
    from rosic.core.robot.profile import RobotId
    from rosic.core.slot import BookedSlot
    from rosic.features.booking.context import BookingContext
    from rosic.organiser.calendar_events import CalendarEvent

LONGEST_SLEEP_NS = 20 * SECOND_NS
"""The wall clock may be set while this sleeps: that is seen after so long at the latest."""
AGAIN_NS = 10 * SECOND_NS
"""After something failed."""

log = logging.getLogger("rosic.times")


class BookingScheduler:
    """Sleeps until something is due, and tells or does it, once.

    Attributes:
        vacancy: Who could have which robot now.
    """

    def __init__(self, times: BookingContext) -> None:
        self.vacancy = Availability(times)
        self._times = times
        self._woken = asyncio.Event()
        self._ending = SlotEnd(times, self.vacancy, self.look)
        self._unused = IdleSlotRelease(times, self.vacancy)
        self._offering = TurnOffers(times, self.vacancy)

    def look(self) -> None:
        """Look again soon: something was booked, given back, or an order has ended."""
        self._woken.set()

    def keep(self, principal: PrincipalId, robot: RobotId) -> bool:
        """Count a slot as used just now. Return False if it is not this person's."""
        return self._unused.keep(principal, robot)

    async def run(self) -> None:
        """Follow the calendar until cancelled. What fails is logged and tried again."""
        while True:
            self._woken.clear()
            try:
                wake_ns = await self._follow()
            except Refusal as refusal:
                log.warning("times could not be followed: %s", refusal)
                wake_ns = self._times.clock.monotonic_ns() + AGAIN_NS
            except Exception:
                log.exception("times could not be followed")
                wake_ns = self._times.clock.monotonic_ns() + AGAIN_NS
            await self._sleep(wake_ns)

    async def close(self) -> None:
        """Wait for robots that come to rest, briefly."""
        await self._ending.close()

    async def _follow(self) -> int:
        """Do all that is due, and return when to look again, monotonic clock."""
        times = self._times
        await self._ring(times.calendar.due(times.clock.wall_ns()))
        wakes = [self._ending.seen_to(), await self._offering.pass_on()]
        wanted = [r for r in times.waiting.wanted() if r in times.vocabulary.profiles]
        wakes.extend([await self._attend(robot) for robot in wanted])
        # What all this has written may ring, too: it is looked at before sleeping.
        now_ns, wall_ns = times.clock.monotonic_ns(), times.clock.wall_ns()
        next_ns = times.calendar.next_event_ns()
        if next_ns is not None:
            wakes.append(now_ns + next_ns - wall_ns)
        return min((ns for ns in wakes if ns is not None), default=now_ns + LONGEST_SLEEP_NS)

    async def _attend(self, robot: RobotId) -> int | None:
        """See to a robot that somebody waits for; a fault with one holds no other up."""
        try:
            unused_ns = await self._unused.look_at(robot)
            offer_ns = await self._offering.offer(robot)
        except Refusal:
            raise
        except Exception:
            log.exception("nobody can be offered %s now", robot)
            return self._times.clock.monotonic_ns() + AGAIN_NS
        return min((ns for ns in (unused_ns, offer_ns) if ns is not None), default=None)

    async def _sleep(self, wake_ns: int) -> None:
        delay_ns = min(wake_ns - self._times.clock.monotonic_ns(), LONGEST_SLEEP_NS)
        if delay_ns <= 0 or self._woken.is_set():
            await asyncio.sleep(0)
            return
        # Half a nanosecond more: whole ones survive becoming seconds and back.
        seconds = (delay_ns + 0.5) / SECOND_NS
        await sleep_or_wake(self._times.clock, seconds, self._woken)

    # ---- bells ----

    async def _ring(self, events: tuple[CalendarEvent, ...]) -> None:
        """Tell starts and warnings; let those come to rest whose time is over."""
        events = tuple([event for event in events if not await self._takes_back(event)])
        ended: dict[RobotId, set[PrincipalId]] = {}
        for event in events:
            robot = event.slot.robot
            if not self.vacancy.booked(robot):
                continue
            if event.kind == "start":
                ended.setdefault(robot, set())
                self._unused.begins(event.slot)
            elif event.kind == "end":
                ended.setdefault(robot, set()).add(event.slot.principal)
        for robot, people in ended.items():
            self._ending.change_over(robot, people)
        for event in events:
            if not event.overtaken and self.vacancy.booked(event.slot.robot):
                self._tell(event)

    async def _takes_back(self, event: CalendarEvent) -> bool:
        """Let no slot begin whose owner has lost the right: nobody gives way to them."""
        slot = event.slot
        if event.kind != "start" or self.vacancy.slot(slot.robot) is not slot:
            return False
        return await self._unused.takes_back(slot)

    def _tell(self, event: CalendarEvent) -> None:
        slot = event.slot
        if event.kind == "start":
            self._starts(slot)
        elif event.kind == "warning":
            self._warn(slot)

    def _starts(self, slot: BookedSlot) -> None:
        """Tell the owner, unless they were told just now, or have to wait until it is at rest."""
        told_just_now = slot.by == slot.principal and slot.start_ns - slot.made_ns < MINUTE_NS
        if self._ending.is_unsure(slot.robot):
            self._ending.tell_to_wait(slot)
        elif slot.robot not in self.vacancy.barred and not told_just_now:
            self._begins(slot)

    def _begins(self, slot: BookedSlot) -> None:
        times = self._times
        shown, until = times.shown(slot.robot), self._moment(slot, slot.end_ns)
        holder = self.vacancy.holder(slot.robot)
        if holder not in {None, slot.principal}:
            said = keeper_messages.begins_taken(shown, times.calendar.name_of(holder or ""))
            times.reach.tell((slot.principal,), said)
            return
        menu = Button(shown, f"/use {slot.robot}")
        times.reach.tell((slot.principal,), keeper_messages.begins(shown, until), ((menu,),))

    def _warn(self, slot: BookedSlot) -> None:
        """Say how long it goes on from now on, which after a pause is less than the bell says."""
        times = self._times
        following = times.calendar.present(slot.robot, slot.end_ns)
        if following is not None and following.principal == slot.principal:
            return  # it goes on
        left_s = -(-(slot.end_ns - times.clock.wall_ns()) // SECOND_NS)
        said = keeper_messages.ends_soon(
            times.shown(slot.robot), left_s, self._moment(slot, slot.end_ns)
        )
        times.reach.tell((slot.principal,), said)

    def _moment(self, slot: BookedSlot, at_ns: int) -> str:
        zone = self._times.sides.zone_of(slot.principal)
        return moment(at_ns, self._times.clock.wall_ns(), zone)
