"""Skills that are topics: one message, or a bounded stream that ends in zeros."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosic.contracts.live_control import live_outcome, never_steered
from rosic.core.i18n import joined, said
from rosic.core.order import OrderEnding, Outcome
from rosic.core.sample_gate import LiveEnd
from rosic.core.units import measured
from rosic.robots.ros2.bindings.answers import check_fields
from rosic.robots.ros2.bindings.binding_call import filled, filled_with, over
from rosic.robots.ros2.errors import NotSent
from rosic.robots.ros2.live_stream import LivePace, LiveStream
from rosic.robots.ros2.motion_endings import in_doubt
from rosic.robots.ros2.velocity_stream import StreamPace, VelocityStream

if TYPE_CHECKING:
    from rosic.contracts.live_control import LiveControls
    from rosic.core.deadman import MotionBreak
    from rosic.robots.ros2.bindings.binding_call import BindingCall
    from rosic.robots.ros2.client.rclpy_import import RosObject
    from rosic.robots.ros2.client.runtime import RosRuntime
    from rosic.robots.ros2.client.topics import Publisher
    from rosic.robots.ros2.profile import TopicBinding
    from rosic.robots.ros2.stopping import RestResult

DURATION = "duration"
# A zero that is lost on the way is followed by others; the robot's watchdog is behind them.
ZEROS = 3


class TopicSkill:
    """Publishes to one topic. Nothing acknowledges: what is known of the end is measured."""

    def __init__(self, binding: TopicBinding) -> None:
        self._binding = binding
        self._publisher: Publisher | None = None
        self._cls: RosObject = None

    def types(self) -> set[str]:
        """Return the topic's type."""
        return {self._binding.type}

    async def open(self, runtime: RosRuntime) -> None:
        """Open the publisher and check the fields of the message."""
        self._cls = runtime.types.message(self._binding.type)
        check_fields(self._cls, self._binding.message)
        if self._binding.stream_hz == 0:
            self._publisher = await runtime.publisher(self._binding.name, self._binding.type)

    async def close(self) -> None:
        """Leave the topic."""
        publisher, self._publisher = self._publisher, None
        if publisher is not None:
            await publisher.close()

    async def carry(self, call: BindingCall) -> Outcome:
        """Publish once, or stream."""
        if call.controls is not None:
            return await self._steer(call, call.controls)
        if self._binding.stream_hz > 0:
            return await self._drive(call, await self._stream(call))
        publisher = await self._listened_to(call)
        message = publisher.made(filled(self._binding.message, call.order))
        call.leave()
        try:
            publisher.send(message)
        except NotSent as fault:
            raise call.offline() from fault
        return Outcome(OrderEnding.SENT)

    async def fall_silent(self, call: BindingCall) -> RestResult:
        """Stream, cease without a zero, and wait for measured rest; for measuring a watchdog."""
        stream = await self._stream(call)
        if await stream.run() is not None:
            return await call.side.stop_controller.apply()
        side = call.side
        begun_ns = side.clock.monotonic_ns()
        return await side.stop_controller.measure(begun_ns, side.rest_timeout_s, again=False)

    async def _listened_to(self, call: BindingCall) -> Publisher:
        # A stream shares its publisher with the zeros that end it: two publishers of one topic may
        # overtake each other, and a velocity that comes after the zero would count.
        publisher = self._publisher or call.side.stop_controller.zeros.get(self._binding.name)
        if publisher is None:
            raise call.offline()
        await call.there(lambda: publisher.listeners > 0, publisher.topic)
        return publisher

    async def _taken(self, call: BindingCall) -> Publisher:
        publisher = await self._listened_to(call)
        # Matched before it is on the graph: who it is has to be known before it is driven.
        await call.there(lambda: bool(publisher.takers()), publisher.topic)
        return publisher

    async def _stream(self, call: BindingCall) -> VelocityStream:
        publisher = await self._taken(call)
        values = filled(self._binding.message, call.order)
        pace = StreamPace(1.0 / self._binding.stream_hz, _duration_s(call))
        return VelocityStream(call, publisher, values, pace)

    async def _drive(self, call: BindingCall, stream: VelocityStream) -> Outcome:
        broken = await stream.run()
        if not call.allowed():
            return Outcome(OrderEnding.CANCELLED)
        if broken is not None:
            return await self._broken_off(call, stream, broken)
        resting = await self._zeroed(call)
        if not call.side.measured.measures_rest or (resting.confirmed and not stream.moved):
            return Outcome(OrderEnding.SENT)
        if resting.confirmed:
            return Outcome(
                OrderEnding.DONE, said("drove for {duration_s:g} s", duration_s=_duration_s(call))
            )
        return await self._does_not_obey(call)

    async def _zeroed(self, call: BindingCall) -> RestResult:
        """Send zero, and see whether it comes to rest."""
        side = call.side
        ended_ns = side.clock.monotonic_ns()
        period_s = 1.0 / self._binding.stream_hz
        for _ in range(ZEROS):
            side.stop_controller.zero()
            await side.clock.sleep(period_s)
        return await side.stop_controller.measure(ended_ns, side.rest_timeout_s, again=True)

    async def _steer(self, call: BindingCall, controls: LiveControls) -> Outcome:
        """Send what samples say, as long as they come."""
        publisher = await self._taken(call)
        end = await controls.begin(call.side.watchdog_s)
        if end is not None:
            return never_steered(end)
        message, order = self._binding.message, call.order
        pace = LivePace(1.0 / self._binding.stream_hz, 1.0 / self._binding.live_hz)
        stream = LiveStream(
            call, publisher, controls, lambda values: filled_with(message, order, values), pace
        )
        broken = await stream.run()
        if broken is None and call.allowed():
            resting = await self._zeroed(call)
            if not call.allowed():  # a stop came meanwhile, and says more about rest
                return Outcome(OrderEnding.CANCELLED, _driven(stream))
            return await self._let_go(call, stream, resting)
        if not call.allowed():
            return Outcome(OrderEnding.CANCELLED)
        assert broken is not None  # noqa: S101 - else it was let go
        return await self._broken_off(call, stream, broken)

    async def _let_go(self, call: BindingCall, stream: LiveStream, resting: RestResult) -> Outcome:
        """Say how a live order ended that nothing broke off."""
        end, measures = stream.end or LiveEnd.CLOSED, call.side.measured.measures_rest
        if measures and not resting.confirmed:
            return await self._does_not_obey(call)
        if end is LiveEnd.RELEASED and not (measures and stream.moved):
            return Outcome(OrderEnding.SENT)
        most_s = stream.most_s
        return live_outcome(end, stream.seconds, most_s, _driven(stream))

    async def _broken_off(
        self, call: BindingCall, stream: VelocityStream, broken: MotionBreak
    ) -> Outcome:
        """Bring it to rest, and say what was measured."""
        call.interrupted(broken)
        resting = await call.side.stop_controller.apply()
        stream.way.look()
        what = joined("; ", (_driven(stream), over(broken)))
        if not call.allowed():  # a stop came meanwhile, and says more about rest
            return Outcome(OrderEnding.CANCELLED, what)
        if not resting.confirmed:
            raise in_doubt(call.side.shown, what, resting)
        facts = {"driven_s": stream.seconds}
        if stream.way.metres is not None:
            facts["distance_m"] = stream.way.metres
        return Outcome(OrderEnding.FAILED, what, facts, code=broken.code)

    async def _does_not_obey(self, call: BindingCall) -> Outcome:
        """Zero did not bring it to rest, or that was not seen: apply everything else."""
        resting = await call.side.stop_controller.apply()
        if not resting.confirmed:
            call.in_doubt()
            raise in_doubt(call.side.shown, "", resting)
        if call.side.stop_controller.own is None or resting.declined or resting.unanswered:
            return Outcome(
                OrderEnding.FAILED, said("it came to rest late, and not by its own stop")
            )
        return Outcome(
            OrderEnding.FAILED, said("it came to rest only when its own stop was called")
        )


def _driven(stream: VelocityStream) -> str:
    """Return for how long, and how far, as far as anybody knows."""
    seconds, metres = stream.seconds, stream.way.metres
    if stream.moved and stream.way.jumped:
        return said(
            "drove for {seconds:.1f} s; its odometry jumped, so how far could not be measured",
            seconds=seconds,
        )
    if not stream.moved:
        return said("sent velocities for {seconds:.1f} s", seconds=stream.sent_s)
    if metres is None:
        return said("drove for {seconds:.1f} s; how far was not measured", seconds=seconds)
    return said(
        "drove for {seconds:.1f} s, {way} by its odometry",
        seconds=seconds,
        way=measured(f"{metres:.2f} m", metres, "m"),
    )


def _duration_s(call: BindingCall) -> float:
    given = call.order.arguments.get(DURATION, 0.0)
    return float(given) if isinstance(given, (int, float)) else 0.0
