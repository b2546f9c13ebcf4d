"""Ends that are there and do not meet: quality of service that does not fit, said once."""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rosic.robots.ros2.client.graph import GraphSnapshot
    from rosic.robots.ros2.client.topics import Subscription
    from rosic.robots.ros2.stopping import StopController

_log = logging.getLogger(__name__)

# Discovery sees an end a little before it is matched.
LOOKS = 3


class QosMismatch:
    """Compares who is on the graph with who is matched.

    ROS reports incompatible quality of service as an event, once, to whoever asked for it when
    the end was made; comparing also finds what was there before, and whatever else keeps two ends
    apart.
    """

    def __init__(self, robot: str) -> None:
        self._robot = robot
        self._apart: dict[str, int] = {}
        self._doubt = ""

    def look(
        self, seen: GraphSnapshot, heard: list[Subscription], stop_controller: StopController
    ) -> None:
        """Take in a look at the graph, and log what should meet and does not."""
        topics = {topic.name: topic for topic in seen.topics}
        for source in heard:
            topic = topics.get(source.topic)
            there = topic is not None and topic.publishers > 0
            self._count(source.topic, apart=there and source.publishers == 0, verb="hears nothing")
        for publisher in stop_controller.zeros.values():
            topic = topics.get(publisher.topic)
            there = topic is not None and topic.subscribers > 0
            apart = there and publisher.listeners == 0
            self._count(publisher.topic, apart=apart, verb="is not heard")

    def doubt(self, why: str) -> None:
        """Log, once, why rest is not measured though what should show it is heard."""
        if why and why != self._doubt:
            _log.warning("%s: whether it rests is not measured: %s", self._robot, why)
        self._doubt = why

    def _count(self, topic: str, *, apart: bool, verb: str) -> None:
        count = self._apart[topic] = self._apart.get(topic, 0) + 1 if apart else 0
        if count == LOOKS:
            _log.warning(
                "%s: ROSIC %s on %s although the other side is there: incompatible QoS or type",
                self._robot,
                verb,
                topic,
            )
