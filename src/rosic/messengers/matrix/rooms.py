"""Which rooms we are in, what kind each is, and what happens to them."""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING, Any, Final

from rosic.core.identity import Address
from rosic.core.message import Chat, ChatEvent, ChatEventKind, ChatKind
from rosic.errors import MessengerFault
from rosic.messengers.matrix.incoming import PLATFORM
from rosic.messengers.matrix.private_rooms import PrivateRooms
from rosic.messengers.matrix.room_calls import ENCRYPTION, RoomCalls
from rosic.messengers.matrix.room_table import CREATE

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping, Sequence

    from rosic.contracts.messenger import Knows, Passed
    from rosic.messengers.matrix.client import MatrixClient

MEMBER: Final = "m.room.member"
TOMBSTONE: Final = "m.room.tombstone"
PRIVATE_MEMBERS: Final = 2
MOVES_AT_MOST: Final = 100
"""Rooms that are waited for until somebody invites us there; anybody may name any."""
JOINS_AT_MOST: Final = 20
"""Rooms joined after one sync; anybody may invite us into any number."""
INVITED_AT_MOST: Final = 1_000
"""Invitations of strangers that wait to be accepted or declined; of more nothing is noted."""
DIRECT_AT_MOST: Final = 500
"""Direct chats with strangers that are entered in one run; after that they are declined."""

log = logging.getLogger("rosic.messengers.matrix")


