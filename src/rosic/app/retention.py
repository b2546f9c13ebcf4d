"""Once a day: times that are long over, and old administrative acts, are forgotten as was set."""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING

from rosic.core.time_units import DAY_NS

if TYPE_CHECKING:
    from collections.abc import Callable

    from rosic.config.gateway_file import Keep
    from rosic.contracts.store import AuditStore
    from rosic.gateway.transactions import Transactions
    from rosic.organiser.calendar import Calendar


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
