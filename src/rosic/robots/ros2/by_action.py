"""Skills that are actions: acceptance is the receipt, feedback the progress, the result the end."""

from __future__ import annotations

import asyncio
import logging
from contextlib import suppress
from typing import TYPE_CHECKING

from rosic.core.common_start import begins_ns
from rosic.core.order import Ending, Outcome
from rosic.core.saying import said
from rosic.errors import RobotUnreachable, RosicError
from rosic.robots.ros2.errand import DECLINED, Answer, note
from rosic.robots.ros2.faults import NoAnswer, NotSent
from rosic.robots.ros2.goal_fields import Fields
from rosic.robots.ros2.messages import to_message
from rosic.robots.ros2.reading import compile_path
from rosic.robots.ros2.reasons import Reasons
from rosic.robots.ros2.two_clocks import ahead_ns

if TYPE_CHECKING:
    from rosic.core.order import Order
    from rosic.core.skill import ActionBinding
    from rosic.robots.ros2.actions import ActionLink, Goal, GoalEnd
    from rosic.robots.ros2.errand import Errand
    from rosic.robots.ros2.goal_fields import Fraction, Maker
    from rosic.robots.ros2.ros import RosObject
    from rosic.robots.ros2.runtime import RosRuntime

_log = logging.getLogger(__name__)

ACCEPT_WITHIN_S = 5.0
CANCEL_WITHIN_S = 2.0
LOOK_EVERY_S = 0.5
# What a stopped robot still has to say is worth this much waiting.
LAST_WORD_S = 1.0
_NS = 1_000_000_000


class ByAction:
    """Sends goals of one action."""

    def __init__(self, binding: ActionBinding, maker: Maker | None = None) -> None:
        """Make it.

        Args:
            binding: Which action, and what its answers say.
            maker: Makes its goals, if not from the fields that the binding names.
        """
        self._binding = binding
        self._maker = maker or Fields(binding)
        self._link: ActionLink | None = None
        self._cls: RosObject = None
        self._reasons = Reasons()

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
        self._answer = Answer(cls.Result, binding.success, binding.message)
        self._reasons.open(runtime)
        self._link = await runtime.action(binding.name, binding.type)

    async def close(self) -> None:
        """Leave the action."""
        await self._maker.close()
        link, self._link = self._link, None
        if link is not None:
            await link.close()

    async def carry(self, errand: Errand) -> Outcome:
        """Send the goal and follow it to its end."""
        link, order = self._link, errand.order
        if link is None:
            raise errand.offline()
        together = bool(self._binding.start)
        await errand.there(link.ready, link.name, together=together)
        made = self._maker.make(errand)
        if isinstance(made, Outcome):
            return made
        values = self._started(made.values, errand)
        to_message(self._cls.Goal, values)
        sent_ns = errand.side.clock.wall_ns()
        errand.leave(together=together)
        watch = _Watch(errand, made.fraction)
        try:
            goal = await link.send(
                values, timeout_s=ACCEPT_WITHIN_S, goal_id=order.cid, on_feedback=watch.feedback
            )
        except NotSent as fault:
            raise errand.offline() from fault
        except NoAnswer as fault:
            raise RobotUnreachable(
                said(
                    "{shown} has not answered for {accept_within_s:g} s.",
                    shown=errand.side.shown,
                    accept_within_s=ACCEPT_WITHIN_S,
                )
            ) from fault
        if goal is None:
            reason = await self._reasons.why(errand.side.namespace, sent_ns)
            return Outcome(Ending.REFUSED, _declined(errand, reason), code=DECLINED)
        errand.received()
        if not errand.allowed():
            await _call_off(goal)
        return self._outcome(errand, await self._end(goal, errand, watch))

    def _started(self, values: dict[str, object], errand: Errand) -> dict[str, object]:
        """Add the common start, if there is one and the action takes it."""
        clock = errand.side.clock
        start_ns = begins_ns(errand.order, clock.monotonic_ns())
        if self._binding.start and start_ns is not None:
            at_ns = start_ns + ahead_ns(clock.wall_ns, clock.monotonic_ns)
            values[f"{self._binding.start}.sec"] = at_ns // _NS
            values[f"{self._binding.start}.nanosec"] = at_ns % _NS
        return values

    async def _end(self, goal: Goal, errand: Errand, watch: _Watch) -> GoalEnd | None:
        """Wait for the end; None when a stop brought the robot to rest and no more was said.

        Raises:
            RobotUnreachable: It fell silent, took too long (and was called off), or did not
                confirm a stop.
        """
        limit_s = self._binding.timeout_s + _until_start_s(errand.order, watch.now_ns())
        deadline_ns = watch.now_ns() + int(limit_s * _NS)
        end = asyncio.ensure_future(goal.end())
        halted = asyncio.ensure_future(errand.halted.wait())
        try:
            while True:
                await asyncio.wait(
                    {end, halted}, timeout=LOOK_EVERY_S, return_when=asyncio.FIRST_COMPLETED
                )
                if not end.done() and halted.done():
                    await asyncio.wait({end}, timeout=LAST_WORD_S)
                if end.done():
                    return end.result()
                if halted.done():
                    _confirmed(errand)
                    return None
                await _give_up(goal, errand, watch, limit_s if watch.now_ns() > deadline_ns else 0)
        except NoAnswer as fault:
            raise RobotUnreachable(
                said("{shown} cannot be reached any more.", shown=errand.side.shown)
            ) from fault
        finally:
            if not end.done():
                goal.forget()
            end.cancel()
            halted.cancel()

    def _outcome(self, errand: Errand, end: GoalEnd | None) -> Outcome:
        if end is None:
            return Outcome(Ending.CANCELLED)
        result = end.result
        words, facts = self._answer.words(result), self._answer.facts(result)
        if end.status == "unknown":
            raise RobotUnreachable(
                said("{shown} has not said how it ended.", shown=errand.side.shown)
            )
        if end.status == "succeeded" and self._answer.succeeded(result):
            return Outcome(Ending.DONE, words, facts)
        if end.status == "cancelled" or not errand.allowed():
            return Outcome(Ending.CANCELLED, words, facts)
        return Outcome(Ending.FAILED, words, facts)


