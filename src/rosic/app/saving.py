"""Keeps how much of the rate limits is used, so that a restart gives nobody more than the limit."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosic.organiser.rates import SAVE_EVERY_S

if TYPE_CHECKING:
    from rosic.contracts.clock import Clock
    from rosic.contracts.store import Store
    from rosic.organiser.rates import Rates


async def save_now_and_then(rates: Rates, store: Store, clock: Clock) -> None:
    """Save what changed, at a bounded pace, until cancelled. Waits for no disk and for no turn."""
    while True:
        await clock.sleep(SAVE_EVERY_S)
        save(rates, store)


def save(rates: Rates, store: Store) -> None:
    """Save what changed since the last time."""
    facts = rates.save()
    if facts:
        store.note(*facts)
