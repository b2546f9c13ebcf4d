"""Actions: goals that take a while, tell how they go, and can be called off."""

from __future__ import annotations

import asyncio
from functools import partial
from typing import TYPE_CHECKING, Literal, NamedTuple, Protocol, TypeAlias

from rosic.robots.ros2.client.client_link import ClientLink
from rosic.robots.ros2.client.services import wait_until
from rosic.robots.ros2.errors import BadValue, NoAnswer, NotSent
from rosic.robots.ros2.messages.encode import to_message
from rosic.robots.ros2.publishers import ends_of

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from rosic.robots.ros2.client.connection import RosConnection
    from rosic.robots.ros2.client.rclpy_import import RosObject
    from rosic.robots.ros2.messages.encode import Values
    from rosic.robots.ros2.publishers import Ends

End: TypeAlias = Literal["succeeded", "cancelled", "aborted", "unknown"]
Stage: TypeAlias = Literal["accepted", "executing", "cancelling", "ended", "unknown"]
CancelAnswer: TypeAlias = Literal["cancelling", "refused", "unknown", "ended"]

MAX_GOALS = 64
GOAL_ID_BYTES = 16
# What an action consists of, at the server's side.
_SERVICES, _TOPICS = ("send_goal", "cancel_goal", "get_result"), ("feedback", "status")

# action_msgs/msg/GoalStatus
_ENDS: dict[int, End] = {4: "succeeded", 5: "cancelled", 6: "aborted"}
_STAGES: dict[int, Stage] = {
    1: "accepted",
    2: "executing",
    3: "cancelling",
    4: "ended",
    5: "ended",
    6: "ended",
}
# action_msgs/srv/CancelGoal
_CANCEL_ANSWERS: dict[int, CancelAnswer] = {1: "refused", 2: "unknown", 3: "ended"}


class GoalEnd(NamedTuple):
    """How a goal ended, in the robot's own words.

    Attributes:
        status: What the action server says became of it.
        result: Its result message, to be read with `reading.compile_path`.
    """

    status: End
    result: RosObject


class ActionLink(ClientLink):
    """A client of one action. Goals under way stay with the robot when it is closed: cancel them.

    Attributes:
        rejected: How many goals the server did not accept.
    """

    def __init__(
        self,
        runtime: RosConnection,
        name: str,
        cls: RosObject,
        handle: RosObject,
        make: Callable[[], RosObject],
    ) -> None:
        """Make it; see `ClientLink`."""
        super().__init__(runtime, name, cls, handle, make)
        self.rejected = 0
        self._goals = 0

    def servers(self) -> Ends:
        """Return who offers the action now: one that begins anew is another."""
        if not self._runtime.alive:
            return {}
        node = self._runtime.thread.node
        return ends_of(node.get_publishers_info_by_topic(f"{self.name}/_action/feedback"))

    async def send(
        self,
        values: Values,
        *,
        timeout_s: float,
        found_within_s: float = 0.0,
        goal_id: bytes | None = None,
        on_feedback: Callable[[RosObject], None] | None = None,
    ) -> Goal | None:
        """Send a goal and wait until the server has accepted it.

        Args:
            values: Fields of the goal.
            timeout_s: For the acceptance.
            found_within_s: How long to look for a server.
            goal_id: 16 bytes, so that the robot's log and ours speak of the same; a server turns
                an id away that it has seen before. By default rclpy draws one.
            on_feedback: Called on the event loop with the newest feedback message.

        Returns:
            The goal under way, or None: the server did not accept it, and nothing moves.

        Raises:
            BadValue: A value does not fit; nothing was sent.
            NotSent: No server, too many goals, or the link is closed.
            NoAnswer: Sent, and no word of acceptance in time. If it still comes, the goal is
                cancelled at once; the same when this call is cancelled.
        """
        message = to_message(self._cls.Goal, values)
        if not self.ready():
            await wait_until(self.sought, self.name, found_within_s)
        if self._goals >= MAX_GOALS:
            raise NotSent(f"Too many goals are under way; nothing was sent to {self.name}.")
        feedback = None if on_feedback is None else _Newest(self._runtime, on_feedback)
        uuid = None if goal_id is None else self._uuid(goal_id)
        self._goals += 1
        self._unresolved += 1
        self._runtime.traffic.went()
        try:
            handle = await self._runtime.thread.ask(
                lambda: self._begin(message, uuid, feedback),
                self.name,
                timeout_s=timeout_s,
                late=self._call_off,
            )
        except BaseException as fault:
            self._ended(known=isinstance(fault, NotSent))
            raise
        self._runtime.traffic.came()
        if not handle.accepted:
            self._ended(known=True)
            self.rejected += 1
            return None
        return Goal(self._runtime, self.name, handle, self._ended)

    def _sees(self, handle: RosObject) -> bool:
        return bool(handle.server_is_ready())

    def _ends(self, node: RosObject) -> Mapping[str, int]:
        inside = f"{self.name}/_action"
        services = {end: node.count_services(f"{inside}/{end}") for end in _SERVICES}
        return services | {end: node.count_publishers(f"{inside}/{end}") for end in _TOPICS}

    def _destroy(self, node: RosObject, handle: RosObject) -> None:  # noqa: ARG002 - it knows its own
        handle.destroy()

    def _begin(self, message: RosObject, uuid: RosObject, feedback: _Newest | None) -> RosObject:
        """Send the goal, and leave nothing behind that rclpy would keep; on the ROS thread."""
        client = self._handle
        before = {id(future) for future in getattr(client, "_futures", ())}
        future = client.send_goal_async(
            message,
            feedback_callback=None if feedback is None else feedback.arrived,
            goal_uuid=uuid,
        )
        for other in list(getattr(client, "_futures", ())):
            if other is not future and id(other) not in before:
                client.remove_future(other)  # rclpy 9.1 registers two and forgets this one
        if feedback is not None:
            future.add_done_callback(partial(_drop_feedback, client, feedback))
        return future

    def _call_off(self, handle: RosObject) -> None:
        """Cancel a goal whose acceptance nobody waits for any more."""
        if handle.accepted and self._runtime.alive:
            self._runtime.thread.post(handle.cancel_goal_async)

    def _uuid(self, goal_id: bytes) -> RosObject:
        if len(goal_id) != GOAL_ID_BYTES:
            raise BadValue(f"A goal's id has {GOAL_ID_BYTES} bytes, not {len(goal_id)}.")
        return self._runtime.ros.ids.UUID(uuid=list(goal_id))

    def _ended(self, *, known: bool) -> None:
        """Count a goal no more; where it is not known how it ended, what it was sent over stays."""
        self._goals -= 1
        self._unresolved -= known


