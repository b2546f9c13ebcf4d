"""Whose turn it is: a robot that is free is offered to the first who waits, then to the next."""

from __future__ import annotations

from typing import TYPE_CHECKING

import msgspec

from rosic.core.i18n import said
from rosic.core.identity import OPERATOR
from rosic.core.message import Button
from rosic.core.slot import SlotId
from rosic.core.time_units import SECOND_NS
from rosic.features.booking import messages as words
from rosic.features.booking import scheduler_messages
from rosic.features.booking.context import decided
from rosic.organiser.calendar_messages import moment
from rosic.organiser.wait_queue import turn_over, your_turn

if TYPE_CHECKING:
    from rosic.core.identity import PrincipalId
    from rosic.core.robot.profile import RobotId
    from rosic.core.slot import BookedSlot
    from rosic.features.booking.context import BookingContext
    from rosic.features.booking.slots import Availability
    from rosic.organiser.wait_queue import TurnOffer


# ---- idle release ----

# A slot whose owner is not there is given to whoever waits, after a question.

POLL_NS = 5 * SECOND_NS


class WatchedSlot(msgspec.Struct):
    """A slot that is looked at.

    Attributes:
        since_ns: When its owner was last known to want it, monotonic clock.
        asked_ns: When they were asked; None: not since then.
    """

    slot: SlotId
    since_ns: int
    asked_ns: int | None = None


class IdleSlotRelease:
    """Asks owners who do nothing while somebody waits, and releases their slots.

    After a restart the count begins anew.
    """

    def __init__(self, times: BookingContext, availability: Availability) -> None:
        self._times = times
        self._availability = availability
        self._watches: dict[RobotId, WatchedSlot] = {}
        self._release_ns = int(times.idle_release_s * SECOND_NS)
        self._notice_ns = int(min(times.notice_s, times.idle_release_s) * SECOND_NS)

    def begins(self, slot: BookedSlot) -> None:
        """Count from now on."""
        self._watches[slot.robot] = WatchedSlot(slot.id, self._times.clock.monotonic_ns())

    def keep(self, principal: PrincipalId, robot: RobotId) -> bool:
        """Count as used now. Return False if it is not this person's slot."""
        slot = self._availability.slot(robot)
        if slot is None or slot.principal != principal:
            return False
        self.begins(slot)
        return True

    async def look_at(self, robot: RobotId) -> int | None:
        """Ask or release, if it is time; return when to look again, monotonic clock.

        Raises:
            RecordUnavailable: Nothing was released.
        """
        now_ns, slot = self._times.clock.monotonic_ns(), self._availability.slot(robot)
        if slot is None:
            return None
        if await self.takes_back(slot):
            return now_ns
        watch = self._watches.get(robot)
        if watch is None or watch.slot != slot.id:
            self.begins(slot)
            watch = self._watches[robot]
        lease = self._times.sides.lease(robot)
        if lease.holder == slot.principal:
            used_ns = now_ns if lease.active else lease.idle_since_ns
            if used_ns > watch.since_ns:
                watch.since_ns, watch.asked_ns = used_ns, None
            if lease.active:
                return now_ns + POLL_NS
        return await self._next_step(slot, watch, now_ns)

    async def _next_step(self, slot: BookedSlot, watch: WatchedSlot, now_ns: int) -> int | None:
        ask_ns = watch.since_ns + self._release_ns - self._notice_ns
        if watch.asked_ns is None:
            if now_ns < ask_ns:
                return ask_ns
            if slot.end_ns - self._times.clock.wall_ns() <= self._notice_ns:
                return None  # it ends by itself before that
            watch.asked_ns = now_ns
            self._ask(slot, watch, now_ns)
        release_ns = watch.asked_ns + self._notice_ns
        if now_ns < release_ns:
            return release_ns
        await self._release(slot)
        return None

    def _ask(self, slot: BookedSlot, watch: WatchedSlot, now_ns: int) -> None:
        times = self._times
        idle_s, notice_s = (now_ns - watch.since_ns) / SECOND_NS, self._notice_ns / SECOND_NS
        given = scheduler_messages.unused(times.shown(slot.robot), idle_s, notice_s)
        keep = Button(said("Keep it"), f"/wait keep {slot.robot}")
        give = Button(said("Give it back"), f"{words.CANCEL} only {slot.id}")
        times.reach.tell((slot.principal,), given, ((keep, give),), lifetime_s=notice_s)

    async def takes_back(self, slot: BookedSlot) -> bool:
        """Free a slot whose owner may not move the robot any more; return whether it was one."""
        times = self._times
        if times.sides.may_book(slot.principal, slot.robot) is None:
            return False
        facts = times.calendar.cancel(slot.id, slot.principal)
        await times.changes.take_away(decided("release", OPERATOR, times.clock.wall_ns(), facts))
        self._watches.pop(slot.robot, None)
        times.reach.tell((slot.principal,), scheduler_messages.taken_back(times.shown(slot.robot)))
        return True

    async def _release(self, slot: BookedSlot) -> None:
        times = self._times
        async with times.changes.turn() as turn:
            if self._availability.slot(slot.robot) is not slot:
                return
            facts = times.calendar.cancel(slot.id, slot.principal)
            await turn.write(decided("release", OPERATOR, times.clock.wall_ns(), facts))
        self._watches.pop(slot.robot, None)
        zone = times.sides.zone_of(slot.principal)
        until = moment(slot.end_ns, times.clock.wall_ns(), zone)
        sentence = scheduler_messages.released(times.shown(slot.robot), until)
        times.reach.tell((slot.principal,), sentence)


