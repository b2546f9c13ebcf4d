"""Keeps how much of the rate limits is used, so that a restart gives nobody more than the limit."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosic.organiser.rates import SAVE_EVERY_S, Rates

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from rosic.app.parts import Settings
    from rosic.contracts.clock import Clock
    from rosic.contracts.store import Store
    from rosic.core.record import Fact
    from rosic.core.rights import Rights
    from rosic.core.robot import Profile, RobotId


def rates_of(
    settings: Settings,
    profiles: Mapping[RobotId, Profile],
    rights: Rights,
    clock: Clock,
    note: Callable[[Fact], None],
) -> Rates:
    """Return what limits people, robots and roles; nothing of it is used yet."""

    def shown(robot: RobotId) -> str:
        return profiles[robot].shown

    return Rates(clock, settings.limit, settings.robot_limits, rights.rates, note, shown)


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
