"""What publishers keep: when it is asked for, and when it counts."""

from __future__ import annotations

from typing import TYPE_CHECKING, cast

import pytest

from rosic.core.time_units import SECOND_NS
from rosic.robots.ros2.client.connection import RosConnection
from rosic.robots.ros2.client.graph import GraphSnapshot, GraphTopic
from rosic.robots.ros2.client.kept_topics import KeptTopics
from rosic.robots.ros2.client.topics import LatestMessage
from rosic.robots.ros2.errors import NotSent
from rosic.testing.clock import ManualClock, settle

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rosic.robots.ros2.client.executor_thread import RosThread
    from rosic.robots.ros2.client.runtime import RosRuntime
    from rosic.robots.ros2.publishers import About

TOPIC = "/foreign/power"
HOUR_NS = 3_600 * SECOND_NS
KEPT = GraphSnapshot((), (GraphTopic(TOPIC, (), 1, 0, latched=1),), (), (), complete=True)


class Thread:
    """No thread: nobody waits for what comes."""

    alive = True

    def hand_over(self, _call: object) -> bool:
        return False


class Number:
    """A message of one number."""

    @staticmethod
    def get_fields_and_field_types() -> Mapping[str, str]:
        return {"data": "int32"}


def latest(clock: ManualClock) -> LatestMessage:
    connection = RosConnection(cast("RosThread", Thread()), clock.monotonic_ns, clock.wall_ns)
    return LatestMessage(connection, TOPIC, Number, None)


def about(sent_ns: int, gid: bytes) -> About:
    """Return what rclpy says of a message that was sent at a moment of the wall clock."""
    return {"source_timestamp": sent_ns, "publisher_gid": {"data": gid}}


@pytest.mark.parametrize("kept_before", [False, True])
async def test_what_another_kept_for_long_does_not_replace_what_is_newer(
    *, kept_before: bool
) -> None:
    clock = ManualClock()
    heard, now_ns = latest(clock), clock.wall_ns()
    take = heard.arrived_kept if kept_before else heard.arrived
    take(b"new", about(now_ns, b"a"))
    size, told_ns = heard.size_bytes, heard.told_ns
    heard.arrived_kept(b"of old", about(now_ns - HOUR_NS, b"b"))
    assert (heard.size_bytes, heard.told_ns) == (size, told_ns)
    await clock.advance(1.0)
    heard.arrived_kept(b"newest", about(clock.wall_ns(), b"b"))
    assert (heard.size_bytes, heard.told_age_s) == (len(b"newest"), 0.0)


class Link:
    """A link that has no room at first."""

    def __init__(self) -> None:
        self.asked = 0
        self.full = True

    async def hear_kept(self, _latest: LatestMessage) -> None:
        self.asked += 1
        if self.full:
            raise NotSent("More than 1024 ROS topics, services and actions are in use.")


async def test_what_could_not_be_asked_for_is_asked_for_at_the_next_look() -> None:
    kept, link, source = KeptTopics(), Link(), latest(ManualClock())
    runtime = cast("RosRuntime", link)
    for number in (1, 2):
        kept.look(runtime, KEPT, (source,))
        await settle()
        assert link.asked == number
    link.full = False
    for _ in range(3):
        kept.look(runtime, KEPT, (source,))
        await settle()
    assert link.asked == 3, "what is heard is not asked for again"
    kept.close()
