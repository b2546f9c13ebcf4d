"""Why a robot declined: ROS has no field for it, but nodes write it to the log everybody can read.

``/rosout`` is kept for those who come later, so it is opened only when there is something to ask.
"""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

from rosic.core.time_units import SECOND_NS
from rosic.errors import RosicError
from rosic.robots.ros2.bindings.answers import note
from rosic.robots.ros2.client.topics import TopicQos
from rosic.robots.ros2.messages.names import is_under

if TYPE_CHECKING:
    from rosic.robots.ros2.client.rclpy_import import RosObject
    from rosic.robots.ros2.client.runtime import RosRuntime

LOG = "/rosout"
LOG_TYPE = "rcl_interfaces/msg/Log"
WARNING = 30
WITHIN_S = 0.5
# Clocks of two computers that share a graph agree about this well.
CLOCKS_AGREE_S = 0.5


class RosoutReasons:
    """Looks up in the log why a robot declined."""

    def __init__(self) -> None:
        self._runtime: RosRuntime | None = None

    def types(self) -> set[str]:
        """Return the type of a line of the log."""
        return {LOG_TYPE}

    def open(self, runtime: RosRuntime) -> None:
        """Remember where to ask."""
        self._runtime = runtime

    async def why(self, namespace: str, sent_ns: int) -> str:
        """Return the last warning that a node of the robot wrote since then; empty if none.

        Args:
            namespace: Below which the robot's nodes are.
            sent_ns: Wall clock.
        """
        if self._runtime is None or not namespace:
            return ""
        found: asyncio.Future[str] = asyncio.get_running_loop().create_future()

        def look(line: RosObject) -> None:
            at_ns = line.stamp.sec * SECOND_NS + line.stamp.nanosec
            if (
                line.level >= WARNING
                and is_under("/" + line.name.replace(".", "/"), namespace)
                and at_ns >= sent_ns - CLOCKS_AGREE_S * SECOND_NS
                and not found.done()
            ):
                found.set_result(note(line.msg).rstrip("."))

        try:
            log = await self._runtime.stream(LOG, LOG_TYPE, look, TopicQos(latched=True, depth=100))
        except RosicError:
            return ""
        try:
            async with asyncio.timeout(WITHIN_S):
                return await found
        except TimeoutError:
            return ""
        finally:
            await log.close()
