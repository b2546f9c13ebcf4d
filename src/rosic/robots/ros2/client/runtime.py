"""The gateway's one place on a ROS 2 graph, and everything it opens there."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Self

from rosic.robots.ros2.client.actions import ActionLink
from rosic.robots.ros2.client.connection import EndpointCounts, RosConnection
from rosic.robots.ros2.client.executor_thread import RosThread
from rosic.robots.ros2.client.qos import publisher_events, subscription_events
from rosic.robots.ros2.client.services import ServiceLink
from rosic.robots.ros2.client.topics import (
    LatestMessage,
    MessageStream,
    Publisher,
    RateLimitedTopic,
    TopicQos,
)
from rosic.robots.ros2.errors import BadName
from rosic.robots.ros2.messages.names import check_graph_name, check_node_name
from rosic.robots.ros2.publishers import MessageInfoCallback

if TYPE_CHECKING:
    from collections.abc import Callable
    from types import TracebackType

    from rosic.core.traffic import TrafficCounter
    from rosic.robots.ros2.client.rclpy_import import RosObject
    from rosic.robots.ros2.client.topics import Subscription
    from rosic.robots.ros2.messages.types import TypeRegistry

NODE_NAME = "chat_interface"
TEXT = "std_msgs/msg/String"
MAX_DOMAIN_ID = 232

_RELIABLE = TopicQos()
_NEWEST = TopicQos(reliable=False, depth=1)
_KEPT = TopicQos(latched=True, depth=1)


class RosRuntime(RosConnection):
    """One node for one process. Made by `RosRuntime.open`, used on the event loop that opened it.

    Attributes:
        types: The types that may be used.
        node_name: As seen on the graph.
    """

    def __init__(
        self,
        types: TypeRegistry,
        thread: RosThread,
        *,
        node_name: str,
        now_ns: Callable[[], int],
        wall_ns: Callable[[], int],
        counts: EndpointCounts | None = None,
    ) -> None:
        super().__init__(thread, now_ns, wall_ns, counts)
        self.types = types
        self.node_name = node_name

    @classmethod
    async def open(
        cls,
        types: TypeRegistry,
        *,
        node_name: str = NODE_NAME,
        domain_id: int | None = None,
        now_ns: Callable[[], int] = time.monotonic_ns,
        wall_ns: Callable[[], int] = time.time_ns,
    ) -> RosRuntime:
        """Join the graph.

        Args:
            types: The types that profiles name.
            node_name: How others see this process.
            domain_id: The ROS domain; None for the one the environment names.
            now_ns: The monotonic clock on which telemetry is dated.
            wall_ns: The wall clock, by which is dated what was kept.

        Raises:
            RosMissing: There is no ROS 2 here.
            BadName: The node or the domain cannot be called that.
            NotSent: ROS 2 is here and would not start.
        """
        if domain_id is not None and not 0 <= domain_id <= MAX_DOMAIN_ID:
            raise BadName(f"A ROS domain is a number from 0 to {MAX_DOMAIN_ID}, not {domain_id}.")
        thread = RosThread(check_node_name(node_name), domain_id)
        await thread.start()
        return cls(types, thread, node_name=node_name, now_ns=now_ns, wall_ns=wall_ns)

    def counting(self, traffic: TrafficCounter) -> RosRuntime:
        """Return the same node, with what passes the endpoints opened by it counted apart."""
        return RosRuntime(
            self.types,
            self.thread,
            node_name=self.node_name,
            now_ns=self.now_ns,
            wall_ns=self.wall_ns,
            counts=EndpointCounts(traffic, self.quota),
        )

    def know(self, types: TypeRegistry) -> None:
        """Use these types from now on; what is open stays open."""
        self.types = types

    async def close(self) -> None:
        """Leave the graph. Whoever still waits for an answer gets `NoAnswer`. May be repeated."""
        await self.thread.close()

    async def __aenter__(self) -> Self:
        return self

    async def __aexit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        await self.close()

    async def publisher(
        self, topic: str, type_name: str, quality: TopicQos = _RELIABLE
    ) -> Publisher:
        """Open a publisher.

        Raises:
            BadName: The topic or the type is not known.
            NotSent: The link is closed, or there are too many endpoints.
        """
        cls, name = self.types.message(type_name), check_graph_name(topic)
        profile, node = quality.profile(self.ros), self.thread.node
        events = publisher_events()
        handle = await self.opened(
            lambda: node.create_publisher(cls, name, profile, event_callbacks=events)
        )
        return Publisher(self, name, cls, handle)

    async def latest(
        self,
        topic: str,
        type_name: str,
        quality: TopicQos = _NEWEST,
        on_new: Callable[[LatestMessage], None] | None = None,
    ) -> LatestMessage:
        """Subscribe to a topic of which only the newest message matters.

        Args:
            topic: Where.
            type_name: What.
            quality: By default best effort, which meets every publisher.
            on_new: Called on the event loop when something new is there; not for every message.

        Raises as `publisher` does.
        """
        cls, name = self.types.message(type_name), check_graph_name(topic)
        latest = LatestMessage(self, name, cls, on_new)
        latest.handle = await self._subscribe(
            cls, name, MessageInfoCallback(latest.arrived), quality
        )
        return latest

    async def hear_kept(self, latest: LatestMessage) -> None:
        """Take what a publisher of this topic keeps for whoever comes later, too.

        DDS sends that to none who did not ask for it when subscribing, and who asks for it hears
        nobody who does not keep: so it takes a second subscription. Raises as `publisher` does.
        """
        callback = MessageInfoCallback(latest.arrived_kept)
        await latest.hear_kept(lambda: self._subscribe(latest.cls, latest.topic, callback, _KEPT))

    async def stream(
        self,
        topic: str,
        type_name: str,
        on_message: Callable[[RosObject], None],
        quality: TopicQos = _RELIABLE,
    ) -> MessageStream:
        """Subscribe to a topic of which every message matters, such as what a robot says.

        The oldest are dropped and counted when more than the quality's depth wait for the loop.
        Raises as `publisher` does.
        """
        cls, name = self.types.message(type_name), check_graph_name(topic)
        stream = MessageStream(self, name, cls, on_message, quality.depth)
        stream.handle = await self._subscribe(cls, name, stream.arrived, quality)
        return stream

    async def paced_words(
        self,
        topic: str,
        on_words: Callable[[bytes, int], None],
        at_most: int,
        quality: TopicQos = _RELIABLE,
    ) -> RateLimitedTopic:
        """Subscribe to texts that may come at any rate and length; see `RateLimitedTopic`.

        Raises as `publisher` does.
        """
        cls, name = self.types.message(TEXT), check_graph_name(topic)
        words = RateLimitedTopic(self, name, cls, on_words, at_most)
        words.handle = await self._subscribe(cls, name, words.arrived, quality)
        return words

    async def hear(
        self, topic: Subscription, arrived: Callable[[bytes], None], quality: TopicQos
    ) -> RosObject:
        """Have a subscription told what comes, on the ROS thread; return rclpy's own.

        Raises as `publisher` does.
        """
        return await self._subscribe(topic.cls, topic.topic, arrived, quality)

    async def service(self, name: str, type_name: str) -> ServiceLink:
        """Open a client of a service. Raises as `publisher` does."""
        cls, name = self.types.service(type_name), check_graph_name(name)

        def make() -> RosObject:
            return self.thread.node.create_client(cls, name)

        return ServiceLink(self, name, cls, await self.opened(make), make)

    async def action(self, name: str, type_name: str) -> ActionLink:
        """Open a client of an action. Raises as `publisher` does."""
        cls, name = self.types.action(type_name), check_graph_name(name)

        def make() -> RosObject:
            return self.ros.action.ActionClient(self.thread.node, cls, name)

        return ActionLink(self, name, cls, await self.opened(make), make)

    async def _subscribe(
        self,
        cls: RosObject,
        topic: str,
        arrived: Callable[[bytes], None] | MessageInfoCallback,
        quality: TopicQos,
    ) -> RosObject:
        profile, node, events = quality.profile(self.ros), self.thread.node, subscription_events()
        return await self.opened(
            lambda: node.create_subscription(
                cls, topic, arrived, profile, event_callbacks=events, raw=True
            )
        )
