"""Who hears what a robot says of its own accord (Algorithm 8): whoever spoke to it last."""

from __future__ import annotations

from collections import OrderedDict
from typing import TYPE_CHECKING, TypeAlias

from rosic.contracts.messenger import Messenger
from rosic.core.identity import PrincipalId
from rosic.core.message import Chat

if TYPE_CHECKING:
    from rosic.core.robot.profile import RobotId
    from rosic.organiser.organiser import Organiser

CHATS_AT_MOST = 8

Ear: TypeAlias = tuple[Messenger, Chat]
_Spoken: TypeAlias = tuple[Messenger, Chat, PrincipalId]


class RobotFollowers:
    """Per robot, the chats that used or commanded it last. In memory, bounded."""

    def __init__(self, organiser: Organiser) -> None:
        self._organiser = organiser
        self._chats: dict[RobotId, OrderedDict[tuple[str, str], _Spoken]] = {}

    def note(self, robot: RobotId, messenger: Messenger, chat: Chat, who: PrincipalId) -> None:
        """Remember that somebody spoke to a robot from a chat."""
        chats = self._chats.get(robot)
        if chats is None:
            chats = self._chats[robot] = OrderedDict()
        where = (messenger.name, chat.id)
        chats[where] = (messenger, chat, who)
        chats.move_to_end(where)
        if len(chats) > CHATS_AT_MOST:
            chats.popitem(last=False)

    def leave(self, messenger: str, chat: str, who: PrincipalId | None = None) -> None:
        """Tell a chat nothing more: we were put out of it, or they left who had spoken there."""
        where = (messenger, chat)
        for chats in self._chats.values():
            if where in chats and who in (None, chats[where][2]):
                del chats[where]

    def of(self, robot: RobotId) -> tuple[Ear, ...]:
        """Return the chats to tell, leaving out people who may not see the robot any more."""
        return tuple(
            (messenger, chat)
            for messenger, chat, who in self._chats.get(robot, OrderedDict()).values()
            if robot in self._organiser.visible(who)
        )
