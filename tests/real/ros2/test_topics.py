from __future__ import annotations

import asyncio
import contextlib
import time
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from rosic.robots.ros2.client.services import wait_until
from rosic.robots.ros2.client.topics import ON_ITS_WAY_S, LatestMessage, TopicQos
from rosic.robots.ros2.errors import BadName, BadValue, NotSent
from rosic.robots.ros2.messages.decode import compile_path
from tests.pace import pace, patience

if TYPE_CHECKING:
    from rosic.robots.ros2.client.rclpy_import import RosObject
    from rosic.robots.ros2.client.runtime import RosRuntime
    from rosic.robots.ros2.messages.types import TypeRegistry
    from rosic.testing.ros2.graph import RosProcess

TWIST = "geometry_msgs/msg/Twist"
STAMPED = "geometry_msgs/msg/PoseWithCovarianceStamped"
INT32 = "std_msgs/msg/Int32"
STRING = "std_msgs/msg/String"

# On a busy machine DDS itself may drop a burst before the thread that counts sees it.
BURSTS = 20


def resident_mib() -> float:
    return int(Path("/proc/self/statm").read_text().split()[1]) * 4096 / 2**20


async def listened_to(peer: RosProcess, name: str, number: int) -> None:
    peer.say(f"listeners {name} {number}")
    await asyncio.to_thread(peer.expect, "ok listeners")


async def test_a_velocity_arrives_as_it_was_meant(runtime: RosRuntime, peer: RosProcess) -> None:
    publisher = await runtime.publisher("/omni/cmd_vel", TWIST)
    await wait_until(lambda: publisher.listeners == 1, "/omni/cmd_vel", 30)
    publisher.publish({"linear.x": 1, "angular": {"z": -0.25}})
    assert await asyncio.to_thread(peer.expect, "twist") == "1.0 -0.25"


@pytest.mark.parametrize("made_before", [False, True])
async def test_what_has_a_header_is_stamped_when_it_is_sent(
    runtime: RosRuntime, *, made_before: bool
) -> None:
    publisher = await runtime.publisher("/omni/there", STAMPED)
    heard = await runtime.latest("/omni/there", STAMPED)
    await wait_until(lambda: publisher.listeners == 1, "/omni/there", 30)
    made = publisher.made({"pose.pose.position.x": 1.0})
    await asyncio.sleep(0.2)
    begun_ns = time.time_ns()
    if made_before:
        publisher.send(made)
    else:
        publisher.publish({"pose.pose.position.x": 1.0})
    await heard.newer(0, timeout_s=60 * pace())
    message = heard.message()
    assert message is not None
    assert message.pose.pose.position.x == 1.0
    stamp = message.header.stamp
    assert begun_ns <= stamp.sec * 10**9 + stamp.nanosec <= time.time_ns()


async def test_a_publisher_outlives_what_it_has_sent(runtime: RosRuntime) -> None:
    publisher = await runtime.publisher("/omni/last_words", STRING)
    publisher.publish({"data": "good bye"})
    begun_s = time.monotonic()
    await publisher.close()
    assert time.monotonic() - begun_s > 0.9 * ON_ITS_WAY_S
    silent = await runtime.publisher("/omni/last_words", STRING)
    await asyncio.wait_for(silent.close(), 60 * pace())


async def test_what_does_not_fit_is_not_sent(runtime: RosRuntime, peer: RosProcess) -> None:
    publisher = await runtime.publisher("/omni/cmd_vel", TWIST)
    await wait_until(lambda: publisher.listeners == 1, "/omni/cmd_vel", 30)
    with pytest.raises(BadValue, match=r"linear\.x must be a finite number"):
        publisher.publish({"linear.x": float("nan")})
    publisher.publish({"linear.x": 0.5})
    assert await asyncio.to_thread(peer.expect, "twist") == "0.5 0.0"
    assert not any("nan" in line for line in peer.lines)


