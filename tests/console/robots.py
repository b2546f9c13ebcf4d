"""Simulated robots that note when they are stopped, or whose side says nothing."""

from __future__ import annotations

import asyncio
import time
from typing import TYPE_CHECKING, cast

from msgspec.structs import replace

from rosic.config.plugins import robot_factory
from rosic.core.order import OrderStage, StageReport
from rosic_sim.robots.robot import SimulatedRobot

if TYPE_CHECKING:
    from rosic.contracts.adapter import RobotFactory
    from rosic.contracts.robot import Tell
    from rosic.core.order import Order, Outcome, RestReport, Stop
    from rosic.core.robot.profile import Presence

STOPPED_AT: list[tuple[str, float]] = []
"""Each robot that was handed a stop, and when: seconds of the wall clock."""
CUT: set[str] = set()
"""Robots whose cable is pulled."""
SILENT: set[str] = set()
"""Robots whose side never says that it has received anything."""
RESTLESS: set[str] = set()
"""Robots that do not confirm that they are at rest."""


DRAINED: set[str] = set()
"""Robots whose battery is nearly empty."""


SAYING: dict[str, float | str] = {}
"""What omni measures instead of what it does, by name."""


class NotingRobot(SimulatedRobot):
    """A simulated robot that notes when it was handed a stop."""

    async def stop(self, stop: Stop) -> RestReport:
        STOPPED_AT.append((stop.robot, time.time()))
        report = await super().stop(stop)
        return replace(report, confirmed=False) if stop.robot in RESTLESS else report

    async def execute(self, order: Order, tell: Tell) -> Outcome:
        if order.robot not in SILENT:
            return await super().execute(order, tell)
        tell(StageReport(OrderStage.SENT))
        await asyncio.Event().wait()
        raise AssertionError("never")

    def presence(self) -> Presence:
        found = super().presence()
        if SAYING and self.profile.id == "omni":
            found = replace(found, values=SAYING)
        if self.profile.id in DRAINED:
            found = replace(found, values={**found.values, "battery": 7.0})
        return replace(found, online=False, age_s=2.0) if self.profile.id in CUT else found


def noting(kind: str) -> RobotFactory:
    """Return the factory of a kind of robot; simulated ones note."""
    return cast("RobotFactory", NotingRobot) if kind == "simulated" else robot_factory(kind)
