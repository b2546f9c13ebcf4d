"""Calls of services and goals of actions, each followed until its order is over."""

from __future__ import annotations

import asyncio
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, Final, NamedTuple

from rosic.api.ordering import RefusedOrder
from rosic.api.rosbridge.messages import (
    ActionFeedback,
    ActionResult,
    ServiceResponse,
    given_id,
)
from rosic.api.rosbridge.orders import ACTION, SERVICE, OrderBindings
from rosic.api.rosbridge.topics import absolute
from rosic.api.schemas import ChatIn, OrderIn, StopIn
from rosic.core.i18n import said
from rosic.errors import NotFound, RosicError, TooManyRequests

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from rosic.api.callers import ApiCaller
    from rosic.api.context import ApiContext
    from rosic.api.order_feed import OrderEntry
    from rosic.api.ordering import CallerRequests
    from rosic.api.rosbridge.introspection import GraphIntrospection
    from rosic.api.rosbridge.messages import CallService, CancelActionGoal, Id, SendActionGoal, Told
    from rosic.contracts.graph_topics import Fields, GraphTopics
    from rosic.core.robot.profile import RobotId

    Say = Callable[[Told], None]

LOOK_S: Final = 60.0
RESULT_WITHIN_S, RESULT_LOOK_S = 2.0, 0.02
GOALS_AT_MOST: Final = 64
"""Goals and calls of one client that are not over."""
UNKNOWN, SUCCEEDED, CANCELLED, ABORTED = 0, 4, 5, 6
_STATUS: Final = {
    "done": SUCCEEDED,
    "sent": SUCCEEDED,
    "cancelled": CANCELLED,
    "failed": ABORTED,
    "refused": ABORTED,
}
NO_GOAL: Final = said("You have no such goal under way.")
TOO_MANY: Final = said("Too many goals and calls at once. Wait for an answer first.")


class _Goal(NamedTuple):
    """A goal under way: its id, its action, and the robot that has it."""

    id: Id
    action: str
    robot: RobotId

    def is_meant(self, heard: CancelActionGoal) -> bool:
        """Whether it is to be cancelled; without an id, every one of that action that has none."""
        if heard.id is not None or self.id is not None:
            return self.id == heard.id
        return absolute(self.action) == absolute(heard.action)


class FollowedGoals:
    """Tells clients how far their goals are."""

    def __init__(self, context: ApiContext) -> None:
        self._following: dict[str, Callable[[OrderEntry], None]] = {}
        context.feed.changed.connect(self._note)

    def follow(self, order: str, tell: Callable[[OrderEntry], None]) -> None:
        """Tell of each step of an order, until it is left."""
        self._following[order] = tell

    def leave(self, order: str) -> None:
        """Tell of an order no more."""
        self._following.pop(order, None)

    def _note(self, entry: OrderEntry) -> None:
        tell = self._following.get(entry.id)
        if tell is not None:
            tell(entry)


