"""Who has proven in which chat that they hold their phone. In memory only, and not for long."""

from __future__ import annotations

from collections import OrderedDict
from typing import TYPE_CHECKING, Final

from rosic.contracts.clock import ClockReading, passed_ns, reading

if TYPE_CHECKING:
    from rosic.authoriser.monotonic_clock import MonotonicWallClock
    from rosic.core.identity import PrincipalId
    from rosic.core.message import Chat

IDLE_NS: Final = 3_600_000_000_000
PROVEN_AT_MOST: Final = 20_000


class SecondFactorSessions:
    """Principal and chat to the last use; an idle hour ends it, by either clock."""

    def __init__(self, time: MonotonicWallClock) -> None:
        self._time = time
        self._used: OrderedDict[tuple[PrincipalId, str, str], ClockReading] = OrderedDict()

    def fresh(self, principal: PrincipalId, chat: Chat) -> bool:
        """Whether an hour without use has not passed."""
        used = self._used.get((principal, chat.platform, chat.id))
        return used is not None and passed_ns(self._time, used) < IDLE_NS

    def refresh(self, principal: PrincipalId, chat: Chat) -> None:
        """Begin the hour anew. Bounded: those used longest ago go first."""
        where = (principal, chat.platform, chat.id)
        self._used[where] = reading(self._time)
        self._used.move_to_end(where)
        if len(self._used) > PROVEN_AT_MOST:
            self._used.popitem(last=False)

    def end(self, principal: PrincipalId) -> None:
        """Forget somebody in every chat; looks at all of them, which is rare."""
        for where in [where for where in self._used if where[0] == principal]:
            del self._used[where]
