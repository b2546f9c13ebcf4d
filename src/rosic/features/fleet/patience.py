"""Who has refused what, and when it is asked again: later each time, and others before it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, NamedTuple

if TYPE_CHECKING:
    from rosic.core.fleet.task import TaskId
    from rosic.core.robot.profile import RobotId

AGAIN_NS: Final = 2_000_000_000
"""A task that no robot took just now is not offered again at once."""
FIRST_NS: Final = 4 * AGAIN_NS
"""Longer than the task waits: others are asked before it is this robot's turn again."""
LONGEST_NS: Final = 300_000_000_000
"""Each time that a robot is asked somebody reads that it refuses, and it may do so all night."""
DOUBLED_AT_MOST: Final = 16


class _Refused(NamedTuple):
    """How often a robot has refused a task, and until when it is not asked again."""

    times: int
    until_ns: int


class RetryBackoff:
    """Keeps one robot from being asked the same for ever. Times are of the monotonic clock.

    What a robot refuses for one task it mostly refuses for the next, and for this one again.
    """

    def __init__(self) -> None:
        self._tasks: dict[TaskId, int] = {}
        self._robots: dict[RobotId, int] = {}
        self._pairs: dict[RobotId, dict[TaskId, _Refused]] = {}

    def refused(self, task: TaskId, robot: RobotId, now_ns: int) -> None:
        """Note that a robot did not take a task. It has not moved."""
        self._tasks[task] = self._robots[robot] = now_ns + AGAIN_NS
        pairs = self._pairs.setdefault(robot, {})
        times = pairs[task].times if task in pairs else 0
        wait_ns = min(LONGEST_NS, FIRST_NS << min(times, DOUBLED_AT_MOST))
        pairs[task] = _Refused(times + 1, now_ns + wait_ns)

    def forget(self, task: TaskId) -> None:
        """Let go what was refused of a task: it is over, or a person says what is to follow."""
        self._tasks.pop(task, None)
        for pairs in self._pairs.values():
            pairs.pop(task, None)

    def not_now(self, now_ns: int) -> tuple[frozenset[TaskId], frozenset[RobotId]]:
        """Return the tasks that were refused just now, and the robots that did not take one."""
        self._tasks = {task: at for task, at in self._tasks.items() if at > now_ns}
        self._robots = {robot: at for robot, at in self._robots.items() if at > now_ns}
        return frozenset(self._tasks), frozenset(self._robots)

    def declined(self, robot: RobotId, now_ns: int) -> frozenset[TaskId]:
        """Return what a robot is not asked again yet; mostly nothing."""
        pairs = self._pairs.get(robot, {})
        return frozenset(task for task, refused in pairs.items() if refused.until_ns > now_ns)
