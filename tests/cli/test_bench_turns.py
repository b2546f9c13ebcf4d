"""What the bench of fleets compares, it has seen in turns; a gateway that ended is no result."""

from __future__ import annotations

import sys
from contextlib import AsyncExitStack
from typing import TYPE_CHECKING

import pytest

from rosic.bench.load_generator import ReportedValues, RobotHeartbeat, frame
from rosic.bench.paired_runs import REPORTS, in_turns, times_as_much, waiting
from rosic.bench.reporting_robots import ReportDelivery, ReportingRobot
from rosic.bench.scaling_process import profile_of
from rosic.core.order_gate import OrderGate
from rosic.core.robot.view import Pose
from rosic.system import SystemClock

if TYPE_CHECKING:
    from pathlib import Path

ANSWERS = """
import sys
name, each, log, turns = sys.argv[1:]
print("seen", flush=True)
for at, _ in enumerate(sys.stdin):
    if at == int(turns):
        break
    with open(log, "a") as file:
        file.write(name)
    print(float(each) * at, flush=True)
"""


async def rows_of(log: Path, turns: int) -> list[list[float]]:
    """Return what two processes say in four turns after one; the second has only so many."""
    async with AsyncExitStack() as stack:
        several = [
            await stack.enter_async_context(
                waiting(sys.executable, "-c", ANSWERS, name, each, str(log), many)
            )
            for name, each, many in (("a", "2", "5"), ("b", "3", str(turns)))
        ]
        assert [await one.line() for one in several] == [b"seen\n", b"seen\n"]
        return await in_turns(several, REPORTS, 4, float)


async def test_processes_take_turns_and_are_compared_turn_for_turn(tmp_path: Path) -> None:
    first, second = await rows_of(tmp_path / "log", 5)

    assert (tmp_path / "log").read_text() == "ababababab"
    assert (first, second) == ([2.0, 4.0, 6.0, 8.0], [3.0, 6.0, 9.0, 12.0])
    assert times_as_much(second, first) == 1.5


async def test_a_process_that_ends_before_its_turns_is_no_result(tmp_path: Path) -> None:
    with pytest.raises(RuntimeError, match="has ended"):
        await rows_of(tmp_path / "log", 2)


def test_what_a_robot_said_last_is_what_is_known_of_it() -> None:
    clock = SystemClock()
    robots = {
        profile.id: ReportingRobot(profile, OrderGate.new(profile.id), clock)
        for profile in map(profile_of, range(3))
    }
    feed = ReportDelivery(robots)
    feed.join(robots)

    for said in (
        ReportedValues("robot1", 41.0, 1.0, 2.0),
        RobotHeartbeat("robot0"),
        ReportedValues("robot1", 42.0, 3.0, 4.0),
    ):
        feed.take(frame(said)[2:])

    assert feed.messages == 3
    heard, reported, silent = (robot.presence() for robot in robots.values())
    assert (heard.online, heard.values, heard.pose) == (True, {}, None)
    assert (reported.values, reported.pose) == ({"battery": 42.0}, Pose(3.0, 4.0))
    assert (silent.online, silent.age_s) == (False, None)
