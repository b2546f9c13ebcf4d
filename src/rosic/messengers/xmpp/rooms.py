"""Who is in the rooms that we take part in, by the address that the room's service names."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from rosic.core.identity import Address
from rosic.core.message import Chat, ChatEvent, ChatEventKind, ChatKind
from rosic.messengers.xmpp.stanzas import PLATFORM, USER

if TYPE_CHECKING:
    from collections.abc import Callable
    from xml.etree.ElementTree import Element

    from rosic.messengers.xmpp.settings import XmppSettings

EVERYBODY_SEEN: Final = "100"
OURSELVES: Final = "110"
HIDDEN_FROM_NOW: Final = frozenset({"173", "174"})
NEW_NICK: Final = "303"
PUT_OUT: Final = frozenset({"301", "321"})


class RoomOccupants:
    """Knows everybody in them. A nickname is shown, and nobody is known by it."""

    def __init__(self, settings: XmppSettings) -> None:
        self._nick = settings.nick
        self._there: dict[str, dict[str, str]] = {room: {} for room in settings.rooms}

    def __contains__(self, room: str) -> bool:
        return room in self._there

    def left(self) -> None:
        """Know that we are in none any more."""
        for people in self._there.values():
            people.clear()

    def is_in(self, room: str) -> bool:
        """Whether we are in a room that shows who is there."""
        return self._nick in self._there.get(room, ())

    def who(self, room: str, nick: str) -> str:
        """Return the account of somebody who is in a room now; empty where it is not known."""
        return self._there.get(room, {}).get(nick, "") if self.is_in(room) else ""

    def happened(
        self, xml: Element, refuse: Callable[[str], None], passed: Callable[[ChatEvent], None]
    ) -> None:
        """Follow what a room says of itself and of somebody in it.

        Args:
            xml: As it came from a room.
            refuse: Called with a room that hides addresses: nobody is there then.
            passed: Told who left, and that we were put out.
        """
        room, _, nick = xml.get("from", "").partition("/")
        people = self._there[room]
        codes = {one.get("code", "") for one in xml.iterfind(f"{USER}x/{USER}status")}
        gone = xml.get("type") in {"unavailable", "error"}
        ours = OURSELVES in codes
        if codes & HIDDEN_FROM_NOW or (ours and not gone and EVERYBODY_SEEN not in codes):
            people.clear()
            refuse(room)
        elif not gone and nick:
            item = xml.find(f"{USER}x/{USER}item")
            people[nick] = "" if item is None else item.get("jid", "").partition("/")[0]
        elif gone and NEW_NICK not in codes:
            who, chat = people.pop(nick, ""), Chat(PLATFORM, room, ChatKind.GROUP)
            if ours:
                people.clear()
                passed(ChatEvent(chat=chat, what=ChatEventKind.REMOVED))
            elif codes & PUT_OUT and who:
                who_left = Address(PLATFORM, who)
                passed(ChatEvent(chat=chat, what=ChatEventKind.LEFT, who=who_left))
        elif gone:
            people.pop(nick, None)