# ---- turn offer ----

"""A robot at work, stopped or away becomes free without a word; so often it is looked at."""


class TurnOffers:
    """Offers free robots, once each."""

    def __init__(self, times: BookingContext, availability: Availability) -> None:
        self._times = times
        self._availability = availability
        self._told: dict[RobotId, TurnOffer] = {}

    async def pass_on(self) -> int | None:
        """Take out of the queues who let their turn pass, and tell them.

        Returns:
            When the next offer expires, monotonic clock.

        Raises:
            RecordUnavailable: Nobody was taken out.
        """
        times = self._times
        if times.waiting.lapsed():
            async with times.changes.turn() as turn:
                lapsed = times.waiting.lapsed()  # somebody may have taken it meanwhile
                await turn.write([waiting.no_more() for waiting in lapsed])
            for waiting in lapsed:
                if self._availability.has(waiting.principal, waiting.robot):
                    continue  # they went ahead without a tap
                again = Button(said("Wait again"), f"/wait {waiting.robot}")
                given = turn_over(times.shown(waiting.robot))
                times.reach.tell((waiting.principal,), given, ((again,),))
        return times.waiting.next_expiry_ns()

    async def offer(self, robot: RobotId) -> int | None:
        """Offer a robot if it is free; return when to look again, monotonic clock."""
        times, waiting = self._times, self._times.waiting
        await self._drop_who_has_it(robot)
        await self._drop_who_may_not(robot)
        queue = waiting.queue(robot)
        if not queue:
            self._told.pop(robot, None)
            return None
        standing = waiting.standing(robot)
        following = queue[0] if standing is None else standing.principal
        if not self._availability.free_for(robot, following):
            waiting.withdraw(robot)
            self._told.pop(robot, None)
            poll_ns = times.clock.monotonic_ns() + POLL_NS
            return min(poll_ns, self._availability.lapses_ns(robot) or poll_ns)
        made = waiting.offer(robot)
        if made is not None and made is not self._told.get(robot):
            self._told[robot] = made
            self._availability.keep(made)
            self._tell(made)
        return None if made is None else made.expires_ns

    def _tell(self, made: TurnOffer) -> None:
        times = self._times
        seconds = (made.expires_ns - times.clock.monotonic_ns()) / SECOND_NS
        given = your_turn(times.shown(made.robot), seconds)
        row = (
            Button(said("Take it"), f"/wait take {made.robot}"),
            Button(said("Not now"), f"/wait none {made.robot}"),
        )
        times.reach.tell((made.principal,), given, (row,), lifetime_s=seconds)

    async def _drop_who_has_it(self, robot: RobotId) -> None:
        """Whoever has a robot, and more than the offer of it, does not wait for it any more."""
        standing = self._times.waiting.standing(robot)
        if standing is not None and self._availability.is_only_kept(standing):
            return
        for principal in self._times.waiting.queue(robot):
            if self._availability.has(principal, robot):
                await self._drop(principal, robot)

    async def _drop_who_may_not(self, robot: RobotId) -> None:
        """Take the first out of the queue as long as they have no right to the robot any more."""
        times = self._times
        while queue := times.waiting.queue(robot):
            if times.sides.may_book(queue[0], robot) is None:
                return
            await self._drop(queue[0], robot)
            times.reach.tell((queue[0],), words.no_right_any_more(times.shown(robot)))

    async def _drop(self, principal: PrincipalId, robot: RobotId) -> None:
        async with self._times.changes.turn() as turn:
            await turn.write(self._times.waiting.leave(principal, robot))