class Rooms:
    """Joins, leaves, and tells whoever watches.

    Args:
        name: Of the messenger, for the log.
        encrypted_only: People are told nothing in private where it is not encrypted.

    Attributes:
        private: Those with one person alone.
    """

    def __init__(self, name: str, client: MatrixClient, *, encrypted_only: bool) -> None:
        self.private = PrivateRooms(name, client, encrypted_only=encrypted_only)
        self._name = name
        self._client = client
        self._calls = RoomCalls(client)
        self._known: Knows = _nobody
        self._passed: Passed = _untold
        self._invited: dict[str, bool] = {}
        self._moving: dict[str, str] = {}
        self._uninvited: dict[str, str] = {}
        self._direct = 0

    def begin(self, known: Knows, passed: Passed) -> None:
        """Begin a run: ask and tell these; say first that everything is heard in every room."""
        self._known, self._passed = known, passed
        self._invited, self._moving, self._direct = {}, {}, 0
        self._uninvited = {}
        self._tell(ChatEvent(chat=Chat(PLATFORM, ""), what=ChatEventKind.HEARING))

    def kind(self, room: str) -> ChatKind:
        """Return how many can read along: two at the most, invited ones counted, are private."""
        few = len(self._client.members(room)) <= PRIVATE_MEMBERS
        return ChatKind.PRIVATE if few else ChatKind.GROUP

    def chat(self, room: str) -> Chat:
        """Return a room as a chat."""
        return Chat(PLATFORM, room, self.kind(room))

    # ---- what a sync says ----

    def invited(self, room: str, state: Iterable[Mapping[str, Any]]) -> None:
        """Note where we were invited to, from what a sync shows of it.

        A direct chat is entered whoever asks for it: that is how somebody new begins.
        """
        for source in state:
            if source.get("type") != MEMBER or source.get("state_key") != self._client.user:
                continue
            content, sender = source.get("content"), source.get("sender")
            direct = isinstance(content, dict) and content.get("is_direct") is True
            known = isinstance(sender, str) and self._known(Address(PLATFORM, sender))
            if room in self._invited or len(self._invited) < INVITED_AT_MOST or known:
                self._invited[room] = known or (direct and self._may_enter())

    def left(self, rooms: Iterable[str]) -> None:
        """Note rooms that we are not in any more."""
        for room in rooms:
            self._invited.pop(room, None)
            self._tell(
                ChatEvent(chat=Chat(PLATFORM, room, ChatKind.GROUP), what=ChatEventKind.REMOVED)
            )

    def happened(self, room: str, source: Mapping[str, Any]) -> None:
        """Follow an event that is about the room itself."""
        self.private.appeared(room)
        content = source.get("content")
        if not isinstance(content, dict) or "state_key" not in source:
            return
        if source.get("type") == MEMBER:
            self._member(room, source, content)
        elif source.get("type") == TOMBSTONE:
            replacement = content.get("replacement_room")
            if isinstance(replacement, str) and replacement.startswith("!"):
                self._moving[room] = replacement

    def _member(self, room: str, source: Mapping[str, Any], content: Mapping[str, Any]) -> None:
        who, sender = source.get("state_key"), source.get("sender")
        # Whoever has left was there: a group of three is not private before.
        there = self._client.members(room) | ({who} if isinstance(who, str) else set())
        if not isinstance(who, str) or len(there) <= PRIVATE_MEMBERS:
            return
        now, before = str(content.get("membership")), _before(source)
        by = Address(PLATFORM, sender) if isinstance(sender, str) else None
        if who == self._client.user:
            if now == "join" and before != "join":
                what, told = ChatEventKind.ADDED, by
            else:
                return
        elif now in {"leave", "ban"} and before == "join":
            what, told = ChatEventKind.LEFT, Address(PLATFORM, who)
        else:
            return
        chat = Chat(PLATFORM, room, ChatKind.GROUP)
        self._tell(ChatEvent(chat=chat, what=what, who=told, title=self._title(room)))

    def _title(self, room: str) -> str:
        found = self._client.rooms.get(room)
        return "" if found is None else str(found.name or "")

    def _may_enter(self) -> bool:
        self._direct += 1
        return self._direct <= DIRECT_AT_MOST

    # ---- what follows from it ----

    @property
    def has_work(self) -> bool:
        """Whether there is a room to join or to decline."""
        return bool(self._invited or self._moving)

    async def follow(self) -> None:
        """Join where we are welcome, decline the rest, and go where rooms have moved."""
        for room in list(self._invited)[:JOINS_AT_MOST]:
            welcome = self._invited.pop(room)
            done = await self._attempt(self._calls.join if welcome else self._calls.leave, room)
            if welcome and done and room in self._uninvited:
                self._moving[self._uninvited.pop(room)] = room
        for old, new in list(self._moving.items())[:JOINS_AT_MOST]:
            del self._moving[old]
            await self._move(old, new)

    async def _move(self, old: str, new: str) -> None:
        """Go where a room has moved: now, or once somebody invites us there."""
        was_there = new in self._client.rooms
        if not await self._attempt(self._calls.join, new):
            self._uninvited[new] = old
            while len(self._uninvited) > MOVES_AT_MOST:
                del self._uninvited[next(iter(self._uninvited))]
            return
        if not await self._is_successor(old, new):
            if not was_there:  # anybody who may change a room can name any other
                await self._attempt(self._calls.leave, new)
            return
        self._tell(
            ChatEvent(
                chat=Chat(PLATFORM, old, ChatKind.GROUP), what=ChatEventKind.MOVED, new_id=new
            )
        )

    async def _is_successor(self, old: str, new: str) -> bool:
        """Whether a room says of itself that it follows another: both must say so.

        An upgraded room that is not encrypted any more follows nothing.
        """
        try:
            created = await self._calls.state(new, CREATE)
            encrypted = await self._calls.state(new, ENCRYPTION)
        except MessengerFault:
            return False
        before = created.get("predecessor")
        named = isinstance(before, dict) and before.get("room_id") == old
        return named and (bool(encrypted) or not self._client.is_encrypted(old))

    async def _attempt(self, act: Callable[[str], Any], room: str) -> bool:
        try:
            await act(room)
        except MessengerFault as fault:
            log.info("%s: a room was not entered or left: %s", self._name, fault)
            return False
        return True

    def _tell(self, passing: ChatEvent) -> None:
        try:
            self._passed(passing)
        except Exception:
            log.exception("%s: what happened to a room was not followed", self._name)


def entered_at(events: Sequence[Mapping[str, Any]], own: str) -> int:
    """Return where in what a sync brought of a room our own time there begins; 0: before it.

    What was written since we were invited is meant for us: people write before we have joined.
    Events are looked at as they came: what any member encrypted is no event of the room itself.
    """
    joined = invited = 0
    for number, source in enumerate(events):
        if source.get("type") != MEMBER or source.get("state_key") != own:
            continue
        content = source.get("content")
        membership = content.get("membership") if isinstance(content, dict) else None
        if membership == "invite":
            invited = number + 1
        elif membership == "join" and _before(source) != "join":
            joined = number + 1
    return invited or joined


def _before(source: Mapping[str, Any]) -> object:
    unsigned = source.get("unsigned")
    before = unsigned.get("prev_content") if isinstance(unsigned, dict) else None
    return before.get("membership") if isinstance(before, dict) else None


def _nobody(_who: Address) -> bool:
    return False


def _untold(_what: object) -> None:
    pass
