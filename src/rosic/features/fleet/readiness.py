"""Why a robot would not begin at once, and so why a task waits."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from rosic.core.fleet.task import FleetMembership
from rosic.core.i18n import joined
from rosic.features.fleet import multi_robot_messages as words
from rosic.features.fleet.messages import waits_for

if TYPE_CHECKING:
    from rosic.core.fleet.state import FleetState
    from rosic.core.fleet.task import Task
    from rosic.core.identity import PrincipalId
    from rosic.core.robot.profile import RobotId
    from rosic.gateway.components import Components

NAMED_AT_MOST: Final = 3


def why_not_ready(rooms: Components, fleet: FleetState, robot: RobotId, who: PrincipalId) -> str:
    """Return why a robot would not begin at once for somebody; empty if it would."""
    presence, profile = rooms.linker.presence(robot), rooms.profiles[robot]
    holder = rooms.organiser.whose(robot)
    battery, described = presence.values.get("battery"), profile.telemetry.get("battery")
    least = described.alert_below if described is not None else None
    low = least is not None and isinstance(battery, int | float) and battery < least
    hindrances = (
        (presence.online is False, words.NOT_THERE),
        (fleet.standing(robot) is not FleetMembership.ACTIVE, words.NO_PART),
        (rooms.board[robot].latched, words.STOPPED),
        (holder is not None and holder != who, words.ANOTHERS),
        (rooms.linker.current(robot) is not None, words.AT_WORK),
        (presence.moves, words.NOT_AT_REST),
        (low, words.BATTERY_LOW),
    )
    return next((why for so, why in hindrances if so), "")


def why_waits(rooms: Components, fleet: FleetState, task: Task, visible: frozenset[RobotId]) -> str:
    """Return what a task waits for, as whoever sees these robots may read it; empty: for nothing.

    One robot that is ready is enough: then it begins as soon as it is its turn.
    """
    if not fleet.ready(task):
        return waits_for(task.after)
    why = {robot: why_not_ready(rooms, fleet, robot, task.author) for robot in task.left}
    if not why or not all(why.values()):
        return ""
    told = [
        words.state(rooms.profiles[robot].shown, reason)
        for robot, reason in why.items()
        if robot in visible
    ]
    more = len(why) - len(told[:NAMED_AT_MOST])
    if told and more > 0:
        return joined("; ", (*told[:NAMED_AT_MOST], words.so_many_more(more)))
    return joined("; ", told)
