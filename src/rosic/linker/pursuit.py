"""A stop that was not confirmed is applied again until rest was measured (I5, I7)."""

from __future__ import annotations

import asyncio
import logging
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable, Mapping

    from rosic.contracts.clock import Clock
    from rosic.contracts.robot import Robot
    from rosic.core.order import RestReport, Stop
    from rosic.core.robot.profile import Presence, RobotId
    from rosic.core.stop_registry import StopRegistry

log = logging.getLogger("rosic.stop")

EVERY_S: Final = 1.0


class StopPursuit:
    """Of every robot that is stopped, until it was seen at rest, resumed, or stopped once more.

    A robot that is not there is left alone until it is back. One whose rest its link cannot tell is
    told once, and once more whenever it comes back: nothing else would show that it heard.

    Args:
        robots: By name; more may come.
        presence: What a robot's side last said.
        stops: Says whether a stop is still the last one, and stands.
        clock: Counts the pauses.
    """

    def __init__(
        self,
        robots: Mapping[RobotId, Robot],
        presence: Callable[[RobotId], Presence],
        stops: StopRegistry,
        clock: Clock,
    ) -> None:
        self._robots, self._presence = robots, presence
        self._stops = stops
        self._clock = clock
        self._under_way: dict[RobotId, asyncio.Task[RestReport | None]] = {}
        self._told: set[RobotId] = set()
        self._confirmed: dict[RobotId, tuple[int, RestReport]] = {}

    def begin(self, stop: Stop, first: asyncio.Task[RestReport] | None) -> None:
        """Go on after a first try.

        Args:
            stop: Takes the place of an earlier one of the same robot.
            first: What comes of that try. None: there was none, and there is none unless the robot
                is seen to move.
        """
        self.end(stop.robot)
        if first is not None:
            self._told.add(stop.robot)
        task = asyncio.create_task(self._pursue(stop, first))
        self._under_way[stop.robot] = task
        task.add_done_callback(lambda done: self._over(stop, done))

    def end(self, robot: RobotId) -> None:
        """Leave a robot alone: its stop is undone, or it is not ours any more."""
        task = self._under_way.pop(robot, None)
        self._told.discard(robot)
        if task is not None:
            task.cancel()

    def __contains__(self, robot: RobotId) -> bool:
        """Whether the stop of a robot is not confirmed yet."""
        return robot in self._under_way

    def in_doubt(self, robot: RobotId) -> bool:
        """Whether this run told a robot to stop, never saw it at rest, and it is not there now.

        What was stopped before this run may have been seen at rest then: that is not known.
        """
        return robot in self._told and self._presence(robot).online is False

    async def rested(self, robot: RobotId, generation: int) -> RestReport | None:
        """Wait until a stop, or a later one that took its place, was confirmed.

        Everybody who has stopped a robot hears of it, however many stopped it after them. Cutting
        the wait off leaves the pursuit as it is.

        Args:
            robot: Which one.
            generation: Of the stop. It may have been confirmed already.

        Returns:
            What was measured. None: it was undone first, or it is not known any more.
        """
        while (task := self._under_way.get(robot)) is not None:
            await asyncio.wait((task,))
        confirmed_generation, rest = self._confirmed.get(robot, (0, None))
        return rest if confirmed_generation >= generation else None

    def close(self) -> None:
        """End all of them."""
        for robot in tuple(self._under_way):
            self.end(robot)

    def _over(self, stop: Stop, task: asyncio.Task[RestReport | None]) -> None:
        robot = stop.robot
        if self._under_way.get(robot) is not task:
            return
        del self._under_way[robot]
        self._told.discard(robot)
        rest = None if task.cancelled() or task.exception() else task.result()
        if rest is not None:
            self._confirmed[robot] = stop.generation, rest

    async def _pursue(
        self, stop: Stop, first: asyncio.Task[RestReport] | None
    ) -> RestReport | None:
        robot = self._robots[stop.robot]
        asked = first is not None
        # Cut off, this leaves the first try be: its answer is waited for elsewhere, too.
        rest = None if first is None else await _come_of(stop, asyncio.shield(first))
        unheard = asked and self._presence(stop.robot).online is not True
        while rest is None or not rest.confirmed:
            await self._clock.sleep(EVERY_S)
            entry = self._stops.get(stop.robot)
            if entry is None or not entry.latched or entry.generation != stop.generation:
                return None
            presence = self._presence(stop.robot)
            if presence.online is False:
                unheard = asked
            elif presence.at_rest and not asked:
                return None
            elif unheard or presence.at_rest is not None:
                unheard, asked = False, True
                self._told.add(stop.robot)
                rest = await _come_of(stop, robot.stop(stop))
        return rest


async def _come_of(stop: Stop, tried: Awaitable[RestReport]) -> RestReport | None:
    """Wait for what comes of a try; None: a fault of an adapter, which is not the end of it."""
    try:
        return await tried
    except Exception:
        log.exception("the stop of %s failed", stop.robot)
        return None
