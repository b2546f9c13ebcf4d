"""What orders are given with that are no line of a chat: of rules, of tasks, to many robots."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple, Protocol

from rosic.core.i18n import said
from rosic.core.policy.query import NOTHING, AuthContext

if TYPE_CHECKING:
    from rosic.core.identity import Caller, PrincipalId
    from rosic.core.order_status import Face
    from rosic.core.robot.profile import RobotId
    from rosic.gateway.delivery.notifier import Notifier
    from rosic.gateway.delivery.sender import ChatSender
    from rosic.gateway.end_buttons import EndButtons
    from rosic.gateway.handover import LeaseHandover
    from rosic.gateway.order_execution import OrderExecutor
    from rosic.gateway.stop import StopLane


class OrderServices(NamedTuple):
    """What such an order goes through, besides the rooms, and how people hear of it."""

    executor: OrderExecutor
    stop_lane: StopLane
    handover: LeaseHandover
    chat_sender: ChatSender
    reach: Notifier
    face: Face
    ends: EndButtons


class AlertTasks(Protocol):
    """Whoever keeps the tasks of a fleet. A refusal says that nothing was changed."""

    async def pause(self, robot: RobotId, by: PrincipalId, why: str) -> bool:
        """Pause the task of a robot; it comes to rest. False: it has none.

        Raises:
            Refusal: Why not.
        """

    async def reallocate(self, robot: RobotId, by: PrincipalId, why: str) -> None:
        """Give the task of a robot to another, which was stopped first.

        Raises:
            Refusal: It has none, or nobody else can.
        """


class AutomatedRequester:
    """Who asks when a rule or a task does: its author, who has shown and confirmed nothing.

    Attributes:
        caller: The author.
    """

    def __init__(self, caller: Caller) -> None:
        self.caller = caller

    def auth_context(self) -> AuthContext:
        """Return that nothing counts besides who it is."""
        return NOTHING


def no_tasks(shown: str) -> str:
    """Return that there is no other robot to give a task to."""
    return said("{robot} has no task that another robot could take.", robot=shown)
