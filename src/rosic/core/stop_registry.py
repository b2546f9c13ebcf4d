"""Which robots are stopped, by whom, since when; written by the stop lane alone.

The linker writes it; admission reads it. It holds what people are told; the gate at each robot
holds what is enforced.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosic.core.i18n import said
from rosic.core.signal import Deferred, Signal
from rosic.errors import RobotStopped

if TYPE_CHECKING:
    from collections.abc import Iterable

    from rosic.core.identity import PrincipalId
    from rosic.core.robot.profile import RobotId
    from rosic.errors import Refusal


class StoppedRobot:
    """One robot's entry.

    Attributes:
        generation: Of its last stop; never decreases (I13).
        by, since_ns: Whose that was and when, as people are told; wall clock, kept over a restart.
        own: Who stopped an order of their own by it, and nothing that was stopped before; empty: it
            was no such stop.
        stoppers: Everybody who has stopped it since it was last free, and when they first did; "":
            somebody of whom nothing is known. A later stop takes nobody else's away.
        at_ns: When this run stopped it, wall clock: what was received before is older. 0: not yet.
    """

    __slots__ = ("at_ns", "by", "generation", "latched", "own", "since_ns", "stoppers")

    def __init__(self, generation: int, *, latched: bool) -> None:
        self.generation = generation
        self.latched = latched
        self.by: PrincipalId = ""
        self.own: PrincipalId = ""
        self.at_ns = self.since_ns = 0
        self.stoppers: dict[PrincipalId, int] = {"": 0} if latched else {}

    def alone(self, principal: PrincipalId) -> bool:
        """Whether somebody, and nobody else, has stopped it since it was last free."""
        return self.stoppers.keys() == {principal}

    def stopped_their_own(self, principal: PrincipalId) -> None:
        """Note that somebody's last stop was of an order of theirs, and of nothing else."""
        self.own = principal

    def stop(self, by: PrincipalId, at_ns: int) -> int:
        """Latch and return the new generation."""
        self.generation += 1
        if not self.latched:
            self.stoppers = {}
        self.stoppers.setdefault(by, at_ns)
        self.latched = True
        self.by, self.own = by, ""
        self.at_ns = self.since_ns = at_ns
        return self.generation

    def resume(self, generation: int) -> None:
        """Unlatch, if no later stop has come meanwhile."""
        if self.generation == generation:
            self.latched = False

    def not_later(self, now_ns: int) -> None:
        """Let its last stop not lie ahead."""
        self.at_ns = min(self.at_ns, now_ns)


class StopRegistry(dict["RobotId", StoppedRobot]):
    """Every robot's entry; read for every order, so that it is a plain table.

    Attributes:
        barred: Returns why a robot must stay stopped, whoever asks; None if it need not. Asked
            before anybody is told to resume it. Whoever knows is made later (`not_known_yet`).
        changed: A robot was stopped, or may go on. Whoever is told holds a stop up: it only notes.
        cancels: How often somebody has ended what they had under way: of one robot, or with no
            robot ("") of all. Empty as long as nobody has.
    """

    def __init__(
        self,
        robots: Iterable[RobotId],
        found: dict[RobotId, tuple[int, bool]],
        barred: Deferred[[RobotId], Refusal | None],
    ) -> None:
        self.barred = barred
        self.changed: Signal[[RobotId]] = Signal()
        self.cancels: dict[tuple[PrincipalId, RobotId], int] = {}
        for robot in robots:
            self.add_robot(robot, found.get(robot, (0, False)))

    def add_robot(self, robot: RobotId, found: tuple[int, bool]) -> None:
        """Know one more robot, with its last stop generation and whether it is stopped (I13)."""
        generation, latched = found
        self[robot] = StoppedRobot(generation, latched=latched)

    def stop(self, robot: RobotId, by: PrincipalId, at_ns: int) -> int:
        """Latch and return the new generation."""
        generation = self[robot].stop(by, at_ns)
        self.changed.emit(robot)
        return generation

    def cancel(self, principal: PrincipalId, robots: Iterable[RobotId]) -> None:
        """Let nothing of somebody begin any more that was admitted before; none means all."""
        for robot in tuple(robots) or ("",):
            self.cancels[principal, robot] = self.cancels.get((principal, robot), 0) + 1

    def cancelled(self, principal: PrincipalId, robot: RobotId) -> int:
        """Return how often somebody has ended what they had under way with a robot."""
        of_all = self.cancels.get((principal, ""), 0)
        return of_all + self.cancels.get((principal, robot), 0)

    def resume(self, robot: RobotId, generation: int) -> None:
        """Unlatch, if no later stop has come meanwhile."""
        entry = self[robot]
        before = entry.latched
        entry.resume(generation)
        if before and not entry.latched:
            self.changed.emit(robot)

    def not_later(self, now_ns: int) -> None:
        """Let no stop lie ahead: the clock was set back, and that is the right time.

        Whatever is received from now on would otherwise count as older than those stops.
        """
        for entry in self.values():
            entry.not_later(now_ns)

    def newest(self) -> tuple[int, PrincipalId]:
        """Return a number that grows with every stop of any robot, and whose the last one was."""
        last = max(self.values(), key=lambda entry: entry.at_ns, default=None)
        return sum(entry.generation for entry in self.values()), "" if last is None else last.by

    def latched(self) -> tuple[RobotId, ...]:
        """Return the robots that are stopped."""
        return tuple(robot for robot, entry in self.items() if entry.latched)


def not_known_yet() -> Deferred[[RobotId], Refusal | None]:
    """Return what bars every robot until it is bound to whoever knows better."""
    return Deferred(_starting)


def _starting(_robot: RobotId) -> Refusal | None:
    return RobotStopped(
        said("ROSIC is still starting, so nothing is resumed yet. Try again in a moment.")
    )
