"""What has to be done now and then: rights that end, people who wait in vain, counts to write."""

from __future__ import annotations

import asyncio
import logging
from typing import TYPE_CHECKING

from rosic.core.time_units import DAY_NS
from rosic.errors import RosicError
from rosic.gateway.scheduling import sleep_or_wake
from rosic.organiser.rate_limits import SAVE_EVERY_S, RateLimits
from rosic.organiser.refusals import CLOCK_SET_BACK

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable, Mapping

    from rosic.app.features import Features
    from rosic.app.settings import GatewaySettings
    from rosic.contracts.clock import Clock
    from rosic.contracts.store import Store
    from rosic.core.policy.permissions import Permissions
    from rosic.core.records import Fact
    from rosic.core.robot.profile import Profile, RobotId
    from rosic.gateway.feature import Kernel

EVERY_S = 60.0
# A right that ends ends what moves under it within a second.
SOONEST_S = 0.2

log = logging.getLogger("rosic.minding")


class Maintenance:
    """Two tasks: one that ends what has ended by the clock, and one for all that is written.

    Args:
        daily: Done once a day.
    """

    def __init__(
        self, kernel: Kernel, features: Features, daily: Callable[[], Awaitable[None]]
    ) -> None:
        self._kernel, self._features, self._daily = kernel, features, daily
        self._access, self._clock = kernel.access, kernel.clock
        self._enforcer, self._authority = kernel.enforcer, kernel.enforcer.policy
        self._day_ns = self._clock.monotonic_ns()
        self._behind = False
        # One each, as each clears its own before it looks.
        self._rights_changed, self._due_changed = asyncio.Event(), asyncio.Event()
        self._authority.when_changed.connect(self._rights_changed.set)
        self._authority.when_changed.connect(self._due_changed.set)

    async def run(self) -> None:
        """Mind until cancelled. What fails is logged and tried again.

        A disk that hangs neither writes nor fails: what ends by the clock never waits behind a
        write (I8).
        """
        async with asyncio.TaskGroup() as both:
            both.create_task(self._again_and_again(self._end_in_time, self._rights_changed))
            both.create_task(self._again_and_again(self.look, self._due_changed))

    async def _again_and_again(
        self, look: Callable[[], Awaitable[None]], changed: asyncio.Event
    ) -> None:
        while True:
            changed.clear()
            try:
                await look()
            except RosicError as fault:
                log.warning("not everything could be minded: %s", fault)
            except Exception:
                log.exception("not everything could be minded")
            # Not past a grant or a key that is given meanwhile: it may end sooner.
            await sleep_or_wake(self._clock, self._pause_s(), changed)

    def _pause_s(self) -> float:
        now_ns = self._clock.wall_ns()
        ends = (
            self._authority.grants_book.next_end_ns(now_ns),
            self._access.keys.next_end_ns(now_ns),
        )
        next_ns = min((end for end in ends if end is not None), default=None)
        if next_ns is None:
            return EVERY_S
        return min(EVERY_S, max(SOONEST_S, (next_ns - now_ns) / 1e9))

    async def _end_in_time(self) -> None:
        """Look at the clock, and end what has ended by it. Waits for nothing."""
        self._look_at_clock()
        self._enforcer.enforce()

    async def look(self) -> None:
        """Write down all that is due.

        Raises:
            RecordUnavailable: Something could not be written; what has ended has ended.
        """
        access, authority = self._access, self._authority
        async with access.changes.turn() as turn:
            now_ns = self._clock.wall_ns()
            over = authority.grants_book.over(now_ns)
            await turn.write(
                (
                    *authority.grants_book.ended(now_ns),
                    *access.enrolment.invitations.stale(),
                    *access.time.due(),
                    *access.counters.due(),
                )
            )
        self._kernel.shared.grants_ended.emit(over)
        await self._features.each_minute()
        if self._clock.monotonic_ns() >= self._day_ns:
            await self._daily()
            self._day_ns = self._clock.monotonic_ns() + DAY_NS

    def _look_at_clock(self) -> None:
        """Say once that the machine's clock was set back; it does not count until accepted."""
        behind_s, behind = self._access.time.behind_s(), self._access.time.behind
        if behind and not self._behind:
            log.warning(
                "the clock of this machine is %.0f s behind the latest time that was seen here; "
                "what has ended stays ended, and nothing new moves. See: rosic clock",
                behind_s,
            )
            self._kernel.reach.tell(self._kernel.admins(), CLOCK_SET_BACK, urgent=True)
        self._behind = behind


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
