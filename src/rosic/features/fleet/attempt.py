"""One attempt at a step of a task: an order like any other, as the task's author.

The rights are those of that moment. Nobody is asked to confirm anything, and nobody is made to
give a robot up: what would want that is refused, and said.
"""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Final, NamedTuple

from rosic.container.records import ReplyTo
from rosic.core.deadman import INTERRUPTED, STOOD_STILL
from rosic.core.fleet.events import AttemptEnd
from rosic.core.fleet.task import TaskReason
from rosic.core.i18n import in_language, joined
from rosic.core.identity import command_id
from rosic.core.order import OrderEnding, Request
from rosic.core.order_status import ENGLISH, wording_in
from rosic.core.policy.query import NOTHING
from rosic.errors import (
    FirstNeeded,
    NotPermitted,
    NotUnderstood,
    OrderVoid,
    OutOfBounds,
    Refusal,
    Repeated,
    RobotStopped,
    Unrecognised,
)
from rosic.features.fleet import messages as words
from rosic.features.fleet.task_parser import step_for
from rosic.gateway.limit_clamping import LimitClamping
from rosic.gateway.order_services import AutomatedRequester
from rosic.gateway.order_status import AwaitedOrder, OrderMessage, stop_button
from rosic.gateway.requests import RequestFactory
from rosic.gateway.rest_wait import comes_to_rest

if TYPE_CHECKING:
    from collections.abc import Callable

    from rosic.contracts.clock import Clock
    from rosic.contracts.messenger import Messenger
    from rosic.core.fleet.events import BeginAttempt, RecallAttempt
    from rosic.core.fleet.task import Task
    from rosic.core.identity import Caller, CommandId, PrincipalId
    from rosic.core.language import Do
    from rosic.core.message import Chat
    from rosic.core.order import Order, Outcome, Permit
    from rosic.core.robot.profile import RobotId
    from rosic.features.fleet.dispatch_state import TaskText
    from rosic.gateway.components import Components
    from rosic.gateway.order_services import OrderServices


# ---- one attempt ----

NEVER = (NotPermitted, OutOfBounds, NotUnderstood, FirstNeeded)
"""What a robot will refuse the next time as well."""


class TaskAttempt(NamedTuple):
    """One attempt that was begun.

    Attributes:
        skill: Of the step.
        began_ns: Monotonic clock.
        took: It has the robot because of this, and not because its author had it before.
    """

    number: int
    skill: str
    began_ns: int
    took: bool


class TaskRequester(NamedTuple):
    """Who waits for an attempt.

    Attributes:
        over: Called once the order has ended and that is on disk.
        wanted: Whether the attempt still counts.
    """

    over: Callable[[Order, Outcome], None]
    wanted: Callable[[], bool]


class TaskAttempts:
    """Gives the orders of tasks."""

    def __init__(self, rooms: Components, hands: OrderServices, clock: Clock) -> None:
        self._rooms = rooms
        self._hands = hands
        self._clock = clock
        self._clamping = LimitClamping(rooms, RequestFactory(rooms, clock), clock)

    async def attempt(
        self, task: Task, doing: BeginAttempt, text: TaskText, asker: TaskRequester
    ) -> TaskAttempt | None:
        """Ask a robot for one step. On return its order is on disk and under way.

        Args:
            task: Which; its author asks.
            doing: Which step, of whom.
            text: What was said for the task.
            asker: Who waits for it.

        Returns:
            None if it was not wanted any more once it was on disk: no robot has heard of it.

        Raises:
            Refusal: Why not. No robot has moved because of it.
        """
        rooms = self._rooms
        caller = rooms.authoriser.stand_for(task.author)
        # What nobody said stays within their limits, as in an order of their own.
        step = step_for(rooms, doing.robot, text.lines[doing.step])
        line, note = self._clamping.of(caller, step)
        request = self._request(doing, line, text, attempt_id(task, doing.attempt))
        complete = rooms.container.complete
        permits = rooms.organiser.admit(
            caller, [request], lambda one: complete(one).arguments, lambda: NOTHING
        )
        try:
            messenger, chat = self._where(task, text)
            shown = rooms.profiles[doing.robot].shown
            title = str(words.order_title(f"{shown}: {request.text}", task))
            origin = ReplyTo(messenger.name, chat, "", title)
            [order] = await rooms.container.prepare(permits, [request], origin)
        except BaseException:
            rooms.organiser.abandon(permits)
            raise
        order_message = self._card(caller, (messenger, chat), request)
        asked = joined(", ", filter(None, (order.words, note)))
        if not self._begin(order, asked, caller, order_message, task, asker):
            return None
        return TaskAttempt(
            doing.attempt, line.skills[0].id, self._clock.monotonic_ns(), _took(permits)
        )

    def _request(self, doing: BeginAttempt, line: Do, text: TaskText, cid: CommandId) -> Request:
        [skill] = line.skills
        now_ns, wall_ns = self._clock.monotonic_ns(), self._clock.wall_ns()
        lives_ns = skill.order_lifetime_ns
        return Request(
            cid,
            doing.robot,
            skill,
            line.spoken,
            text.lines[doing.step],
            wall_ns,
            0,
            now_ns + lives_ns,
            wall_ns + lives_ns,
        )

    def _where(self, task: Task, text: TaskText) -> tuple[Messenger, Chat]:
        """Return where the order is shown: where the task was given, or else in private."""
        reach = self._hands.reach
        places = reach.chats(task.author)
        for messenger in reach.messengers:
            here = messenger.name == text.messenger
            if here and reach.may_read(task.author, text.chat):
                return messenger, text.chat
        if not places:
            raise NotPermitted(words.no_chat(self._rooms.organiser.name_of(task.author)))
        return places[0]

    def _card(
        self, caller: Caller, where: tuple[Messenger, Chat], request: Request
    ) -> OrderMessage:
        hands, robot = self._hands, request.robot
        catalogue = hands.chat_sender.languages.of(caller.principal)
        wording = ENGLISH if catalogue is None else wording_in(catalogue)
        return OrderMessage(
            *where,
            "",
            caller.principal,
            wording,
            about=robot,
            buttons=stop_button(robot),
            after=hands.ends[robot, request.text, catalogue],
        )

    def _begin(
        self,
        order: Order,
        asked: str,
        caller: Caller,
        order_message: OrderMessage,
        task: Task,
        asker: TaskRequester,
    ) -> bool:
        """RELAYCOMMAND goes on by itself, unless nobody wants it any more.

        Between the look and the beginning nothing else happens: whoever takes the task from its
        robot from here on finds the order there, and ends it.
        """
        hands, shown = self._hands, self._rooms.profiles[order.robot].shown
        catalogue = order_message.words.catalogue
        what = in_language(asked, catalogue)
        title = in_language(words.order_title(f"{shown}: {what}", task), catalogue)
        status = AwaitedOrder(shown, title, hands.face, self._clock.wall_ns(), order_message.words)
        order_message.show(order.cid, status)
        wanted = asker.wanted()
        if wanted:
            status.over = partial(asker.over, order)
            hands.executor.begin(
                order,
                AutomatedRequester(caller),
                order_message,
                status,
                self._rooms.linker.dispatch,
            )
        else:
            hands.executor.forgo(
                order,
                AutomatedRequester(caller),
                order_message,
                status,
                OrderVoid(words.NOT_WANTED),
            )
        hands.chat_sender.show(order_message)
        return wanted


