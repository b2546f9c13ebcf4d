"""What every gateway under measurement is made of, whatever is measured."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosic.app.gateway import GatewayParts
from rosic.app.runtime import face_of
from rosic.config.units import compile_units
from rosic.robots.memory import MemoryRobot
from rosic.stores.stop_latch import MemoryLatch
from rosic.system import SystemClock, SystemEntropy

if TYPE_CHECKING:
    from rosic.contracts.adapter import RobotFactory
    from rosic.contracts.messenger import Messenger
    from rosic.contracts.store import StopLatch, Store

CLOCK = SystemClock()


def parts_of(
    store: Store,
    *messengers: Messenger,
    robot: RobotFactory = MemoryRobot,
    latch: StopLatch | None = None,
) -> GatewayParts:
    """Return the parts of a gateway with real clocks, over a store.

    Args:
        store: Where it writes.
        messengers: Through which it is spoken to.
        robot: Makes each of its robots.
        latch: Where stops outlive a crash; None: in memory.
    """
    return GatewayParts(
        messengers=messengers,
        robot_factory=lambda _kind: robot,
        store=store,
        latch=MemoryLatch() if latch is None else latch,
        clock=CLOCK,
        entropy=SystemEntropy(),
        units=compile_units(),
        face=face_of(),
    )
