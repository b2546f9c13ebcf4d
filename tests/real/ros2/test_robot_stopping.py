"""A stop is measured, works whatever else is wrong, and so does the end of a gateway."""

from __future__ import annotations

import asyncio
import re
import signal
import time
from typing import TYPE_CHECKING, NamedTuple

import pytest
from msgspec.structs import replace

from rosic.core.order import OrderEnding, Outcome, Stop
from rosic.errors import OrderVoid, RobotOffline, RobotUnreachable
from rosic.robots.ros2.bindings.parameters import SET_PARAMETERS
from rosic.robots.ros2.client.runtime import RosRuntime
from rosic.robots.ros2.goal_watch import LOOK_EVERY_S
from rosic.robots.ros2.messages.types import TypeRegistry
from rosic.system import SystemClock
from rosic.testing.ros2.graph import RosGraph
from tests.pace import pace, patience
from tests.real.ros2.simulated import Simulated, opened, set_fault, shipped, simulated, until

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Callable, Iterator
    from pathlib import Path

    from rosic.core.order import StageReport
    from rosic.core.robot.skill import Argument
    from rosic.robots.ros2.client.rclpy_import import RosObject
    from rosic.robots.ros2.client.services import ServiceLink
    from rosic.robots.ros2.client.topics import LatestMessage
    from rosic.robots.ros2.messages.encode import Values
    from rosic.robots.ros2.profile import Ros2Profile
    from tests.real.ros2.simulated import TriedRobot

FAR: dict[str, Argument] = {"direction": "forward", "distance": 4.0, "speed": 0.5}
# Longer than any machine takes for what is asked meanwhile.
LONG_M_S = 0.05
LONG: dict[str, Argument] = {"direction": "forward", "distance": 4.0, "speed": LONG_M_S}
NEAR: dict[str, Argument] = {"direction": "back", "distance": 0.5, "speed": 0.25}
ODOMETRY = "nav_msgs/msg/Odometry"
AT_REST_M_S = 0.005
FAST_M_S = 0.3
ROUNDED = 0.1
TRIES = 5


pytestmark = pytest.mark.usefixtures("omni")


@pytest.fixture
def clock() -> SystemClock:
    return SystemClock()


@pytest.fixture(scope="module")
def omni(tmp_path_factory: pytest.TempPathFactory, interfaces: Path) -> Iterator[Simulated]:  # noqa: ARG001 - built before
    folder = tmp_path_factory.mktemp("omni")
    with RosGraph(folder) as graph, simulated(graph, folder, "omni") as simulation:
        yield simulation


@pytest.fixture
async def odometry(omni: Simulated) -> AsyncIterator[LatestMessage]:
    """What somebody else measures, who has nothing to do with the robot under test."""
    types = TypeRegistry([ODOMETRY])
    domain = omni.graph.domain_id
    async with await RosRuntime.open(types, node_name="onlooker", domain_id=domain) as runtime:
        latest = await runtime.latest("/omni/odom", ODOMETRY)
        await latest.newer(0, timeout_s=60)
        yield latest


def x_m(odometry: LatestMessage) -> float:
    message = odometry.message()
    assert message is not None
    return float(message.pose.pose.position.x)


def speed_m_s(odometry: LatestMessage) -> float:
    message = odometry.message()
    assert message is not None
    return abs(float(message.twist.twist.linear.x))


async def stands(odometry: LatestMessage) -> bool:
    """Tell whether the robot is at rest now, by the next that it says to somebody else.

    They may hear it late, so what it said before now does not count.
    """
    now_s = time.time()
    await until(lambda: said_at_s(odometry) >= now_s)
    return speed_m_s(odometry) <= AT_REST_M_S


def said_at_s(odometry: LatestMessage) -> float:
    message = odometry.message()
    assert message is not None
    return float(message.header.stamp.sec + message.header.stamp.nanosec / 1e9)


async def moving(
    robot: TriedRobot, move: dict[str, Argument] | None = None
) -> asyncio.Task[Outcome]:
    await until(lambda: robot.presence().at_rest is True)  # from what was before
    task = asyncio.create_task(robot.do("move", move or FAR))
    await until(lambda: robot.presence().at_rest is False or task.done())
    assert not task.done(), task
    return task


