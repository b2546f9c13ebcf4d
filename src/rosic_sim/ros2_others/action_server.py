"""One action of a robot, served as rclpy wants it: a goal waits for its robot to say the end."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from typing import TYPE_CHECKING, NamedTuple, TypeAlias

if TYPE_CHECKING:
    from rosic.robots.ros2.client.rclpy_import import RosObject

Begin: TypeAlias = Callable[["RosObject"], str]
"""Takes a goal's request and begins; returns why not, or nothing."""

SUCCEEDED, CANCELLED, ABORTED = "succeeded", "cancelled", "aborted"


class ActionCallbacks(NamedTuple):
    """What a robot does about the goals of one action.

    Attributes:
        begin: Begins one; why it does not is written to the log, as ROS nodes do.
        began: Hears that a goal was accepted, with its id in hexadecimal digits.
        halt: Brings what is under way to rest.
    """

    begin: Begin
    began: Callable[[str], None]
    halt: Callable[[], None]


class SingleGoalServer:
    """Serves one action, one goal at a time: a new goal takes the place of the one before.

    Attributes:
        action: Its class.
        cancelling: Somebody has called the present goal off, and it is not yet over.
    """

    def __init__(
        self, node: RosObject, action: RosObject, name: str, sides: ActionCallbacks
    ) -> None:
        self.action = action
        self.cancelling = False
        self._node = node
        self._sides = sides
        self._rclpy = import_module("rclpy.action")
        self._future = import_module("rclpy.task").Future
        self._present: tuple[RosObject, RosObject] | None = None
        self._ends: dict[bytes, RosObject] = {}
        self._server = self._rclpy.ActionServer(
            node,
            action,
            name,
            self._carry,
            goal_callback=self._asked,
            handle_accepted_callback=self._accepted,
            cancel_callback=self._called_off,
        )

    @property
    def busy(self) -> bool:
        """Whether a goal is under way."""
        return self._present is not None

    def feedback(self, **fields: object) -> None:
        """Tell how the present goal goes."""
        if self._present is not None and self._present[0].is_active:
            self._present[0].publish_feedback(self.action.Feedback(**fields))

    def end(self, how: str, **fields: object) -> None:
        """End the present goal."""
        if self._present is None:
            return
        (_, ended), self._present = self._present, None
        self.cancelling = False
        ended.set_result((how, fields))

    # ---- what rclpy calls ----

    def _asked(self, request: RosObject) -> RosObject:
        why_not = self._sides.begin(request)
        if why_not:
            self._node.get_logger().warning(why_not)
            return self._rclpy.GoalResponse.REJECT
        return self._rclpy.GoalResponse.ACCEPT

    def _accepted(self, handle: RosObject) -> None:
        self.end(ABORTED)
        self._present = handle, self._future()
        self._ends[bytes(handle.goal_id.uuid)] = self._present[1]
        self._sides.began(bytes(handle.goal_id.uuid).hex())
        handle.execute()

    async def _carry(self, handle: RosObject) -> RosObject:
        # It may be over before rclpy comes round to this.
        how, fields = await self._ends.pop(bytes(handle.goal_id.uuid))
        if how == CANCELLED:
            handle.canceled()
        elif how == SUCCEEDED:
            handle.succeed()
        else:
            handle.abort()
        return self.action.Result(**fields)

    def _called_off(self, handle: RosObject) -> RosObject:
        if self._present is not None and self._present[0].goal_id == handle.goal_id:
            self.cancelling = True
            self._sides.halt()
        return self._rclpy.CancelResponse.ACCEPT
