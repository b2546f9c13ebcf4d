"""Of which robot a message of ours speaks: whoever replies to it means that one."""

from __future__ import annotations

from collections import OrderedDict
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable

    from rosic.container.container import Containers
    from rosic.core.message import Chat
    from rosic.core.robot import RobotId
    from rosic.pipeline.said import Said

REMEMBERED = 8_192


class Subjects:
    """Bounded, in memory: of what is forgotten, a robot has to be named again."""

    def __init__(self) -> None:
        self._about: OrderedDict[tuple[str, str, str], str] = OrderedDict()

    def note(self, messenger: str, chat: Chat, message: str, about: str) -> None:
        """Remember of whom a message speaks; empty: of nobody."""
        if not about:
            return
        where = (messenger, chat.id, message)
        self._about[where] = about
        self._about.move_to_end(where)
        if len(self._about) > REMEMBERED:
            self._about.popitem(last=False)

    def of(self, said: Said) -> str:
        """Return whom the message speaks of that somebody replies to; empty: nobody known."""
        inbound = said.inbound
        return self._about.get((said.messenger.name, inbound.chat.id, inbound.answers), "")


def meant(
    said: Said,
    subjects: Subjects,
    container: Containers,
    visible: frozenset[RobotId],
    members: Callable[[str], tuple[RobotId, ...]],
) -> str:
    """Return who is meant where a line names nobody: whom it replies to, else whoever was chosen.

    Nobody learns by it of a robot that they may not see.
    """
    about = subjects.of(said) if said.inbound.answers else ""
    if about and visible.intersection(members(about)):
        return about
    return container.selected(said.caller.principal, said.inbound.chat)
