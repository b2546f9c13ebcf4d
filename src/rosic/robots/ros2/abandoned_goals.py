"""Goals that were given up, and whose server has not said that it gave them up (I6).

A process that is frozen goes on with its goal as soon as it runs again, however long that takes and
though the robot has rested meanwhile. It is asked to call the goal off until it answers, and then
the robot is brought to rest once more.
"""

from __future__ import annotations

import asyncio
import logging
from typing import TYPE_CHECKING, Final, NamedTuple

from rosic.core.i18n import said
from rosic.errors import RobotOffline
from rosic.robots.ros2.errors import NoAnswer, NotSent

if TYPE_CHECKING:
    from collections.abc import Callable

    from rosic.contracts.clock import Clock
    from rosic.robots.ros2.client.actions import Goal

_log = logging.getLogger(__name__)

EVERY_S: Final = 0.5
ANSWER_WITHIN_S: Final = 1.0


class AbandonedGoal(NamedTuple):
    """A goal that was given up and has not ended yet.

    Attributes:
        goal: What may go on.
        there: Whether somebody offers its action now.
    """

    goal: Goal
    there: Callable[[], bool]


class AbandonedGoals:
    """Those of one robot.

    Args:
        clock: Of the robot.
        settle: Begins to bring the robot to rest.
    """

    def __init__(self, clock: Clock, settle: Callable[[], None]) -> None:
        self._clock = clock
        self._settle = settle
        self._following: dict[asyncio.Task[None], AbandonedGoal] = {}

    def add(self, loose: AbandonedGoal) -> None:
        """Ask for its end until somebody answers."""
        task = asyncio.create_task(self._follow(loose.goal))
        self._following[task] = loose
        task.add_done_callback(self._following.pop)

    def check(self, shown: str) -> None:
        """See that nothing which is there may go on with what was given up.

        Raises:
            RobotOffline: Something may; nothing was sent.
        """
        if any(loose.there() for loose in self._following.values()):
            raise RobotOffline(
                said(
                    "{shown} was told to end what was broken off, and has not answered; it may go "
                    "on with it. Nothing was sent; please look.",
                    shown=shown,
                )
            )

    def close(self) -> None:
        """Ask no more."""
        for task in tuple(self._following):
            task.cancel()

    async def _follow(self, goal: Goal) -> None:
        try:
            while not goal.over:
                try:
                    answer = await goal.cancel(timeout_s=ANSWER_WITHIN_S)
                except NoAnswer:
                    await self._clock.sleep(EVERY_S)
                    continue
                _log.info("a goal of %s that was given up: %s", goal.name, answer)
                break
            self._settle()
        except NotSent:  # the link is closed, and with it the robot
            return
        finally:
            goal.forget()
