"""Forgetting once a day what the record need not know any more."""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING, Protocol, runtime_checkable

if TYPE_CHECKING:
    from rosic.contracts.clock import Clock

SOON_S = 60.0  # a gateway that is restarted every day forgets too, but not while it starts
DAY_S = 86_400.0

log = logging.getLogger("rosic.gateway")


@runtime_checkable
class ForgettingStore(Protocol):
    """A record that can forget commands that are settled and old."""

    async def prune(self) -> int:
        """Forget them. Return how many.

        Raises:
            StoreFault: Not all were forgotten; the rest is tried the next time.
        """
        ...


async def forget_daily(store: ForgettingStore, clock: Clock) -> None:
    """Forget soon after the start, then once a day, until cancelled. What fails is logged."""
    await clock.sleep(SOON_S)
    while True:
        try:
            count = await store.prune()
        except Exception:
            log.exception("old commands could not be forgotten; I try again in a day")
        else:
            if count:
                log.info("%d old commands were forgotten", count)
        await clock.sleep(DAY_S)
