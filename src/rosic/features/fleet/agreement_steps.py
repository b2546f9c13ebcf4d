"""What a new task or mission lets robots do: a button that begins it is bound to that (I16).

One that goes on needs no such thing: robots and steps are those that it was given with.
"""

from __future__ import annotations

from contextlib import suppress
from itertools import chain
from typing import TYPE_CHECKING, Final

from rosic.core.fleet.task import FleetMembership
from rosic.errors import Refusal
from rosic.features.fleet.task_parser import PermittedSteps
from rosic.gateway.agreement import TaskSteps

if TYPE_CHECKING:
    from rosic.core.fleet.state import FleetState
    from rosic.core.identity import PrincipalId
    from rosic.core.language import Do
    from rosic.core.robot.profile import RobotId
    from rosic.features.fleet.mission_commands import MissionCommands
    from rosic.features.fleet.task_commands import TaskCommands
    from rosic.gateway.components import Components

STEPS_READ_AT_MOST: Final = {"task": 96, "mission": 24}
"""So many are worked out for a button: all of a large task would hold the loop (I15).

Up to five buttons that begin missions are shown together.
"""


class AgreementSteps:
    """Works out what a command of tasks or missions comes to, as far as there is time for it."""

    def __init__(
        self,
        rooms: Components,
        fleet: FleetState,
        tasks: TaskCommands,
        missions: MissionCommands,
    ) -> None:
        self._rooms = rooms
        self._fleet = fleet
        self._tasks = tasks
        self._missions = missions

    def of(self, verb: str, rest: str, who: PrincipalId) -> TaskSteps:
        """Return what a command lets robots do; nothing of one that lets them do nothing.

        Robots are read until it would take too long for one step of the event loop. Who may do what
        for somebody is in the number of the rules as well, for whoever binds a button to this.

        Args:
            verb: ``task`` or ``mission``.
            rest: As typed after it.
            who: Whoever says it.

        Raises:
            Refusal: It is not done: it is said badly, or for nobody.
        """
        asked = self._tasks.asked if verb == "task" else self._missions.asked
        permitted, standing = PermittedSteps(self._rooms, who), self._fleet.standing
        found: list[Do] = []
        unread: list[tuple[RobotId, ...]] = []
        left = at_most = STEPS_READ_AT_MOST[verb]
        for robots, every_line in asked(rest, who):
            lines = every_line[:at_most]
            for number, robot in enumerate(robots):
                if left < len(lines):
                    unread.append(robots[number:])
                    break
                left -= len(lines)
                if standing(robot) is FleetMembership.RETIRED:
                    continue
                with suppress(Refusal):
                    permitted.all(robot, lines)
                    found += [permitted.reader.read(robot, line) for line in lines]
        others = dict.fromkeys(chain.from_iterable(dict.fromkeys(unread)))
        return TaskSteps(
            found, [robot for robot in others if standing(robot) is not FleetMembership.RETIRED]
        )