class GoalEnded(Protocol):
    """Takes in that nobody waits for the end of a goal any more."""

    def __call__(self, *, known: bool) -> None:
        """Take it in, and whether it is known how it ended."""
        ...


class Goal:
    """A goal that a server has accepted.

    Attributes:
        name: Of the action.
        id: 16 bytes, as the robot's side knows it.
    """

    def __init__(
        self, runtime: RosConnection, name: str, handle: RosObject, ended: GoalEnded
    ) -> None:
        self.name = name
        self.id = bytes(handle.goal_id.uuid)
        self._runtime = runtime
        self._handle = handle
        # Asked for at once: a server forgets the result of a goal a few seconds after its end.
        self._result = asyncio.ensure_future(self._watch())
        self._result.add_done_callback(lambda result: ended(known=_heard(result)))

    @property
    def over(self) -> bool:
        """Whether it is known how it ended."""
        return self._result.done() and not self._result.cancelled()

    @property
    def stage(self) -> Stage:
        """Where the server says the goal is; it lags a little behind `end` and the feedback."""
        return _STAGES.get(int(self._handle.status), "unknown")

    async def end(self, *, timeout_s: float | None = None) -> GoalEnd:
        """Wait for the end. Cancelling this call leaves the goal as it is.

        Raises:
            NoAnswer: The server has not said in time how it ended. The robot may still move.
        """
        try:
            async with asyncio.timeout(timeout_s):
                return await asyncio.shield(self._result)
        except TimeoutError:
            raise NoAnswer(f"{self.name} has not come to an end within {timeout_s:g} s.") from None

    def tell_end(self, tell: Callable[[GoalEnd], object]) -> None:
        """Tell of the end as soon as it is heard, whether anybody still waits for it or not."""
        self._result.add_done_callback(lambda ended: _heard(ended) and tell(ended.result()))

    async def cancel(self, *, timeout_s: float) -> CancelAnswer:
        """Ask the server to call the goal off. What then happens, `end` tells.

        Returns:
            ``cancelling``; or ``refused``; ``ended`` when there is nothing left to cancel;
            ``unknown`` when the server does not know the goal, as after its restart.

        Raises:
            NotSent: The link is closed.
            NoAnswer: The server did not answer in time. It may or may not be cancelling.
        """
        self._runtime.traffic.went()
        answer = await self._runtime.thread.ask(
            self._handle.cancel_goal_async, self.name, timeout_s=timeout_s
        )
        self._runtime.traffic.came()
        if answer.return_code == 0 and answer.goals_canceling:
            return "cancelling"
        return _CANCEL_ANSWERS.get(answer.return_code, "refused")

    def forget(self) -> None:
        """Wait for the end no longer. The robot does not hear of it."""
        self._result.cancel()

    async def _watch(self) -> GoalEnd:
        answer = await self._runtime.thread.ask(
            self._handle.get_result_async, self.name, timeout_s=None
        )
        self._runtime.traffic.came()
        return GoalEnd(_ENDS.get(answer.status, "unknown"), answer.result)


class _Newest:
    """Feedback on its way to the event loop: only the newest is worth telling."""

    def __init__(self, runtime: RosConnection, tell: Callable[[RosObject], None]) -> None:
        self._runtime = runtime
        self._tell = tell
        self._newest: RosObject = None
        self._offered = False

    def arrived(self, message: RosObject) -> None:
        """Take a feedback message; on the ROS thread."""
        self._runtime.traffic.came()
        self._newest = message.feedback
        if not self._offered:
            self._offered = True
            if not self._runtime.thread.hand_over(self._deliver):
                self._offered = False

    def _deliver(self) -> None:
        self._offered = False
        self._tell(self._newest)


def _drop_feedback(client: RosObject, feedback: _Newest, future: RosObject) -> None:
    """Forget whom to tell about a goal that was not accepted; rclpy would remember for ever."""
    handle = None if future.cancelled() or future.exception() else future.result()
    if handle is not None and handle.accepted:
        return
    callbacks = getattr(client, "_feedback_callbacks", {})
    for key in [key for key, callback in callbacks.items() if callback == feedback.arrived]:
        del callbacks[key]


def _heard(result: asyncio.Future[GoalEnd]) -> bool:
    """Tell whether the end was heard; so asyncio does not complain of a failure nobody asks for."""
    return not result.cancelled() and result.exception() is None
