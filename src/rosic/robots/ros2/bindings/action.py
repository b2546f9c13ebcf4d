"""Skills that are actions: acceptance is the receipt, feedback the progress, the result the end."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

from rosic.core.deadman import INTERRUPTED, BreakCause
from rosic.core.i18n import joined, said
from rosic.core.order import OrderEnding, Outcome
from rosic.core.synchronised_start import begins_ns
from rosic.core.time_units import SECOND_NS
from rosic.errors import RobotUnreachable
from rosic.robots.ros2.abandoned_goals import AbandonedGoal
from rosic.robots.ros2.bindings.answers import BindingAnswer
from rosic.robots.ros2.bindings.binding_call import DECLINED, over
from rosic.robots.ros2.bindings.goal_fields import GoalFields
from rosic.robots.ros2.client.executor_thread import ahead_ns
from rosic.robots.ros2.errors import NoAnswer, NotSent
from rosic.robots.ros2.goal_watch import GoalWatch, call_off, until_start_s
from rosic.robots.ros2.messages.decode import compile_path
from rosic.robots.ros2.messages.encode import to_message
from rosic.robots.ros2.motion_endings import NotAtRest, after_the_end, in_doubt, moved
from rosic.robots.ros2.publishers import born_anew, named_since
from rosic.robots.ros2.rosout_reasons import RosoutReasons

if TYPE_CHECKING:
    from rosic.core.deadman import MotionBreak
    from rosic.robots.ros2.bindings.binding_call import BindingCall
    from rosic.robots.ros2.bindings.goal_fields import GoalMaker
    from rosic.robots.ros2.client.actions import ActionLink, Goal, GoalEnd
    from rosic.robots.ros2.client.rclpy_import import RosObject
    from rosic.robots.ros2.client.runtime import RosRuntime
    from rosic.robots.ros2.goal_watch import ServerPresence
    from rosic.robots.ros2.profile import ActionBinding

ACCEPT_WITHIN_S = 5.0


class ActionSkill:
    """Sends goals of one action."""

    def __init__(self, binding: ActionBinding, maker: GoalMaker | None = None) -> None:
        """Make it.

        Args:
            binding: Which action, and what its answers say.
            maker: Makes its goals, if not from the fields that the binding names.
        """
        self._binding = binding
        self._maker = maker or GoalFields(binding)
        self._link: ActionLink | None = None
        self._cls: RosObject = None
        self._reasons = RosoutReasons()

    def types(self) -> set[str]:
        """Return the action's type, and that of the log in which refusals are explained."""
        return {self._binding.type, *self._reasons.types(), *self._maker.types()}

    async def open(self, runtime: RosRuntime) -> None:
        """Open the action's client and check every field that the profile names."""
        binding = self._binding
        self._cls = cls = runtime.types.action(binding.type)
        await self._maker.open(runtime, cls)
        if binding.start:
            compile_path(cls.Goal, f"{binding.start}.sec")
        self._answer = BindingAnswer(cls.Result, binding)
        self._reasons.open(runtime)
        self._link = await runtime.action(binding.name, binding.type)

    async def close(self) -> None:
        """Leave the action."""
        await self._maker.close()
        link, self._link = self._link, None
        if link is not None:
            await link.close()

    async def carry(self, call: BindingCall) -> Outcome:
        """Send the goal and follow it to its end."""
        link, order = self._link, call.order
        if link is None:
            raise call.offline()
        together = bool(self._binding.start)
        await call.there(link.sought, link.name, together=together)
        made = self._maker.make(call)
        if isinstance(made, Outcome):
            return made
        values = self._started(made.values, call)
        to_message(self._cls.Goal, values)
        sent_ns = call.side.clock.wall_ns()
        watch = GoalWatch(call, made.fraction, _served_by(link))
        call.leave(together=together)
        try:
            with watch.looking():
                goal = await link.send(
                    values, timeout_s=ACCEPT_WITHIN_S, goal_id=order.cid, on_feedback=watch.feedback
                )
        except NotSent as fault:
            raise call.offline() from fault
        except NoAnswer as fault:
            call.unanswered()
            raise RobotUnreachable(
                said(
                    "{shown} has not answered for {accept_within_s:g} s.",
                    shown=call.side.shown,
                    accept_within_s=ACCEPT_WITHIN_S,
                )
            ) from fault
        if goal is None:
            reason = await self._reasons.why(call.side.namespace, sent_ns)
            return Outcome(OrderEnding.REFUSED, _declined(call, reason), code=DECLINED)
        call.received()
        if not call.allowed():
            await call_off(goal)
        end = await self._end(goal, call, watch, link)
        done = end is not None and end.status == "succeeded"
        if watch.broken is not None and call.allowed() and not done:
            return await self._broken_off(call, watch, watch.broken, end)
        return await self._outcome(call, end)

    def _started(self, values: dict[str, object], call: BindingCall) -> dict[str, object]:
        """Add the common start, if there is one and the action takes it."""
        clock = call.side.clock
        start_ns = begins_ns(call.order, clock.monotonic_ns())
        if self._binding.start and start_ns is not None:
            at_ns = start_ns + ahead_ns(clock.wall_ns, clock.monotonic_ns)
            values[f"{self._binding.start}.sec"] = at_ns // SECOND_NS
            values[f"{self._binding.start}.nanosec"] = at_ns % SECOND_NS
        return values

    async def _end(
        self, goal: Goal, call: BindingCall, watch: GoalWatch, link: ActionLink
    ) -> GoalEnd | None:
        """Wait for the end; None when a stop, or a break, brought no more words.

        Raises:
            RobotUnreachable: It fell silent, took too long (and was called off), or did not
                confirm a stop.
        """

        def told(found: GoalEnd) -> None:
            if found.status != "unknown":
                call.answered(found.result)

        goal.tell_end(told)
        limit_s = self._binding.timeout_s + until_start_s(call.order, watch.now_ns())
        end = asyncio.ensure_future(goal.end())
        halted = asyncio.ensure_future(call.halted.wait())
        try:
            await watch.end(goal, end, halted, limit_s)
            if end.done():
                return end.result()
        except NoAnswer as fault:
            raise RobotUnreachable(
                said("{shown} cannot be reached any more.", shown=call.side.shown)
            ) from fault
        finally:
            if not end.done():
                call.given_up(AbandonedGoal(goal, link.ready))
            end.cancel()
            halted.cancel()
        if call.halted.is_set():
            _confirmed(call)
        return None

    async def _broken_off(
        self, call: BindingCall, watch: GoalWatch, broken: MotionBreak, end: GoalEnd | None
    ) -> Outcome:
        """Say what is known of a goal that did not get to its end; nobody begins it again."""
        side, result, metres = call.side, None if end is None else end.result, watch.way.metres
        words = "" if result is None else self._answer.words(result)
        what = joined("; ", filter(None, (words, moved(metres), over(broken))))
        if watch.resting is not None and not watch.resting.confirmed:
            raise in_doubt(side.shown, what, watch.resting)
        if watch.resting is None and end is None:
            raise RobotUnreachable(joined(": ", (side.shown, what)))
        facts = {} if metres is None else {"distance_m": metres}
        facts |= {} if result is None else self._answer.facts(result)
        return Outcome(OrderEnding.FAILED, what, facts, code=broken.code)

    async def _outcome(self, call: BindingCall, end: GoalEnd | None) -> Outcome:
        if end is None:
            return Outcome(OrderEnding.CANCELLED)
        result = end.result
        doubt = NotAtRest() if end.status == "unknown" else await after_the_end(call)
        words = joined("; ", filter(None, (self._answer.words(result), doubt.words)))
        facts = self._answer.facts(result)
        if end.status == "unknown":
            raise RobotUnreachable(
                said("{shown} has not said how it ended.", shown=call.side.shown)
            )
        if end.status == "succeeded" and self._answer.succeeded(result):
            words = joined("; ", filter(None, (words, self._answer.in_doubt(result))))
            return Outcome(OrderEnding.DONE, words, facts, code=doubt.code)
        if not call.allowed():
            return Outcome(OrderEnding.CANCELLED, words, facts)
        if end.status == "cancelled":  # by its own side, or by somebody beside us
            return Outcome(OrderEnding.CANCELLED, words, facts, code=INTERRUPTED)
        return Outcome(OrderEnding.FAILED, words, facts, code=doubt.code)


def _served_by(link: ActionLink) -> ServerPresence:
    """Return what says why those who offer the action now do so no more; None: they do."""
    first = link.servers()

    def missed(*, quiet: bool) -> BreakCause | None:
        nonlocal first
        now = link.servers()
        first = named_since(first, now)
        replaced = quiet and bool(first) and not now.keys() <= first.keys()
        if replaced or born_anew(first, now):
            return BreakCause.REBORN
        return None if link.ready() else BreakCause.UNSERVED

    return missed


def _confirmed(call: BindingCall) -> None:
    """Make sure that a stop was measured to have worked.

    Raises:
        RobotUnreachable: It was not.
    """
    if call.rest is None or not call.rest.confirmed:
        raise RobotUnreachable(said("{shown} has not confirmed the stop.", shown=call.side.shown))


def _declined(call: BindingCall, reason: str) -> str:
    if not reason:
        return said("{shown} declined.", shown=call.side.shown)
    return said("{reason}. Nothing was done.", reason=reason)