async def test_telemetry_keeps_the_newest_value(runtime: RosRuntime, peer: RosProcess) -> None:
    told: list[int] = []
    latest = await runtime.latest(
        "/omni/count", INT32, on_new=lambda new: told.append(new.received)
    )
    assert latest.message() is None
    assert latest.age_s is None
    await listened_to(peer, "count", 1)
    await _counts_to(peer, latest, 500)
    assert (newest := latest.message()) is not None
    assert newest.data == 500
    assert latest.received_ns is not None
    assert latest.age_s is not None
    assert latest.age_s < 5
    # It is there as soon as it came, and told of on the loop, a moment later.
    await wait_until(lambda: told[-1:] == [latest.received], "the last word of it", 30 * pace())
    assert len(told) <= latest.received


async def _counts_to(peer: RosProcess, latest: LatestMessage, last: int) -> None:
    """Have it count until the last number is heard: telemetry is best effort, and may lose it."""
    for _ in range(5):
        peer.say(f"burst {last}")
        await asyncio.to_thread(peer.expect, "ok burst")
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout(10 * pace()):
                return await _value(latest, last)
    pytest.fail(f"{last} was never heard")


async def _value(latest: LatestMessage, wanted: int) -> None:
    async with asyncio.timeout(60 * pace()):
        while (message := latest.message()) is None or message.data != wanted:
            await latest.newer(latest.received, timeout_s=30)


async def test_waiting_for_something_newer_is_bounded(runtime: RosRuntime) -> None:
    latest = await runtime.latest("/omni/count", INT32)
    with pytest.raises(TimeoutError):
        await latest.newer(0, timeout_s=0.05)


