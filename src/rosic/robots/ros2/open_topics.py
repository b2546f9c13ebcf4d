"""Topics that are opened for programs: every message in, checked messages out."""

from __future__ import annotations

import asyncio
from collections import deque
from contextlib import suppress
from functools import cached_property
from typing import TYPE_CHECKING, Any, Final

from rosic.robots.ros2.bindings.answers import OrderAnswers
from rosic.robots.ros2.client.topics import Subscription, TopicQos
from rosic.robots.ros2.messages.encode import to_message
from rosic.robots.ros2.messages.fields import fields_of, unpacked
from rosic.robots.ros2.messages.names import check_graph_name

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

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
HEARD_BYTES: Final = 8 << 20
"""Of those that wait for the event loop; one that is larger waits alone."""
FRESH_NS: Final = 250_000_000
"""Once a message has waited so long for the event loop, the newest alone is told."""
SAID: Final = (4_096, 480, 60, 7)
"""Messages that a publisher keeps until every subscriber has them: of a flood of small ones none
is lost. The larger they are the fewer."""
SAID_BYTES: Final = 32 << 20
"""Of all that one publisher keeps; more only where seven messages are larger."""
MATCHED_LOOKS: Final = 50
MATCHED_EVERY_S: Final = 0.01
STEP_NS: Final = 4_000_000
"""So long the event loop looks at messages of one topic in one step."""


class RawTopicMessage:
    """A message as it came; looked at once, when first asked for."""

    def __init__(self, content: bytes, look: Callable[[bytes], Fields]) -> None:
        self._content, self._look = content, look

    @property
    def size(self) -> int:
        """Return how many bytes came."""
        return len(self._content)

    @cached_property
    def fields(self) -> Fields:
        """Return its fields.

        Raises:
            BadValue: What came is of another type.
        """
        return self._look(self._content)


class HeardMessages:
    """What came of a topic and waits for the event loop: all of it, as long as the loop keeps up.

    Put in on the ROS thread, taken on the loop.

    Attributes:
        lost: How many were dropped because the loop did not come to them.
    """

    def __init__(self, now_ns: Callable[[], int]) -> None:
        self.lost = 0
        self._now_ns = now_ns
        self._waiting: deque[tuple[int, bytes]] = deque()

    def __len__(self) -> int:
        return len(self._waiting)

    def put(self, content: bytes) -> None:
        """Take a message in; the oldest give way where there is no room."""
        room = max(1, min(HEARD, HEARD_BYTES // max(1, len(content))))
        while len(self._waiting) >= room:
            self._drop_oldest()
        self._waiting.append((self._now_ns(), content))

    def take(self) -> bytes | None:
        """Return the oldest; the newest, where that has waited too long; None: nothing waits."""
        try:
            came_ns, content = self._waiting.popleft()
            if self._now_ns() - came_ns > FRESH_NS:
                while self._waiting:
                    _, content = self._waiting.popleft()
                    self.lost += 1
        except IndexError:  # the other thread was quicker
            return None
        return content

    def _drop_oldest(self) -> None:
        with suppress(IndexError):  # likewise
            self._waiting.popleft()
            self.lost += 1


class HeardTopic(Subscription):
    """Every message of a topic, in order, as bytes until somebody looks."""

    def __init__(
        self, runtime: RosConnection, topic: str, cls: RosObject, on_message: OnMessage
    ) -> None:
        super().__init__(runtime, topic, cls)
        self._on_message, self._read = on_message, fields_of(cls)
        self._waiting = HeardMessages(runtime.now_ns)

    @property
    def lost(self) -> int:
        """How many messages were dropped because the loop did not come to them."""
        return self._waiting.lost

    async def open(self, runtime: RosRuntime, quality: TopicQos) -> None:
        """Begin to listen."""
        self.handle = await runtime.hear(self, self.arrived, quality)

    def arrived(self, content: bytes) -> None:
        """Take a message; on the ROS thread."""
        self._runtime.traffic.came(len(content))
        self._waiting.put(content)
        self._knock()

    def _deliver(self) -> None:
        until_ns = self._runtime.now_ns() + STEP_NS
        for _ in range(len(self._waiting)):
            content = self._waiting.take()
            if content is None:
                break
            self._on_message(RawTopicMessage(content, self._look))
            if self._runtime.now_ns() > until_ns:
                break
        if self._waiting:
            self._knock()

    def _look(self, content: bytes) -> Fields:
        found: dict[str, Any] = self._read(self._decode(content))
        return found


class CheckedPublisher:
    """Publishes what programs say, each field checked.

    DDS counts what it keeps in messages. So when larger ones come, another publisher takes over,
    which keeps fewer; the one before keeps what it has until all is over.
    """

    def __init__(self, runtime: RosRuntime, topic: str, type_name: str) -> None:
        self._runtime, self._topic, self._type_name = runtime, topic, type_name
        self._cls = runtime.types.message(type_name)
        self._publishers: list[Publisher] = []
        self._depth = SAID[0]
        self._turn = asyncio.Lock()

    async def open(self) -> None:
        """Be on the topic. Raises as `OpenTopics.listen` does."""
        quality = TopicQos(depth=self._depth)
        opened = await self._runtime.publisher(self._topic, self._type_name, quality)
        self._publishers.append(opened)
        await _matched(self._runtime, opened)

    async def packed(self, fields: Fields) -> bytes:
        """Check and serialise; see `contracts.graph_topics.OpenedPublisher`.

        Raises:
            BadValue: A field does not fit.
            NotSent: The link is closed, or too much is open.
        """
        content = self._publishers[-1].packed(to_message(self._cls, unpacked(self._cls, fields)))
        if len(content) * self._depth > SAID_BYTES:
            depth = next((each for each in SAID if len(content) * each <= SAID_BYTES), SAID[-1])
            if depth < self._depth:
                await self._keep_fewer(depth)
        return content

    def send(self, content: bytes) -> None:
        """Send it.

        Raises:
            NotSent: The link is closed, or ROS did not take it.
        """
        self._publishers[-1].send(content)

    async def _keep_fewer(self, depth: int) -> None:
        async with self._turn:
            if depth < self._depth:
                self._depth = depth
                await self.open()

    async def close(self) -> None:
        """Leave the topic."""
        for publisher in self._publishers:
            await publisher.close()


class OpenTopics:
    """The topics of the graph that a robot is on; see `contracts.graph_topics.GraphTopics`.

    Attributes:
        answers: What the robot's side says of orders; its link puts that in.
    """

    def __init__(
        self, told: Ros2Profile, station: ChatInterfaceNode, traffic: TrafficCounter
    ) -> None:
        self.answers = OrderAnswers()
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

    @property
    def stop_service_type(self) -> str:
        """Return the type of that service."""
        return self._told.stop.type if self._told.stop is not None else ""

    @property
    def releases_by(self) -> Mapping[str, object]:
        """Return the fields by which that service lets the robot go on; empty: it never does."""
        stop = self._told.stop
        return {} if stop is None else stop.release

    def feedback(self, n: int) -> Fields | None:
        """Return the newest feedback about one of the newest orders, by its number."""
        return self.answers.feedback(n)

    def end(self, n: int) -> Fields | None:
        """Return the result or the response that ended one of the newest orders."""
        return self.answers.end(n)

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
        opened = CheckedPublisher(runtime, topic, type_name)
        await opened.open()
        return opened

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
