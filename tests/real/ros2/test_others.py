"""Robots as others build them, in a process of their own: Nav2, and an arm with ros2_control."""

from __future__ import annotations

import asyncio
from contextlib import aclosing
from math import pi
from typing import TYPE_CHECKING, Any

import pytest

from rosic.core.order import OrderEnding, OrderStage, Outcome, StageReport, Stop
from rosic.core.robot.view import OccupancyMap, ViewKind
from rosic.errors import OrderVoid, RobotOffline
from rosic.robots.ros2.client.graph import wait_for
from rosic.robots.ros2.client.runtime import RosRuntime
from rosic.robots.ros2.interfaces.cache import KNOWN, ensure_built, make_importable
from rosic.robots.ros2.messages.types import TypeRegistry
from rosic.system import SystemClock
from rosic.testing.ros2.graph import RosGraph
from tests.pace import pace
from tests.real.ros2.simulated import Simulated, TriedRobot, opened, shipped, simulated, until

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Iterator

    from rosic.core.robot.skill import Argument
    from rosic.robots.ros2.client.topics import LatestMessage

ODOMETRY, JOINTS = "nav_msgs/msg/Odometry", "sensor_msgs/msg/JointState"

pytestmark = [pytest.mark.usefixtures("others"), pytest.mark.limit(240)]


@pytest.fixture
def clock() -> SystemClock:
    return SystemClock()


@pytest.fixture(scope="module")
def others(tmp_path_factory: pytest.TempPathFactory, interfaces: object) -> Iterator[Simulated]:  # noqa: ARG001 - built before
    for package in KNOWN.values():
        ensure_built(package)
        make_importable(package)
    folder = tmp_path_factory.mktemp("others")
    with RosGraph(folder) as graph, simulated(graph, folder, "rover", "picker") as simulation:
        yield simulation


@pytest.fixture
async def onlooker(others: Simulated) -> AsyncIterator[RosRuntime]:
    """Somebody else on the graph, who has nothing to do with the robot under test."""
    types, domain = TypeRegistry([ODOMETRY, JOINTS]), others.graph.domain_id
    async with await RosRuntime.open(types, node_name="onlooker", domain_id=domain) as runtime:
        yield runtime


@pytest.fixture
async def rover(clock: SystemClock) -> AsyncIterator[TriedRobot]:
    async with opened(shipped("rover"), clock) as robot:
        yield robot


@pytest.fixture
async def picker(clock: SystemClock) -> AsyncIterator[TriedRobot]:
    async with opened(shipped("picker"), clock) as robot:
        yield robot


class CarriedOrder:
    """The life of one order, as it was told."""

    def __init__(self, robot: TriedRobot, skill: str, arguments: dict[str, Argument]) -> None:
        self.reports: list[StageReport] = []
        self.task = asyncio.create_task(self._carry_out(robot, skill, arguments))

    @property
    def fraction(self) -> float:
        return max((r.fraction or 0.0 for r in self.reports), default=0.0)

    async def _carry_out(
        self, robot: TriedRobot, skill: str, arguments: dict[str, Argument]
    ) -> Outcome:
        """Ask for it once everything of the robot was found: before that nothing is sent."""
        async with asyncio.timeout(60 * pace()):
            while True:
                try:
                    return await robot.execute(robot.order(skill, arguments), self.reports.append)
                except RobotOffline:
                    await asyncio.sleep(0.05)

    def stages(self) -> list[OrderStage]:
        return list(dict.fromkeys(report.stage for report in self.reports))

    async def under_way(self, fraction: float = 0.02) -> None:
        await until(lambda: self.fraction > fraction or self.task.done(), timeout_s=30)
        assert not self.task.done(), self.task.result()

    async def end(self) -> Outcome:
        async with asyncio.timeout(60 * pace()):
            return await self.task


async def do(robot: TriedRobot, skill: str, arguments: dict[str, Argument]) -> Outcome:
    return await CarriedOrder(robot, skill, arguments).end()


def place_of(rover: TriedRobot) -> tuple[float, float]:
    """Return where the rover says it is, once it has said so anew."""
    found = rover.presence().pose
    assert found is not None
    return found.x_m, found.y_m


# ---- Nav2 ----


