"""Every kind of binding, against a robot's side that is plain rclpy."""

from __future__ import annotations

import asyncio
import logging
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
from msgspec.structs import replace

from rosic.core.order import OrderEnding, OrderStage, Outcome, Stop
from rosic.errors import ConfigurationError, OrderVoid, RobotOffline, RobotUnreachable
from rosic.robots.ros2.client.graph import wait_for
from rosic.robots.ros2.client.runtime import RosRuntime
from rosic.robots.ros2.messages.types import TypeRegistry
from rosic.system import SystemClock
from rosic.testing.ros2.graph import RosGraph, RosProcess
from tests.pace import pace, patience
from tests.real.ros2.simulated import TriedRobot, opened, profile_of, until

if TYPE_CHECKING:
    from collections.abc import Iterator

PEER = Path(__file__).with_name("peer.py")
LINK = {"kind": "ros2", "namespace": "/omni"}


pytestmark = pytest.mark.usefixtures("peer")


@pytest.fixture
def clock() -> SystemClock:
    return SystemClock()


@pytest.fixture(scope="module")
def peer(tmp_path_factory: pytest.TempPathFactory) -> Iterator[RosProcess]:
    """A node /omni/robot that writes down velocities, answers services and gives text back."""
    with RosGraph(tmp_path_factory.mktemp("peer")) as graph:
        yield graph.start(PEER)


def omni(skill: dict[str, object], **more: object) -> TriedRobot:
    parameters = {
        "text": {"text": True},
        "speed": {"min": 0.0, "max": 1.0},
        "slow": {"choices": {"yes": ()}},
        "duration": {"unit": "s", "min": 0.1, "max": 5.0},
    }
    profile = profile_of(
        id="omni",
        title="Omni",
        link=LINK,
        skills={"do": {**skill, "parameters": parameters}},
        **more,
    )
    return TriedRobot(profile, SystemClock())


async def done(
    robot: TriedRobot, stages: list[OrderStage] | None = None, **arguments: float | str
) -> Outcome:
    """Open a robot, have it do the one thing it can, and close it."""
    told: list[OrderStage] = [] if stages is None else stages
    await robot.open(lambda _text: None)
    try:
        order = robot.order("do", arguments)
        return await robot.execute(order, lambda report: told.append(report.stage))
    finally:
        await robot.close()


# ---- topics ----


async def test_one_message_is_sent_and_nobody_claims_more(peer: RosProcess) -> None:
    topic = {
        "name": "/omni/to_robot_topic",
        "type": "std_msgs/msg/String",
        "message": {"data": "$text"},
    }
    stages: list[OrderStage] = []
    heard: list[str] = []
    async with await RosRuntime.open(TypeRegistry(["std_msgs/msg/String"])) as listener:
        await listener.stream(
            "/omni/from_robot_topic", "std_msgs/msg/String", lambda m: heard.append(m.data)
        )
        peer.say("listeners voice 1")
        await asyncio.to_thread(peer.expect, "ok listeners")
        robot = omni({"topic": topic})
        await robot.open(lambda _text: None)
        order = robot.order("do", {"text": "on\u202ece \ud800"})
        outcome = await robot.execute(order, lambda report: stages.append(report.stage))
        assert outcome == Outcome(OrderEnding.SENT)
        assert stages == [OrderStage.SENT]
        await until(lambda: bool(heard))
        await robot.close()
    assert heard == ["heard: once \ufffd"]


async def test_a_stream_is_bounded_and_ends_in_zeros(peer: RosProcess) -> None:
    topic = {
        "name": "/omni/cmd_vel",
        "type": "geometry_msgs/msg/Twist",
        "message": {"linear.x": "$speed"},
        "stream_hz": 20.0,
    }
    robot = omni({"topic": topic}, watchdog_s=0.5)
    peer.lines.clear()
    outcome = await done(robot, speed=0.25, duration=0.5)
    assert outcome.ending is OrderEnding.SENT, "this robot does not measure its rest"
    await asyncio.to_thread(peer.expect, "twist 0.0")
    velocities = [line.split()[1] for line in peer.lines if line.startswith("twist")]
    assert 8 / patience() <= velocities.count("0.25") <= 11
    assert velocities == sorted(velocities, reverse=True)
    assert velocities[-1] == "0.0"


