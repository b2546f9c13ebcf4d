"""What people had chosen before, chat by chat, so that a choice can be taken back."""

from __future__ import annotations

from collections import OrderedDict
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from rosic.core.identity import PrincipalId
    from rosic.core.message import Chat

PLACES_AT_MOST: Final = 10_000
STEPS_AT_MOST: Final = 8


class SelectionHistory:
    """Each person's way to their present choice. In memory: of an earlier run only the end is kept.

    Bounded: places where nobody has chosen for longest are forgotten first, and of each the oldest.
    """

    def __init__(self, at_most: int = PLACES_AT_MOST) -> None:
        self._at_most = at_most
        self._steps: OrderedDict[tuple[PrincipalId, str, str, str], tuple[str, ...]] = OrderedDict()

    def note(self, principal: PrincipalId, chat: Chat, name: str) -> None:
        """Somebody has just chosen anew where this was chosen; empty: nothing was."""
        key = _key(principal, chat)
        steps = (*self._steps.pop(key, ()), name)
        self._steps[key] = steps[-STEPS_AT_MOST:]
        if len(self._steps) > self._at_most:
            self._steps.popitem(last=False)

    def has(self, principal: PrincipalId, chat: Chat) -> bool:
        """Whether there is a choice to take back."""
        return _key(principal, chat) in self._steps

    def take(self, principal: PrincipalId, chat: Chat) -> str | None:
        """Return what was chosen before the last choice, and forget it; None if that is unknown."""
        key = _key(principal, chat)
        steps = self._steps.pop(key, ())
        if len(steps) > 1:
            self._steps[key] = steps[:-1]
        return steps[-1] if steps else None


def _key(principal: PrincipalId, chat: Chat) -> tuple[PrincipalId, str, str, str]:
    return principal, chat.platform, chat.id, chat.topic
