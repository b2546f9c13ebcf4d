"""What was said when a task was given, and where: sealed in its author's container."""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING, Final, NamedTuple

import msgspec

from rosic.core.message import Chat
from rosic.core.records import Fact, Letter
from rosic.core.time_units import MINUTE_NS, SECOND_NS

if TYPE_CHECKING:
    from collections.abc import Iterable

    from rosic.core.fleet.task import TaskId
    from rosic.core.identity import PrincipalId
    from rosic.core.robot.profile import RobotId


# ---- what was said of a task ----
# Sealed in its author's container.

KIND: Final = "task-letter"
THERE: Final = b"\x01"

log = logging.getLogger("rosic.fleet")


class TaskText(msgspec.Struct, frozen=True):
    """What a task is about.

    Attributes:
        lines: What a robot is asked, step by step, without its name.
        messenger: Through which it was given.
        chat: Where its orders are shown.
        title: How people call it; empty for its first line.
    """

    lines: tuple[str, ...]
    messenger: str
    chat: Chat
    title: str = ""

    @property
    def shown(self) -> str:
        """What people read."""
        return self.title or "; ".join(self.lines)


_encode = msgspec.msgpack.Encoder().encode
_said = msgspec.msgpack.Decoder(TaskText).decode


class TaskTexts:
    """What is known of tasks besides ids and numbers."""

    def __init__(self) -> None:
        self._said: dict[TaskId, TaskText] = {}
        self._whose: dict[TaskId, PrincipalId] = {}

    def get(self, task: TaskId) -> TaskText | None:
        """Return what was said; None if its author's container was erased."""
        return self._said.get(task)

    def fact(self, task: TaskId, author: PrincipalId, text: TaskText) -> Fact:
        """Return what keeps it."""
        return Fact(kind=KIND, key=task, body=THERE, letter=Letter(author, _encode(text)))

    def forgotten(self, tasks: Iterable[TaskId]) -> tuple[Fact, ...]:
        """Return what lets it go."""
        return tuple(Fact(kind=KIND, key=task, body=b"") for task in tasks)

    def end_all(self, principal: PrincipalId) -> tuple[Fact, ...]:
        """Return what lets go everything that somebody has said."""
        return self.forgotten(task for task, who in self._whose.items() if who == principal)

    def restore(self, facts: Iterable[Fact]) -> None:
        """Take over what earlier runs wrote."""
        for fact in facts:
            self.apply(fact)

    def apply(self, fact: Fact) -> None:
        """Let a fact be so; one that nobody can read any more is as good as none."""
        self._said.pop(fact.key, None)
        self._whose.pop(fact.key, None)
        if not fact.body or fact.letter is None:
            return
        try:
            self._said[fact.key] = _said(fact.letter.content)
            self._whose[fact.key] = fact.letter.container
        except msgspec.MsgspecError:
            log.warning("what was said for a task cannot be read")


# ---- when a robot is asked again ----
# Later each time, and others before it.

AGAIN_NS: Final = 2 * SECOND_NS
"""A task that no robot took just now is not offered again at once."""
FIRST_NS: Final = 4 * AGAIN_NS
"""Longer than the task waits: others are asked before it is this robot's turn again."""
LONGEST_NS: Final = 5 * MINUTE_NS
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
