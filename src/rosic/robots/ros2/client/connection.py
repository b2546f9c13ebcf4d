"""The link to a graph as every endpoint holds it: whether it is alive, its thread, its counts."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple, TypeVar

from rosic.core.traffic import TrafficCounter
from rosic.robots.ros2.errors import NotSent

if TYPE_CHECKING:
    from collections.abc import Callable

    from rosic.robots.ros2.client.executor_thread import RosThread
    from rosic.robots.ros2.client.rclpy_import import RclpyModules, RosObject

T = TypeVar("T")

MAX_ENDPOINTS = 1024


class EndpointQuota:
    """How many topics, services and actions one node may still open."""

    def __init__(self) -> None:
        self._left = MAX_ENDPOINTS

    def take(self) -> None:
        """Take one.

        Raises:
            NotSent: There is none left.
        """
        if not self._left:
            raise NotSent(f"More than {MAX_ENDPOINTS} ROS topics, services and actions are in use.")
        self._left -= 1

    def give_back(self) -> None:
        """Let another have it."""
        self._left += 1


class EndpointCounts(NamedTuple):
    """What is counted of endpoints.

    Attributes:
        traffic: What passes those that are opened by one connection. What comes is counted on the
            ROS thread, what answers on the event loop: a race may lose one.
        quota: Of the node, whoever opens by it.
    """

    traffic: TrafficCounter
    quota: EndpointQuota


class RosConnection:
    """What publishers, subscriptions and clients of services and actions need of the link.

    Attributes:
        now_ns: The monotonic clock on which telemetry is dated.
        wall_ns: The wall clock, to which senders' stamps are compared.
        thread: The ROS thread, for the modules beside this one.
        traffic, quota: See `EndpointCounts`.
    """

    def __init__(
        self,
        thread: RosThread,
        now_ns: Callable[[], int],
        wall_ns: Callable[[], int],
        counts: EndpointCounts | None = None,
    ) -> None:
        self.thread = thread
        self.now_ns = now_ns
        self.wall_ns = wall_ns
        self.traffic, self.quota = counts or (TrafficCounter(), EndpointQuota())

    @property
    def alive(self) -> bool:
        """Whether anything can be sent. It ends with `close`, or when ROS shuts itself down."""
        return self.thread.alive

    @property
    def ros(self) -> RclpyModules:
        """ROS 2 itself, for the modules beside this one."""
        return self.thread.ros

    async def opened(self, make: Callable[[], T]) -> T:
        """Open one endpoint on the ROS thread.

        Raises:
            NotSent: The link is closed, or there are too many endpoints.
        """
        self.quota.take()
        try:
            return await self.thread.run(make)
        except BaseException:
            self.quota.give_back()
            raise

    async def discard(self, destroy: Callable[[RosObject], object]) -> None:
        """Close one endpoint; for the endpoints themselves."""
        if self.alive:
            await self.thread.run(lambda: destroy(self.thread.node))
            self.quota.give_back()
