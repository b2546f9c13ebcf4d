"""A goal whose server is gone has ended: the server that comes after it knows nothing of it."""

from __future__ import annotations

import asyncio
import time
from typing import TYPE_CHECKING

import pytest

from rosic.core.order import OrderStage
from rosic.errors import RobotUnreachable
from rosic.system import SystemClock
from rosic.testing.ros2.graph import RosGraph
from tests.pace import pace
from tests.real.ros2.simulated import TriedRobot, profile_of
from tests.real.ros2.test_robot_bindings import LINK, PEER

if TYPE_CHECKING:
    from pathlib import Path

WITHIN_S = 45.0  # DDS forgets a node that was killed after 20 s
ANEW_WITHIN_S = 15.0
LIMIT_S = 600.0


@pytest.mark.parametrize("again", [False, True])
async def test_a_goal_whose_server_ends_is_broken_off(
    tmp_path: Path, interfaces: Path, *, again: bool
) -> None:
    action = {
        "name": "/omni/move",
        "type": "rosic_interfaces/action/Move",
        "goal": {"direction": "forward", "distance_m": 5.0},
        "timeout_s": LIMIT_S,
    }
    profile = profile_of(id="omni", title="Omni", link=LINK, skills={"do": {"action": action}})
    with RosGraph(tmp_path) as graph:
        peer = graph.start(PEER, interfaces)
        robot = TriedRobot(profile, SystemClock())
        stages: list[OrderStage] = []
        await robot.open(lambda _text: None)
        try:
            under_way = asyncio.create_task(
                robot.execute(robot.order("do"), lambda report: stages.append(report.stage))
            )
            await asyncio.to_thread(peer.expect, "goal forward", timeout_s=60 * pace())
            async with asyncio.timeout(60 * pace()):
                while OrderStage.RUNNING not in stages:  # noqa: ASYNC110 - nobody is told
                    await asyncio.sleep(0.01)
            await asyncio.to_thread(peer.kill)
            begun_s = time.monotonic()
            if again:
                await asyncio.to_thread(graph.start, PEER, interfaces)
            why = (
                "its software began anew"
                if again
                else "software (told nothing of it|for it was not)"
            )
            with pytest.raises(RobotUnreachable, match=why):
                await under_way
        finally:
            await robot.close()
    within_s = ANEW_WITHIN_S if again else WITHIN_S
    assert time.monotonic() - begun_s < within_s * pace()
