"""One order on its way through one binding, and what every binding has in common."""

from __future__ import annotations

import asyncio
import logging
from typing import TYPE_CHECKING, NamedTuple, Protocol

from rosic.core.deadman import BreakCause
from rosic.core.i18n import said
from rosic.core.order import OrderProgress, OrderStage, StageReport
from rosic.core.synchronised_start import TOO_LATE_NS, begins_ns, misses_start
from rosic.core.time_units import SECOND_NS
from rosic.errors import RobotOffline
from rosic.robots.ros2.client.services import wait_until
from rosic.robots.ros2.errors import NotSent
from rosic.robots.ros2.messages.coerce import clean_text

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from rosic.contracts.clock import Clock
    from rosic.contracts.live_control import LiveControls
    from rosic.contracts.robot import Tell
    from rosic.core.deadman import MotionBreak
    from rosic.core.order import Order, Outcome
    from rosic.core.order_gate import OrderGate
    from rosic.core.robot.skill import Argument
    from rosic.robots.ros2.abandoned_goals import AbandonedGoal
    from rosic.robots.ros2.bindings.answers import OrderAnswers
    from rosic.robots.ros2.client.rclpy_import import RosObject
    from rosic.robots.ros2.client.runtime import RosRuntime
    from rosic.robots.ros2.stopping import RestResult, StopController
    from rosic.robots.ros2.telemetry import Measurements

_log = logging.getLogger(__name__)

DECLINED = "robot-declined"
JUST_AFTER_S = 0.001


class RobotSide(NamedTuple):
    """One robot's side, as far as a binding needs it.

    Attributes:
        watchdog_s: A gap of ours that is longer breaks off what moves.
        answers: Keeps what the robot's side says of orders.
    """

    shown: str
    gate: OrderGate
    clock: Clock
    stop_controller: StopController
    measured: Measurements
    namespace: str
    rest_timeout_s: float
    watchdog_s: float
    answers: OrderAnswers


class Binding(Protocol):
    """Carries orders of one skill through its binding."""

    def types(self) -> set[str]:
        """Return the types that the binding names."""
        ...

    async def open(self, runtime: RosRuntime) -> None:
        """Open what it needs, so that nothing has to be found when an order comes.

        Raises:
            BadName: A name, a type or a field does not exist.
        """
        ...

    async def close(self) -> None:
        """Close it."""
        ...

    async def carry(self, call: BindingCall) -> Outcome:
        """Carry one order. See ``contracts.robot.Robot.execute``."""
        ...


def over(broken: MotionBreak) -> str:
    """Return why a motion did not go on."""
    seconds = broken.seconds
    if broken.cause is BreakCause.LATE:
        return said(
            "broken off because ROSIC itself stood still for {seconds:.1f} s", seconds=seconds
        )
    if broken.cause is BreakCause.SILENT:
        return said("broken off because it was not heard for {seconds:.1f} s", seconds=seconds)
    if broken.cause is BreakCause.UNMEASURED:
        return said(
            "broken off because its motion was not measured for {seconds:.1f} s", seconds=seconds
        )
    if broken.cause is BreakCause.UNREPORTED:
        return said(
            "broken off because its software told nothing of it for {seconds:.1f} s",
            seconds=seconds,
        )
    return _left(broken.cause)


def _left(cause: BreakCause) -> str:
    if cause is BreakCause.GONE:
        return said("broken off because it was not there any more")
    if cause is BreakCause.UNSERVED:
        return said("broken off because the software for it was not there any more")
    if cause is BreakCause.REBORN:
        return said("broken off because its software began anew")
    if cause is BreakCause.NAMELESS:
        return said("broken off because somebody unknown took its velocities, too")
    return said("broken off because it came to rest by itself")