async def test_a_nav2_robot_goes_to_a_point_and_says_how_far_it_is(rover: TriedRobot) -> None:
    carried = CarriedOrder(rover, "goto", {"x": -0.6, "y": 0.5, "yaw": pi / 2})
    outcome = await carried.end()

    assert outcome.ending is OrderEnding.DONE, outcome
    assert carried.stages() == [OrderStage.SENT, OrderStage.RECEIVED, OrderStage.RUNNING]
    fractions = [r.fraction for r in carried.reports if r.fraction is not None]
    assert fractions == sorted(fractions)
    assert any(0.1 < f < 0.9 for f in fractions)
    assert place_of(rover) == pytest.approx((-0.6, 0.5), abs=0.05)
    pose = rover.presence().pose
    assert pose is not None
    assert pose.yaw_rad == pytest.approx(pi / 2, abs=0.05)


async def test_a_place_of_the_profile_is_where_it_says(rover: TriedRobot) -> None:
    outcome = await do(rover, "visit", {"place": "dock"})

    assert outcome.ending is OrderEnding.DONE, outcome
    assert place_of(rover) == pytest.approx((0.0, 0.0), abs=0.05)


async def test_where_no_way_leads_it_fails_with_its_own_words(rover: TriedRobot) -> None:
    outcome = await do(rover, "goto", {"x": 1.2, "y": 0.0, "yaw": 0.0})

    assert outcome.ending is OrderEnding.FAILED
    assert outcome.note.startswith(
        "there is no way to 1.20, 0.00"
    )  # and what else there was to say


async def test_a_stop_brings_it_to_measured_rest_and_voids_what_was_meant(
    rover: TriedRobot, onlooker: RosRuntime
) -> None:
    odometry = await onlooker.latest("/rover/odom", ODOMETRY)
    carried = CarriedOrder(rover, "goto", {"x": -3.0, "y": -2.0, "yaw": 0.0})
    await carried.under_way()

    rest = await rover.stop(Stop("rover", rover.gate.generation + 1))

    assert rest.confirmed
    assert (await carried.end()).ending is OrderEnding.CANCELLED
    await odometry.newer(odometry.received, timeout_s=5 * pace())
    message: Any = odometry.message()
    twist = message.twist.twist
    assert abs(twist.linear.x) < 0.01
    assert abs(twist.angular.z) < 0.01
    await rover.resume(rover.gate.generation)


async def test_an_order_that_is_given_up_brings_it_to_rest(rover: TriedRobot) -> None:
    carried = CarriedOrder(rover, "goto", {"x": -3.0, "y": 2.0, "yaw": 0.0})
    await carried.under_way()

    carried.task.cancel()
    with pytest.raises(asyncio.CancelledError):
        await carried.task

    assert rover.presence().at_rest is True


async def test_a_goal_that_somebody_else_sends_ends_ours_as_failed(
    rover: TriedRobot, clock: SystemClock
) -> None:
    """Nav2 takes the newest goal: whoever sends one past ROSIC takes the robot, and it is said."""
    carried = CarriedOrder(rover, "goto", {"x": -3.0, "y": 2.0, "yaw": 0.0})
    await carried.under_way()
    async with opened(shipped("rover"), clock) as another:
        outcome = await do(another, "visit", {"place": "dock"})
        assert outcome.ending is OrderEnding.DONE, outcome
    assert (await carried.end()).ending is OrderEnding.FAILED


async def test_battery_map_way_and_place_are_seen(rover: TriedRobot) -> None:
    await until(lambda: "battery" in rover.presence().values)
    assert 50 < float(rover.presence().values["battery"]) <= 90
    # What its localisation keeps is asked for once the graph shows that it keeps anything.
    await until(lambda: rover.presence().pose is not None)
    async with asyncio.timeout(60 * pace()), aclosing(rover.look(ViewKind.MAP)) as views:
        seen = (await anext(views)).content
    assert isinstance(seen, OccupancyMap)
    assert (seen.width, seen.height) == (100, 80)
    assert seen.pose is not None
    assert seen.pose.frame == seen.origin.frame == "map"


async def test_what_the_profiles_name_is_on_the_graph(onlooker: RosRuntime) -> None:
    skills = [skill for name in ("rover", "picker") for skill in shipped(name).skills.values()]
    wanted = {(s.action.name, s.action.type) for s in skills if s.action is not None}
    assert len(wanted) == 3
    await wait_for(
        onlooker,
        lambda seen: wanted <= {(offer.name, offer.types[0]) for offer in seen.actions},
        timeout_s=60 * pace(),  # who is found last waits for the discovery of all others
    )


