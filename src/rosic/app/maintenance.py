"""What has to be done now and then: rights that end, people who wait in vain, counts to write."""

from __future__ import annotations

import asyncio
import logging
from typing import TYPE_CHECKING, Final

from rosic.contracts.store import FileBackedRecord, RepairableStopFile
from rosic.core.i18n import said
from rosic.core.time_units import DAY_NS
from rosic.errors import RosicError
from rosic.gateway.scheduling import sleep_or_wake
from rosic.organiser.rate_limits import SAVE_EVERY_S, RateLimits
from rosic.organiser.refusals import CLOCK_SET_BACK

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable, Mapping

    from rosic.app.features import Features
    from rosic.app.settings import GatewaySettings
    from rosic.config.gateway_file import Keep
    from rosic.contracts.clock import Clock
    from rosic.contracts.store import AuditStore, Store
    from rosic.core.policy.permissions import Permissions
    from rosic.core.records import Fact
    from rosic.core.robot.profile import Profile, RobotId
    from rosic.gateway.feature import Kernel
    from rosic.gateway.transactions import Transactions
    from rosic.organiser.calendar import Calendar


# ---- record monitor ----

# Says when a file of the data folder vanishes, or is written by somebody else, meanwhile.

LOOK_EVERY_S: Final = 2.0
TOGETHER: Final = "it, or rosic.db, rosic.db-wal and record.mark as they were last,"
BACK: Final = said("The files of my record are all there again. Robots may move.")

log = logging.getLogger("rosic.record")


def lost(file: str) -> str:
    """Return what follows from a file that is gone."""
    return said(
        "{file} of my record is gone or was replaced, emptied or overwritten. Nothing moves until "
        "it is back; stop still works. The operator has to look at the data folder.",
        file=file,
    )


class RecordMonitor:
    """Looks every two seconds; each order is looked at besides, when it is written down.

    Args:
        store: The record.
        latch: The stop file.
        tell: Says a sentence to the admins.
    """

    def __init__(
        self, store: object, latch: object, clock: Clock, tell: Callable[[str], object]
    ) -> None:
        self._store = store
        self._latch = latch
        self._clock = clock
        self._tell = tell
        self._said = ""

    async def run(self) -> None:
        """Look until cancelled."""
        while isinstance(self._store, FileBackedRecord):
            self.say(await asyncio.to_thread(self._store.lost_file))
            if self._said:
                await self._mend()
            await self._clock.sleep(LOOK_EVERY_S)

    async def _mend(self) -> None:
        """Write again what is known here; the mark the record itself writes again."""
        if isinstance(self._latch, RepairableStopFile):
            try:
                await self._latch.mend()
            except (OSError, RosicError) as error:
                log.warning("the stop file cannot be written again: %s", error)

    def lost_file(self) -> str:
        """Return the file that was not there when it was looked for last; empty: all were."""
        return self._said

    def say(self, file: str) -> None:
        """Say what has changed.

        Args:
            file: That is not there now; empty: all are.
        """
        if file == self._said:
            return
        self._said = file
        if file:
            log.error(
                "%s of the record is gone or was replaced, emptied or overwritten: nothing "
                "moves until it is back; end me and put %s back, see rosic doctor",
                file,
                TOGETHER,
            )
        else:
            log.warning("the files of the record are all there again")
        self._tell(lost(file) if file else BACK)


# ---- maintenance ----

# ---- retention ----

# Once a day: times that are long over, and old administrative acts, are forgotten as was set.

log = logging.getLogger("rosic.gateway")


class Retention:
    """Forgets what is kept longer than was set.

    Args:
        keep: How long.
        calendar: Whose slots.
        changes: Through which slots are forgotten.
        ledger: Whose acts; None: they cannot be forgotten.
        wall_ns: What time it is; one that never goes back.
    """

    def __init__(
        self,
        keep: Keep,
        calendar: Calendar,
        changes: Transactions,
        ledger: AuditStore | None,
        wall_ns: Callable[[], int],
    ) -> None:
        self._keep = keep
        self._calendar = calendar
        self._changes = changes
        self._ledger = ledger
        self._wall_ns = wall_ns

    async def forget(self) -> None:
        """Forget, in small steps, so that other changes pass between them.

        Raises:
            RecordUnavailable, StoreFault: Not all was forgotten; the rest is tried again soon.
        """
        now_ns = self._wall_ns()
        slots_ns = now_ns - int(self._keep.slots_days * DAY_NS)
        slots = 0
        while True:
            async with self._changes.turn() as turn:
                facts = self._calendar.outdated(slots_ns)
                await turn.write(facts)
            if not facts:
                break
            slots += len(facts)
        acts = 0
        if self._ledger is not None:
            before_ns = now_ns - int(self._keep.decisions_days * DAY_NS)
            acts = await self._ledger.forget_decisions(before_ns)
        if slots or acts:
            log.info("%d old times and %d old administrative acts were forgotten", slots, acts)


# ---- maintenance ----

EVERY_S = 60.0
# A right that ends ends what moves under it within a second.
SOONEST_S = 0.2

log = logging.getLogger("rosic.maintenance")


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
