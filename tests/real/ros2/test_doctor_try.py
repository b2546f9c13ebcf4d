"""`rosic doctor --try` on a robot that is a process of its own on a ROS 2 graph."""

from __future__ import annotations

import asyncio
import re
from typing import TYPE_CHECKING

import pytest

from rosic.app.config import load_config
from rosic.app.setup.diagnostics_checks import DiagnosticFinding, FindingVerdict
from rosic.app.setup.stop_test import try_robot
from rosic.robots.ros2.bindings.parameters import SET_PARAMETERS
from rosic.robots.ros2.client.runtime import RosRuntime
from rosic.robots.ros2.messages.types import TypeRegistry
from rosic.system import SystemClock, SystemEntropy
from rosic.testing.ros2.graph import RosGraph
from tests.cli.running import rosic, write_config
from tests.pace import patience
from tests.real.ros2.simulated import Simulated, set_fault, simulated, until

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Iterator
    from pathlib import Path

    from rosic.robots.ros2.client.topics import LatestMessage, Publisher

ODOMETRY = "nav_msgs/msg/Odometry"
OMNI = """
[[messenger]]
kind = "terminal"

[[principal]]
name = "Ada"
address = "terminal:{uid}"
role = "admin"

[[robot]]
profile = "omni"
"""
STOPPED = re.compile(r"stop: at rest after (\d+\.\d\d) s \(from a slow drive\)")
BARKED = re.compile(
    r"watchdog: (at rest|not seen at rest) (\d+\.\d\d) s after the last message; "
    r"the profile says 0.5 s(, and 0.5 s to come to rest is usual: good|: too late; .*)"
)

pytestmark = [pytest.mark.usefixtures("omni"), pytest.mark.limit(240)]


@pytest.fixture(scope="module")
def omni(tmp_path_factory: pytest.TempPathFactory, interfaces: Path) -> Iterator[Simulated]:  # noqa: ARG001 - built before
    folder = tmp_path_factory.mktemp("omni")
    with RosGraph(folder) as graph, simulated(graph, folder, "omni") as simulation:
        yield simulation


@pytest.fixture
async def onlooker(omni: Simulated) -> AsyncIterator[RosRuntime]:
    """Somebody else on the graph, who mends afterwards what a test has broken."""
    types = TypeRegistry([ODOMETRY, SET_PARAMETERS])
    domain = omni.graph.domain_id
    async with await RosRuntime.open(types, node_name="onlooker", domain_id=domain) as runtime:
        yield runtime
        await set_fault(runtime, "omni", "watchdog_s", 0.5)
        await set_fault(runtime, "omni", "battery", 1.0)


async def tried(folder: Path) -> tuple[DiagnosticFinding, DiagnosticFinding]:
    """Try it; return what was found of its stop, and of its watchdog."""
    config = load_config(write_config(folder, OMNI))
    stop, watchdog, _ = [f async for f in try_robot(config, "omni", SystemClock(), SystemEntropy())]
    return stop, watchdog


def watched(finding: DiagnosticFinding) -> tuple[str, float]:
    """Return what a finding says of the watchdog: how it ended, and the seconds."""
    said = BARKED.fullmatch(finding.text)
    assert said is not None, finding.text
    assert said[3].endswith("good") == (finding.verdict is FindingVerdict.GOOD)
    return said[1], float(said[2])


async def test_its_stop_and_its_watchdog_are_measured(tmp_path: Path, omni: Simulated) -> None:
    before = len(omni.actuations("omni"))

    stop, watchdog = await tried(tmp_path)

    assert (stop.verdict, watchdog.verdict) == (FindingVerdict.GOOD, FindingVerdict.GOOD)
    measured = STOPPED.fullmatch(stop.text)
    assert measured is not None, stop.text
    assert 0.02 < float(measured[1]) < 1.0 * patience()
    how, seconds = watched(watchdog)
    assert how == "at rest"
    assert 0.4 < seconds < 1.0 * patience()
    assert len(omni.actuations("omni")) == before + 2


async def test_a_robot_without_a_watchdog_is_seen_to_go_on_and_is_stopped(
    tmp_path: Path, onlooker: RosRuntime
) -> None:
    await set_fault(onlooker, "omni", "watchdog_s", 0.0)
    odometry = await onlooker.latest("/omni/odom", ODOMETRY)

    _, watchdog = await tried(tmp_path)

    assert watchdog.verdict is FindingVerdict.LOOK
    how, seconds = watched(watchdog)
    assert how == "not seen at rest"
    assert seconds >= 5.0
    await until(lambda: speed_m_s(odometry.message()) == 0.0)