class ClientCalls:
    """What one client has called.

    Args:
        context: The rooms.
        speech: Places orders, and stops.
        introspection: Answers what is only asked.
        followed: Tells how far goals are.
        caller: Who calls.
        say: Tells the client.
    """

    def __init__(
        self,
        context: ApiContext,
        speech: CallerRequests,
        introspection: GraphIntrospection,
        followed: FollowedGoals,
        caller: ApiCaller,
        say: Say,
    ) -> None:
        self._context, self._speech, self._introspection = context, speech, introspection
        self._followed, self._caller, self._say = followed, caller, say
        self._bindings = OrderBindings(context)
        self._goals: list[_Goal] = []
        self._under_way = 0

    # ---- services ----

    async def call(self, heard: CallService) -> RosicError | None:
        """Call a service, and answer. Return why it was refused; it is answered, too."""
        refused: RosicError | None = None
        values: Any
        try:
            values, good = await self._called(heard)
        except RefusedOrder as why:
            values, good = why.problem.detail, False
        except RosicError as why:
            values, good, refused = self._read(why), False, why
        self._say(ServiceResponse(heard.service, values, good, given_id(heard.id)))
        return refused

    def gives_stop(self, heard: CallService) -> bool:
        """Give the stop that a service stands for, and wait for nothing; False: it is none."""
        robot = self._bindings.stops(self._caller, heard.service)
        if robot is not None:
            self._speech.give_stop(self._caller, (robot,))
        return robot is not None

    async def _called(self, heard: CallService) -> tuple[Any, bool]:
        request = heard.args if isinstance(heard.args, dict) else {}
        answer = self._introspection.answer(self._caller, heard.service, request)
        if answer is not None:
            return answer, True
        stops = self._bindings.stops(self._caller, heard.service)
        if stops is not None:
            stopped = await self._speech.stop(self._caller, StopIn(robots=(stops,)))
            if self._bindings.releases(stops, request):
                return {"success": False, "message": self._only_stops(stops)}, True
            return {"success": stopped.at_rest is True, "message": stopped.text}, True
        bound, arguments = self._bindings.find(self._caller, SERVICE, heard.service, "", heard.args)
        with self._counted():
            entry, text = await self._placed(bound.robot, bound.skill.id, arguments)
            if entry is None:
                return text, False
            await self._over(entry)
        return self._ended(entry)

    def _only_stops(self, robot: RobotId) -> str:
        sentence = said(
            "{shown} is stopped: this service only stops. Whoever may lets it go on by: "
            "resume {robot}",
            shown=self._context.kernel.rooms.profiles[robot].shown,
            robot=robot,
        )
        return self._context.callers.read_by(sentence, self._caller)

    # ---- actions ----

    async def send_goal(self, heard: SendActionGoal) -> RosicError | None:
        """Send a goal, and tell how it ends. Return why it was refused; that is told, too."""
        refused: RosicError | None = None
        values: Any
        status, good = UNKNOWN, False
        try:
            bound, arguments = self._bindings.find(
                self._caller, ACTION, heard.action, heard.action_type, heard.args
            )
            with self._counted():
                entry, values = await self._placed(bound.robot, bound.skill.id, arguments)
                if entry is not None:
                    await self._follow(heard, entry)
                    await self._result_of(entry)
                    values, good = self._ended(entry)
                    status = _STATUS.get(entry.ending, UNKNOWN)
        except RefusedOrder as why:
            values = why.problem.detail
        except RosicError as why:
            values, refused = self._read(why), why
        self._say(ActionResult(heard.action, values, status, good, given_id(heard.id)))
        return refused

    async def _follow(self, heard: SendActionGoal, entry: OrderEntry) -> None:
        if heard.feedback:

            def tell(step: OrderEntry) -> None:
                values = self._feedback(step)
                if values is not None:
                    self._say(ActionFeedback(heard.action, values, given_id(heard.id)))

            self._followed.follow(entry.id, tell)
        goal = _Goal(heard.id, heard.action, entry.robot)
        self._goals.append(goal)
        try:
            await self._over(entry)
        finally:
            self._goals.remove(goal)
            self._followed.leave(entry.id)

    async def cancel_goal(self, heard: CancelActionGoal) -> None:
        """Cancel a goal of this client; how it ends is its result.

        Raises:
            NotFound: It has none.
        """
        robots = {goal.robot for goal in self._goals if goal.is_meant(heard)}
        if not robots:
            raise NotFound(NO_GOAL)
        for robot in sorted(robots):
            await self._speech.say(self._caller, ChatIn(text=f"cancel {robot}"))

    # ---- orders ----

    @contextmanager
    def _counted(self) -> Iterator[None]:
        """Count one more order, until it is over.

        Raises:
            TooManyRequests: There are too many.
        """
        if self._under_way >= GOALS_AT_MOST:
            raise TooManyRequests(TOO_MANY, retry_after_s=1.0)
        self._under_way += 1
        try:
            yield
        finally:
            self._under_way -= 1

    async def _placed(
        self, robot: RobotId, skill: str, arguments: dict[str, float | str]
    ) -> tuple[OrderEntry | None, str]:
        """Place an order. Return it, or what is said instead."""
        wanted = OrderIn(skill=skill, arguments=arguments, wait_s=0)
        placed = await self._speech.place(self._caller, robot, wanted, "")
        return self._context.feed[placed.id], placed.text

    async def _over(self, entry: OrderEntry) -> None:
        """Wait until an order is over; the feed keeps it as long as it is not."""
        while not entry.is_over:
            await self._speech.wait(entry, LOOK_S)

    async def _result_of(self, entry: OrderEntry) -> None:
        """Wait for the result of a goal that was called off, but not for long.

        Its robot is at rest, and so its order over, before the server says how it ended.
        """
        graph, loop = self._graph(entry), asyncio.get_running_loop()
        if graph is None or _STATUS.get(entry.ending) != CANCELLED:
            return
        until_s = loop.time() + RESULT_WITHIN_S
        while graph.end(entry.n) is None and loop.time() < until_s:  # noqa: ASYNC110 - tells nobody
            await asyncio.sleep(RESULT_LOOK_S)

    def _feedback(self, step: OrderEntry) -> Fields | None:
        """Return how far an order is: as its robot's side says it, or as ROSIC does of others."""
        if step.is_over:
            return None
        graph = self._graph(step)
        if graph is not None:
            return graph.feedback(step.n)
        return {"fraction": step.fraction or 0.0, "stage": step.note}

    def _ended(self, entry: OrderEntry) -> tuple[Any, bool]:
        """Return how an order ended, and whether that is an answer.

        It is what the robot's side has answered; of a robot that is on no graph here it is what
        ROSIC knows, as most robots' answers have it.
        """
        note = self._context.callers.read_by(entry.note, self._caller) or entry.ending
        graph = self._graph(entry)
        if graph is None:
            good = _STATUS.get(entry.ending) == SUCCEEDED
            return {"success": good, "message": note, "ending": entry.ending}, True
        answer = graph.end(entry.n)
        return (note, False) if answer is None else (answer, True)

    def _graph(self, entry: OrderEntry) -> GraphTopics | None:
        rooms = self._context.kernel.rooms
        there = entry.robot in rooms.profiles  # it may have been retired meanwhile
        return rooms.linker.graph_topics(entry.robot) if there else None

    def _read(self, why: RosicError) -> str:
        return self._context.callers.read_by(why.sentence, self._caller)
