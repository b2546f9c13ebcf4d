"""A slot whose owner is not there is given to whoever waits, after a question."""

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

if TYPE_CHECKING:
    from rosic.core.identity import PrincipalId
    from rosic.core.robot.profile import RobotId
    from rosic.core.slot import BookedSlot
    from rosic.features.booking.context import BookingContext
    from rosic.features.booking.slots import Availability

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
        said = scheduler_messages.released(times.shown(slot.robot), until)
        times.reach.tell((slot.principal,), said)
