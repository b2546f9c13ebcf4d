"""Keeps how much of the rate limits is used, so that a restart gives nobody more than the limit."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosic.organiser.rate_limits import SAVE_EVERY_S, RateLimits

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from rosic.app.settings import GatewaySettings
    from rosic.contracts.clock import Clock
    from rosic.contracts.store import Store
    from rosic.core.policy.permissions import Permissions
    from rosic.core.records import Fact
    from rosic.core.robot.profile import Profile, RobotId


def rates_of(
    settings: GatewaySettings,
    profiles: Mapping[RobotId, Profile],
    rights: Permissions,
    clock: Clock,
    note: Callable[[Fact], None],
) -> RateLimits:
    """Return what limits people, robots and roles; nothing of it is used yet."""

    def shown(robot: RobotId) -> str:
        return profiles[robot].shown

    return RateLimits(clock, settings.limit, settings.robot_limits, rights.rates, note, shown)


async def save_now_and_then(rates: RateLimits, store: Store, clock: Clock) -> None:
    """Save what changed, at a bounded pace, until cancelled. Waits for no disk and for no turn."""
    while True:
        await clock.sleep(SAVE_EVERY_S)
        save(rates, store)


def save(rates: RateLimits, store: Store) -> None:
    """Save what changed since the last time."""
    facts = rates.save()
    if facts:
        store.note(*facts)
