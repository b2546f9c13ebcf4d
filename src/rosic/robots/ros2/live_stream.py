"""Velocities that samples replace while they are sent: a live order over a topic.

When each is sent decides how soon a robot follows a hand, so the stream waits for the sample and
not for its tick: one that comes later than ``1 / live_hz`` after the last message goes out at once,
the step of the event loop after it came. One that comes sooner waits for what is left of that, and
whatever comes meanwhile takes its place. Without samples the newest is sent again ``stream_hz``
times a second, as any stream is, until the controls have been silent for too long. Everything that
is asked before a message of any stream is asked before each of these.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, NamedTuple

from rosic.core.time_units import SECOND_NS
from rosic.robots.ros2.velocity_stream import StreamPace, VelocityStream

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from rosic.contracts.live_control import LiveControls
    from rosic.core.robot.skill import Argument
    from rosic.core.sample_gate import LiveEnd
    from rosic.robots.ros2.bindings.binding_call import BindingCall
    from rosic.robots.ros2.client.topics import Publisher
    from rosic.robots.ros2.messages.encode import Values

WISH: Final = 0.05
"""Whoever asks for less than this share of what they may have does not miss any motion."""


class LivePace(NamedTuple):
    """How often velocities are sent: without samples, and at most."""

    period_s: float
    gap_s: float


class LiveStream(VelocityStream):
    """The velocities of one live order, sent until it ends.

    Attributes:
        most_s: For how long it may be driven.
        end: Why its controls let it go on no further; None: something else has ended it.
    """

    def __init__(
        self,
        call: BindingCall,
        publisher: Publisher,
        controls: LiveControls,
        filled: Callable[[Mapping[str, Argument]], Values],
        pace: LivePace,
    ) -> None:
        """Make it; its controls have taken a sample.

        Args:
            call: The order.
            publisher: Of its topic.
            controls: What steers it.
            filled: Makes the fields of a message of values, SI.
            pace: How often they are sent.
        """
        gate = controls.gate
        fastest = {one.name: max(-one.low, one.high) for one in gate.ranges}
        bounded = StreamPace(pace.period_s, gate.most_s)
        super().__init__(call, publisher, filled({**gate.values, **fastest}), bounded)
        self.most_s = gate.most_s
        self.end: LiveEnd | None = None
        self._controls = controls
        self._filled = filled
        self._gap_s = pace.gap_s
        self._made: dict[str, Argument] = {}
        self._wish_ns: int | None = None
        self._followed = False

    def _over(self, past_s: float) -> bool:  # noqa: ARG002 - its controls know how long it lasts
        self.end = self._controls.look()
        return self.end is not None

    def _send(self) -> bool:
        values = self._controls.values
        if values != self._made:
            self._made = {**values}
            self._message = self._publisher.made(self._filled(values))
            self._wish(self._wants())
        # To make it took its time: what was young enough before may not be any more.
        return self._controls.look() is None and super()._send()

    async def _pause(self, past_s: float) -> None:  # noqa: ARG002
        """Wait for a sample, or the tick; not less than the gap."""
        clock = self._call.side.clock
        await self._controls.changed(min(self._pace.period_s, self._controls.left_s()))
        left_s = self._gap_s - (clock.monotonic_ns() - self._sent_ns) / SECOND_NS
        if left_s > 0:
            await clock.sleep(left_s)

    def _wants(self) -> bool:
        return any(
            abs(float(self._made[one.name])) > WISH * max(-one.low, one.high)
            for one in self._controls.gate.ranges
        )

    def _wish(self, wants: bool) -> None:
        """Note since when it is to move, if it is."""
        if not wants:
            self._wish_ns, self._followed = None, False
        elif self._wish_ns is None:
            self._wish_ns = self._call.side.clock.monotonic_ns()

    def _rests(self) -> bool:
        """Tell whether it has moved since it is to move, and rests."""
        if self._wish_ns is None:
            return False
        resting = self._call.side.measured.at_rest(self._wish_ns)
        self._followed = self._followed or resting is False
        return self._followed and resting is True

    def _tell(self, share: float) -> None:  # noqa: ARG002
        """Say that it moves; nobody knows how long it lasts."""
        self.way.look()
        call = self._call
        if not self.moved and call.side.measured.at_rest(self._begun_ns) is False:
            self.moved = True
            call.received()
            call.running(None)
