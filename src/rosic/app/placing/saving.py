"""Keeps how much of the rate limits is used, so that a restart gives nobody more than the limit."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosic.organiser.rates import SAVE_EVERY_S

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from rosic.contracts.clock import Clock
    from rosic.contracts.store import Store
    from rosic.core.rate import RateLimit
    from rosic.core.record import Fact
    from rosic.core.robot import Profile, RobotId
    from rosic.organiser.organiser import Organiser
    from rosic.organiser.rates import Rates


def limit_rates(
    organiser: Organiser,
    profiles: Mapping[RobotId, Profile],
    robots: Mapping[RobotId, RateLimit],
    note: Callable[[Fact], None],
) -> None:
    """Let robots and roles be asked only as often as was set, and say who keeps what is used.

    Before what was used is restored: it is taken over only for whom there is a limit.
    """
    rates = organiser.rates
    rates.robots, rates.roles = robots, organiser.rights.rates
    rates.shown_of = lambda robot: profiles[robot].shown
    rates.note = note


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