async def test_a_watchdog_slower_than_its_profile_says_is_looked_at(
    tmp_path: Path, onlooker: RosRuntime
) -> None:
    await set_fault(onlooker, "omni", "watchdog_s", 2.0)

    _, watchdog = await tried(tmp_path)

    assert watchdog.verdict is FindingVerdict.LOOK
    how, seconds = watched(watchdog)
    assert how == "at rest"
    assert 1.8 < seconds < 3.0 * patience()
    written = float(watchdog.text.rpartition(", or write watchdog_s: ")[2])
    # Shown to a hundredth; written is the next tenth of what was measured.
    assert -0.0051 < written - seconds < 0.1051


async def test_a_robot_that_is_not_measured_to_move_is_looked_at_and_stays_stopped(
    tmp_path: Path, onlooker: RosRuntime
) -> None:
    await set_fault(onlooker, "omni", "battery", 0.01)
    config = load_config(write_config(tmp_path, OMNI))

    found = [f async for f in try_robot(config, "omni", SystemClock(), SystemEntropy())]

    stop, watchdog, stays = found
    assert {finding.verdict for finding in found} == {FindingVerdict.LOOK}
    assert "(it was sent velocities, and not measured to move)" in stop.text
    assert watchdog.text == "watchdog: it was sent velocities, and not measured to move"
    assert stays.text.startswith("it stays stopped")


async def test_a_robot_whose_rest_several_report_is_not_moved(
    tmp_path: Path, omni: Simulated
) -> None:
    types, domain = TypeRegistry([ODOMETRY]), omni.graph.domain_id
    before, found = 0, list[DiagnosticFinding]()
    async with await RosRuntime.open(types, node_name="second", domain_id=domain) as second:
        odometry = await second.publisher("/omni/odom", ODOMETRY)
        own = await second.latest("/omni/odom", ODOMETRY)
        await own.newer(0, timeout_s=60)
        telling = asyncio.create_task(tell_again_and_again(odometry, own))
        for number in range(5):  # where the processors are busy, the second may be found late
            before = len(omni.actuations("omni"))
            (folder := tmp_path / str(number)).mkdir()
            config = load_config(write_config(folder, OMNI))
            found = [f async for f in try_robot(config, "omni", SystemClock(), SystemEntropy())]
            assert found[0].verdict is FindingVerdict.LOOK
            if len(found) == 1:
                break
        telling.cancel()

    text = "whether it rests is not measured: more than one program reports it; it was not moved"
    assert found == [DiagnosticFinding("omni", FindingVerdict.LOOK, text)]
    assert len(omni.actuations("omni")) == before


async def tell_again_and_again(odometry: Publisher, own: LatestMessage) -> None:
    """Report what the robot itself reports: nothing but a second one speaks against it."""
    while True:
        message = own.message()
        assert message is not None
        pose = message.pose.pose
        odometry.publish(
            {
                "pose.pose.position.x": pose.position.x,
                "pose.pose.position.y": pose.position.y,
                "pose.pose.orientation.z": pose.orientation.z,
                "pose.pose.orientation.w": pose.orientation.w,
            }
        )
        await asyncio.sleep(0.1)


async def test_the_command_says_so_line_by_line(tmp_path: Path, omni: Simulated) -> None:
    config = write_config(tmp_path, OMNI)

    ran = await asyncio.to_thread(
        rosic, "doctor", "-c", config, "--try", "omni", env=omni.graph.environment
    )

    assert ran.err == ""
    *_, stop, watchdog, _ = ran.out.splitlines()
    assert re.fullmatch(r"omni +stop: at rest after \d+\.\d\d s \(from a slow drive\)", stop)
    assert re.fullmatch(r"omni +watchdog: at rest \d+\.\d\d s after the last message; .*", watchdog)


def speed_m_s(message: object) -> float | None:
    """Return how fast odometry says that it is; None before the first word."""
    if message is None:
        return None
    linear = message.twist.twist.linear  # type: ignore[attr-defined]
    return float(abs(linear.x) + abs(linear.y))
