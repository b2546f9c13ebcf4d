"""Whether everything that was asked has ended and was told: what a script waits for."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rosic.app.gateway import Gateway
    from rosic.contracts.clock import Clock

EVERY_S = 0.02


async def until_quiet(gateway: Gateway, clock: Clock, *, seconds: float) -> bool:
    """Wait until everything has ended and was told. Return whether it has, in time."""
    deadline_ns = clock.monotonic_ns() + int(seconds * 1e9)
    while not gateway.quiet:
        if clock.monotonic_ns() > deadline_ns:
            return False
        await clock.sleep(EVERY_S)
    return True
