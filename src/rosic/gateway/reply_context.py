"""Of which robot a message of ours speaks: whoever replies to it means that one."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable

    from rosic.container.container import Containers
    from rosic.core.message import Chat, Inbound
    from rosic.core.robot.profile import RobotId
    from rosic.gateway.message_context import MessageContext

# Messages, at least; at most twice as many.
REMEMBERED = 4_096


class ReplyTargets:
    """Bounded, in memory: of what is forgotten, a robot has to be named again."""

    def __init__(self) -> None:
        # Two generations: the older one is dropped whole, so that no message costs a search.
        self._about: dict[tuple[str, str, str], str] = {}
        self._older: dict[tuple[str, str, str], str] = {}

    def note(self, messenger: str, chat: Chat, message: str, about: str) -> None:
        """Remember of whom a message speaks; empty: of nobody."""
        if not about:
            return
        if len(self._about) >= REMEMBERED:
            self._older, self._about = self._about, {}
        self._about[messenger, chat.id, message] = about

    def of(self, said: MessageContext) -> str:
        """Return whom the message speaks of that somebody replies to; empty: nobody known."""
        return self.answered(said.messenger.name, said.inbound)

    def answered(self, messenger: str, inbound: Inbound) -> str:
        """Return the same of what is no command, such as a place that is sent in reply."""
        where = (messenger, inbound.chat.id, inbound.answers)
        return self._about.get(where) or self._older.get(where, "")


def meant(
    said: MessageContext,
    subjects: ReplyTargets,
    container: Containers,
    visible: frozenset[RobotId],
    members: Callable[[str], tuple[RobotId, ...]],
) -> str:
    """Return who is meant where a reply names nobody: whom it replies to, else whoever was chosen.

    Nobody learns by it of a robot that they may not see.
    """
    about = subjects.of(said)
    if about and visible.intersection(members(about)):
        return about
    return container.selected(said.caller.principal, said.inbound.chat)
