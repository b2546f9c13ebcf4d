"""One principal's and one robot's container: units that share nothing (I11)."""

from __future__ import annotations

from collections import OrderedDict
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rosic.core.identity import PrincipalId
    from rosic.core.robot import RobotId

CHATS_AT_MOST = 64


class PersonContainer:
    """What belongs to one person: which robot they chose, chat by chat."""

    __slots__ = ("_selected", "principal")

    def __init__(self, principal: PrincipalId) -> None:
        self.principal = principal
        self._selected: OrderedDict[bytes, str] = OrderedDict()

    def select(self, chat: bytes, name: str) -> None:
        """Choose a robot or a group for a chat; an empty name undoes the choice."""
        self._selected.pop(chat, None)
        if name:
            self._selected[chat] = name
            if len(self._selected) > CHATS_AT_MOST:
                self._selected.popitem(last=False)

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
