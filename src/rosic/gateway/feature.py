"""What a capability is to the gateway: made from the kernel, run, told of robots, closed.

Each package of `rosic.features` offers ``setup(kernel) -> Feature``. It takes its commands and
says which facts it keeps while it is made; from then on the gateway only meets it as a `Feature`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from rosic.core.deferred import Deferred

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from rosic.contracts.clock import Clock
    from rosic.core.records import Fact, Memory
    from rosic.core.robot.profile import Presence, RobotId
    from rosic.gateway.components import Components
    from rosic.gateway.pipeline import Pipeline
    from rosic.gateway.robot_argument import RobotArgument
    from rosic.gateway.robot_registry import AddedRobot
    from rosic.gateway.transactions import Transactions


class Feature:
    """One capability of a gateway. What it does not need of this it leaves as it is here."""

    async def run(self) -> None:
        """Do what it does on its own, until cancelled; return if there is nothing."""

    async def close(self) -> None:
        """Follow nothing any more, and write down what is open. The record is open still."""

    def robot_added(self, newcomer: AddedRobot) -> None:
        """Hear of one more robot, which every room knows by now."""


class RobotAssessment:
    """How robots do, for whoever watches or shows them; the feature that measures it is bound.

    Attributes:
        presence: Returns what a robot reports, with how it does.
        line: Returns what a dashboard says of it; empty for nothing.
    """

    def __init__(self) -> None:
        self.presence: Deferred[[RobotId, Presence], Presence] = Deferred(_as_reported)
        self.line: Deferred[[RobotId], str] = Deferred(_nothing_measured)


class Kernel(NamedTuple):
    """What features are made from.

    Attributes:
        changes: Writes facts, and tells who keeps them.
        memory: What earlier runs left.
        naming: Finds the robot that is meant at the beginning of a line.
        assessment: Says how robots do.
    """

    rooms: Components
    pipeline: Pipeline
    changes: Transactions
    clock: Clock
    memory: Memory
    naming: RobotArgument
    assessment: RobotAssessment

    def keep(
        self,
        kind: str,
        restore: Callable[[Iterable[Fact]], object],
        apply: Callable[[Fact], object],
    ) -> None:
        """Give a feature the facts of a kind: those of earlier runs now, each new one later."""
        restore(self.memory.facts.get(kind, ()))
        self.changes.keep(kind, apply)


def _as_reported(_robot: RobotId, presence: Presence) -> Presence:
    return presence


def _nothing_measured(_robot: RobotId) -> str:
    return ""
