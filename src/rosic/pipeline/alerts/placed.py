"""Which messages tell of which alarms: whoever reacts to one means those occurrences."""

from __future__ import annotations

from collections import OrderedDict
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from rosic.contracts.messenger import Messenger
    from rosic.core.message import Chat

REMEMBERED = 4_096


class Occurrence(NamedTuple):
    """One alarm: its rule, and when it was raised. A later one of the same rule is another."""

    rule: str
    at_ns: int


class Placed:
    """Bounded, in memory: what an earlier run said is told again if nobody has seen it."""

    def __init__(self) -> None:
        self._known: OrderedDict[tuple[str, str, str], tuple[Occurrence, ...]] = OrderedDict()

    def note(
        self, told: tuple[Occurrence, ...], messenger: Messenger, chat: Chat, message: str
    ) -> None:
        """A message tells of one alarm, or of many."""
        self._known[messenger.name, chat.id, message] = told
        if len(self._known) > REMEMBERED:
            self._known.popitem(last=False)

    def of(self, messenger: Messenger, chat: Chat, message: str) -> tuple[Occurrence, ...]:
        """Return of which alarms a message tells."""
        return self._known.get((messenger.name, chat.id, message), ())

    def answered(self, messenger: Messenger, chat: Chat, message: str) -> None:
        """What is put beside this message from now on says nothing new."""
        self._known.pop((messenger.name, chat.id, message), None)
