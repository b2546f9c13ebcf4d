"""Says that a robot at work is not there any more, when it is back, and when it rests at last."""

from __future__ import annotations

import asyncio
import logging
from typing import TYPE_CHECKING, Final, NamedTuple

from rosic.core import messages
from rosic.core.i18n import said
from rosic.core.robot.alert_config import RecipientCircle
from rosic.core.time_units import MINUTE_NS, SECOND_NS

if TYPE_CHECKING:
    from rosic.contracts.clock import Clock
    from rosic.core.identity import PrincipalId
    from rosic.core.order import Order, Outcome
    from rosic.core.robot.profile import Presence, RobotId
    from rosic.features.alerts.recipients import Recipients
    from rosic.gateway.components import Components
    from rosic.gateway.delivery.notifier import Notifier
    from rosic.gateway.order_execution import OrderExecutor


# ---- stop violations ----

# Says that a robot which was stopped and at rest moves all the same: by somebody else's hand.

log = logging.getLogger("rosic.stop")

EVERY_S: Final = 0.5
AT_ONCE: Final = 500
"""So many robots are looked at in one step of the event loop."""
LOOKS: Final = 2
"""So often in a row it is seen to move: one measurement alone may be a push, or noise."""


class StopViolations:
    """Follows robots that are stopped, from their measured rest on.

    ROSIC sends nothing: whoever drives the robot stands beside it, or has to be found. Whoever
    stopped it is told, once for each stop; where nobody known did, whoever holds or may operate it.
    """

    def __init__(
        self, rooms: Components, reach: Notifier, clock: Clock, circles: Recipients
    ) -> None:
        self._rooms = rooms
        self._reach = reach
        self._clock = clock
        self._circles = circles
        self._rested: dict[RobotId, int] = {}
        self._moved: dict[RobotId, int] = {}
        self._told: dict[RobotId, int] = {}

    async def run(self) -> None:
        """Look until cancelled."""
        while True:
            await self.look()
            await self._clock.sleep(EVERY_S)

    async def look(self) -> None:
        """Look once."""
        for number, (robot, entry) in enumerate(tuple(self._rooms.stops.items())):
            if number % AT_ONCE == AT_ONCE - 1:
                await asyncio.sleep(0)
            if entry.latched and self._told.get(robot) != entry.generation:
                self._see(robot, entry.generation)

    def _see(self, robot: RobotId, generation: int) -> None:
        presence = self._rooms.linker.presence(robot)
        if robot in self._rooms.linker.pursuit or not presence.moves:
            self._moved[robot] = 0
            if presence.at_rest:
                self._rested[robot] = generation
        elif self._rested.get(robot) == generation:
            self._moved[robot] += 1
            if self._moved[robot] >= LOOKS:
                self._told[robot] = generation
                self._tell(robot)

    def _tell(self, robot: RobotId) -> None:
        shown = self._rooms.profiles[robot].shown
        log.warning("%s is stopped, was measured at rest, and moves; ROSIC sends nothing", robot)
        text = said(
            "{shown} is stopped and was at rest; now it moves, and not by me. Please look.",
            shown=shown,
        )
        self._reach.tell(self._whom(robot), text, urgent=True)

    def _whom(self, robot: RobotId) -> tuple[PrincipalId, ...]:
        by = self._rooms.stops[robot].by
        if by and self._circles.may_hear(by, robot):
            return (by,)
        return self._circles.of(robot, RecipientCircle.HOLDER, 0)


# ---- offline notices ----

"""So many robots are looked at in one step of the event loop."""
CONCERNED_NS: Final = 15 * SECOND_NS
"""Whoever's order has ended so long ago is not concerned any more: its link's deadline, and more,
is over."""
LOOKED_AFTER_NS: Final = 10 * MINUTE_NS
"""A robot that was said to move is followed for so long, or until it is measured at rest."""


class _Worked(NamedTuple):
    """For whom a robot works, or worked last, and when it was seen to."""

    principal: PrincipalId
    seen_ns: int


class _Moving(NamedTuple):
    """Who was told that a robot moves, and until when it is followed."""

    principal: PrincipalId
    until_ns: int


