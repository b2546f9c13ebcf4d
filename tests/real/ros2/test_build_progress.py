"""How far building interfaces is: from a worker's thread to the log and to the chat."""

from __future__ import annotations

import asyncio
import logging
from typing import TYPE_CHECKING

from rosic.robots.ros2.client.node import SAY_EVERY_NS, BuildProgress

if TYPE_CHECKING:
    import pytest


async def test_each_tenth_is_logged_and_people_are_told_now_and_then(
    caplog: pytest.LogCaptureFixture,
) -> None:
    told: list[str] = []
    now_ns = 0
    progress = BuildProgress(told.append, lambda: now_ns)
    caplog.set_level(logging.INFO)

    for step in range(1, 101):
        now_ns += SAY_EVERY_NS // 40
        await asyncio.to_thread(progress, "nav2_msgs", step / 100)

    logged = [record.getMessage() for record in caplog.records if "nav2_msgs" in record.message]
    assert logged == [
        f"building the ROS interfaces nav2_msgs, once: {tenths * 10} %" for tenths in range(11)
    ]
    assert told == [
        f"building the ROS interfaces nav2_msgs, once: {percent} %" for percent in (0, 50, 90)
    ]
