"""The one task that follows the calendar: starts, warnings, ends, and whose turn it is."""

from __future__ import annotations

import asyncio
import logging
from typing import TYPE_CHECKING

from rosic.core.i18n import said
from rosic.core.message import Button
from rosic.core.time_units import MINUTE_NS, SECOND_NS
from rosic.errors import Refusal
from rosic.features.booking import messages as words
from rosic.features.booking import scheduler_messages
from rosic.features.booking.slots import Availability
from rosic.features.booking.turn_offer import IdleSlotRelease, TurnOffers
from rosic.gateway.scheduling import sleep_or_wake
from rosic.organiser.calendar_messages import moment

if TYPE_CHECKING:
    from collections.abc import Callable

    from rosic.core.identity import PrincipalId
    from rosic.core.robot.profile import RobotId
    from rosic.core.slot import BookedSlot
    from rosic.features.booking.context import BookingContext
    from rosic.organiser.calendar_events import CalendarEvent


# ---- handing over ----

POLL_NS = 5 * SECOND_NS
"""So often it is looked at whether a robot that was not at rest has been resumed."""
AGAIN_S = 10.0
"""After a handover that failed."""
CLOSE_WITHIN_S = 2.0

log = logging.getLogger("rosic.booking")


class SlotEnd:
    """Takes robots from those whose time is over. The next one begins only after measured rest.

    Args:
        look: Called when a robot may have become free.
    """

    def __init__(
        self, times: BookingContext, availability: Availability, look: Callable[[], None]
    ) -> None:
        self._times = times
        self._availability = availability
        self._look = look
        self._under_way: dict[RobotId, asyncio.Task[None]] = {}
        self._unsure: set[RobotId] = set()

    def change_over(self, robot: RobotId, ended: set[PrincipalId]) -> None:
        """A slot of a robot has begun or ended: take the robot from whoever should not have it.

        Args:
            robot: Which one.
            ended: Whose slots have ended just now.
        """
        holder, slot = self._availability.holder(robot), self._availability.slot(robot)
        if holder is None or robot in self._under_way:
            return
        if slot is None and holder not in ended:
            return  # somebody who needs no slot while it is nobody's time
        if slot is not None and (
            slot.principal == holder or self._times.sides.may_stay(holder, slot)
        ):
            return
        self._begin(robot, holder, words.OVER if holder in ended else words.BEGUN)

    def is_unsure(self, robot: RobotId) -> bool:
        """Whether a robot was asked to come to rest and has not confirmed it."""
        return robot in self._unsure

    def seen_to(self) -> int | None:
        """Let robots go that somebody has looked at and resumed; return when to look next."""
        for robot in tuple(self._unsure):
            if self._times.sides.ready(robot):
                self._unsure.discard(robot)
                self._availability.barred.discard(robot)
                self._tell_begins(robot, "")
        return self._times.clock.monotonic_ns() + POLL_NS if self._unsure else None

    def _begin(self, robot: RobotId, holder: PrincipalId, reason: str) -> None:
        self._availability.barred.add(robot)
        self._times.waiting.withdraw(robot)
        task = asyncio.create_task(self._hand_over(robot, holder, reason))
        self._under_way[robot] = task

    async def _hand_over(self, robot: RobotId, holder: PrincipalId, reason: str) -> None:
        try:
            at_rest = await self._measured(robot, holder, reason)
        finally:
            self._under_way.pop(robot, None)
        if at_rest:
            self._unsure.discard(robot)
            self._availability.barred.discard(robot)
        else:
            self._unsure.add(robot)
        self._tell_holder(robot, holder, reason, at_rest=at_rest)
        if at_rest:
            self._tell_begins(robot, holder)
        else:
            self._tell_wait(robot, holder)
        self._look()

    async def _measured(self, robot: RobotId, holder: PrincipalId, reason: str) -> bool:
        """Return whether rest was confirmed; until that is known the robot is nobody's."""
        told = False
        while True:
            try:
                return await self._times.sides.handover(robot, reason)
            except Exception:
                log.exception("%s could not be handed over", robot)
            if not told:
                sentence = scheduler_messages.no_answer(self._times.shown(robot))
                self._times.reach.tell((holder,), sentence, urgent=True)
                told = True
            await self._times.clock.sleep(AGAIN_S)

    def _tell_holder(
        self, robot: RobotId, holder: PrincipalId, reason: str, *, at_rest: bool
    ) -> None:
        times, shown = self._times, self._times.shown(robot)
        slot = self._availability.slot(robot)
        if reason == words.OVER or slot is None:
            sentence = scheduler_messages.ended(shown, at_rest=at_rest)
        else:
            name = times.calendar.name_of(slot.principal)
            sentence = scheduler_messages.taken_over(shown, name, at_rest=at_rest)
        times.reach.tell((holder,), sentence)

    def _tell_begins(self, robot: RobotId, before: PrincipalId) -> None:
        """Tell whose slot it is that they can begin; who waits in the queue is offered it."""
        slot = self._availability.slot(robot)
        if slot is not None and slot.principal != before:
            times, shown = self._times, self._times.shown(robot)
            zone = times.sides.zone_of(slot.principal)
            until = moment(slot.end_ns, times.clock.wall_ns(), zone)
            menu = Button(shown, f"/use {robot}")
            times.reach.tell((slot.principal,), scheduler_messages.begins(shown, until), ((menu,),))

    def _tell_wait(self, robot: RobotId, before: PrincipalId) -> None:
        slot = self._availability.slot(robot)
        if slot is not None and slot.principal != before:
            self.tell_to_wait(slot)

    def tell_to_wait(self, slot: BookedSlot) -> None:
        """Tell an owner that their time has begun and the robot has not confirmed rest."""
        shown, barred = self._times.shown(slot.robot), self._times.sides.barred(slot.robot)
        if barred is not None:
            said_so = scheduler_messages.cannot_begin(shown, barred.sentence)
            self._times.reach.tell((slot.principal,), said_so)
            return
        resume = Button(said("Resume {shown}", shown=shown), f"/resume {slot.robot}")
        may = self._times.sides.may_resume(slot.principal, slot.robot)
        rows = ((resume,),) if may else ()
        self._times.reach.tell((slot.principal,), scheduler_messages.wait_for_rest(shown), rows)

    async def close(self) -> None:
        """Wait for what is under way, briefly, and let go of the rest."""
        under_way = tuple(self._under_way.values())
        if under_way:
            await asyncio.wait(under_way, timeout=CLOSE_WITHIN_S)
        for task in under_way:
            task.cancel()
        await asyncio.gather(*under_way, return_exceptions=True)


