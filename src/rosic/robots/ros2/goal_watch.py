"""Following a goal that a robot carries out: is it heard, is it in time, and are we?"""

from __future__ import annotations

import asyncio
import logging
from contextlib import contextmanager, suppress
from typing import TYPE_CHECKING, Any, Final, Protocol

from rosic.core.deadman import BreakCause, MotionBreak
from rosic.core.i18n import said
from rosic.core.time_units import SECOND_NS
from rosic.errors import RobotUnreachable, RosicError
from rosic.robots.ros2.bindings.answers import note
from rosic.robots.ros2.messages.decode import compile_path
from rosic.robots.ros2.motion_endings import OdometryDistance
from rosic.robots.ros2.profile import Ros2Skill

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rosic.core.order import Order
    from rosic.robots.ros2.bindings.binding_call import BindingCall
    from rosic.robots.ros2.bindings.goal_fields import Fraction
    from rosic.robots.ros2.client.actions import Goal
    from rosic.robots.ros2.client.rclpy_import import RosObject
    from rosic.robots.ros2.stopping import RestResult


# ---- feedback pulse ----

# Whether the feedback of a goal still comes: what carries a goal out may be frozen, or gone.
#
# Feedback is no duty in ROS: many a server tells only that it has begun. So its ceasing says
# something only of a server that has told of the goal again and again.

STEADY: Final = 5
"""So many messages are feedback that comes again and again; fewer may be stages."""
GAPS: Final = 3
"""So many times its longest gap so far is no gap any more."""
QUIET_S: Final = 1.0


class FeedbackPulse:
    """Counts the feedback of one goal, by the monotonic clock."""

    __slots__ = ("_count", "_last_ns", "_longest_ns")

    def __init__(self, now_ns: int) -> None:
        self._count = 0
        self._last_ns = now_ns
        self._longest_ns = 0

    def beat(self, now_ns: int) -> None:
        """Take in that feedback has come."""
        if self._count:
            self._longest_ns = max(self._longest_ns, now_ns - self._last_ns)
        self._count += 1
        self._last_ns = now_ns

    def silent_s(self, now_ns: int) -> float:
        """Return for how long none has come, from the goal's acceptance on."""
        return (now_ns - self._last_ns) / SECOND_NS

    def quiet(self, now_ns: int) -> bool:
        """Tell whether none comes now; whether it will again is not known."""
        return self._longer_than(QUIET_S, now_ns)

    def ceased(self, now_ns: int, within_s: float) -> bool:
        """Tell whether feedback that came again and again comes no more.

        Args:
            now_ns: The monotonic clock.
            within_s: The deadline of the robot's side, at least.
        """
        return self._count >= STEADY and self._longer_than(within_s, now_ns)

    def _longer_than(self, least_s: float, now_ns: int) -> bool:
        return now_ns - self._last_ns > max(least_s * SECOND_NS, GAPS * self._longest_ns)


# ---- goal watch ----

_log = logging.getLogger(__name__)

LOOK_EVERY_S: Final = 0.5
# What a stopped robot still has to say is worth this much waiting.
LAST_WORD_S: Final = 1.0
CANCEL_WITHIN_S: Final = 2.0
# A robot that is not heard is said to be away at once; it is cancelled again when it is back.
CANCEL_UNHEARD_WITHIN_S: Final = 0.5


class ServerPresence(Protocol):
    """Tells whether those who took a goal still offer its action."""

    def __call__(self, *, quiet: bool) -> BreakCause | None:
        """Return why they do not; None: they do.

        A server that began anew knows nothing of the goal, and would never say how it ended.

        Args:
            quiet: No feedback comes now: whoever offers the action besides has taken their place.
        """
        ...


