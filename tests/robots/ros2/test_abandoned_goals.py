"""What was given up is asked for its end until somebody answers."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING, cast

import pytest

from rosic.errors import RobotOffline
from rosic.robots.ros2.abandoned_goals import AbandonedGoal, AbandonedGoals
from rosic.robots.ros2.errors import NoAnswer, NotSent
from rosic.system import SystemClock
from tests.pace import pace

if TYPE_CHECKING:
    from rosic.robots.ros2.client.actions import Goal


class Asked:
    """A goal that answers as is said, in order."""

    name = "/base/go"

    def __init__(self, *answers: str | Exception) -> None:
        self.over = False
        self.forgotten = asyncio.Event()
        self._answers = list(answers)

    async def cancel(self, *, timeout_s: float) -> str:
        del timeout_s
        answer = self._answers.pop(0)
        if isinstance(answer, Exception):
            raise answer
        return answer

    def forget(self) -> None:
        self.forgotten.set()


async def settled_after(goal: Asked) -> int:
    settled: list[int] = []
    goals = AbandonedGoals(SystemClock(), lambda: settled.append(1))
    goals.add(AbandonedGoal(cast("Goal", goal), lambda: True))
    with pytest.raises(RobotOffline, match="Base was told to end what was broken off"):
        goals.check("Base")
    await asyncio.wait_for(goal.forgotten.wait(), 60 * pace())
    await asyncio.sleep(0)
    goals.check("Base")
    goals.close()
    return len(settled)


async def test_it_is_asked_again_and_then_the_robot_is_brought_to_rest() -> None:
    assert await settled_after(Asked(NoAnswer("silent"), "cancelling")) == 1
    assert await settled_after(Asked("unknown")) == 1


async def test_one_that_has_ended_meanwhile_is_not_asked() -> None:
    goal = Asked()
    goal.over = True
    assert await settled_after(goal) == 1


async def test_nothing_is_done_on_a_link_that_is_closed() -> None:
    assert await settled_after(Asked(NotSent("closed"))) == 0


async def test_what_has_left_the_graph_hinders_nobody() -> None:
    goals = AbandonedGoals(SystemClock(), lambda: None)
    goals.add(AbandonedGoal(cast("Goal", Asked(*[NoAnswer("silent")] * 9)), lambda: False))
    goals.check("Base")
    goals.close()