class BindingCall:
    """One order under way.

    Attributes:
        controls: What steers it, if it is live.
        left: It has passed the gate: from here on the robot may move.
        halted: Set when a stop has done what it could; ``rest`` then says what came of it.
        loose: Its goal, given up without a word of how it ended: it may go on.
        unsettled: Whether the robot rests is not known: once it is heard again it is brought to
            rest first.
    """

    def __init__(
        self,
        order: Order,
        tell: Tell,
        side: RobotSide,
        patience_s: float,
        controls: LiveControls | None = None,
    ) -> None:
        self.order = order
        self.controls = controls
        self.side = side
        self.left = False
        self.unsettled = False
        self.loose: AbandonedGoal | None = None
        self.halted = asyncio.Event()
        self.rest: RestResult | None = None
        self._tell = tell
        self._patience_s = patience_s
        self._received = False
        self._is_cut_off = False
        self._progress = OrderProgress()

    async def there(self, ready: Callable[[], bool], what: str, *, together: bool = False) -> None:
        """Make sure that somebody is there.

        Args:
            ready: Whether somebody is.
            what: Who is meant.
            together: Whether the order keeps its common start: it is not waited for longer than
                it may be late, as the others move meanwhile.

        Raises:
            OrderVoid: Nobody is, and the order's time is over.
            RobotOffline: Nobody is, though discovery had its time.
        """
        if ready():
            return
        try:
            await wait_until(ready, what, self._patient_s(together=together))
        except NotSent as fault:
            now_ns, wall_ns = self.side.clock.monotonic_ns(), self.side.clock.wall_ns()
            missed = together and misses_start(self.order, now_ns, wall_ns)
            if missed or self.order.is_late(now_ns, wall_ns):  # being late is why, not discovery
                self.side.gate.pass_order(self.order, now_ns, wall_ns, together=together)
            raise self.offline() from fault

    def _patient_s(self, *, together: bool) -> float:
        now_ns = self.side.clock.monotonic_ns()
        start_ns = begins_ns(self.order, now_ns) if together else None
        if start_ns is None:
            return self._patience_s
        return max(
            0.0, min(self._patience_s, (start_ns + TOO_LATE_NS - now_ns) / SECOND_NS + JUST_AFTER_S)
        )

    def offline(self) -> RobotOffline:
        """Return the refusal of a robot that is not there."""
        return RobotOffline(said("{shown} is not there. Nothing was sent.", shown=self.side.shown))

    def leave(self, *, together: bool = False) -> None:
        """Pass the gate and say that it is sent. The message must leave without suspension.

        Args:
            together: Whether the message carries the common start, if there is one.

        Raises:
            OrderVoid: The gate declined.
        """
        clock = self.side.clock
        self.side.gate.pass_order(
            self.order, clock.monotonic_ns(), clock.wall_ns(), together=together
        )
        self.left = True
        _log.debug("%s: order %d is sent", self.order.robot, self.order.n)
        self._tell(StageReport(OrderStage.SENT))

    def allowed(self) -> bool:
        """Tell whether it may go on: no stop has come, and nobody is cutting it off."""
        return not self._is_cut_off and self.side.gate.still_allows(self.order)

    def cut_off(self) -> None:
        """It is being ended without a stop, as ROSIC closes.

        The robot is brought to rest, and may say that its goal came to nothing before anybody has
        cancelled that.
        """
        self._is_cut_off = True
        self.unsteer()

    def unsteer(self) -> None:
        """Nobody steers it any more: a stop has come, or it is being ended."""
        if self.controls is not None:
            self.controls.close()

    def stopped(self, rest: RestResult) -> None:
        """A stop has done what it could, and this came of it."""
        self.rest = rest
        self.halted.set()

    def given_up(self, goal: AbandonedGoal) -> None:
        """Nobody waits for the end of its goal any more; it may go on."""
        self.loose = goal

    def in_doubt(self) -> None:
        """The robot was not seen at rest, though nothing moves it on purpose any more."""
        self.unsettled = True

    def unanswered(self) -> None:
        """It was sent, and nothing came back: the robot may be about it, now or later."""
        if self.order.skill.actuates:
            self.in_doubt()

    def interrupted(self, broken: MotionBreak) -> None:
        """It is broken off. That is said at once: coming to rest may take its time."""
        self.in_doubt()
        self.side.measured.cut()
        _log.warning("%s: order %d is broken off: %s", self.order.robot, self.order.n, broken)
        self.running(None, over(broken))

    def fed_back(self, message: RosObject) -> None:
        """Its side says how far it is, in its own words."""
        self.side.answers.put_feedback(self.order.n, message)

    def answered(self, message: RosObject) -> None:
        """Its side says how it ended, in its own words."""
        self.side.answers.put_end(self.order.n, message)

    def received(self) -> None:
        """The robot's side has it."""
        if not self._received:
            self._received = True
            self._tell(StageReport(OrderStage.RECEIVED))

    def running(self, fraction: float | None, note: str = "") -> None:
        """The robot's side says how far it is; what falls back or comes too early is not told."""
        if not self._received:
            return
        told = self._progress.reported(fraction)
        self._tell(StageReport(OrderStage.RUNNING, told, note))


def filled(values: Mapping[str, float | int | str | bool], order: Order) -> dict[str, object]:
    """Return the fields of a message with ``$name`` replaced by the order's arguments (SI).

    Text from a chat is cleaned; everything is checked against the message's type afterwards.
    """
    return filled_with(values, order, order.arguments)


def filled_with(
    values: Mapping[str, float | int | str | bool],
    order: Order,
    arguments: Mapping[str, Argument],
) -> dict[str, object]:
    """Return the same with other arguments than the order's own: those of a sample (SI)."""
    found: dict[str, object] = {}
    for field, value in values.items():
        given = order.skill.filled(value, arguments)
        found[field] = clean_text(given) if isinstance(given, str) else given
    return found
