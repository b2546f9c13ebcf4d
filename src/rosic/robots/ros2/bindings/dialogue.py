"""The paper's Algorithm 8: words to a robot, and words from it, over a pair of topics."""

from __future__ import annotations

import asyncio
import logging
from typing import TYPE_CHECKING

from rosic.core.i18n import said
from rosic.core.order import OrderEnding, Outcome
from rosic.core.time_units import SECOND_NS
from rosic.errors import RosicError
from rosic.robots.ros2.bindings.binding_call import DECLINED
from rosic.robots.ros2.client.topics import TopicQos
from rosic.robots.ros2.errors import NotSent
from rosic.robots.ros2.messages.coerce import clean_text

if TYPE_CHECKING:
    from rosic.contracts.clock import Clock
    from rosic.contracts.robot import Say
    from rosic.robots.ros2.bindings.binding_call import BindingCall
    from rosic.robots.ros2.client.rclpy_import import RosObject
    from rosic.robots.ros2.client.runtime import RosRuntime
    from rosic.robots.ros2.client.topics import MessageStream, Publisher

_log = logging.getLogger(__name__)

TO, FROM = "to_robot_topic", "from_robot_topic"
TYPE = "std_msgs/msg/String"
GREETING = "Hello from ROSIC."
STOP = "stop"
NOT_REACHABLE = said("robot not reachable")
ANSWER_WITHIN_S = 5.0
LOOK_EVERY_S = 0.1
DEPTH = 50


class DialogueBinding:
    """The text link of one robot.

    The greeting verifies it, at the start and whenever the robot comes back: that it was answered
    is what is known of the robot. A topic does not acknowledge, and words that come back may be
    about anything, so no order ends better than ``SENT``. The log says how much was said, and not
    what.

    Attributes:
        answered: None while the greeting's answer may still come, then whether anything came.
        heard_ns: When it last said anything, on the monotonic clock; None if it never did.
    """

    def __init__(self, shown: str, namespace: str, clock: Clock) -> None:
        self.answered: bool | None = None
        self.heard_ns: int | None = None
        self._shown = shown
        self._namespace = namespace
        self._clock = clock
        self._say: Say | None = None
        self._publisher: Publisher | None = None
        self._stream: MessageStream | None = None
        self._greeting: asyncio.Task[None] | None = None
        self._was_there = False

    def types(self) -> set[str]:
        """Return the type of both topics."""
        return {TYPE}

    async def open(self, runtime: RosRuntime) -> None:
        """Subscribe first, so that no answer is missed."""
        quality = TopicQos(depth=DEPTH)
        self._stream = await runtime.stream(
            f"{self._namespace}/{FROM}", TYPE, self._received, quality
        )
        self._publisher = await runtime.publisher(f"{self._namespace}/{TO}", TYPE, quality)

    def begin(self, say: Say) -> None:
        """Verify the link by a greeting; what the robot says goes to ``say`` from now on."""
        self._say = say
        self._greeting = asyncio.create_task(self._greet())

    async def close(self) -> None:
        """Leave both topics."""
        if self._greeting is not None:
            self._greeting.cancel()
            self._greeting = None
        publisher, self._publisher = self._publisher, None
        stream, self._stream = self._stream, None
        if publisher is not None:
            await publisher.close()
        if stream is not None:
            await stream.close()

    def look(self) -> None:
        """Notice that the robot has gone, or has come back and is to be greeted; once a second."""
        there = self._there()
        if not there and self._was_there:
            self.answered = False
        elif there and not self._was_there and self.answered is False:
            self._greeting = asyncio.create_task(self._greet())
        self._was_there = there

    def age_s(self) -> float | None:
        """Return seconds since the robot last said something; None if it never did."""
        heard_ns = self.heard_ns
        return None if heard_ns is None else (self._clock.monotonic_ns() - heard_ns) / SECOND_NS

    async def carry(self, call: BindingCall) -> Outcome:
        """Say a person's words to the robot."""
        words = [v for v in call.order.arguments.values() if isinstance(v, str)]
        text = clean_text(" ".join(words)).strip()
        if not text:
            return Outcome(OrderEnding.REFUSED, said("There is nothing to say."), code=DECLINED)
        await call.there(self._there, self._namespace)
        call.leave()
        try:
            self.send_to_robot(text)
        except NotSent as fault:
            raise call.offline() from fault
        return Outcome(OrderEnding.SENT)

    def send_to_robot(self, message: str) -> None:
        """Publish to ``to_robot_topic``.

        Raises:
            NotSent: The link is closed, or ROS did not take it.
        """
        if self._publisher is None:
            raise NotSent("The link to ROS 2 is closed; nothing was sent.")
        _log.info("Sending to robot: %d characters, to %s", len(message), self._shown)
        self._publisher.publish({"data": message})

    def tell_stop(self) -> None:
        """Say stop: all that can be done to a robot that is only spoken to. Never raises."""
        try:
            self.send_to_robot(STOP)
        except RosicError as fault:
            _log.warning("%s was not told to stop: %s", self._shown, fault)

    def _received(self, message: RosObject) -> None:
        """Algorithm 8's ROBOT_CALLBACK: display, and bring it to the chat."""
        text = clean_text(message.data)
        self.answered = True
        self.heard_ns = self._clock.monotonic_ns()
        _log.info("Received from robot: %d characters, from %s", len(text), self._shown)
        if self._say is not None and text.strip():
            self._say(text)

    def _there(self) -> bool:
        publisher, stream = self._publisher, self._stream
        if publisher is None or stream is None:
            return False
        return publisher.listeners > 0 and stream.publishers > 0

    def _unanswered(self) -> bool:
        return self.answered is None

    async def _greet(self) -> None:
        """Send the greeting as soon as somebody is there, and wait for any answer, for a while."""
        self.answered = None
        deadline_ns = self._clock.monotonic_ns() + int(ANSWER_WITHIN_S * SECOND_NS)
        greeted = False
        while self._unanswered() and self._clock.monotonic_ns() < deadline_ns:
            if not greeted and self._there():
                greeted = self._was_there = True
                try:
                    self.send_to_robot(GREETING)
                except NotSent as fault:
                    _log.warning("%s was not greeted: %s", self._shown, fault)
            await self._clock.sleep(LOOK_EVERY_S)
        if self._unanswered():
            self.answered = False
            _log.warning("%s: %s", self._shown, NOT_REACHABLE)
            if self._say is not None:
                self._say(NOT_REACHABLE)