async def moving_fast(robot: TriedRobot, odometry: LatestMessage) -> asyncio.Task[Outcome]:
    """Return a motion that somebody else sees at speed; one that ended unseen is made again.

    Where the processors are busy, they may see none of it until it is over.
    """
    for _ in range(TRIES):
        task = await moving(robot)
        async with asyncio.timeout(60 * pace()):
            while speed_m_s(odometry) <= FAST_M_S and not task.done():  # noqa: ASYNC110
                await asyncio.sleep(0.01)
        if not task.done():
            return task
    pytest.fail(f"{TRIES} motions ended before anybody saw them at speed")


async def test_what_is_done_is_what_was_measured(
    clock: SystemClock, odometry: LatestMessage
) -> None:
    async with opened(shipped("omni"), clock) as robot:
        before = x_m(odometry)
        outcome = await robot.do("move", NEAR)
        await until(lambda: speed_m_s(odometry) == 0.0)
        assert outcome.ending is OrderEnding.DONE
        assert outcome.note == "moved 0.50 m back"
        assert outcome.facts["distance_m"] == pytest.approx(0.5, abs=0.01)
        assert x_m(odometry) - before == pytest.approx(-0.5, abs=0.01)
        await until(lambda: robot.presence().at_rest is True)
        presence = robot.presence()
        assert presence.values["x"] == pytest.approx(x_m(odometry), abs=0.001)
        battery = presence.values["battery"]
        assert isinstance(battery, float)
        assert 90 < battery <= 100


async def test_a_velocity_is_streamed_and_its_end_is_measured(
    omni: Simulated, clock: SystemClock, odometry: LatestMessage
) -> None:
    begun = len(omni.actuations("omni"))
    async with opened(shipped("omni"), clock) as robot:
        before = x_m(odometry)
        outcome = await robot.do(
            "drive", {"linear": -0.2, "lateral": 0.0, "angular": 0.0, "duration": 1.0}
        )
        assert outcome.ending is OrderEnding.DONE, outcome
        assert robot.presence().at_rest is True
        # On a busy machine the stream stutters, and the robot's own watchdog stops it in between.
        assert -0.26 < x_m(odometry) - before < -0.05
    assert {line.split()[0] for line in omni.actuations("omni")[begun:]} == {"drive"}


async def test_a_robot_that_falls_silent_is_stopped_by_its_own_watchdog(clock: SystemClock) -> None:
    async with opened(shipped("omni"), clock) as robot:
        order = robot.order(
            "drive", {"linear": -0.2, "lateral": 0.0, "angular": 0.0, "duration": 0.5}
        )
        rest = await robot.fall_silent(order, lambda _report: None)
        assert rest.confirmed
        assert 0.3 < rest.seconds < 1.5 * patience(), "the watchdog of this robot takes 0.5 s"


async def test_a_measuring_of_the_watchdog_that_is_called_off_ends_at_rest(
    omni: Simulated, clock: SystemClock, odometry: LatestMessage
) -> None:
    """Its last word is of before it began to move, and nothing but a stop ends it."""
    types, domain = TypeRegistry([SET_PARAMETERS]), omni.graph.domain_id
    async with await RosRuntime.open(types, node_name="saboteur", domain_id=domain) as saboteur:
        await set_fault(saboteur, "omni", "watchdog_s", 0.0)
        try:
            async with opened(shipped("omni"), clock) as robot:
                await until(lambda: robot.presence().at_rest is True)
                order = robot.order(
                    "drive", {"linear": -0.2, "lateral": 0.0, "angular": 0.0, "duration": 2.0}
                )

                def call_off(_report: StageReport) -> None:
                    measuring.cancel()  # as soon as the first velocity is out

                measuring = asyncio.create_task(robot.fall_silent(order, call_off))
                with pytest.raises(asyncio.CancelledError):
                    await measuring
                await odometry.newer(odometry.received + 10, timeout_s=30)
                assert await stands(odometry)
        finally:
            await set_fault(saboteur, "omni", "watchdog_s", 0.5)


