"""Velocities sent again and again for a time, and the law that ends them (I6)."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from rosic.core.deadman import BreakCause, DeadMan, MotionBreak
from rosic.core.time_units import SECOND_NS
from rosic.robots.ros2.errors import NotSent
from rosic.robots.ros2.motion_endings import OdometryDistance, told_m_s
from rosic.robots.ros2.publishers import UnidentifiedEndpoints, born_anew

if TYPE_CHECKING:
    from rosic.robots.ros2.bindings.binding_call import BindingCall
    from rosic.robots.ros2.client.topics import Publisher
    from rosic.robots.ros2.messages.encode import Values


class StreamPace(NamedTuple):
    """How often velocities are sent, and for how long in all."""

    period_s: float
    duration_s: float


class VelocityStream:
    """The velocities of one drive, sent until it ends.

    Who takes the velocities is looked at immediately before each is sent. What remains is the way
    from there to DDS, some microseconds in which an end may be matched; and that ROS may call a
    robot by its name only later. Nothing is sent then, and if that takes long the drive is over.

    Attributes:
        moved: The robot was measured to move.
        seconds: For how long it was driven, as far as is known: to the last message that was sent
            in time and, where the robot's side fell silent, to its last word.
        sent_s: For how long velocities were sent.
        way: How far it went.
    """

    def __init__(
        self, call: BindingCall, publisher: Publisher, values: Values, pace: StreamPace
    ) -> None:
        self.moved = False
        self.seconds = self.sent_s = 0.0
        self.way = OdometryDistance(call.side.measured, told_m_s(values))
        self._call = call
        self._publisher = publisher
        self._message = publisher.made(values)
        self._pace = pace
        self._begun_ns = self._sent_ns = 0
        self._newcomers = UnidentifiedEndpoints(publisher.takers(), call.side.watchdog_s / 2)
        self._restarts = call.side.measured.restarts

    async def run(self) -> MotionBreak | None:
        """Pass the gate and send, until the time is over, a stop comes, or it is broken off.

        Returns:
            What broke it off; None otherwise. Nothing is sent any more, no zero either.

        Raises:
            OrderVoid, RobotOffline: The robot has not moved.
        """
        call, clock = self._call, self._call.side.clock
        call.leave()
        self._begun_ns = clock.monotonic_ns()
        side = call.side
        dead_man = DeadMan(
            self._begun_ns, watchdog_s=side.watchdog_s, heard_within_s=side.measured.within_s
        )
        sent = False
        while True:
            now_ns = clock.monotonic_ns()
            broken, past_s = self._look(dead_man, now_ns), (now_ns - self._begun_ns) / SECOND_NS
            if broken is not None or self._over(past_s) or not call.allowed():
                self._ended(broken, dead_man.last_ns)
                return broken
            # Whoever had no name for so long may have one now; the robot has come to rest by then.
            unsent_s = (now_ns - self._sent_ns) / SECOND_NS
            if sent and unsent_s > side.watchdog_s:
                broken = MotionBreak(BreakCause.NAMELESS, unsent_s)
                self._ended(broken, self._sent_ns)
                return broken
            # A process that was frozen goes on from wherever it was: the look takes its time, so
            # the clock is asked once more, and nothing stands between its answer and the sending.
            if dead_man.late(clock.monotonic_ns()):
                continue
            try:
                sent = self._send() or sent
            except NotSent as fault:
                if not sent:
                    raise call.offline() from fault
                self._ended(None, now_ns)
                return MotionBreak(BreakCause.GONE, 0.0)
            await self._pause(past_s)
            self._tell(past_s / self._pace.duration_s)

    def _over(self, past_s: float) -> bool:
        """Tell whether nothing more is to be sent, though nothing has broken it off."""
        return past_s >= self._pace.duration_s

    async def _pause(self, past_s: float) -> None:
        """Wait until the next message is due."""
        await self._call.side.clock.sleep(min(self._pace.period_s, self._pace.duration_s - past_s))

    def _send(self) -> bool:
        """Send, unless somebody has joined who has no name yet: it may be the robot, reborn."""
        if self._newcomers.waits:
            return False
        self._publisher.send(self._message)
        self._sent_ns = self._call.side.clock.monotonic_ns()
        return True

    def _look(self, dead_man: DeadMan, now_ns: int) -> MotionBreak | None:
        measured = self._call.side.measured
        age_s, judged_s = measured.age_s() or 0.0, measured.judged_age_s()
        rests = self._rests()
        # Where nobody was seen at first, whoever is there now may be the robot, reborn.
        there = self._publisher.listeners > 0 and bool(self._newcomers.first)
        # Last, as nothing may come between it and the sending.
        another = self._another(now_ns)
        return dead_man.look(
            now_ns,
            judged_s,
            # What was said together with the last word of what shows rest is no later word.
            heard=age_s < (judged_s or 0.0) - measured.within_s / 4,
            there=there,
            another=another,
            rests=rests,
        )

    def _rests(self) -> bool:
        """Tell whether it has moved, and is at rest, though it is to move."""
        return self.moved and self._call.side.measured.at_rest(self._begun_ns) is True

    def _another(self, now_ns: int) -> BreakCause | None:
        """Tell whether who takes the velocities, or shows whether it rests, is another now."""
        takers = self._publisher.takers()
        nameless = self._newcomers.nameless(takers, now_ns)
        anew = self._call.side.measured.restarts != self._restarts
        if anew or born_anew(self._newcomers.first, takers):
            return BreakCause.REBORN
        return BreakCause.NAMELESS if nameless else None

    def _tell(self, share: float) -> None:
        """Say that it moves, once that is measured, and how much of its time is over."""
        self.way.look()
        call = self._call
        if not self.moved and call.side.measured.at_rest(self._begun_ns) is False:
            self.moved = True
            call.received()
        call.running(min(1.0, share))

    def _ended(self, broken: MotionBreak | None, last_ns: int) -> None:
        unknown = {BreakCause.SILENT, BreakCause.UNMEASURED}
        silent_s = broken.seconds if broken is not None and broken.cause in unknown else 0.0
        self.sent_s = (last_ns - self._begun_ns) / SECOND_NS
        self.seconds = max(0.0, self.sent_s - silent_s)
