"""Topics that are opened for programs: how much is kept for whoever takes nothing."""

from __future__ import annotations

import asyncio
import signal
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from rosic.robots.ros2.open_topics import (
    FRESH_NS,
    HEARD,
    HEARD_BYTES,
    SAID_BYTES,
    CheckedPublisher,
    HeardMessages,
)
from tests.pace import pace

if TYPE_CHECKING:
    from rosic.robots.ros2.client.runtime import RosRuntime
    from rosic.testing.ros2.graph import RosGraph

STRING = "std_msgs/msg/String"
LISTENER = Path(__file__).parent / "topic_listener.py"
LARGE = 65_536
FLOOD = 1_500
BESIDE_BYTES = 32 << 20
"""What else may grow meanwhile: what is on its way, and what the allocator keeps."""


def resident_bytes() -> int:
    return int(Path("/proc/self/statm").read_text().split()[1]) * 4096


async def say(publisher: CheckedPublisher, text: str) -> None:
    publisher.send(await publisher.packed({"data": text}))


async def test_a_subscriber_that_stands_still_is_kept_few_bytes_and_the_newest(
    graph: RosGraph, runtime: RosRuntime
) -> None:
    listener = graph.start(LISTENER, "/chatter", "10", ready=None)
    publisher = CheckedPublisher(runtime, "/chatter", STRING)
    async with asyncio.timeout(120 * pace()):
        await publisher.open()
        found = asyncio.ensure_future(asyncio.to_thread(listener.expect, "heard"))
        while not found.done():
            await say(publisher, "hello")
            await asyncio.wait((found,), timeout=0.05)
        await found
        await say(publisher, "x" * LARGE)
        listener.process.send_signal(signal.SIGSTOP)
        try:
            before = resident_bytes()
            for number in range(FLOOD):
                await say(publisher, f"{number} ".ljust(LARGE, "x"))
                await asyncio.sleep(0)
            assert resident_bytes() - before <= SAID_BYTES + BESIDE_BYTES
        finally:
            listener.process.send_signal(signal.SIGCONT)
        over = asyncio.ensure_future(asyncio.to_thread(listener.expect, "all"))
        while not over.done():
            await say(publisher, "last")
            await asyncio.wait((over,), timeout=0.05)
    assert str(FLOOD - 1) in over.result().split()
    await publisher.close()


@pytest.mark.parametrize(("size", "most"), [(64, HEARD), (2 * LARGE, 64), (2 * HEARD_BYTES, 1)])
def test_what_comes_of_a_topic_waits_in_few_bytes(size: int, most: int) -> None:
    messages, content = HeardMessages(lambda: 0), bytes(size)
    for _ in range(2 * HEARD):
        messages.put(content)
    assert len(messages) == most
    assert messages.lost == 2 * HEARD - most


def test_all_that_comes_is_taken_until_it_has_waited_too_long_then_the_newest() -> None:
    now_ns = 0
    messages = HeardMessages(lambda: now_ns)
    for number in range(6):
        messages.put(b"%d" % number)
    assert [messages.take(), messages.take()] == [b"0", b"1"]
    now_ns = FRESH_NS + 1
    messages.put(b"newest")
    assert messages.take() == b"newest"
    assert messages.take() is None
    assert messages.lost == 4
