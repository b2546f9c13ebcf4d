"""Since when we have listened without a gap: a value machine, fed with what the syncs did.

What was sent while nobody listened is backlog. It is stamped as such explicitly
(``listening_since_ns`` one above the receive time), so that no clock decides it. Afterwards the
stamp is the moment at which the sync that found nothing was asked, less a grace, because the
homeserver's clock is not ours. It cannot let backlog in: that came earlier, stamped. What a
homeserver leaves out of one room is backlog of that room (`room_backlog`), and of no other.
"""

from __future__ import annotations

from typing import Final, NamedTuple

from rosic.core.time_units import SECOND_NS

GAP_NS: Final = 5 * SECOND_NS
JUMP_NS: Final = 2 * SECOND_NS
"""Wall and monotonic clock may drift this far apart between two syncs. More is a clock that was
set, or a machine that slept."""
GRACE_NS: Final = 2 * SECOND_NS
SHORT_SYNCS: Final = 3
"""So many syncs in a row without a gap show an empty backlog as well: with people writing all the
time, none comes back empty."""


class SyncMoment(NamedTuple):
    """One moment on both clocks."""

    wall_ns: int
    monotonic_ns: int


class SyncGap:
    """Frozen until what was missed has been received.

    Attributes:
        frozen: What is received now is backlog.
        since_ns: Wall clock; has a meaning while not frozen.
    """

    def __init__(self) -> None:
        self.frozen = True
        self.since_ns = 0
        self._answered: SyncMoment | None = None
        self._short = 0

    def answered(self, now: SyncMoment) -> None:
        """Note that a sync succeeded; call it before stamping what it brought."""
        last, self._answered = self._answered, now
        apart_ns = jumped_ns = 0
        if last is not None:
            apart_ns = now.monotonic_ns - last.monotonic_ns
            jumped_ns = now.wall_ns - last.wall_ns - apart_ns
        if apart_ns > GAP_NS or abs(jumped_ns) > JUMP_NS:
            self.frozen = True
            self._short = 0

    def stamp(self, received_ns: int) -> int:
        """Return ``listening_since_ns`` for a message received now."""
        return received_ns + 1 if self.frozen else self.since_ns

    def drained(self, asked: SyncMoment, *, empty: bool) -> bool:
        """Note what the sync brought, after it was stamped; thaw if that was the backlog.

        Returns:
            True at the moment of thawing.
        """
        if not self.frozen:
            return False
        self._short += 1
        if not (empty or self._short >= SHORT_SYNCS):
            return False
        self.frozen = False
        self.since_ns = asked.wall_ns - GRACE_NS
        return True
