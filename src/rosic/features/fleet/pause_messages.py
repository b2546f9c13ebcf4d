"""Sentences about tasks that are paused, cancelled and continued together."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from rosic.core.i18n import said, said_n

if TYPE_CHECKING:
    from collections.abc import Sequence

ALL: Final = frozenset(
    {"all", "everything", "it", "that", "this", "now", "please"}
    | {"alle", "alles", "bitte", "jetzt", "lassen", "wieder"}
)
BUTTONS_AT_MOST: Final = 4
NAMED_AT_MOST: Final = 8

CONTINUE = said("Continue")
CANCEL = said("Cancel")
NOTHING_PAUSED = said("Nothing of yours is paused.")
TOO_LATE = said("The time is over by which that was to be begun. Nothing was changed.")


def cancelled(tasks: Sequence[str]) -> str:
    """Return that somebody's tasks were cancelled."""
    return said_n(
        "Task {tasks} is cancelled.",
        "{n} tasks are cancelled: {tasks}.",
        len(tasks),
        tasks=_some(tasks),
    )


def paused(tasks: Sequence[str]) -> str:
    """Return that somebody's tasks are paused, or about to be."""
    return said_n(
        "Task {tasks} is paused; its robot is brought to rest.",
        "{n} tasks are paused, and their robots are brought to rest: {tasks}.",
        len(tasks),
        tasks=_some(tasks),
    )


def went_on(tasks: Sequence[str]) -> str:
    """Return that somebody's tasks go on."""
    return said_n(
        "Task {tasks} goes on.", "{n} tasks go on: {tasks}.", len(tasks), tasks=_some(tasks)
    )


def stay_paused(tasks: Sequence[str]) -> str:
    """Return that somebody's tasks did not go on by a word that may have been meant for others."""
    return said_n(
        "Task {tasks} stays paused until you continue it.",
        "{n} tasks stay paused until you continue them: {tasks}.",
        len(tasks),
        tasks=_some(tasks),
    )


def resume_label(shown: str, tasks: Sequence[str]) -> str:
    """Return the label of the button that resumes a robot which then moves by itself."""
    return said_n(
        "Resume {shown}: task {tasks} goes on",
        "Resume {shown}: {n} tasks go on",
        len(tasks),
        shown=shown,
        tasks=_some(tasks),
    )


def cannot_pause(shown: str) -> str:
    """Return that a robot cannot hold a single command half way."""
    return said("{shown} cannot hold that half way. Cancel it, or stop it.", shown=shown)


def cancel_label(shown: str) -> str:
    """Return the label of the button that ends what one robot does."""
    return said("Cancel {shown}", shown=shown)


def _some(tasks: Sequence[str]) -> str:
    more = ", ..." if len(tasks) > NAMED_AT_MOST else ""
    return ", ".join(tasks[:NAMED_AT_MOST]) + more