async def test_a_stop_is_confirmed_only_at_rest(
    clock: SystemClock, odometry: LatestMessage
) -> None:
    async with opened(shipped("omni"), clock) as robot:
        running = await moving_fast(robot, odometry)
        rest = await robot.stop(Stop("omni", 1))
        standing = await stands(odometry)
        at = x_m(odometry)
        outcome = await asyncio.wait_for(running, 60 * pace())
        assert rest.confirmed
        assert rest.seconds > 0.1, "from this speed it takes longer to brake"
        assert standing
        assert outcome.ending is OrderEnding.CANCELLED
        assert 0 < outcome.facts["distance_m"] < 4.0
        await odometry.newer(odometry.received + 5, timeout_s=30)
        assert x_m(odometry) == pytest.approx(at, abs=0.002), "it stands where it was said to stand"
        again = await robot.stop(Stop("omni", 2))
        assert again.confirmed
        with pytest.raises(OrderVoid):
            await robot.do("move", NEAR)


async def test_a_stop_reaches_goals_of_another_gateway(
    clock: SystemClock, odometry: LatestMessage
) -> None:
    """As after a crash: the goal is not ours any more, and the robot still carries it out."""
    profile = shipped("omni")
    # Nothing but the cancelling of goals can stop it.
    bare = replace(profile, stop=None, skills={"move": profile.skills["move"]})
    async with opened(bare, SystemClock()) as other, opened(bare, clock) as robot:
        running = await moving(other)
        rest = await robot.stop(Stop("omni", 1))
        assert rest.confirmed
        assert await stands(odometry)
        assert (await asyncio.wait_for(running, 60 * pace())).ending is OrderEnding.CANCELLED


async def test_the_same_command_through_another_gateway_acts_once(
    omni: Simulated, clock: SystemClock
) -> None:
    """Its gate knows nothing of the command, as after a restored backup; the robot does."""
    before = len(omni.actuations("omni"))
    async with (
        opened(shipped("omni"), SystemClock()) as other,
        opened(shipped("omni"), clock) as robot,
    ):
        robot._salt = other._salt
        order = other.order("move", {"direction": "back", "distance": 0.02, "speed": 0.25})
        assert (await other.execute(order, lambda _report: None)).ending is OrderEnding.DONE
        outcome = await robot.execute(order, lambda _report: None)
        assert outcome.ending is OrderEnding.REFUSED
    assert len(omni.actuations("omni")) == before + 1


async def test_a_goal_that_takes_too_long_is_called_off(
    clock: SystemClock, odometry: LatestMessage
) -> None:
    profile = shipped("omni")
    move = profile.skills["move"]
    assert move.action is not None
    short = replace(move, action=replace(move.action, timeout_s=1.0))
    # A crowded machine may hold us up for longer than half a second, which is another matter.
    patient = replace(profile, skills={"move": short}, watchdog_s=60.0 * pace())
    async with opened(patient, clock) as robot:
        with pytest.raises(RobotUnreachable, match=r"omni was not done within 1 s and was told"):
            await robot.do("move", FAR)
        await until(lambda: speed_m_s(odometry) <= AT_REST_M_S)


async def test_closing_brings_what_is_under_way_to_rest(
    clock: SystemClock, odometry: LatestMessage
) -> None:
    async with opened(shipped("omni"), clock) as robot:
        running = await moving(robot)
        await robot.close()
        assert await stands(odometry)
        assert (await asyncio.wait_for(running, 60 * pace())).ending is OrderEnding.CANCELLED


class HeardLast:
    """A way to stop a robot that is slower than the others: the order has ended before it."""

    def __init__(self, link: ServiceLink, ended: asyncio.Future[Outcome]) -> None:
        self._link = link
        self._ended = ended
        self.ready = link.ready
        self.close = link.close

    async def call(self, values: Values, *, timeout_s: float, urgent: bool) -> RosObject:
        await asyncio.wait((self._ended,))
        return await self._link.call(values, timeout_s=timeout_s, urgent=urgent)


async def test_what_closing_cuts_short_has_not_failed(clock: SystemClock) -> None:
    """The robot's own stop is faster than the cancelling: its goal ends as aborted."""
    async with opened(shipped("omni"), clock) as robot:
        running = await moving(robot)
        calls: list[object] = [
            HeardLast(link, running) if link.name.endswith("/cancel_goal") else link
            for link in robot._stop_controller.calls
        ]
        robot._stop_controller.calls[:] = calls  # type: ignore[assignment]
        await robot.close()
        outcome = await asyncio.wait_for(running, 60 * pace())
    assert outcome.ending is OrderEnding.CANCELLED


