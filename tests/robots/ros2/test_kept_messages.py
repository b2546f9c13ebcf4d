"""What publishers keep, and when it counts."""

from __future__ import annotations

from typing import TYPE_CHECKING, cast

import pytest

from rosic.core.time_units import SECOND_NS
from rosic.robots.ros2.client.connection import RosConnection
from rosic.robots.ros2.client.topics import LatestMessage
from rosic.testing.clock import ManualClock

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rosic.robots.ros2.client.executor_thread import RosThread
    from rosic.robots.ros2.publishers import About

TOPIC = "/foreign/power"
HOUR_NS = 3_600 * SECOND_NS


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
