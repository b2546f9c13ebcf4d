"""The page in a real browser, and a robot on a real ROS 2 graph: from the press to the wheels."""

from __future__ import annotations

import asyncio
import signal
import time
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple, cast

import pytest
from playwright.async_api import expect

from rosic.config.plugins import robot_factory
from rosic.robots.ros2.robot import Ros2Robot
from rosic.testing.ros2.graph import RosGraph
from tests.api.served import served
from tests.console.browser import DESK, chromium, opened
from tests.console.cable import cable
from tests.pace import pace, patience
from tests.real.ros2.simulated import Simulated, shipped, simulated, until

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Iterator

    from rosic.contracts.adapter import RobotFactory
    from rosic.core.order import RestReport, Stop
    from rosic.testing.ros2.graph import RosProcess
    from tests.api.served import ServedGateway
    from tests.console.browser import OpenPage
    from tests.console.cable import Cable

pytestmark = pytest.mark.limit(300)
LISTENER = Path(__file__).with_name("odometry_listener.py")
HANDED_WITHIN_S = 0.1
REST_WITHIN_S = 0.3
MOVES = 0.02
STOPPED_AT: list[float] = []
"""When the robot's adapter was handed a stop: seconds of the wall clock."""


class NotingRos2Robot(Ros2Robot):
    """A robot on a graph that notes when it is handed a stop."""

    async def stop(self, stop: Stop) -> RestReport:
        STOPPED_AT.append(time.time())
        return await super().stop(stop)


def noting(kind: str) -> RobotFactory:
    return cast("RobotFactory", NotingRos2Robot) if kind == "ros2" else robot_factory(kind)


class Odometry(NamedTuple):
    """What the robot itself says of how fast it is."""

    listener: RosProcess

    def since(self, wall_s: float) -> list[tuple[float, float]]:
        """Return [seconds of the wall clock, speed] of what came since."""
        each = [line.split() for line in list(self.listener.lines) if line[:1].isdigit()]
        told = [(int(at) / 1e9, float(speed)) for at, speed in each]
        return [(at_s, speed) for at_s, speed in told if at_s >= wall_s]

    async def moves(self, wall_s: float) -> None:
        await until(lambda: any(speed > MOVES for _, speed in self.since(wall_s)))

    async def rested_at(self, wall_s: float) -> float:
        """Return when it was last seen to move, once it has not for a while."""
        await until(
            lambda: (
                len(told := self.since(time.time() - 1.0)) > 5
                and all(speed < MOVES for _, speed in told)
            )
        )
        return max((at_s for at_s, speed in self.since(wall_s) if speed >= MOVES), default=wall_s)


class Scene(NamedTuple):
    """A person at the page, and the robot."""

    place: ServedGateway
    there: OpenPage
    cable: Cable
    odometry: Odometry
    robot: Simulated


@pytest.fixture(scope="module")
def robot(
    tmp_path_factory: pytest.TempPathFactory,
    interfaces: Path,  # noqa: ARG001 - built before
) -> Iterator[tuple[Simulated, Odometry]]:
    folder = tmp_path_factory.mktemp("console")
    with RosGraph(folder) as graph, simulated(graph, folder, "omni") as robot:
        yield robot, Odometry(graph.start(LISTENER, "/omni/odom"))


@pytest.fixture
async def scene(robot: tuple[Simulated, Odometry]) -> AsyncIterator[Scene]:
    STOPPED_AT.clear()
    async with (
        served(profiles=(shipped("omni"),), robots_of=noting) as place,
        cable(place.server.port) as link,
        chromium() as browser,
        opened(browser, place, DESK, url=link.url) as there,
    ):
        await until(lambda: place.gateway.rooms.linker.presence("omni").online is True)
        await there.sign_in()
        await there.go("drive/omni")
        await expect(there.page.get_by_role("application")).to_be_visible()
        yield Scene(place, there, link, robot[1], robot[0])


def done(scene: Scene, number: int) -> bool:
    orders = list(scene.place.server.context.feed.newest())
    return len(orders) == number and orders[0].ending == "done"


async def test_a_form_and_a_line_move_it(scene: Scene) -> None:
    _, there, _, odometry, _ = scene
    page = there.page
    form = page.get_by_role("form", name="Move in a straight line")
    await form.get_by_label("Distance").fill("0.1")
    await form.get_by_label("Direction").select_option("left")
    begun_s = time.time()
    await form.get_by_role("button", name="Give the order").click()
    row = page.locator("table.orders tbody tr").first
    await expect(row.locator(".received")).to_contain_text("move, 0.10 m left")
    await odometry.moves(begun_s)
    await until(lambda: done(scene, 1))
    await expect(row).to_contain_text("done")
    await there.say("omni turn left 10")
    await expect(row.locator(".received")).to_contain_text("turn, 10 deg left")
    await until(lambda: done(scene, 2))


async def test_a_stop_is_at_the_robot_at_the_press(scene: Scene) -> None:
    place, there, _, odometry, _ = scene
    page = there.page
    begun_s = time.time()
    await there.say("omni move 3 m forward")
    await odometry.moves(begun_s)
    await page.evaluate(
        "addEventListener('keydown', () => { window.pressed = Date.now(); }, true);"
    )
    await page.locator("#main-part").focus()
    await page.keyboard.press("Space")
    await until(lambda: bool(STOPPED_AT))
    await expect(page.locator(".stop-said strong")).to_have_text("At rest")
    pressed_s = await page.evaluate("window.pressed") / 1000
    assert STOPPED_AT[0] - pressed_s < HANDED_WITHIN_S * patience()
    rested_s = await odometry.rested_at(pressed_s)
    assert rested_s - pressed_s < 2.0 * patience()
    assert place.gateway.rooms.stops["omni"].latched
    await there.picture("ros2-stopped")
    await there.say("resume omni")
    await until(lambda: not place.gateway.rooms.stops["omni"].latched)


@pytest.mark.parametrize("how", ["cable", "page"])
async def test_a_robot_in_hand_rests_when_the_page_is_cut_off_or_gone(
    scene: Scene, how: str
) -> None:
    place, there, link, odometry, _ = scene
    watchdog_s = place.gateway.rooms.profiles["omni"].watchdog_s
    assert watchdog_s is not None
    begun_s = time.time()
    await there.page.get_by_role("application").focus()
    await there.page.keyboard.down("ArrowUp")
    await odometry.moves(begun_s)
    await expect(there.page.locator(".jogging .said")).to_contain_text("Driving live")
    cut_s = time.time()
    if how == "cable":
        link.whole.clear()
    else:
        await there.kill()
    rested_s = await odometry.rested_at(cut_s)
    assert rested_s - cut_s < (watchdog_s + REST_WITHIN_S) * patience()
    if how == "page":
        return
    await expect(there.page.locator(".link")).to_contain_text("No connection to the gateway")
    link.whole.set()
    await there.connected()
    again_s = time.time()  # the arrow key is still held, and nothing goes on by itself
    await asyncio.sleep(0.5)
    assert all(speed < MOVES for _, speed in odometry.since(again_s))


async def test_what_a_robot_did_not_receive_stands_out(scene: Scene) -> None:
    _, there, _, _, robot = scene
    robot.process.process.send_signal(signal.SIGSTOP)
    try:
        await there.say("omni move 0.1 m left")
        row = there.page.locator("table.orders tbody tr").first
        await expect(row).to_have_class("mismatch", timeout=60_000 * pace())
        await expect(row.locator(".received")).to_contain_text("sent, and not received")
        await there.picture("ros2-mismatch")
    finally:
        robot.process.process.send_signal(signal.SIGCONT)
