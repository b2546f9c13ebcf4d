"""Who is told of an alarm, and who may say that they have seen it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosic.core.policy.scope import FLEET, GRANT
from rosic.core.robot.alert_config import CIRCLES, RecipientCircle

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from rosic.authoriser.authoriser import Authoriser
    from rosic.core.identity import PrincipalId
    from rosic.core.robot.profile import RobotId
    from rosic.organiser.organiser import Organiser


class Recipients:
    """Finds people around a robot. Walks everybody: an alarm is rare, and its circle is not kept.

    Only those are found who may see the robot now, whose key is good and who are not locked.
    """

    def __init__(self, authoriser: Authoriser, organiser: Organiser) -> None:
        self._authoriser = authoriser
        self._organiser = organiser
        self._belongs: dict[RecipientCircle, Callable[[PrincipalId, RobotId], bool]] = {
            RecipientCircle.HOLDER: lambda who, robot: organiser.whose(robot) == who,
            RecipientCircle.OPERATORS: self.may_acknowledge,
            RecipientCircle.ADMINS: self._gives,
        }

    def of(self, robot: RobotId, first: RecipientCircle, level: int) -> tuple[PrincipalId, ...]:
        """Return whom to tell after so many escalations; where nobody is, the next circle."""
        start = CIRCLES.index(first) + level
        for circle in CIRCLES[min(start, len(CIRCLES) - 1) :]:
            found = tuple(self._within(robot, circle))
            if found:
                return found
        return ()

    def _within(self, robot: RobotId, circle: RecipientCircle) -> Iterator[PrincipalId]:
        belongs = self._belongs[circle]
        for person in self._authoriser.directory.people():
            if person.is_robot:
                continue
            if self.may_hear(person.id, robot) and belongs(person.id, robot):
                yield person.id

    def may_hear(self, who: PrincipalId, robot: RobotId) -> bool:
        """Whether somebody may be told of a robot at all."""
        return (
            self._authoriser.has_access(who)
            and who not in self._organiser.locked
            and robot in self._organiser.visible(who)
        )

    def may_acknowledge(self, who: PrincipalId, robot: RobotId) -> bool:
        """Whether somebody may say for everybody that an alarm was seen: who may operate it."""
        return self._organiser.why_not_move(who, robot) is None

    def _gives(self, who: PrincipalId, robot: RobotId) -> bool:
        rights, now_ns = self._organiser.rights, self._organiser.wall_ns()
        return rights.holds(who, FLEET, GRANT, now_ns) or rights.holds(who, robot, GRANT, now_ns)
