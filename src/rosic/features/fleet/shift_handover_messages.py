"""What people read when a shift ends."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from rosic.core.i18n import joined, said, said_n
from rosic.core.language.sanitise import echo
from rosic.core.language.suggestions import AND, listed
from rosic.core.message import Button

if TYPE_CHECKING:
    from collections.abc import Sequence

HOW_TO: Final = said("Say to whom: /handover and the name of who takes over.")
NOTHING: Final = said(
    "You look after no task and have no robot now. There is nothing to hand over."
)
OVER: Final = said("That offer is over. Nothing was changed.")
STAYS: Final = said("Everything stays as it is.")
ACCEPT: Final = said("I take over")
DECLINE: Final = said("Not me")


def nobody(name: str) -> str:
    """Return that a name does not say who it is."""
    return said(
        "I do not know for certain who {name} is. Write the name as it stands in /people.",
        name=echo(name),
    )


def in_vain(name: str, tasks: Sequence[str]) -> str:
    """Return that somebody could do nothing with it."""
    if not tasks:
        return said("{name} may not move these robots. An admin can give the right.", name=name)
    return said(
        "{name} may move no robot for {tasks}. An admin can give the right.",
        name=name,
        tasks=_numbered(tasks),
    )


def _numbered(tasks: Sequence[str]) -> str:
    if len(tasks) == 1:
        return said("task {task}", task=tasks[0])
    return said("the tasks {tasks}", tasks=listed(tuple(tasks), AND))


def not_reached(name: str) -> str:
    """Return that nobody could be asked."""
    return said("{name} cannot be reached now. Nothing was changed.", name=name)


def _all_of_it(tasks: int, robots: int) -> str:
    parts: list[str] = []
    if tasks:
        parts.append(said_n("one task", "{n} tasks", tasks))
    if robots:
        parts.append(said_n("one robot", "{n} robots", robots))
    return joined(", ", parts) if parts else said("nothing any more")


def offered(name: str, tasks: int, robots: int) -> str:
    """Return the question whether somebody takes over."""
    return said(
        "{name} hands over to you: {what}. From then on your rights count for them.",
        name=name,
        what=_all_of_it(tasks, robots),
    )


def choices(number: str) -> tuple[tuple[Button, ...], ...]:
    """Return the answers."""
    row = (
        Button(ACCEPT, f"/handover accept {number}"),
        Button(DECLINE, f"/handover decline {number}"),
    )
    return (row,)


def asked(name: str) -> str:
    """Return that somebody was asked."""
    return said("{name} is asked. Until then everything stays yours.", name=name)


def declined(name: str) -> str:
    """Return that somebody does not take over."""
    return said("{name} does not take over. Everything stays yours.", name=name)


def accepted(name: str, tasks: int, robots: int) -> str:
    """Return that somebody has taken over."""
    return said("{name} has taken over: {what}.", name=name, what=_all_of_it(tasks, robots))


def yours(name: str, tasks: int, robots: int) -> str:
    """Return what somebody looks after from now on."""
    return said("Yours now, from {name}: {what}.", name=name, what=_all_of_it(tasks, robots))