async def test_after_a_stop_no_velocity_follows_the_zero(peer: RosProcess) -> None:
    topic = {
        "name": "/omni/cmd_vel",
        "type": "geometry_msgs/msg/Twist",
        "message": {"linear.x": "$speed"},
        "stream_hz": 50.0,
    }
    robot = omni({"topic": topic}, watchdog_s=0.5)
    await robot.open(lambda _text: None)
    try:
        peer.lines.clear()
        running = asyncio.create_task(robot.do("do", {"speed": 0.25, "duration": 5.0}))
        await asyncio.to_thread(peer.expect, "twist 0.25")
        rest = await robot.stop(Stop("omni", 1))
        outcome = await asyncio.wait_for(running, 60 * pace())
        await asyncio.to_thread(peer.expect, "twist 0.0")
        await asyncio.sleep(0.2)
    finally:
        await robot.close()
    assert not rest.confirmed, "it has no way to measure rest"
    assert outcome.ending is OrderEnding.CANCELLED
    velocities = [line.split()[1] for line in peer.lines if line.startswith("twist")]
    assert velocities == sorted(velocities, reverse=True)


async def test_no_stream_begins_before_it_is_shown_who_takes_it(
    peer: RosProcess, monkeypatch: pytest.MonkeyPatch
) -> None:
    topic = {
        "name": "/omni/cmd_vel",
        "type": "geometry_msgs/msg/Twist",
        "message": {"linear.x": "$speed"},
        "stream_hz": 20.0,
    }
    robot = omni({"topic": topic}, watchdog_s=0.5)
    peer.lines.clear()
    await robot.open(lambda _text: None)
    try:
        publisher = robot._stop_controller.zeros["/omni/cmd_vel"]
        await until(lambda: publisher.listeners > 0 and bool(publisher.takers()))
        monkeypatch.setattr(publisher, "takers", dict)  # as while the graph lags behind
        with pytest.raises(RobotOffline):
            await robot.do("do", {"speed": 0.25, "duration": 0.5})
        monkeypatch.undo()
        await robot.do("do", {"speed": 0.5, "duration": 0.5})
        await asyncio.to_thread(peer.expect, "twist 0.5")
    finally:
        await robot.close()
    assert not [line for line in peer.lines if line == "twist 0.25"]


# ---- services ----


async def test_the_answer_of_a_service_is_the_receipt(peer: RosProcess) -> None:
    stages: list[OrderStage] = []
    service = {"name": "/omni/stop", "type": "std_srvs/srv/Trigger"}
    outcome = await done(omni({"service": service}), stages)
    assert outcome == Outcome(OrderEnding.DONE, "at rest")
    assert stages == [OrderStage.SENT, OrderStage.RECEIVED]
    await asyncio.to_thread(peer.expect, "stopped")


async def test_a_service_that_does_not_answer_leaves_doubt(peer: RosProcess) -> None:
    service = {
        "name": "/omni/slow",
        "type": "std_srvs/srv/SetBool",
        "request": {"data": True},
        "timeout_s": 0.3,
    }
    with pytest.raises(RobotUnreachable, match=r"Omni has not answered for 0.3 s"):
        await done(omni({"service": service}))
    await asyncio.to_thread(peer.expect, "slow done")


CODED: dict[str, object] = {
    "name": "/omni/code",
    "type": "action_msgs/srv/CancelGoal",
    "success": "return_code",
    "good": 0,
    "codes": {"3": "gripper blocked"},
}


@pytest.mark.parametrize(
    ("code", "outcome"),
    [
        (0, Outcome(OrderEnding.DONE)),
        (1, Outcome(OrderEnding.FAILED, "code 1")),
        (3, Outcome(OrderEnding.FAILED, "code 3, gripper blocked")),
    ],
)
async def test_a_service_may_answer_by_a_code(code: int, outcome: Outcome) -> None:
    request = {"goal_info.stamp.sec": code}
    assert await done(omni({"service": {**CODED, "request": request}})) == outcome


async def test_what_nobody_judges_is_said_where_it_counts_as_done() -> None:
    unjudged = {key: CODED[key] for key in ("name", "type")}
    request = {"goal_info.stamp.sec": 3}
    assert await done(omni({"service": {**unjudged, "request": request}})) == Outcome(
        OrderEnding.DONE, "answered return_code 3; whether that is success is not known"
    )


