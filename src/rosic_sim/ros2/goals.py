"""The actions of one simulated robot: goals in, feedback and results out."""

from __future__ import annotations

from functools import partial
from importlib import import_module
from typing import TYPE_CHECKING, NamedTuple

from rosic_sim.robots.goals import machine_arguments
from rosic_sim.robots.machines.activity import Activity, ActivityRefused, ActivityState
from rosic_sim.ros2.endpoints import ACTIONS, INTERFACES, LEFT_TO_THE_ROBOT, START

if TYPE_CHECKING:
    from collections.abc import Callable

    from rosic.robots.ros2.client.rclpy_import import RosObject
    from rosic_sim.robots.machines.arguments import Value
    from rosic_sim.ros2.endpoints import SimulatedRobotNode

FEEDBACK_EVERY_S = 0.1
# A cancelled goal is answered when the machine has come to rest, or after this.
REST_WITHIN_S = 15.0


class _Open(NamedTuple):
    """A goal that has no result yet."""

    handle: RosObject
    action: RosObject
    activity: Activity
    ended: RosObject


class MachineActions:
    """Offers the actions of a machine. The machine itself sees to one goal at a time."""

    def __init__(self, owner: SimulatedRobotNode) -> None:
        self._owner = owner
        self._machine = owner.machine
        self._rclpy = import_module("rclpy.action")
        self._future: Callable[[], RosObject] = import_module("rclpy.task").Future
        self._open: list[_Open] = []
        self._begun: Activity | None = None
        self._told_s = 0.0
        types = import_module(f"{INTERFACES}.action")
        for skill, name in ACTIONS[owner.model].items():
            action = getattr(types, name)
            self._rclpy.ActionServer(
                owner.node,
                action,
                skill,
                partial(self._carry, action),
                goal_callback=partial(self._asked, skill),
                handle_accepted_callback=partial(self._accepted, skill),
                cancel_callback=self._called_off,
            )

    def turn(self, now_s: float) -> None:
        """Tell how the goals go; end those that have come to an end."""
        for goal in tuple(self._open):
            if self._over(goal.activity, now_s):
                self._open.remove(goal)
                goal.ended.set_result(None)
        if now_s - self._told_s < FEEDBACK_EVERY_S:
            return
        self._told_s = now_s
        for goal in self._open:
            activity = goal.activity
            if activity.running:
                goal.handle.publish_feedback(
                    goal.action.Feedback(fraction=activity.fraction, stage=activity.stage)
                )

    def _over(self, activity: Activity, now_s: float) -> bool:
        """Tell whether there is a result: what was cancelled is measured once it is at rest."""
        if activity.running:
            return False
        late = now_s - activity.begun_s - activity.facts.get("duration_s", 0.0) > REST_WITHIN_S
        return activity.state is not ActivityState.CANCELLED or self._machine.at_rest() or late

    # ---- what rclpy calls ----

    def _asked(self, skill: str, request: RosObject) -> RosObject:
        """Begin, or turn down with the reason in the log."""
        answer = self._rclpy.GoalResponse
        owner = self._owner
        if not owner.linked:
            return answer.REJECT
        try:
            self._begun = self._machine.begin(
                skill,
                machine_arguments(owner.model, skill, _values(request)),
                owner.now_s(),
                owner.start_s(getattr(request, START)),
            )
        except ActivityRefused as cannot:
            owner.node.get_logger().warning(cannot.reason)
            return answer.REJECT
        return answer.ACCEPT

    def _accepted(self, skill: str, handle: RosObject) -> None:
        """Write down that it acts, before the first step of the motion."""
        self._owner.began(skill, bytes(handle.goal_id.uuid).hex())
        handle.execute()

    async def _carry(self, action: RosObject, handle: RosObject) -> RosObject:
        """Wait for the end of the machine's activity and say how it was."""
        activity, self._begun = self._begun, None
        if activity is None:
            handle.abort()
            return action.Result(message="superseded")
        goal = _Open(handle, action, activity, self._future())
        self._open.append(goal)
        await goal.ended
        if activity.state is ActivityState.DONE:
            handle.succeed()
        elif handle.is_cancel_requested:
            handle.canceled()
        else:
            handle.abort()
        return action.Result(
            success=activity.state is ActivityState.DONE,
            message=activity.detail,
            fact_names=list(activity.facts),
            fact_values=list(activity.facts.values()),
        )

    def _called_off(self, handle: RosObject) -> RosObject:
        for goal in self._open:
            if bytes(goal.handle.goal_id.uuid) == bytes(handle.goal_id.uuid):
                if goal.activity.running and self._owner.linked:
                    self._machine.halt(self._owner.now_s())
                break
        return self._rclpy.CancelResponse.ACCEPT


def _values(request: RosObject) -> dict[str, Value]:
    """Return a goal's fields, without the start and without what is left to the robot."""
    fields = {name: getattr(request, name) for name in request.get_fields_and_field_types()}
    return {
        name: value
        for name, value in fields.items()
        if name != START and not (name in LEFT_TO_THE_ROBOT and value == 0.0)
    }
