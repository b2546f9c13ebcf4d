"""What has to be done now and then: rights that end, people who wait in vain, counts to write."""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING

from rosic.errors import RosicError

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable

    from rosic.app.access import Access
    from rosic.app.authority import Authority
    from rosic.contracts.clock import Clock
    from rosic.pipeline.people.admitting import Admitting

EVERY_S = 60.0
DAY_NS = 86_400_000_000_000
# A right that ends ends what moves under it within a second.
SOONEST_S = 0.2
BEHIND_S = 2.0

log = logging.getLogger("rosic.minding")


class Minder:
    """One task for all of it."""

    def __init__(
        self,
        access: Access,
        authority: Authority,
        admitting: Admitting,
        daily: Callable[[], Awaitable[None]],
        clock: Clock,
    ) -> None:
        self._daily = daily
        self._day_ns = clock.monotonic_ns()
        self._access = access
        self._authority = authority
        self._admitting = admitting
        self._clock = clock
        self._behind = False

    async def run(self) -> None:
        """Mind until cancelled. What fails is logged and tried again."""
        while True:
            try:
                await self.look()
            except RosicError as fault:
                log.warning("not everything could be minded: %s", fault)
            except Exception:
                log.exception("not everything could be minded")
            await self._clock.sleep(self._pause_s())

    def _pause_s(self) -> float:
        now_ns = self._clock.wall_ns()
        next_ns = self._authority.roster.next_end_ns(now_ns)
        if next_ns is None:
            return EVERY_S
        return min(EVERY_S, max(SOONEST_S, (next_ns - now_ns) / 1e9))

    async def look(self) -> None:
        """Do all that is due.

        Raises:
            RecordUnavailable: Something could not be written; what has ended has ended.
        """
        access, authority = self._access, self._authority
        self._look_at_clock()
        authority.enforce()  # a grant ends by the clock, whether or not that can be written
        async with access.changes.turn() as turn:
            await turn.write(
                (
                    *authority.roster.ended(self._clock.wall_ns()),
                    *access.enrolment.invitations.stale(),
                    *access.time.due(),
                    *access.tally.due(),
                )
            )
        await self._admitting.lapse()
        if self._clock.monotonic_ns() >= self._day_ns:
            await self._daily()
            self._day_ns = self._clock.monotonic_ns() + DAY_NS

    def _look_at_clock(self) -> None:
        """Say once that the machine's clock was set back; it does not count until accepted."""
        behind_s = self._access.time.behind_s()
        if behind_s > BEHIND_S and not self._behind:
            log.warning(
                "the clock of this machine is %.0f s behind the latest time that was seen here; "
                "what has ended stays ended. See: rosic clock",
                behind_s,
            )
        self._behind = behind_s > BEHIND_S