class _Watch:
    """Takes in feedback, and knows for how long nothing was heard."""

    def __init__(self, errand: Errand, fraction: Fraction) -> None:
        self._errand = errand
        self._heard_ns = self.now_ns()
        self._fraction = fraction
        binding = errand.order.skill.action
        self._stage = binding.stage if binding is not None else ""

    def now_ns(self) -> int:
        """Return the monotonic clock."""
        return self._errand.side.clock.monotonic_ns()

    def feedback(self, message: RosObject) -> None:
        """Pass on how far the robot says it is."""
        self._heard_ns = self.now_ns()
        stage = _field(message, self._stage)
        words = note(stage) if isinstance(stage, str) else ""
        self._errand.running(self._fraction(message), words)

    def silent_s(self) -> float:
        """Return for how long neither feedback nor telemetry came; 0 without any telemetry."""
        age_s = self._errand.side.measured.age_s()
        if age_s is None:
            return 0.0
        return min(age_s, (self.now_ns() - self._heard_ns) / _NS)


def _field(message: RosObject, path: str) -> object:
    try:
        return compile_path(type(message), path)(message) if path else None
    except RosicError:
        return None


def _confirmed(errand: Errand) -> None:
    """Make sure that a stop was measured to have worked.

    Raises:
        RobotUnreachable: It was not.
    """
    if errand.rest is None or not errand.rest.confirmed:
        raise RobotUnreachable(said("{shown} has not confirmed the stop.", shown=errand.side.shown))


async def _give_up(goal: Goal, errand: Errand, watch: _Watch, passed_s: float) -> None:
    """Call a goal off that takes too long, or whose robot has fallen silent; else do nothing.

    Raises:
        RobotUnreachable: It was called off.
    """
    shown, silent_s = errand.side.shown, watch.silent_s()
    if silent_s > errand.side.measured.silence_s:
        await _call_off(goal)
        raise RobotUnreachable(
            said("{shown} has not answered for {silent_s:.1f} s.", shown=shown, silent_s=silent_s)
        )
    if passed_s:
        await _call_off(goal)
        raise RobotUnreachable(
            said(
                "{shown} was not done within {passed_s:g} s and was told to stop.",
                shown=shown,
                passed_s=passed_s,
            )
        )


async def _call_off(goal: Goal) -> None:
    """Cancel a goal; whether anybody hears it is not known."""
    with suppress(RosicError):
        answer = await goal.cancel(timeout_s=CANCEL_WITHIN_S)
        _log.debug("a goal of %s was called off: %s", goal.name, answer)


def _until_start_s(order: Order, now_ns: int) -> float:
    return 0.0 if order.start_ns is None else max(0.0, (order.start_ns - now_ns) / _NS)


def _declined(errand: Errand, reason: str) -> str:
    if not reason:
        return said("{shown} declined.", shown=errand.side.shown)
    return said("{reason}. Nothing was done.", reason=reason)
