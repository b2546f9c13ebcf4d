"""The gateway's sign of life: a robot that wants to know whether anybody could stop it listens."""

from __future__ import annotations

import asyncio
import logging
from typing import TYPE_CHECKING

from rosic.errors import RosicError

if TYPE_CHECKING:
    from rosic.contracts.clock import Clock
    from rosic.robots.ros2.client.runtime import RosRuntime
    from rosic.robots.ros2.client.topics import Publisher

_log = logging.getLogger(__name__)

TOPIC = "link"
TYPE = "std_msgs/msg/Header"
EVERY_S = 0.25
_NS = 1_000_000_000


class Heartbeat:
    """Publishes the time on ``<namespace>/link``, four times a second while somebody listens.

    It is sent from the event loop that also gives orders and stops: when that hangs, so does this,
    and the robot comes to rest by itself.
    """

    def __init__(self, namespace: str, clock: Clock) -> None:
        self._namespace = namespace
        self._clock = clock
        self._publisher: Publisher | None = None
        self._task: asyncio.Task[None] | None = None

    def types(self) -> set[str]:
        """Return the type of the message."""
        return {TYPE} if self._namespace else set()

    async def open(self, runtime: RosRuntime) -> None:
        """Begin."""
        if self._namespace:
            self._publisher = await runtime.publisher(f"{self._namespace}/{TOPIC}", TYPE)
            self._task = asyncio.create_task(self._beat(self._publisher, runtime.node_name))

    async def close(self) -> None:
        """Cease."""
        task, self._task = self._task, None
        publisher, self._publisher = self._publisher, None
        if task is not None:
            task.cancel()
        if publisher is not None:
            await publisher.close()

    async def _beat(self, publisher: Publisher, sender: str) -> None:
        while True:
            if publisher.listeners:
                now_ns = self._clock.wall_ns()
                stamp = {"stamp.sec": now_ns // _NS, "stamp.nanosec": now_ns % _NS}
                try:
                    publisher.publish({**stamp, "frame_id": sender})
                except RosicError as fault:
                    _log.warning("no sign of life on %s: %s", publisher.topic, fault)
            await self._clock.sleep(EVERY_S)