def attempt_id(task: Task, attempt: int) -> CommandId:
    """Return the identity of an attempt's order: asked twice, it is the same order."""
    return command_id("task", task.id, str(task.given_ns), str(attempt))


def end_of(refusal: Refusal) -> AttemptEnd:
    """Return what a refusal means for a task."""
    if isinstance(refusal, Repeated):
        return AttemptEnd.UNKNOWN  # it was claimed before, and nobody here saw its end
    if isinstance(refusal, RobotStopped):
        return AttemptEnd.STOPPED
    return AttemptEnd.REFUSED if isinstance(refusal, NEVER) else AttemptEnd.BUSY


def end_after(outcome: Outcome, *, stopped: bool) -> AttemptEnd:
    """Return what the outcome of an order means for a task.

    Args:
        outcome: What the robot did.
        stopped: Somebody has stopped the robot since it was admitted, resumed or not.
    """
    ending = outcome.ending
    if stopped and ending not in {OrderEnding.DONE, OrderEnding.SENT}:
        return AttemptEnd.STOPPED
    if outcome.code == STOOD_STILL:
        return AttemptEnd.INTERRUPTED
    if ending is OrderEnding.CANCELLED:
        # Nobody took it who has seen it at rest: it was ended by its own side.
        return AttemptEnd.FAILED if outcome.code == INTERRUPTED else AttemptEnd.TAKEN
    if ending is OrderEnding.REFUSED:
        never = {refusal.code for refusal in NEVER} | {Unrecognised.code}
        return AttemptEnd.REFUSED if outcome.code in never else AttemptEnd.BUSY
    return _ENDS[ending]


_ENDS = {
    OrderEnding.DONE: AttemptEnd.DONE,
    OrderEnding.FAILED: AttemptEnd.FAILED,
    OrderEnding.SENT: AttemptEnd.SENT,
    OrderEnding.UNKNOWN: AttemptEnd.UNKNOWN,
}


def _took(permits: tuple[Permit, ...]) -> bool:
    return any(permit.new_fence for permit in permits)


CUT_OFF: Final = frozenset({TaskReason.LOST})
"""Nobody can see whether it rests: it is stopped, and stays so until a person has looked."""


class TaskRecall:
    """Ends what a robot does for a task, and nothing else that it does."""

    def __init__(self, rooms: Components, hands: OrderServices, clock: Clock) -> None:
        self._rooms = rooms
        self._hands = hands
        self._clock = clock

    async def recall(self, doing: RecallAttempt, author: PrincipalId, cid: CommandId) -> bool:
        """Return once the robot rests, or once nothing counts that it does for the task.

        Args:
            doing: Which robot, and why.
            author: In whose name it was asked.
            cid: Of the order.

        Returns:
            Whether it was seen at rest, or its side cannot say. If not it was stopped: everything
            that it was asked before is void, however late it hears of it.
        """
        robot, linker = doing.robot, self._rooms.linker
        if doing.why in CUT_OFF or linker.presence(robot).online is False:
            self._cut_off(robot, author)
            return False
        await self._hands.executor.cut_order(robot, cid, words.reason(doing.task, doing.why))
        rested = await comes_to_rest(linker, self._clock, robot)
        if not rested:
            self._cut_off(robot, author)
        else:
            self._give_back(robot, author)
        return rested

    def _cut_off(self, robot: RobotId, author: PrincipalId) -> None:
        """Stop it, and take it from whoever has it: late answers and late orders are void."""
        self._hands.stop_lane.stop_robots((robot,), "")
        if self._rooms.organiser.holder(robot) == author:
            self._rooms.organiser.release(robot)

    def _give_back(self, robot: RobotId, author: PrincipalId) -> None:
        organiser = self._rooms.organiser
        if organiser.holder(robot) == author and not organiser.lease(robot).active:
            organiser.release(robot)