# ---- an arm ----


async def joints_of(onlooker: RosRuntime) -> dict[str, tuple[float, float]]:
    states = await onlooker.latest("/picker/joint_states", JOINTS)
    await states.newer(states.received + 2, timeout_s=10 * pace())
    message: Any = states.message()
    both = zip(message.position, message.velocity, strict=True)
    return dict(zip(message.name, both, strict=True))


async def test_an_arm_goes_to_a_pose_no_faster_than_its_share(
    picker: TriedRobot, onlooker: RosRuntime
) -> None:
    fastest: list[float] = []

    def see(latest: LatestMessage) -> None:
        message: Any = latest.message()
        fastest.append(max(map(abs, message.velocity)))

    states = await onlooker.latest("/picker/joint_states", JOINTS, on_new=see)
    await states.newer(0, timeout_s=10 * pace())
    carried = CarriedOrder(picker, "pose", {"pose": "ready", "speed": 0.4})
    outcome = await carried.end()

    assert outcome.ending is OrderEnding.DONE, outcome
    assert carried.stages() == [OrderStage.SENT, OrderStage.RECEIVED, OrderStage.RUNNING]
    assert any(0.1 < (r.fraction or 0.0) < 0.9 for r in carried.reports)
    found = await joints_of(onlooker)
    profile = shipped("picker")
    wanted = profile.skills["pose"].parameters["pose"].means["ready"]["joints"]
    assert profile.joints is not None
    there = tuple(found[name][0] for name in profile.joints.limits)
    assert there == pytest.approx(wanted, abs=0.01)
    assert 0.1 < max(fastest) <= 0.4 * 2.0 * 1.1


async def test_one_joint_moves_and_the_others_stay(
    picker: TriedRobot, onlooker: RosRuntime
) -> None:
    before = await joints_of(onlooker)
    outcome = await do(picker, "joint", {"joint": "elbow_joint", "angle": 1.2})
    after = await joints_of(onlooker)

    assert outcome.ending is OrderEnding.DONE, outcome
    assert after["elbow_joint"][0] == pytest.approx(1.2, abs=0.01)
    others = before.keys() - {"elbow_joint"}
    assert [after[n][0] for n in others] == pytest.approx([before[n][0] for n in others], abs=1e-3)


async def test_a_joint_does_not_go_further_than_the_profile_lets_it(
    picker: TriedRobot, others: Simulated
) -> None:
    before = others.actuations("picker")
    outcome = await do(picker, "joint", {"joint": "shoulder_lift_joint", "angle": 0.5})

    assert outcome.ending is OrderEnding.REFUSED
    assert outcome.note == (
        "shoulder_lift_joint goes from -3.14 to 0.00 rad only. Nothing was done."
    )
    assert others.actuations("picker") == before


async def test_a_stop_holds_the_arm_where_it_is(picker: TriedRobot, onlooker: RosRuntime) -> None:
    await do(picker, "pose", {"pose": "home", "speed": 1.0})
    carried = CarriedOrder(picker, "pose", {"pose": "stow", "speed": 0.1})
    await carried.under_way()

    rest = await picker.stop(Stop("picker", picker.gate.generation + 1))

    assert rest.confirmed
    assert (await carried.end()).ending is OrderEnding.CANCELLED
    found = await joints_of(onlooker)
    assert max(abs(speed) for _, speed in found.values()) < 0.005
    assert found["elbow_joint"][0] < 2.4, "it did not go on to the pose"
    late = picker.book.order("pose", {"pose": "home", "speed": 0.3}, stop_generation=0)
    with pytest.raises(OrderVoid):
        await picker.execute(late, lambda _report: None)
    await picker.resume(picker.gate.generation)


async def test_a_gripper_that_closes_on_something_holds_it(
    picker: TriedRobot, onlooker: RosRuntime
) -> None:
    held = await do(picker, "grip", {"force": 15.0})
    width = (await joints_of(onlooker))["finger_joint"][0]
    opened_again = await do(picker, "release", {})

    assert held.ending is OrderEnding.DONE, held
    assert width == pytest.approx(0.03, abs=1e-3)
    assert opened_again.ending is OrderEnding.DONE, opened_again
