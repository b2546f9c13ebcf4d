"""The link to a graph as every endpoint holds it: whether it is alive, its thread, its count."""

from __future__ import annotations

from typing import TYPE_CHECKING, TypeVar

from rosic.robots.ros2.errors import NotSent

if TYPE_CHECKING:
    from collections.abc import Callable

    from rosic.robots.ros2.client.executor_thread import RosThread
    from rosic.robots.ros2.client.rclpy_import import RclpyModules, RosObject

T = TypeVar("T")

MAX_ENDPOINTS = 1024


class RosConnection:
    """What publishers, subscriptions and clients of services and actions need of the link.

    Attributes:
        now_ns: The monotonic clock on which telemetry is dated.
        wall_ns: The wall clock, to which senders' stamps are compared.
        thread: The ROS thread, for the modules beside this one.
    """

    def __init__(
        self, thread: RosThread, now_ns: Callable[[], int], wall_ns: Callable[[], int]
    ) -> None:
        self.thread = thread
        self.now_ns = now_ns
        self.wall_ns = wall_ns
        self._endpoints = 0

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
        if self._endpoints >= MAX_ENDPOINTS:
            raise NotSent(f"More than {MAX_ENDPOINTS} ROS topics, services and actions are in use.")
        self._endpoints += 1
        try:
            return await self.thread.run(make)
        except BaseException:
            self._endpoints -= 1
            raise

    async def discard(self, destroy: Callable[[RosObject], object]) -> None:
        """Close one endpoint; for the endpoints themselves."""
        if self.alive:
            await self.thread.run(lambda: destroy(self.thread.node))
            self._endpoints -= 1
