"""Topics that are opened for programs: every message in, checked messages out."""

from __future__ import annotations

import asyncio
from collections import deque
from functools import cached_property
from typing import TYPE_CHECKING, Any, Final

from rosic.robots.ros2.client.topics import Subscription, TopicQos
from rosic.robots.ros2.messages.encode import to_message
from rosic.robots.ros2.messages.fields import fields_of, unpacked
from rosic.robots.ros2.messages.names import check_graph_name

if TYPE_CHECKING:
    from collections.abc import Callable

    from rosic.contracts.graph_topics import Fields, OnMessage
    from rosic.core.traffic import TrafficCounter
    from rosic.robots.ros2.client.connection import RosConnection
    from rosic.robots.ros2.client.node import ChatInterfaceNode
    from rosic.robots.ros2.client.rclpy_import import RosObject
    from rosic.robots.ros2.client.runtime import RosRuntime
    from rosic.robots.ros2.client.topics import Publisher
    from rosic.robots.ros2.profile import Ros2Profile

HEARD: Final = 256
"""Messages of one topic that may wait for the event loop, and in DDS for the ROS thread."""
SAID: Final = 4096
"""Messages that a publisher keeps until every subscriber has them: of a flood none is lost."""
MATCHED_LOOKS: Final = 50
MATCHED_EVERY_S: Final = 0.01
STEP_NS: Final = 4_000_000
"""So long the event loop looks at messages of one topic in one step."""


class RawTopicMessage:
    """A message as it came; looked at once, when first asked for."""

    def __init__(self, content: bytes, look: Callable[[bytes], Fields]) -> None:
        self._content, self._look = content, look

    @cached_property
    def fields(self) -> Fields:
        """Return its fields.

        Raises:
            BadValue: What came is of another type.
        """
        return self._look(self._content)


class HeardTopic(Subscription):
    """Every message of a topic, in order, as bytes until somebody looks.

    Attributes:
        lost: How many were dropped because the loop did not come to them.
    """

    def __init__(
        self, runtime: RosConnection, topic: str, cls: RosObject, on_message: OnMessage
    ) -> None:
        super().__init__(runtime, topic, cls)
        self.lost = 0
        self._on_message, self._read = on_message, fields_of(cls)
        self._waiting: deque[bytes] = deque(maxlen=HEARD)

    async def open(self, runtime: RosRuntime, quality: TopicQos) -> None:
        """Begin to listen."""
        self.handle = await runtime.hear(self, self.arrived, quality)

    def arrived(self, content: bytes) -> None:
        """Take a message; on the ROS thread."""
        if len(self._waiting) == HEARD:
            self.lost += 1
        self._runtime.traffic.came(len(content))
        self._waiting.append(content)
        self._knock()

    def _deliver(self) -> None:
        until_ns = self._runtime.now_ns() + STEP_NS
        for _ in range(len(self._waiting)):
            self._on_message(RawTopicMessage(self._waiting.popleft(), self._look))
            if self._runtime.now_ns() > until_ns:
                break
        if self._waiting:
            self._knock()

    def _look(self, content: bytes) -> Fields:
        found: dict[str, Any] = self._read(self._decode(content))
        return found


class CheckedPublisher:
    """Publishes what programs say, each field checked."""

    def __init__(self, publisher: Publisher, cls: RosObject, runtime: RosRuntime) -> None:
        self._publisher, self._cls, self._runtime = publisher, cls, runtime
        self._stamped = "header" in cls.get_fields_and_field_types()

    def publish(self, fields: Fields) -> None:
        """Check and send; see `contracts.graph_topics.OpenedPublisher`.

        Raises:
            BadValue: A field does not fit.
            NotSent: The link is closed, or ROS did not take it.
        """
        message = to_message(self._cls, unpacked(self._cls, fields))
        if self._stamped and (message.header.stamp.sec or message.header.stamp.nanosec):
            message = bytes(self._runtime.ros.serialization.serialize_message(message))
        self._publisher.send(message)

    async def close(self) -> None:
        """Leave the topic."""
        await self._publisher.close()


class OpenTopics:
    """The topics of the graph that a robot is on; see `contracts.graph_topics.GraphTopics`."""

    def __init__(
        self, told: Ros2Profile, station: ChatInterfaceNode, traffic: TrafficCounter
    ) -> None:
        self._told, self._station, self._traffic = told, station, traffic

    @property
    def reported(self) -> dict[str, str]:
        """Return the topics that the robot's profile binds."""
        told = self._told
        sources = (told.at_rest, told.camera, told.map, told.pose, told.path)
        found = [(each.topic, each.type) for each in sources if each is not None]
        found += [(each.topic, each.type) for each in told.telemetry.values() if each.topic]
        found += [(s.topic.name, s.topic.type) for s in told.skills.values() if s.topic is not None]
        if told.stop is not None and told.stop.zero:
            found.append((told.stop.zero, told.stop.zero_type))
        return {check_graph_name(topic): kind for topic, kind in found}

    @property
    def stop_service(self) -> str:
        """Return the absolute name of the service that stops the robot."""
        stop = self._told.stop
        return check_graph_name(stop.service) if stop is not None and stop.service else ""

    async def listen(self, topic: str, type_name: str, on_message: OnMessage) -> HeardTopic:
        """Listen to a topic, as its publishers offer it.

        Raises:
            ConfigurationError: There is no such type, or that is no name.
            NotSent: The link is closed, or too much is open.
        """
        runtime = await self._runtime(type_name)
        name = check_graph_name(topic)
        heard = HeardTopic(runtime, name, runtime.types.message(type_name), on_message)
        quality = await runtime.thread.run(lambda: _offered(runtime, name))
        await heard.open(runtime, quality)
        return heard

    async def publisher(self, topic: str, type_name: str) -> CheckedPublisher:
        """Open a publisher. Raises as `listen` does."""
        runtime = await self._runtime(type_name)
        opened = await runtime.publisher(topic, type_name, TopicQos(depth=SAID))
        await _matched(runtime, opened)
        return CheckedPublisher(opened, runtime.types.message(type_name), runtime)

    async def _runtime(self, type_name: str) -> RosRuntime:
        return (await self._station.learn({type_name})).counting(self._traffic)


async def _matched(runtime: RosRuntime, publisher: Publisher) -> None:
    """Wait until those who listen already are matched: what is said before that they do not hear.

    Whoever is on the graph and cannot be matched is not waited for for long.
    """
    there = await runtime.thread.run(lambda: runtime.thread.node.count_subscribers(publisher.topic))
    for _ in range(MATCHED_LOOKS):
        if publisher.listeners >= there:
            return
        await asyncio.sleep(MATCHED_EVERY_S)


def _offered(runtime: RosRuntime, topic: str) -> TopicQos:
    """Return the best that all publishers of a topic offer; on the ROS thread."""
    qos = runtime.ros.qos
    ends = runtime.thread.node.get_publishers_info_by_topic(topic)
    profiles = [end.qos_profile for end in ends]
    reliable = all(one.reliability == qos.ReliabilityPolicy.RELIABLE for one in profiles)
    latched = all(one.durability == qos.DurabilityPolicy.TRANSIENT_LOCAL for one in profiles)
    return TopicQos(bool(profiles) and reliable, bool(profiles) and latched, depth=HEARD)
