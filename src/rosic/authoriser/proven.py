"""Who has proven in which chat that they hold their phone. In memory only, and not for long."""

from __future__ import annotations

from collections import OrderedDict
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from rosic.authoriser.highwater import HighWater
    from rosic.core.identity import PrincipalId
    from rosic.core.message import Chat

IDLE_NS: Final = 3_600_000_000_000
PROVEN_AT_MOST: Final = 20_000


class Proven:
    """Principal and chat to the last use; an idle hour ends it, on the monotonic clock."""

    def __init__(self, time: HighWater) -> None:
        self._time = time
        self._used_ns: OrderedDict[tuple[PrincipalId, str, str], int] = OrderedDict()

    def fresh(self, principal: PrincipalId, chat: Chat) -> bool:
        """Whether an hour without use has not passed."""
        used_ns = self._used_ns.get((principal, chat.platform, chat.id))
        return used_ns is not None and self._time.monotonic_ns() - used_ns < IDLE_NS

    def refresh(self, principal: PrincipalId, chat: Chat) -> None:
        """Begin the hour anew. Bounded: those used longest ago go first."""
        where = (principal, chat.platform, chat.id)
        self._used_ns[where] = self._time.monotonic_ns()
        self._used_ns.move_to_end(where)
        if len(self._used_ns) > PROVEN_AT_MOST:
            self._used_ns.popitem(last=False)

    def end(self, principal: PrincipalId) -> None:
        """Forget somebody in every chat; looks at all of them, which is rare."""
        for where in [where for where in self._used_ns if where[0] == principal]:
            del self._used_ns[where]