@pytest.mark.parametrize(
    ("good", "ending"), [("at rest", OrderEnding.DONE), ("AT_REST", OrderEnding.FAILED)]
)
async def test_a_service_may_answer_by_a_word(good: str, ending: OrderEnding) -> None:
    service = {"name": "/omni/stop", "type": "std_srvs/srv/Trigger", "success": "message"}
    outcome = await done(omni({"service": {**service, "good": good}}))
    assert outcome == Outcome(ending, "at rest")


@pytest.mark.parametrize(
    ("spoilt", "sentence"),
    [
        ({"good": True}, r"return_code of the answer is a number, and nothing says which means"),
        ({"success": "goals_canceling"}, r"goals_canceling of the answer holds no number"),
        ({"success": "success"}, r"success"),
        ({"good": "SUCCEEDED"}, r"return_code of the answer holds no word, and 'good' is one"),
    ],
)
async def test_an_answer_that_could_never_mean_success_is_refused(
    spoilt: dict[str, object], sentence: str
) -> None:
    with pytest.raises(ConfigurationError, match=sentence):
        await done(omni({"service": {**CODED, **spoilt}}))


# ---- parameters ----


async def test_a_parameter_is_set_and_read_back() -> None:
    binding = {"node": "/omni/robot", "values": {"speed_m_s": "$speed"}}
    outcome = await done(omni({"set_parameters": binding}), speed=0.75)
    assert outcome == Outcome(OrderEnding.DONE, "set and read back", {"speed_m_s": 0.75})


async def test_a_parameter_that_the_node_declines_fails_with_its_words() -> None:
    binding = {"node": "/omni/robot", "values": {"speed_m_s": "$text"}}
    outcome = await done(omni({"set_parameters": binding}), text="fast")
    assert outcome.ending is OrderEnding.FAILED
    assert "speed_m_s was not set" in outcome.note


# ---- what cannot be ----


async def test_a_robot_that_is_not_there_is_sent_nothing() -> None:
    service = {"name": "/rover/stop", "type": "std_srvs/srv/Trigger"}
    stages: list[OrderStage] = []
    with pytest.raises(RobotOffline, match=r"^Omni is not there\. Nothing was sent\.$"):
        await done(omni({"service": service}), stages)
    assert stages == []


async def test_what_is_too_late_says_so_though_nobody_is_there() -> None:
    robot = omni({"service": {"name": "/rover/stop", "type": "std_srvs/srv/Trigger"}})
    await robot.open(lambda _text: None)
    try:
        with pytest.raises(OrderVoid, match="too late"):
            await robot.execute(robot.book.order("do", late_s=0.001), lambda _report: None)
    finally:
        await robot.close()


@pytest.mark.usefixtures("interfaces")
async def test_nobody_is_waited_for_while_the_others_move() -> None:
    """The one that is not found in time for a common start is too late for it, and says so then."""
    kind = "rosic_interfaces/action/Move"
    robot = omni({"action": {"name": "/rover/move", "type": kind, "start": "start_at"}})
    await robot.open(lambda _text: None)
    try:
        now_ns = SystemClock().monotonic_ns()
        order = replace(robot.order("do"), start_ns=now_ns + 200_000_000)
        with pytest.raises(OrderVoid, match="too late to begin with the others"):
            await robot.execute(order, lambda _report: None)
    finally:
        await robot.close()


async def test_a_value_that_does_not_fit_is_not_sent(peer: RosProcess) -> None:
    peer.lines.clear()
    service = {
        "name": "/omni/slow",
        "type": "std_srvs/srv/SetBool",
        "request": {"data": "$speed"},
    }
    outcome = await done(omni({"service": service}), speed=1.0)
    assert outcome.ending is OrderEnding.REFUSED
    assert outcome.note == "Omni cannot take these values. Nothing was done."
    assert not [line for line in peer.lines if line.startswith("slow")]


@pytest.mark.parametrize(
    ("skill", "sentence"),
    [
        (
            {"service": {"name": "/omni/stop", "type": "nowhere_msgs/srv/Stop"}},
            r"omni: The ROS package nowhere_msgs is not installed here",
        ),
        (
            {"service": {"name": "/omni/stop", "type": "std_srvs/srv/Triger"}},
            r"did you mean Trigger\?",
        ),
        (
            {
                "service": {
                    "name": "/omni/stop",
                    "type": "std_srvs/srv/SetBool",
                    "request": {"dat": True},
                }
            },
            r"did you mean data\?",
        ),
        ({}, r"skill 'do' does not say how it reaches the robot"),
    ],
)
async def test_a_profile_that_can_never_work_says_so(
    skill: dict[str, object], sentence: str
) -> None:
    with pytest.raises(ConfigurationError, match=sentence):
        await done(omni(skill))


