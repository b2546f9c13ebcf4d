"""What people read about the robots of a fleet, one by one and altogether."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from rosic.core.fleet.task import FleetMembership
from rosic.core.i18n import joined, said, said_n
from rosic.core.message import Button
from rosic.organiser.calendar_messages import length

if TYPE_CHECKING:
    from collections.abc import Sequence

BETWEEN: Final = " · "
MAY_NOT: Final = said(
    "Only somebody who may assign tasks here can do that. An admin can give the right."
)
HOW_TO: Final = said("Say which robot: /robot omni, or /robot disable omni, enable, retire, add.")

_NOT_IN: Final = {
    FleetMembership.DISABLED: said("not to be used now"),
    FleetMembership.RETIRED: said("retired"),
}


def about(can: str, state: str) -> str:
    """Return what a robot can do, and whether it takes part."""
    return joined("\n", (can, state)) if state else can


def standing(standing: FleetMembership) -> str:
    """Return why a robot takes no part; nothing if it does."""
    if standing is FleetMembership.ACTIVE:
        return ""
    return said("It takes no part in the fleet: {why}.", why=_NOT_IN[standing])


def left(shown: str, standing: FleetMembership, task: str) -> str:
    """Return that a robot takes no part from now on."""
    parts = [
        said("{robot} is stopped and takes no part: {why}.", robot=shown, why=_NOT_IN[standing])
    ]
    if task:
        parts.append(said("Task {task} leaves it.", task=task))
    return joined(" ", parts)


def joins(shown: str) -> str:
    """Return that a robot takes part again."""
    return said("{robot} takes part again. It is stopped until somebody resumes it.", robot=shown)


def resume_button(robot: str, shown: str) -> tuple[tuple[Button, ...], ...]:
    """Return what lets it move again."""
    return ((Button(said("Resume {robot}", robot=shown), f"resume {robot}"),),)


def is_in(shown: str) -> str:
    """Return that a robot takes part already."""
    return said("{robot} is in the fleet already. Nothing was changed.", robot=shown)


def is_out(shown: str, standing: FleetMembership) -> str:
    """Return that a robot takes no part already."""
    return said(
        "{robot} is {why} already. Nothing was changed.", robot=shown, why=_NOT_IN[standing]
    )


def is_retired(shown: str, robot: str) -> str:
    """Return that enabling is not enough."""
    return said(
        "{robot} was retired. Take it in again with /robot add {id}.", robot=shown, id=robot
    )


def barred(shown: str, standing: FleetMembership) -> str:
    """Return why a robot cannot be resumed."""
    return said(
        "{robot} is {why}, so it stays stopped. Whoever may assign tasks can change that.",
        robot=shown,
        why=_NOT_IN[standing],
    )


# ---- the whole fleet ----


def robots_altogether(at_work: int, free: int, out: int) -> str:
    """Return how many robots do what."""
    parts = [
        said_n("one robot at work", "{n} robots at work", at_work),
        said_n("one free", "{n} free", free),
    ]
    if out:
        parts.append(said_n("one not ready", "{n} not ready", out))
    return joined(", ", parts)


def tasks_altogether(waiting: int, held: int, resting: int, longest_s: int) -> str:
    """Return how many tasks are where."""
    parts = [said_n("one task running", "{n} tasks running", held)]
    if waiting:
        waits = said_n("one waits", "{n} wait", waiting)
        parts.append(said("{waits}, the longest for {time}", waits=waits, time=length(longest_s)))
    if resting:
        parts.append(said_n("one needs a person", "{n} need a person", resting))
    return joined(", ", parts)


def use(share: float, idle_s: int) -> str:
    """Return how much the fleet is used, by tasks and by what people order themselves."""
    return said(
        "At work {share:.0f} % of the time; idle for {time} on the average.",
        share=share * 100,
        time=length(idle_s),
    )


def one(shown: str, states: Sequence[str]) -> str:
    """Return one robot in a line."""
    return joined(": ", (shown, joined(BETWEEN, states)))


def at_task(task: str, what: str) -> str:
    """Return what a robot works at."""
    return said("task {task} ({what})", task=task, what=what)


def free() -> str:
    """Return that a robot has nothing to do."""
    return said("free")


def not_ready() -> str:
    """Return that a robot has nothing to do and is given nothing."""
    return said("not ready")


def theirs(name: str) -> str:
    """Return who has a robot."""
    return said("taken by {holder}", holder=name)


def stopped() -> str:
    """Return that a robot is stopped."""
    return said("stopped")


def not_there() -> str:
    """Return that a robot is not heard of."""
    return said("not there")


def moves() -> str:
    """Return that a robot moves and nobody has asked it to."""
    return said("moving without a task")


def battery(share: float, *, low: bool) -> str:
    """Return how full a battery is."""
    return (
        said("battery {value}, low", value=f"{share:.0f} %")
        if low
        else said("battery {value}", value=f"{share:.0f} %")
    )


def link_of(milliseconds: float) -> str:
    """Return how old the newest news is."""
    return said("heard {ms:.0f} ms ago", ms=milliseconds)


def out_of_fleet(standing: FleetMembership) -> str:
    """Return why a robot takes no part, briefly."""
    return _NOT_IN[standing]


def bottleneck(name: str, waiting: int, free: int, able: int) -> str:
    """Return where tasks wait because of too few robots."""
    waits = said_n("one task waits", "{n} tasks wait", waiting)
    if not able:
        return said("{name}: {waits}, and no robot of it is ready.", name=name, waits=waits)
    return said(
        "{name}: {waits}; {free} of {able} robots are free.",
        name=name,
        waits=waits,
        free=free,
        able=able,
    )


def for_any() -> str:
    """Return how tasks for any robot are called."""
    return said("any robot")
