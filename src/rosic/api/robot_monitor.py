"""Robots as everybody is shown them: those that move are looked at often, those at rest seldom."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, NamedTuple

import msgspec

from rosic.core.time_units import SECOND_NS

if TYPE_CHECKING:
    from collections.abc import Callable, Collection

    from rosic.api.schemas import RobotOut
    from rosic.core.robot.profile import Profile, RobotId

REST_NS: Final = SECOND_NS // 2
"""So often a robot is looked at that does nothing: a cut link is said within 2 s."""
VALUES_NS: Final = SECOND_NS
"""So often it is told how the battery of such a robot falls: it is never quite the same."""


class _Look(NamedTuple):
    shown: RobotOut
    held: tuple[bool, str]
    looked_ns: int
    told_ns: int


class RobotMonitor:
    """Keeps what was last shown of each robot, for all who listen.

    Args:
        show: Returns a robot as it is shown.
        held: Returns cheaply whether a robot is stopped, and who holds it.
        now_ns: Monotonic clock.
    """

    def __init__(
        self,
        show: Callable[[Profile], RobotOut],
        held: Callable[[RobotId], tuple[bool, str]],
        now_ns: Callable[[], int],
    ) -> None:
        self._show, self._held, self._now_ns = show, held, now_ns
        self._looks: dict[RobotId, _Look] = {}
        self._woken: set[RobotId] = set()

    def wake(self, robot: RobotId) -> None:
        """Look at a robot the next time: something is done with it."""
        self._woken.add(robot)

    def look(self, profile: Profile, *, anew: bool = False) -> RobotOut:
        """Return a robot as it is shown; the same object while there is no news of it.

        Args:
            profile: The robot's.
            anew: Somebody has not been told of it yet, and is to know how old what is known is.
        """
        robot, now_ns = profile.id, self._now_ns()
        before, held = self._looks.get(robot), self._held(robot)
        if before is not None and not anew and not self._due(before, robot, held, now_ns):
            return before.shown
        self._woken.discard(robot)
        shown = self._show(profile)
        if before is not None and not anew and _no_news(before, shown, now_ns):
            self._looks[robot] = before._replace(held=held, looked_ns=now_ns)
            return before.shown
        self._looks[robot] = _Look(shown, held, now_ns, now_ns)
        return shown

    def keep(self, robots: Collection[RobotId]) -> None:
        """Forget all others."""
        if len(self._looks) > len(robots):
            self._looks = {robot: self._looks[robot] for robot in self._looks if robot in robots}
            self._woken.intersection_update(robots)

    def _due(self, before: _Look, robot: RobotId, held: tuple[bool, str], now_ns: int) -> bool:
        return (
            _acts(before.shown)
            or now_ns - before.looked_ns >= REST_NS
            or held != before.held
            or robot in self._woken
        )


def _acts(shown: RobotOut) -> bool:
    return shown.presence.at_rest is False or bool(shown.presence.doing)


def _no_news(before: _Look, now: RobotOut, now_ns: int) -> bool:
    """Whether a robot is as it was: ages alone are no news, nor soon how its values creep."""
    was, present = before.shown.presence, now.presence
    values = present.values
    if not _acts(now) and now_ns - before.told_ns < VALUES_NS:
        values = was.values
    ages = {"age_s": was.age_s, "ages_s": was.ages_s}
    same = msgspec.structs.replace(present, values=values, **ages)
    return msgspec.structs.replace(now, presence=same) == before.shown