@pytest.mark.limit(90)
async def test_a_flood_neither_grows_memory_nor_takes_the_loop(
    runtime: RosRuntime, peer: RosProcess
) -> None:
    latest = await runtime.latest("/omni/count", INT32)
    stop = await runtime.service("/omni/stop", "std_srvs/srv/Trigger")
    await listened_to(peer, "count", 1)
    await wait_until(stop.ready, "/omni/stop", 30)
    before, late = resident_mib(), list[float]()
    peer.say("flood 4")
    flood = asyncio.create_task(asyncio.to_thread(peer.expect, "sent"))
    now = asyncio.get_running_loop().time
    while not flood.done():
        await stop.call({}, timeout_s=30, urgent=True)
        slept = now()
        await asyncio.sleep(0.05)
        late.append(now() - slept - 0.05)
    sent = int(await flood)
    await _value(latest, -1)
    slow = patience()
    assert sent > 10_000 / slow
    assert latest.received > 1_000 / slow
    assert resident_mib() - before < 10
    assert sorted(late)[len(late) // 2] < 0.1 * slow


async def test_every_word_a_robot_says_is_heard(runtime: RosRuntime, peer: RosProcess) -> None:
    heard: list[str] = []
    stream = await runtime.stream(
        "/omni/from_robot_topic", STRING, lambda message: heard.append(message.data)
    )
    publisher = await runtime.publisher("/omni/to_robot_topic", STRING)
    await listened_to(peer, "voice", 1)
    await wait_until(lambda: publisher.listeners == 1, "/omni/to_robot_topic", 30)
    for word in ("hello", "what do you see?", "größer 東"):
        publisher.publish({"data": word})
    await wait_until(lambda: len(heard) == 3, "three answers", 30)
    assert heard == ["heard: hello", "heard: what do you see?", "heard: größer 東"]
    assert stream.dropped == 0


async def test_words_that_nobody_takes_are_dropped_and_counted(
    runtime: RosRuntime, peer: RosProcess
) -> None:
    heard: list[str] = []
    stream = await runtime.stream(
        "/omni/from_robot_topic",
        STRING,
        lambda message: heard.append(message.data),
        TopicQos(depth=5),
    )
    await listened_to(peer, "voice", 1)
    for _ in range(BURSTS):
        heard.clear()
        before = stream.dropped
        peer.say("texts 200")
        peer.expect("ok texts")  # on the loop, on purpose: nobody drains meanwhile
        await wait_until(lambda: "200" in heard, "the last word", 30)
        assert len(heard) + stream.dropped - before <= 200
        assert heard == sorted(heard, key=int)
        if stream.dropped:
            return
    pytest.fail("nothing that nobody took was counted")


async def test_a_callback_that_raises_does_not_silence_the_others(
    runtime: RosRuntime, peer: RosProcess
) -> None:
    complaints: list[dict[str, object]] = []
    asyncio.get_running_loop().set_exception_handler(
        lambda _loop, context: complaints.append(context)
    )

    def broken(_new: LatestMessage) -> None:
        raise RuntimeError("broken on purpose")

    await runtime.latest("/omni/count", INT32, on_new=broken)
    good = await runtime.latest("/omni/count", INT32)
    await listened_to(peer, "count", 2)
    await _counts_to(peer, good, 50)
    await wait_until(lambda: bool(complaints), "the complaint", 30)


async def test_a_latched_message_reaches_who_comes_later(runtime: RosRuntime) -> None:
    latched = TopicQos(latched=True, depth=1)
    publisher = await runtime.publisher("/map_name", STRING, latched)
    publisher.publish({"data": "hall"})
    late = await runtime.latest("/map_name", STRING, latched)
    await late.newer(0, timeout_s=30)
    message = late.message()
    assert message is not None
    assert message.data == "hall"


async def test_closing_an_endpoint_leaves_the_graph(runtime: RosRuntime) -> None:
    publisher = await runtime.publisher("/a", STRING)
    latest = await runtime.latest("/a", STRING)
    await wait_until(lambda: publisher.listeners == 1, "/a", 30)
    await latest.close()
    await wait_until(lambda: publisher.listeners == 0, "an empty topic", 30)
    await publisher.close()


@pytest.mark.parametrize("topic", ["", "a b", "/omni/../x", "/1st", "/~/x", "/{node}", "a" * 201])
async def test_a_name_that_is_none_is_refused(runtime: RosRuntime, topic: str) -> None:
    with pytest.raises(BadName, match="is not a ROS name"):
        await runtime.publisher(topic, STRING)


async def test_a_type_that_no_profile_names_is_refused(runtime: RosRuntime) -> None:
    with pytest.raises(BadName, match="is not named by any profile"):
        await runtime.publisher("/x", "std_msgs/msg/Empty")


async def test_after_the_end_nothing_is_sent(runtime: RosRuntime) -> None:
    publisher = await runtime.publisher("/a", STRING)
    latest = await runtime.latest("/a", STRING)
    await runtime.close()
    await runtime.close()
    assert not runtime.alive
    assert publisher.listeners == latest.publishers == 0
    with pytest.raises(NotSent):
        publisher.publish({"data": "x"})
    with pytest.raises(NotSent):
        await runtime.publisher("/b", STRING)


async def test_a_message_of_odometry_crosses_whole(
    runtime: RosRuntime, types: TypeRegistry
) -> None:
    name = "nav_msgs/msg/Odometry"
    seen: list[RosObject] = []
    stream = await runtime.stream("/odom", name, seen.append)
    publisher = await runtime.publisher("/odom", name)
    await wait_until(lambda: publisher.listeners == 1, "/odom", 30)
    covariance = [index / 7 for index in range(36)]
    publisher.publish(
        {"pose.pose.position.x": 0.5, "pose.covariance": covariance, "child_frame_id": "base"}
    )
    await wait_until(lambda: bool(seen), "odometry", 30)
    cls = types.message(name)
    assert compile_path(cls, "pose.pose.position.x")(seen[0]) == 0.5
    assert compile_path(cls, "pose.covariance")(seen[0]) == covariance
    assert compile_path(cls, "child_frame_id")(seen[0]) == "base"
    await stream.close()
