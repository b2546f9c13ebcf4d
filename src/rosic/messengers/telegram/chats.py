"""What has to be remembered about chats: groups that moved, long messages, buttons that stop."""

from __future__ import annotations

from collections import OrderedDict
from typing import TYPE_CHECKING, TypeVar

from rosic.core.language import hears_stop

if TYPE_CHECKING:
    from collections.abc import Callable

    from rosic.core.message import Outbound

K = TypeVar("K")
V = TypeVar("V")

REMEMBERED = 4_096


class Chats:
    """Bounded: what is oldest is forgotten first, and each loss is a small one.

    Without the new id of a group Telegram tells it once more; without the parts of a long message
    it cannot be edited any more; without its nonce a tap on stop keeps to the order of its chat;
    of a chat that we were put out of Telegram says so once more; what was said since a group moved
    is taken for lost with the old group, and said again.

    Args:
        on_moved: Hears the old and the new id of a group, before anything is said to be lost.
    """

    def __init__(self, on_moved: Callable[[str, str], None]) -> None:
        self._on_moved = on_moved
        self._moved: OrderedDict[str, str] = OrderedDict()
        self._since: OrderedDict[tuple[str, str], None] = OrderedDict()
        self._parts: OrderedDict[tuple[str, str], tuple[str, ...]] = OrderedDict()
        self._stops: OrderedDict[str, None] = OrderedDict()
        self._gone: OrderedDict[str, bool] = OrderedDict()

    def moved(self, old: str, new: str) -> None:
        """Remember where a group is now."""
        if old != new and self._moved.get(old) != new:
            _remember(self._moved, old, new)
            self._on_moved(old, new)

    def where(self, chat: str) -> str:
        """Return the id under which a chat is reached now."""
        for _ in range(3):  # a supergroup does not move again; a loop of ids would be an attack
            if chat not in self._moved:
                break
            chat = self._moved[chat]
        return chat

    def sent(self, chat: str, message: str) -> str:
        """Remember what was said to a group by its old id since it moved; return the message."""
        if chat in self._moved:
            _remember(self._since, (chat, message), None)
        return message

    def lost(self, chat: str, message: str) -> bool:
        """Whether a message stayed behind in a group that has moved since.

        A supergroup counts its messages anew: there its number is another's, now or later.
        """
        return chat in self._moved and (chat, message) not in self._since

    def left(self, chat: str, *, begun: bool = True) -> None:
        """Remember that we were put out of a chat, or blocked; or that nobody there has begun."""
        _remember(self._gone, chat, begun)

    def back(self, chat: str) -> None:
        """We are let in again, or somebody there speaks to us."""
        self._gone.pop(chat, None)

    def gone(self, chat: str) -> bool:
        """Whether nothing can be said in a chat."""
        return chat in self._gone

    def begun(self, chat: str) -> bool:
        """Whether a chat in which nothing can be said was ever open to us, as far as is known."""
        return self._gone.get(chat, True)

    def split(self, chat: str, parts: tuple[str, ...]) -> None:
        """Remember which messages make up a long one; it goes by the id of the last."""
        if len(parts) > 1:
            _remember(self._parts, (chat, parts[-1]), parts)
        else:
            self._parts.pop((chat, parts[-1]), None)

    def parts(self, chat: str, message: str) -> tuple[str, ...]:
        """Return the messages that make up this one."""
        return self._parts.get((chat, message), (message,))

    def offered(self, outbound: Outbound) -> None:
        """Remember which of the buttons stop, so that a tap on one overtakes what waits."""
        for row in outbound.buttons:
            for button in row:
                if hears_stop(button.command) is not None:
                    _remember(self._stops, button.nonce, None)

    def stops(self, nonce: str) -> bool:
        """Whether the button with this nonce says stop."""
        return nonce in self._stops


def _remember(table: OrderedDict[K, V], key: K, value: V) -> None:
    table[key] = value
    table.move_to_end(key)
    while len(table) > REMEMBERED:
        table.popitem(last=False)
