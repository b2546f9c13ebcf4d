"""One command, all the way: the fake server, `rosic run`, and the robots as ROS 2 nodes.

Output is captured by `capfd`, as rclpy needs a standard error that is a file.
"""

from __future__ import annotations

import subprocess
import sys
from contextlib import contextmanager
from typing import TYPE_CHECKING

import pytest

from rosic.robots.ros2.interfaces.cache import ensure_built, make_importable
from rosic.testing.ros2.graph import why_missing
from tests.journeys.hops import hop_report, hops_of, newest_sent_s
from tests.journeys.lab import Lab, lab
from tests.journeys.ros import MOVING_M_S, Onlooker, onlooker
from tests.journeys.running import LISTENING, ROOT, environment
from tests.journeys.test_single import check_life, press, report

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping
    from pathlib import Path

    from tests.journeys.running import Launcher

OMNI = ['[[robot]]\nprofile = "omni"']
WITHIN_M = 0.01

pytestmark = [
    pytest.mark.limit(480),
    pytest.mark.skipif(why_missing() is not None, reason=why_missing() or ""),
]


@pytest.fixture(scope="module", autouse=True)
def _interfaces() -> None:
    make_importable()
    ensure_built()


@contextmanager
def rosic_run(place: Lab) -> Iterator[subprocess.Popen[bytes]]:
    """Run the real command while inside, with a log that says when an order is sent."""
    config = place.config.read_text()
    place.config.write_text(config.replace("[gateway]", '[gateway]\nlog_level = "debug"'))
    with (place.folder / "gateway.log").open("wb") as log:
        process = subprocess.Popen(  # noqa: S603 - our own command
            [sys.executable, "-m", "rosic", "run", "-c", str(place.config)],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=log,
            cwd=ROOT,
            env={**environment(), **place.environment},
        )
        try:
            yield process
        finally:
            process.kill()
            process.wait()


async def listens(place: Lab) -> None:
    log = place.folder / "gateway.log"
    assert await place.until(lambda: LISTENING in log.read_text(), 120), log.read_text()


async def test_a_message_moves_a_ros_2_robot(
    tmp_path: Path, launcher: Launcher, capfd: pytest.CaptureFixture[str]
) -> None:
    async with (
        onlooker(tmp_path, "omni") as (looking, variables),
        lab(tmp_path, launcher, robots=OMNI) as place,
    ):
        place.environment = variables
        with rosic_run(place):
            await listens(place)
            await is_there(place, looking)
            before_m = looking.places[-1].x_m

            card = await place.ask(place.bo, "omni move forward 0.5 m", "done ")

            await check_moved(place, looking, before_m)
            check_life(card)
            [begun] = [
                change
                for change in await place.control.call("changes", kinds=["said"])
                if change["message_id"] == card["reply_to"]
            ]
            hops = await hops_of(place, begun, card["message_id"], robot_side(place, looking))
            report(capfd, hop_report("omni move forward 0.5 m, as a message, over ROS 2", hops))
            check_way(hops)
            assert await place.control.violations() == []


async def test_buttons_alone_move_a_ros_2_robot(
    tmp_path: Path, launcher: Launcher, capfd: pytest.CaptureFixture[str]
) -> None:
    async with (
        onlooker(tmp_path, "omni") as (looking, variables),
        lab(tmp_path, launcher, robots=OMNI) as place,
    ):
        place.environment = variables
        with rosic_run(place):
            await listens(place)
            await is_there(place, looking)
            before_m = looking.places[-1].x_m

            menu = await place.ask(place.bo, "/start", "What should omni do?")
            under = menu["message_id"]
            await press(place, under, "🚗 Move in a straight line", "0.50 m forward?")
            await place.control.tap(place.bo, place.bo, under, "Do it")
            card = await place.reads(place.bo, "done ")

            await check_moved(place, looking, before_m)
            check_life(card)
            begun = (await place.control.call("changes", kinds=["pressed"]))[-1]
            hops = await hops_of(place, begun, card["message_id"], robot_side(place, looking))
            report(capfd, hop_report("omni move 0.5 m, with buttons alone, over ROS 2", hops))
            check_way(hops)


async def is_there(place: Lab, looking: Onlooker) -> None:
    """Wait until the gateway has heard the robot, and so has whoever looks on."""

    async def heard() -> bool:
        told = await place.ask(place.ada, "status omni", "omni: ")
        return "at rest" in told["text"]

    assert await place.until(heard)
    assert await place.until(lambda: looking.places)


async def check_moved(place: Lab, looking: Onlooker, before_m: float) -> None:
    """The robot's own odometry says so, to everybody."""
    assert await place.until(lambda: not looking.moves)
    assert looking.places[-1].x_m - before_m == pytest.approx(0.5, abs=WITHIN_M)
    assert len(looking.robots.actuations("omni")) == 1


def check_way(hops: Mapping[str, float]) -> None:
    """Nothing was sent before it was on disk, and nothing received before it was sent."""
    way = ("claimed on disk", "sent to the robot", "received by the robot", "seen to move")
    assert [hop for hop in hops if hop in way] == list(way)


def robot_side(place: Lab, looking: Onlooker) -> dict[str, float]:
    """Return when the last move was sent, and what the robot's side saw of it, in Unix seconds."""
    accepted_s = looking.accepted_s[-1]
    return {
        "sent to the robot": newest_sent_s(place.folder / "gateway.log", "omni", accepted_s),
        "received by the robot": accepted_s,
        "seen to move": looking.began_to_move_s(accepted_s),
        "seen at rest": next(
            earlier.at_s
            for earlier, later in zip(
                reversed(looking.places[1:]), reversed(looking.places[:-1]), strict=True
            )
            if later.speed_m_s > MOVING_M_S
        ),
    }
