"""What was not answered may be carried out all the same: the robot is brought to rest (I6)."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

import pytest

from rosic.errors import RobotUnreachable
from rosic.robots.ros2.bindings import action
from rosic.system import SystemClock
from tests.pace import pace
from tests.real.ros2 import goal_driver
from tests.real.ros2.simulated import opened, until
from tests.real.ros2.test_robot_bindings import omni

if TYPE_CHECKING:
    from rosic.testing.ros2.graph import RosProcess

SLOW: dict[str, object] = {
    "service": {
        "name": "/omni/slow",
        "type": "std_srvs/srv/SetBool",
        "request": {"data": False},
        "timeout_s": 0.05,
    }
}
STOP: dict[str, object] = {"service": "/omni/stop", "type": "std_srvs/srv/Trigger"}


async def test_what_a_service_did_not_answer_is_brought_to_rest_before_anything_else(
    peer: RosProcess,
) -> None:
    robot = omni(SLOW, stop=STOP)
    await robot.open(lambda _text: None)
    try:
        await until(lambda: all(link.ready() for link in robot._stop_controller.calls))
        with pytest.raises(RobotUnreachable, match=r"Omni has not answered for 0.05 s"):
            await robot.do("do", {})
        await asyncio.to_thread(peer.expect, "stopped", timeout_s=10 * pace())
    finally:
        await robot.close()


async def test_nothing_is_stopped_because_a_question_was_not_answered(peer: RosProcess) -> None:
    robot = omni({**SLOW, "class": "observe"}, stop=STOP)
    await robot.open(lambda _text: None)
    try:
        await until(lambda: all(link.ready() for link in robot._stop_controller.calls))
        peer.lines.clear()
        with pytest.raises(RobotUnreachable):
            await robot.do("do", {})
        await asyncio.to_thread(peer.expect, "slow done", timeout_s=60 * pace())
        assert "stopped" not in peer.lines
    finally:
        await robot.close()


async def test_a_robot_whose_acceptance_was_not_heard_is_brought_to_rest(
    mover: RosProcess, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The goal may be under way: DDS drops an answer to a client that its server does not know."""
    monkeypatch.setattr(action, "ACCEPT_WITHIN_S", 0.3)
    mover.say("hesitate")
    await asyncio.to_thread(mover.expect, "ok hesitate")
    async with opened(goal_driver.omni(), SystemClock()) as robot:
        await until(lambda: all(link.ready() for link in robot._stop_controller.calls))
        with pytest.raises(RobotUnreachable, match=r"^Omni has not answered for 0\.3 s\.$"):
            await robot.do("move", {"distance": 1.0})
        await asyncio.to_thread(mover.expect, "stopped", timeout_s=10 * pace())
