"""What people read when something of a mission is not done by when it was to be."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosic.core.i18n import joined, said

if TYPE_CHECKING:
    from rosic.core.fleet.task import TaskId


def task(number: TaskId, what: str, lasts: str, cancels: bool) -> str:
    """Return that one task is late."""
    late = said(
        "Task {task} ({what}) is late: it was to be done within {time}.",
        task=number, what=what, time=lasts,
    )  # fmt: skip
    return _and_then(late, cancels)


def mission(run: str, moment: str, done: tuple[int, int], cancels: bool) -> str:
    """Return that a mission is late.

    Args:
        run: Its name and number.
        moment: By when it was to be done.
        done: How many of how many tasks are.
        cancels: The rest is cancelled.
    """
    late = said(
        "{mission} is late: it was to be done by {time}. {done} of {tasks} tasks are done.",
        mission=run, time=moment, done=done[0], tasks=done[1],
    )  # fmt: skip
    return _and_then(late, cancels)


def _and_then(late: str, cancels: bool) -> str:
    goes_on = said("It goes on.")
    rest = said("The rest of it is cancelled; what moves comes to rest first.")
    return joined(" ", (late, rest if cancels else goes_on))