# ---- a stop by a service that asks ----

MOVES: dict[str, object] = {"service": {"name": "/omni/stop", "type": "std_srvs/srv/Trigger"}}
HOLD = {"service": "/omni/slow", "type": "std_srvs/srv/SetBool"}


@pytest.mark.parametrize("says", [True, False])
async def test_a_stop_says_what_the_profile_says(peer: RosProcess, *, says: bool) -> None:
    robot = omni(MOVES, stop={**HOLD, "request": {"data": says}})
    await robot.open(lambda _text: None)
    try:
        await until(lambda: all(link.ready() for link in robot._stop_controller.calls))
        await robot.stop(Stop("omni", 1))
        await asyncio.to_thread(peer.expect, f"slow done {says}", timeout_s=60 * pace())
    finally:
        await robot.close()


async def test_a_stop_that_leaves_a_field_to_what_it_says_by_itself_is_refused() -> None:
    with pytest.raises(ConfigurationError, match="asks for 'data', and nothing says what it is"):
        await done(omni(MOVES, stop=HOLD))


async def test_a_stop_that_says_what_its_service_does_not_ask_is_refused() -> None:
    with pytest.raises(ConfigurationError, match=r"did you mean data\?"):
        await done(omni(MOVES, stop={**HOLD, "request": {"dat": True}}))


# ---- one node ----


async def test_robots_of_one_process_share_one_node_until_the_last_closes(
    clock: SystemClock,
) -> None:
    service = {"name": "/omni/stop", "type": "std_srvs/srv/Trigger"}
    first = profile_of(id="omni", link=LINK, skills={"do": {"service": service}})
    second = profile_of(id="other", link={"kind": "ros2", "namespace": "/other"})

    async with await RosRuntime.open(TypeRegistry(()), node_name="onlooker") as onlooker:

        def ends() -> list[object]:
            node = onlooker.thread.node  # every node has one end here
            return list(node.get_publishers_info_by_topic("/parameter_events"))

        async def nodes() -> int:
            return len(await onlooker.thread.run(ends))

        async def becomes(expected: int) -> None:
            async with asyncio.timeout(60 * pace()):
                while await nodes() != expected:  # noqa: ASYNC110 - the graph tells nobody
                    await asyncio.sleep(0.05)

        await becomes(2)  # the peer, and the onlooker
        async with opened(first, clock) as robot:
            async with opened(second, clock) as other:
                await until(lambda: robot.presence().online is True)
                await until(lambda: other.presence().online is False)
                await becomes(3)
                # Names of nodes come later than their ends, by seconds when a packet gets lost.
                await wait_for(onlooker, lambda seen: "/chat_interface" in seen.nodes, timeout_s=60)
            assert (await robot.do("do")).ending is OrderEnding.DONE
            await becomes(3)
        await becomes(2)


async def test_ends_that_do_not_fit_are_logged(
    tmp_path: Path, clock: SystemClock, caplog: pytest.LogCaptureFixture
) -> None:
    deaf = tmp_path / "deaf.py"
    deaf.write_text(DEAF)
    profile = profile_of(id="omni", link=LINK, stop={"zero": "/omni/cmd_vel"})
    with RosGraph(tmp_path) as graph:
        graph.start(deaf)
        with caplog.at_level(logging.WARNING, "rosic"):
            async with opened(profile, clock):
                await until(lambda: "incompatible QoS" in caplog.text)
    assert "omni: ROSIC is not heard on /omni/cmd_vel" in caplog.text


DEAF = '''
"""Takes velocities only from a publisher that keeps them for later: ours does not."""
import sys, rclpy
from rclpy.qos import DurabilityPolicy, QoSProfile
from geometry_msgs.msg import Twist
from rclpy.signals import SignalHandlerOptions

rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
node = rclpy.create_node("deaf", namespace="/omni")
quality = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
node.create_subscription(Twist, "cmd_vel", print, quality)
print("ready", flush=True)
sys.stdin.read()
node.destroy_node()
rclpy.try_shutdown()
'''