class OfflineNotices:
    """Follows robots that carry something out, and tells whoever asked for it.

    Whoever was told that a robot moves is told once that it is at rest, when that is measured, or
    that it still moves after `LOOKED_AFTER_NS`. A new order, or a stop, has an answer of its own.
    """

    def __init__(
        self, rooms: Components, executor: OrderExecutor, reach: Notifier, clock: Clock
    ) -> None:
        self._rooms = rooms
        self._executor = executor
        self._reach = reach
        self._clock = clock
        self._worked: dict[RobotId, _Worked] = {}
        self._away: dict[RobotId, PrincipalId] = {}
        self._moving: dict[RobotId, _Moving] = {}

    async def run(self) -> None:
        """Look until cancelled."""
        while True:
            await self.look()
            await self._clock.sleep(EVERY_S)

    def began(self, order: Order) -> None:
        """A robot moves anew, as it was told to; heard only while one is followed."""
        if order.skill.actuates and self._moving.pop(order.robot, None) is not None:
            self._listen()

    def ended(self, order: Order, outcome: Outcome) -> None:
        """An order is over; see `still_moves`."""

    def still_moves(self, order: Order) -> None:
        """Follow a robot that its order's end says to move."""
        self._said_to_move(order.robot, order.permit.principal)

    def _listen(self) -> None:
        self._executor.watching.watch_orders(self, wanted=bool(self._moving))

    async def look(self) -> None:
        """Look once."""
        linker, now_ns = self._rooms.linker, self._clock.monotonic_ns()
        for number, robot in enumerate(tuple(self._rooms.profiles)):
            if number % AT_ONCE == AT_ONCE - 1:
                await asyncio.sleep(0)
            order = linker.current(robot)
            if robot in self._moving:
                self._see_rest(robot, linker.presence(robot))
            if order is not None or robot in self._worked or robot in self._away:
                works = order is not None and order.skill.actuates
                who = order.permit.principal if order is not None and works else ""
                self._see(robot, linker.presence(robot), _Worked(who, now_ns) if who else None)

    def _see(self, robot: RobotId, presence: Presence, works: _Worked | None) -> None:
        if robot in self._away:
            if presence.online:
                who = self._away.pop(robot)
                self._reach.tell((who,), back(self._shown(robot), presence))
                if presence.moves:
                    self._said_to_move(robot, who)
            return
        if presence.online is not False:
            self._note(robot, works)
            return
        worked = self._worked.pop(robot, None)
        if worked is not None:
            self._away[robot] = worked.principal
            self._reach.tell((worked.principal,), away(self._shown(robot), presence), urgent=True)

    def _said_to_move(self, robot: RobotId, who: PrincipalId) -> None:
        self._moving[robot] = _Moving(who, self._clock.monotonic_ns() + LOOKED_AFTER_NS)
        self._listen()

    def _see_rest(self, robot: RobotId, presence: Presence) -> None:
        over = self._clock.monotonic_ns() >= self._moving[robot].until_ns
        if not (presence.at_rest or over):
            return
        who = self._moving.pop(robot).principal
        self._listen()
        if presence.at_rest:
            if not self._rooms.stops[robot].latched:
                self._reach.tell((who,), messages.at_rest_now(self._shown(robot)))
        elif presence.moves:
            text = said("{shown} still moves. Please look.", shown=self._shown(robot))
            self._reach.tell((who,), text, urgent=True)

    def _note(self, robot: RobotId, works: _Worked | None) -> None:
        known = self._worked.get(robot)
        if works is not None:
            self._worked[robot] = works
        elif known is not None and self._clock.monotonic_ns() - known.seen_ns > CONCERNED_NS:
            del self._worked[robot]

    def _shown(self, robot: RobotId) -> str:
        return self._rooms.profiles[robot].shown


def away(shown: str, presence: Presence) -> str:
    """Return that a robot is not there any more."""
    if presence.age_s is None:
        return said("{shown} is not there any more. Please look.", shown=shown)
    return said(
        "{shown} is not there any more, last heard {age_s:.0f} s ago. Please look.",
        shown=shown,
        age_s=presence.age_s,
    )


def back(shown: str, presence: Presence) -> str:
    """Return that it is back, and what was measured of it."""
    if presence.at_rest:
        return said("{shown} is there again, at rest. Nothing goes on by itself.", shown=shown)
    if presence.moves:
        return said("{shown} is there again, and moves. Please look.", shown=shown)
    return said("{shown} is there again; whether it rests is not measured yet.", shown=shown)
