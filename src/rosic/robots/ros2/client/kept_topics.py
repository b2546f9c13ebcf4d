"""Asking for what publishers keep, once the graph shows that they keep anything.

Who subscribes so to a publisher that keeps nothing hears it no better, and has it log a warning of
incompatible quality of service for each.
"""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

from rosic.errors import RosicError

if TYPE_CHECKING:
    from collections.abc import Iterable

    from rosic.robots.ros2.client.graph import GraphSnapshot
    from rosic.robots.ros2.client.runtime import RosRuntime
    from rosic.robots.ros2.client.topics import LatestMessage


class KeptTopics:
    """The second subscriptions of some topics, opened as their publishers come."""

    def __init__(self) -> None:
        self._asking: dict[LatestMessage, asyncio.Task[None]] = {}

    def look(
        self, runtime: RosRuntime, seen: GraphSnapshot, sources: Iterable[LatestMessage]
    ) -> None:
        """Take in who is on the graph, and ask for what is kept there; anew if that failed."""
        keeping = {topic.name for topic in seen.topics if topic.latched}
        for source in sources:
            if source.topic in keeping and source not in self._asking:
                self._asking[source] = asyncio.create_task(self._ask(runtime, source))

    def close(self) -> None:
        """Ask no more; what was opened is closed with its topic."""
        for asking in self._asking.values():
            asking.cancel()
        self._asking.clear()

    async def _ask(self, runtime: RosRuntime, source: LatestMessage) -> None:
        try:
            await runtime.hear_kept(source)
        except RosicError:  # the link is closed, or there are too many subscriptions for now
            self._asking.pop(source, None)
