"""From one person to the next: safe stop, rest measured, lease released, both told."""

from __future__ import annotations

import asyncio
import logging
from typing import TYPE_CHECKING

from rosic.core.i18n import said
from rosic.core.message import Button
from rosic.features.booking import keeper_messages
from rosic.features.booking import messages as words
from rosic.features.booking.vacancy import SECOND_NS
from rosic.organiser.calendar_messages import moment

if TYPE_CHECKING:
    from collections.abc import Callable

    from rosic.core.identity import PrincipalId
    from rosic.core.robot.profile import RobotId
    from rosic.core.slot import BookedSlot
    from rosic.features.booking.context import BookingContext
    from rosic.features.booking.vacancy import Availability

POLL_NS = 5 * SECOND_NS
"""So often it is looked at whether a robot that was not at rest has been resumed."""
AGAIN_S = 10.0
"""After a handover that failed."""
CLOSE_WITHIN_S = 2.0

log = logging.getLogger("rosic.times")


class SlotEnd:
    """Takes robots from those whose time is over. The next one begins only after measured rest.

    Args:
        look: Called when a robot may have become free.
    """

    def __init__(
        self, times: BookingContext, vacancy: Availability, look: Callable[[], None]
    ) -> None:
        self._times = times
        self._vacancy = vacancy
        self._look = look
        self._under_way: dict[RobotId, asyncio.Task[None]] = {}
        self._unsure: set[RobotId] = set()

    def change_over(self, robot: RobotId, ended: set[PrincipalId]) -> None:
        """A slot of a robot has begun or ended: take the robot from whoever should not have it.

        Args:
            robot: Which one.
            ended: Whose slots have ended just now.
        """
        holder, slot = self._vacancy.holder(robot), self._vacancy.slot(robot)
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
                self._vacancy.barred.discard(robot)
                self._tell_begins(robot, "")
        return self._times.clock.monotonic_ns() + POLL_NS if self._unsure else None

    def _begin(self, robot: RobotId, holder: PrincipalId, reason: str) -> None:
        self._vacancy.barred.add(robot)
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
            self._vacancy.barred.discard(robot)
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
                said = keeper_messages.no_answer(self._times.shown(robot))
                self._times.reach.tell((holder,), said, urgent=True)
                told = True
            await self._times.clock.sleep(AGAIN_S)

    def _tell_holder(
        self, robot: RobotId, holder: PrincipalId, reason: str, *, at_rest: bool
    ) -> None:
        times, shown = self._times, self._times.shown(robot)
        slot = self._vacancy.slot(robot)
        if reason == words.OVER or slot is None:
            said = keeper_messages.ended(shown, at_rest=at_rest)
        else:
            name = times.calendar.name_of(slot.principal)
            said = keeper_messages.taken_over(shown, name, at_rest=at_rest)
        times.reach.tell((holder,), said)

    def _tell_begins(self, robot: RobotId, before: PrincipalId) -> None:
        """Tell whose slot it is that they can begin; who waits in the queue is offered it."""
        slot = self._vacancy.slot(robot)
        if slot is not None and slot.principal != before:
            times, shown = self._times, self._times.shown(robot)
            zone = times.sides.zone_of(slot.principal)
            until = moment(slot.end_ns, times.clock.wall_ns(), zone)
            menu = Button(shown, f"/use {robot}")
            times.reach.tell((slot.principal,), keeper_messages.begins(shown, until), ((menu,),))

    def _tell_wait(self, robot: RobotId, before: PrincipalId) -> None:
        slot = self._vacancy.slot(robot)
        if slot is not None and slot.principal != before:
            self.tell_to_wait(slot)

    def tell_to_wait(self, slot: BookedSlot) -> None:
        """Tell an owner that their time has begun and the robot has not confirmed rest."""
        shown, barred = self._times.shown(slot.robot), self._times.sides.barred(slot.robot)
        if barred is not None:
            said_so = keeper_messages.cannot_begin(shown, barred.sentence)
            self._times.reach.tell((slot.principal,), said_so)
            return
        resume = Button(said("Resume {shown}", shown=shown), f"/resume {slot.robot}")
        may = self._times.sides.may_resume(slot.principal, slot.robot)
        rows = ((resume,),) if may else ()
        self._times.reach.tell((slot.principal,), keeper_messages.wait_for_rest(shown), rows)

    async def close(self) -> None:
        """Wait for what is under way, briefly, and let go of the rest."""
        under_way = tuple(self._under_way.values())
        if under_way:
            await asyncio.wait(under_way, timeout=CLOSE_WITHIN_S)
        for task in under_way:
            task.cancel()
        await asyncio.gather(*under_way, return_exceptions=True)