async def test_a_refusal_carries_the_robots_reason(omni: Simulated, clock: SystemClock) -> None:
    begun = len(omni.actuations("omni"))
    async with opened(shipped("omni"), clock) as robot:
        running = await moving(robot, LONG)
        outcome = await robot.do("turn", {"direction": "left", "angle": 1.0})
        assert outcome.ending is OrderEnding.REFUSED
        assert outcome.note == "busy with move. Nothing was done."
        await robot.stop(Stop("omni", 1))
        await running
    assert len(omni.actuations("omni")) == begun + 1


# ---- the robot's side goes away ----


def impatient() -> Ros2Profile:
    profile = shipped("omni")
    return replace(profile, link=replace(profile.link, heartbeat_s=0.5), rest_timeout_s=1.0)


def at_once(profile: Ros2Profile) -> Disappearance:
    """It disappears as soon as it moves, before its software has told of that again and again."""
    return Disappearance(profile)


def told_of_often(profile: Ros2Profile) -> Disappearance:
    """Its software has told of the motion so often that its silence says something."""
    return Disappearance(profile, told=8)


def held_up(profile: Ros2Profile) -> Disappearance:
    """ROSIC itself stands still meanwhile, as on a machine that is too busy for it."""
    assert profile.watchdog_s is not None
    return Disappearance(profile, held_up_s=profile.watchdog_s + LOOK_EVERY_S + 0.3)


def looked_at_late(profile: Ros2Profile) -> Disappearance:
    """Its silence is longer than rest may go unmeasured before anybody asks for its last word."""
    return Disappearance(replace(profile, link=replace(profile.link, heartbeat_s=3.0)))


class Disappearance(NamedTuple):
    """What comes before and after a robot's side is killed: each order of events is legitimate.

    Attributes:
        told: So often its software has told of the motion before.
        held_up_s: For so long ROSIC stands still after it.
    """

    profile: Ros2Profile
    told: int = 0
    held_up_s: float = 0.0


# Whichever deadline is noticed first is named. All of them are over, so all of this is true.
DOUBT = r"omni was sent zero and told to stop; whether it rests could not be measured\."
WHY = "broken off because "
TRUE_OF_IT = re.compile(
    r"omni has not answered for (?P<unanswered>\d+(\.\d)?) s\."
    r"|omni: moved (?P<metres>\d\.\d\d) m by its odometry; broken off because ("
    r"it was not heard for (?P<unheard>\d+\.\d) s"
    r"|its motion was not measured for (?P<unmeasured>\d+\.\d) s"
    r"|its software told nothing of it for (?P<untold>\d+\.\d) s"
    rf"|ROSIC itself stood still for (?P<late>\d+\.\d) s)\. {DOUBT}"
)


def assert_true_of_it(
    said: str, profile: Ros2Profile, *, gone_s: float, under_way_s: float
) -> None:
    """See that what was said of a robot that disappeared is so, its numbers as well.

    Args:
        said: What was said.
        profile: The robot's, with the deadlines.
        gone_s: For how long it had been gone when it was said.
        under_way_s: How long before it was said the order was given.
    """
    found = TRUE_OF_IT.fullmatch(said)
    assert found is not None, said
    numbers = {name: float(number) for name, number in found.groupdict().items() if number}
    metres = numbers.pop("metres", 0.0)
    assert metres <= LONG_M_S * under_way_s + ROUNDED, said
    ((what, seconds),) = numbers.items()
    assert profile.at_rest is not None
    assert profile.watchdog_s is not None
    heartbeat_s, within_s = profile.link.heartbeat_s, profile.at_rest.within_s
    over_s = {
        "unanswered": heartbeat_s,
        "untold": heartbeat_s,
        "unheard": within_s,
        "unmeasured": within_s,
        "late": profile.watchdog_s,
    }
    # It moved by something heard at most `within_s` before it disappeared.
    assert over_s[what] - ROUNDED <= seconds <= gone_s + within_s + ROUNDED, said