# ---- following the calendar ----

LONGEST_SLEEP_NS = 20 * SECOND_NS
"""The wall clock may be set while this sleeps: that is seen after so long at the latest."""
AGAIN_NS = 10 * SECOND_NS
"""After something failed."""


class BookingScheduler:
    """Sleeps until something is due, and tells or does it, once.

    Attributes:
        availability: Who could have which robot now.
    """

    def __init__(self, times: BookingContext) -> None:
        self.availability = Availability(times)
        self._times = times
        self._woken = asyncio.Event()
        self._serving: asyncio.Task[int] | None = None
        self._ending = SlotEnd(times, self.availability, self.look)
        self._unused = IdleSlotRelease(times, self.availability)
        self._offering = TurnOffers(times, self.availability)

    def look(self) -> None:
        """Look again soon: something was booked, given back, or an order has ended."""
        self._woken.set()

    def keep(self, principal: PrincipalId, robot: RobotId) -> bool:
        """Count a slot as used just now. Return False if it is not this person's."""
        return self._unused.keep(principal, robot)

    async def run(self) -> None:
        """Follow the calendar until cancelled. What fails is logged and tried again."""
        try:
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
        finally:
            if self._serving is not None:
                self._serving.cancel()

    async def close(self) -> None:
        """Wait for robots that come to rest, briefly."""
        await self._ending.close()

    async def _follow(self) -> int:
        """Do all that is due, and return when to look again, monotonic clock.

        Whoever waits for a robot is served after what begins and ends. That writes, and a disk that
        hangs neither writes nor fails: meanwhile everything ends in its time (I8).
        """
        times = self._times
        await self._ring(times.calendar.due(times.clock.wall_ns()))
        due_ns = self._due_ns()
        begun = self._serving is None
        serving = self._serving or asyncio.create_task(self._serve())
        self._serving = serving
        if not serving.done():
            await self._until(serving, due_ns)
        if not serving.done():
            return due_ns
        self._serving = None
        if not begun:  # something may have changed since it looked
            return times.clock.monotonic_ns()
        # What it has written may ring, too: it is looked at before sleeping.
        return min(serving.result(), self._due_ns())

    def _due_ns(self) -> int:
        """Return when the next thing begins or ends, monotonic clock; or when to look again."""
        times, now_ns = self._times, self._times.clock.monotonic_ns()
        wakes = [now_ns + LONGEST_SLEEP_NS, self._ending.seen_to()]
        next_ns = times.calendar.next_event_ns()
        if next_ns is not None:
            wakes.append(now_ns + next_ns - times.clock.wall_ns())
        return min(ns for ns in wakes if ns is not None)

    async def _until(self, serving: asyncio.Task[int], due_ns: int) -> None:
        """Wait until those who wait are served, or something else is due, or has changed."""
        left_s = max(0, due_ns - self._times.clock.monotonic_ns()) / SECOND_NS
        sleeping = asyncio.create_task(sleep_or_wake(self._times.clock, left_s, self._woken))
        try:
            await asyncio.wait((serving, sleeping), return_when=asyncio.FIRST_COMPLETED)
        finally:
            sleeping.cancel()

    async def _serve(self) -> int:
        """See to everybody who waits; return when to do so again, monotonic clock.

        Raises:
            RecordUnavailable: Not all could be written.
        """
        times = self._times
        wakes = [await self._offering.pass_on()]
        wanted = [r for r in times.waiting.wanted() if r in times.vocabulary.profiles]
        wakes.extend([await self._attend(robot) for robot in wanted])
        longest_ns = times.clock.monotonic_ns() + LONGEST_SLEEP_NS
        return min((ns for ns in wakes if ns is not None), default=longest_ns)

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

    # ---- events ----

    async def _ring(self, events: tuple[CalendarEvent, ...]) -> None:
        """Tell starts and warnings; let those come to rest whose time is over."""
        back = await asyncio.gather(*map(self._takes_back, events))
        events = tuple(event for event, is_back in zip(events, back, strict=True) if not is_back)
        ended: dict[RobotId, set[PrincipalId]] = {}
        for event in events:
            robot = event.slot.robot
            if not self.availability.booked(robot):
                continue
            if event.kind == "start":
                ended.setdefault(robot, set())
                self._unused.begins(event.slot)
            elif event.kind == "end":
                ended.setdefault(robot, set()).add(event.slot.principal)
        for robot, people in ended.items():
            self._ending.change_over(robot, people)
        for event in events:
            if not event.overtaken and self.availability.booked(event.slot.robot):
                self._tell(event)

    async def _takes_back(self, event: CalendarEvent) -> bool:
        """Let no slot begin whose owner has lost the right: nobody gives way to them."""
        slot = event.slot
        if event.kind != "start" or self.availability.slot(slot.robot) is not slot:
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
        elif slot.robot not in self.availability.barred and not told_just_now:
            self._begins(slot)

    def _begins(self, slot: BookedSlot) -> None:
        times = self._times
        shown, until = times.shown(slot.robot), self._moment(slot, slot.end_ns)
        holder = self.availability.holder(slot.robot)
        if holder not in {None, slot.principal}:
            sentence = scheduler_messages.begins_taken(shown, times.calendar.name_of(holder or ""))
            times.reach.tell((slot.principal,), sentence)
            return
        menu = Button(shown, f"/use {slot.robot}")
        times.reach.tell((slot.principal,), scheduler_messages.begins(shown, until), ((menu,),))

    def _warn(self, slot: BookedSlot) -> None:
        """Say how long it goes on from now on, which after a pause is less than the event says."""
        times = self._times
        following = times.calendar.present(slot.robot, slot.end_ns)
        if following is not None and following.principal == slot.principal:
            return  # it goes on
        left_s = -(-(slot.end_ns - times.clock.wall_ns()) // SECOND_NS)
        sentence = scheduler_messages.ends_soon(
            times.shown(slot.robot), left_s, self._moment(slot, slot.end_ns)
        )
        times.reach.tell((slot.principal,), sentence)

    def _moment(self, slot: BookedSlot, at_ns: int) -> str:
        zone = self._times.sides.zone_of(slot.principal)
        return moment(at_ns, self._times.clock.wall_ns(), zone)
