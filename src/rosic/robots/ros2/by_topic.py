"""Skills that are topics: one message, or a bounded stream that ends in zeros."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosic.core.order import Ending, Outcome
from rosic.core.saying import said
from rosic.errors import RobotUnreachable
from rosic.robots.ros2.errand import check_fields, filled
from rosic.robots.ros2.faults import NotSent
from rosic.robots.ros2.messages import to_message

if TYPE_CHECKING:
    from rosic.core.skill import TopicBinding
    from rosic.robots.ros2.errand import Errand
    from rosic.robots.ros2.rest import Resting
    from rosic.robots.ros2.ros import RosObject
    from rosic.robots.ros2.runtime import RosRuntime
    from rosic.robots.ros2.topics import Publisher

DURATION = "duration"
# A zero that is lost on the way is followed by others; the robot's watchdog is behind them.
ZEROS = 3
_NS = 1_000_000_000


class ByTopic:
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

    async def carry(self, errand: Errand) -> Outcome:
        """Publish once, or stream."""
        publisher = await self._listened_to(errand)
        values = filled(self._binding.message, errand.order)
        to_message(self._cls, values)
        if self._binding.stream_hz > 0:
            return await self._drive(errand, publisher, values)
        errand.leave()
        try:
            publisher.publish(values)
        except NotSent as fault:
            raise errand.offline() from fault
        return Outcome(Ending.SENT)

    async def fall_silent(self, errand: Errand) -> Resting:
        """Stream, cease without a zero, and wait for measured rest; for measuring a watchdog."""
        publisher = await self._listened_to(errand)
        values = filled(self._binding.message, errand.order)
        to_message(self._cls, values)
        await self._stream(errand, publisher, values)
        side = errand.side
        return await side.brakes.measure(side.clock.monotonic_ns(), errand.side.rest_timeout_s)

    async def _listened_to(self, errand: Errand) -> Publisher:
        # A stream shares its publisher with the zeros that end it: two publishers of one topic may
        # overtake each other, and a velocity that comes after the zero would count.
        publisher = self._publisher or errand.side.brakes.zeros.get(self._binding.name)
        if publisher is None:
            raise errand.offline()
        await errand.there(lambda: publisher.listeners > 0, publisher.topic)
        return publisher

    async def _drive(
        self, errand: Errand, publisher: Publisher, values: dict[str, object]
    ) -> Outcome:
        moved = await self._stream(errand, publisher, values)
        if not errand.allowed():
            return Outcome(Ending.CANCELLED)
        side = errand.side
        ended_ns = side.clock.monotonic_ns()
        period_s = 1.0 / self._binding.stream_hz
        for _ in range(ZEROS):
            side.brakes.zero()
            await side.clock.sleep(period_s)
        resting = await side.brakes.measure(ended_ns, errand.side.rest_timeout_s)
        if not side.measured.measures_rest or (resting.confirmed and not moved):
            return Outcome(Ending.SENT)
        if resting.confirmed:
            return Outcome(
                Ending.DONE, said("drove for {duration_s:g} s", duration_s=_duration_s(errand))
            )
        return await self._does_not_obey(errand)

    async def _does_not_obey(self, errand: Errand) -> Outcome:
        """Zero did not bring it to rest: apply everything else."""
        shown = errand.side.shown
        if not (await errand.side.brakes.apply()).confirmed:
            raise RobotUnreachable(
                said("{shown} was sent zero and told to stop, and still moves.", shown=shown)
            )
        return Outcome(Ending.FAILED, said("it came to rest only when its own stop was called"))

    async def _stream(
        self, errand: Errand, publisher: Publisher, values: dict[str, object]
    ) -> bool:
        """Publish for the order's duration; return whether the robot was measured to move.

        Returns early, and publishes nothing more, when a stop comes.
        """
        side, period_s = errand.side, 1.0 / self._binding.stream_hz
        duration_s, moved = _duration_s(errand), False
        errand.leave()
        begun_ns = side.clock.monotonic_ns()
        while (past_s := (side.clock.monotonic_ns() - begun_ns) / _NS) < duration_s:
            if not errand.allowed():
                return moved
            try:
                publisher.publish(values)
            except NotSent as fault:
                if past_s == 0.0:
                    raise errand.offline() from fault
                raise RobotUnreachable(
                    said("{shown} cannot be reached any more.", shown=side.shown)
                ) from fault
            await side.clock.sleep(min(period_s, duration_s - past_s))
            if not moved and side.measured.at_rest(begun_ns) is False:
                moved = True
                errand.received()
            errand.running(min(1.0, past_s / duration_s))
        return moved


def _duration_s(errand: Errand) -> float:
    given = errand.order.arguments.get(DURATION, 0.0)
    return float(given) if isinstance(given, (int, float)) else 0.0