@pytest.mark.parametrize("order", [at_once, told_of_often, held_up, looked_at_late])
async def test_a_robot_that_disappears_at_work_leaves_doubt_and_cannot_confirm_a_stop(
    order: Callable[[Ros2Profile], Disappearance],
    graph: RosGraph,
    clock: SystemClock,
    tmp_path: Path,
) -> None:
    profile, told, held_up_s = order(impatient())
    told_of: list[StageReport] = []
    with simulated(graph, tmp_path, "omni") as simulation:
        async with opened(profile, clock) as robot:
            await until(lambda: robot.presence().at_rest is True)
            given = time.monotonic()
            move = robot.execute(robot.order("move", LONG), told_of.append)
            running = asyncio.create_task(move)
            await until(lambda: robot.presence().at_rest is False or running.done())
            await until(lambda: len(told_of) >= told or running.done())
            assert not running.done(), running
            begun = time.monotonic()
            simulation.process.kill()
            time.sleep(held_up_s)  # noqa: ASYNC251 - it is the loop itself that is held up
            with pytest.raises(RobotUnreachable) as raised:
                await asyncio.wait_for(running, 60 * pace())
            now = time.monotonic()
            assert_true_of_it(
                str(raised.value), profile, gone_s=now - begun, under_way_s=now - given
            )
            assert now - begun < 6.0 * patience()
            await until(lambda: robot.presence().online is False)
            ages_s = robot.presence().ages_s
            assert ages_s.keys() == robot.presence().values.keys()
            assert min(ages_s.values()) > profile.link.heartbeat_s, "told as if they were of now"
            assert time.monotonic() - begun < 6.0 * patience()
            rest = await robot.stop(Stop("omni", 1))
            assert not rest.confirmed
            assert 0.9 < rest.seconds < 2.5 * patience()
            assert robot.gate.latched


@pytest.mark.parametrize(
    "lie",
    [
        "omni is not there. Nothing was sent.",
        "omni has not answered for 0.1 s.",
        "omni has not answered for 9.0 s.",
        f"omni: moved 3.90 m by its odometry; {WHY}it was not heard for 1.1 s. {DOUBT}",
        f"omni: moved 0.01 m by its odometry; {WHY}it came to rest by itself. {DOUBT}",
        f"omni: moved 0.01 m by its odometry; {WHY}it was not there any more. {DOUBT}",
        "omni was sent zero and told to stop, and still moves.",
    ],
)
def test_what_is_not_so_is_not_taken_for_the_truth(lie: str) -> None:
    with pytest.raises(AssertionError):
        assert_true_of_it(lie.replace("\\", ""), impatient(), gone_s=1.5, under_way_s=3.0)


async def test_a_robot_that_hangs_does_not_confirm(
    graph: RosGraph, clock: SystemClock, tmp_path: Path
) -> None:
    with simulated(graph, tmp_path, "omni") as simulation:
        async with opened(impatient(), clock) as robot:
            running = await moving(robot)
            simulation.process.process.send_signal(signal.SIGSTOP)
            try:
                rest = await robot.stop(Stop("omni", 1))
                assert not rest.confirmed
                with pytest.raises(RobotUnreachable):
                    await asyncio.wait_for(running, 60 * pace())
            finally:
                simulation.process.process.send_signal(signal.SIGCONT)
            # The stop that had waited for it, or a later one, is obeyed once it runs again.
            async with asyncio.timeout(60 * pace()):
                while not (await robot.stop(Stop("omni", 2))).confirmed:  # noqa: ASYNC110
                    await asyncio.sleep(0.05)


async def test_an_absent_robot_is_not_there_and_comes_later(
    graph: RosGraph, clock: SystemClock, tmp_path: Path
) -> None:
    async with opened(impatient(), clock) as robot:
        assert robot.presence().online is False
        with pytest.raises(RobotOffline, match=r"^omni is not there\. Nothing was sent\.$"):
            await robot.do("move", NEAR)
        rest = await robot.stop(Stop("omni", 1))
        assert not rest.confirmed
        await robot.resume(1)
        with simulated(graph, tmp_path, "omni"):
            await until(lambda: robot.presence().online is True)
            assert (await robot.do("move", NEAR)).ending is OrderEnding.DONE