class GoalWatch:
    """Takes in feedback, and knows for how long nothing was heard, and nobody looked.

    To be made before the goal is sent: what breaks off while its acceptance is on its way counts.

    Attributes:
        broken: Why it was broken off, if it was.
        resting: What came of bringing it to rest after that; None where rest is not measured.
        way: How far it went.
    """

    def __init__(self, call: BindingCall, fraction: Fraction, missed: ServerPresence) -> None:
        """Begin.

        Args:
            call: The order.
            fraction: Returns how far a feedback message says that it is.
            missed: Whether those who are there now still offer the action.
        """
        self.broken: MotionBreak | None = None
        self.resting: RestResult | None = None
        self.way = OdometryDistance(call.side.measured, 0.0)  # as fast as its odometry says
        self._call = call
        self._pulse = FeedbackPulse(self.now_ns())
        self._unserved_ns: int | None = None
        self._restarts = call.side.measured.restarts
        self._fraction = fraction
        self._missed = missed
        self._looked_ns = self.now_ns()
        skill = call.order.skill
        binding = skill.action if isinstance(skill, Ros2Skill) else None
        self._stage = binding.stage if binding is not None else ""

    def now_ns(self) -> int:
        """Return the monotonic clock."""
        return self._call.side.clock.monotonic_ns()

    def feedback(self, message: RosObject) -> None:
        """Pass on how far the robot says it is."""
        self._pulse.beat(self.now_ns())
        self._call.fed_back(message)
        stage = _field(message, self._stage)
        words = note(stage) if isinstance(stage, str) else ""
        self._call.running(self._fraction(message), words)

    def silent_s(self) -> float:
        """Return for how long neither feedback nor telemetry came; 0 without any telemetry."""
        age_s = self._call.side.measured.age_s()
        if age_s is None:
            return 0.0
        return min(age_s, self._pulse.silent_s(self.now_ns()))

    @contextmanager
    def looking(self) -> Iterator[None]:
        """Look while a goal is sent and its acceptance waited for.

        A side that was frozen meanwhile, and is back, would begin with a goal from before.
        """
        task = asyncio.create_task(self._look_on())
        try:
            yield
        finally:
            task.cancel()

    async def _look_on(self) -> None:
        while self.broken is None:
            await asyncio.sleep(LOOK_EVERY_S)
            self.broken = self._late() or self._look()

    async def end(
        self, goal: Goal, end: asyncio.Future[Any], halted: asyncio.Future[Any], limit_s: float
    ) -> None:
        """Return once the goal has ended, a stop has done what it could, or it was broken off.

        Args:
            goal: Which.
            end: Its end.
            halted: A stop has done what it could.
            limit_s: It may take so long.

        Raises:
            RobotUnreachable: It fell silent, or took too long; it was called off.
        """
        deadline_ns = self.now_ns() + int(limit_s * SECOND_NS)
        while self.broken is None and not end.done() and not halted.done():
            await asyncio.wait(
                {end, halted}, timeout=LOOK_EVERY_S, return_when=asyncio.FIRST_COMPLETED
            )
            self.way.look()
            self.broken = self._late() or (None if end.done() else self._look())
            if self.broken is not None:
                break
            if not end.done() and not halted.done():
                await self._give_up(goal, limit_s if self.now_ns() > deadline_ns else 0.0)
        if self.broken is not None and not end.done():
            await self._break_off(goal, end, self.broken)
        if not end.done():
            await asyncio.wait({end}, timeout=LAST_WORD_S)

    async def _break_off(self, goal: Goal, end: asyncio.Future[Any], broken: MotionBreak) -> None:
        """Bring the robot to rest: whatever half of it is gone, the other may drive on."""
        side = self._call.side
        self._call.interrupted(broken)
        if side.measured.measures_rest:
            self.resting = await side.stop_controller.apply()
        else:
            await call_off(goal)
            await asyncio.wait({end}, timeout=side.rest_timeout_s)
        self.way.look()

    def _late(self) -> MotionBreak | None:
        """Return that nobody looked for too long: ROSIC, or the whole machine, stood still."""
        now_ns, before_ns = self.now_ns(), self._looked_ns
        self._looked_ns = now_ns
        late_s = (now_ns - before_ns) / SECOND_NS - LOOK_EVERY_S
        return MotionBreak(BreakCause.LATE, late_s) if late_s > self._call.side.watchdog_s else None

    def _look(self) -> MotionBreak | None:
        """Return why it must not go on: one half of the robot is gone, whatever the other says."""
        now_ns, measured = self.now_ns(), self._call.side.measured
        broken = self._left(self._missed(quiet=self._pulse.quiet(now_ns)))
        if broken is not None or not self._call.order.skill.actuates:
            return broken
        age_s = measured.judged_age_s() if measured.measures_rest else None
        if age_s is not None and age_s > measured.within_s:
            # What was said together with the last word of what shows rest is no later word.
            heard = self.silent_s() < age_s - measured.within_s / 4
            return MotionBreak(BreakCause.UNMEASURED if heard else BreakCause.SILENT, age_s)
        if self._pulse.ceased(now_ns, measured.silence_s):
            return MotionBreak(BreakCause.UNREPORTED, self._pulse.silent_s(now_ns))
        return None

    def _left(self, why: BreakCause | None) -> MotionBreak | None:
        """Return that nobody carries out the goal any more; one look alone may be wrong."""
        if why is BreakCause.REBORN or self._call.side.measured.restarts != self._restarts:
            return MotionBreak(BreakCause.REBORN, 0.0)
        if why is None:
            self._unserved_ns = None
            return None
        if self._unserved_ns is None:
            self._unserved_ns = self.now_ns()
        unserved_s = (self.now_ns() - self._unserved_ns) / SECOND_NS
        return MotionBreak(why, unserved_s) if unserved_s >= LOOK_EVERY_S else None

    async def _give_up(self, goal: Goal, passed_s: float) -> None:
        """Call a goal off that takes too long, or whose robot is not heard; else do nothing.

        Raises:
            RobotUnreachable: It was called off.
        """
        call, shown, silent_s = self._call, self._call.side.shown, self.silent_s()
        if silent_s > call.side.measured.silence_s:
            call.in_doubt()
            await call_off(goal, CANCEL_UNHEARD_WITHIN_S)
            raise RobotUnreachable(
                said(
                    "{shown} has not answered for {silent_s:.1f} s.", shown=shown, silent_s=silent_s
                )
            )
        if passed_s:
            await call_off(goal)
            raise RobotUnreachable(
                said(
                    "{shown} was not done within {passed_s:g} s and was told to stop.",
                    shown=shown,
                    passed_s=passed_s,
                )
            )


async def call_off(goal: Goal, within_s: float = CANCEL_WITHIN_S) -> None:
    """Cancel a goal; whether anybody hears it is not known."""
    with suppress(RosicError):
        answer = await goal.cancel(timeout_s=within_s)
        _log.debug("a goal of %s was called off: %s", goal.name, answer)


def until_start_s(order: Order, now_ns: int) -> float:
    """Return how long it is to the common start; 0 without one."""
    return 0.0 if order.start_ns is None else max(0.0, (order.start_ns - now_ns) / SECOND_NS)


def _field(message: RosObject, path: str) -> object:
    try:
        return compile_path(type(message), path)(message) if path else None
    except RosicError:
        return None
