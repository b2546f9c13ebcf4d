"""An order for a robot that is at work: said once, before it is claimed, with what can follow.

What follows is the person's own choice, by a tap: this order behind the one that runs, or instead
of it. Only an order of one's own is ended by it.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosic.contracts.background_tasks import BackgroundTasks
from rosic.core.i18n import said
from rosic.core.language import Do
from rosic.core.robot.profile import Busy
from rosic.errors import OrderVoid, RobotBusy
from rosic.gateway.replies import AFTER, INSTEAD

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rosic.core.identity import PrincipalId
    from rosic.core.language import Line
    from rosic.core.order import Order, Request
    from rosic.errors import Refusal
    from rosic.gateway.components import Components
    from rosic.gateway.message_context import MessageContext
    from rosic.gateway.order_execution import OrderExecutor

AFTER_THIS, STOP_THEN_THIS = said("After this"), said("Stop, then this")
GIVES_WAY = said("the next command takes its place")
GAVE_WAY = said("The next command takes its place. This was not done.")


class BusyRobots:
    """Says that a robot is at work, and lets its next order follow by a tap."""

    def __init__(self, rooms: Components, executor: OrderExecutor) -> None:
        self._rooms = rooms
        self._executor = executor
        self._ending: BackgroundTasks[None] = BackgroundTasks()

    def check(self, request: Request, principal: PrincipalId, command: str) -> None:
        """See that a robot begins at once what is asked of it, or takes it into its queue.

        Args:
            request: What is asked of it.
            principal: By whom.
            command: The same as a button would say it.

        Raises:
            RobotBusy: It is at work, and its profile does not queue.
        """
        current = self._rooms.linker.queues[request.robot].current
        if current is None or request.sequel or request.skill.to_safety:
            return
        if self._rooms.profiles[request.robot].busy is Busy.REFUSE:
            raise self._busy(current.order, request, principal, command)

    def _busy(
        self, current: Order, request: Request, principal: PrincipalId, command: str
    ) -> Refusal:
        shown = self._rooms.profiles[current.robot].shown
        what = current.skill.doing
        whose = current.permit.principal
        after = () if request.group else ((AFTER_THIS, f"{AFTER}{command}"),)
        if whose != principal:
            name = self._rooms.organiser.name_of(whose)
            busy = said(
                "{shown} is busy: {what}, for {name}. This was not done.",
                shown=shown,
                what=what,
                name=name,
            )
            return RobotBusy(busy, choices=after)
        busy = said(
            "{shown} is busy: {what}, as you asked. This was not done.", shown=shown, what=what
        )
        instead = ((STOP_THEN_THIS, f"{INSTEAD}{command}"),) if after else ()
        return RobotBusy(busy, choices=(*after, *instead))

    def follow(self, message: MessageContext, command: str, lines: Sequence[Line]) -> str:
        """Let the order of a tap wait for its robot's turn, once, within its own lifetime.

        Returns:
            The command without the sign. With `INSTEAD`, what of the person's own runs there ends,
            and what of it waits is void; the order of the tap comes next.
        """
        robots = {robot for line in lines if isinstance(line, Do) for robot in line.robots}
        message.asks(robots)
        if command.startswith(INSTEAD) and robots:
            principal = message.caller.principal
            for entry in self._executor.take_out(principal, robots):
                entry.void(OrderVoid(GAVE_WAY))
            for order in self._executor.of(principal):
                if order.robot in robots:
                    self._end(order)
        return command[1:]

    def _end(self, order: Order) -> None:
        """End an order; what waits behind it begins when its robot is at rest."""
        ending = self._executor.cut_order(order.robot, order.cid, GIVES_WAY)
        self._ending.begin(ending)
