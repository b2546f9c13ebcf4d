"""Waits until a robot whose order was cut off is at rest. Nothing is latched by it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from rosic.contracts.clock import Clock
    from rosic.core.robot.profile import RobotId
    from rosic.linker.linker import Linker

LOOK_S: Final = 0.05


async def comes_to_rest(linker: Linker, clock: Clock, robot: RobotId) -> bool:
    """Return whether a robot is at rest, or its side cannot say, before its profile's time-out."""
    patience_ns = int(linker.profile(robot).rest_timeout_s * 1e9)
    deadline_ns = clock.monotonic_ns() + patience_ns
    while linker.presence(robot).at_rest is False:
        if clock.monotonic_ns() >= deadline_ns:
            return False
        await clock.sleep(LOOK_S)
    return True
