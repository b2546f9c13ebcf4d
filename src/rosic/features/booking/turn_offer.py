"""Whose turn it is: a robot that is free is offered to the first who waits, then to the next."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosic.core.i18n import said
from rosic.core.message import Button
from rosic.core.time_units import SECOND_NS
from rosic.features.booking import messages as words
from rosic.organiser.wait_queue import turn_over, your_turn

if TYPE_CHECKING:
    from rosic.core.identity import PrincipalId
    from rosic.core.robot.profile import RobotId
    from rosic.features.booking.context import BookingContext
    from rosic.features.booking.slots import Availability
    from rosic.organiser.wait_queue import TurnOffer

POLL_NS = 5 * SECOND_NS
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
