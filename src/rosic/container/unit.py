"""One principal's and one robot's container: units that share nothing (I11)."""

from __future__ import annotations

from collections import OrderedDict
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from collections import Counter

    from rosic.core.identity import PrincipalId
    from rosic.core.robot.profile import RobotId

CHATS_AT_MOST = 64
SHARED_BYTES: Final = 8
"""With so many begins what stands for any part of a chat."""


class PersonContainer:
    """What belongs to one person: which robot they chose, chat by chat.

    Args:
        principal: They.
        there: Where everybody's chats are counted.
    """

    __slots__ = ("_selected", "_there", "principal")

    def __init__(self, principal: PrincipalId, there: Counter[bytes]) -> None:
        self.principal = principal
        self._there = there
        self._selected: OrderedDict[bytes, str] = OrderedDict()

    def select(self, chat: bytes, name: str) -> None:
        """Choose a robot or a group for a chat; an empty name undoes the choice."""
        if self._selected.pop(chat, None) is not None:
            self._leave(chat)
        if name:
            self._selected[chat] = name
            self._there[chat[:SHARED_BYTES]] += 1
            if len(self._selected) > CHATS_AT_MOST:
                self._leave(self._selected.popitem(last=False)[0])

    def clear(self) -> None:
        """Undo every choice."""
        while self._selected:
            self._leave(self._selected.popitem()[0])

    def _leave(self, chat: bytes) -> None:
        own = chat[:SHARED_BYTES]
        self._there[own] -= 1
        if not self._there[own]:
            del self._there[own]

    def selected(self, chat: bytes) -> str:
        """Return the choice for a chat, empty for none."""
        return self._selected.get(chat, "") if self._selected else ""

    def chose(self, chat: bytes) -> bool:
        """Whether there is a choice for a chat, or for a part of it, that begins so."""
        return any(digest.startswith(chat) for digest in self._selected)


class RobotContainer:
    """What belongs to one robot: the number of its last order."""

    __slots__ = ("n", "robot")

    def __init__(self, robot: RobotId, n: int) -> None:
        self.robot = robot
        self.n = n

    def next_number(self) -> int:
        """Return the next order number; numbers skipped by a failed claim stay skipped (I3)."""
        self.n += 1
        return self.n
