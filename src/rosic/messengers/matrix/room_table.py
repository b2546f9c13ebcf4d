"""Which rooms this account is in and who is there, as the homeserver says: it may say anything."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

from rosic.messengers.matrix.sync_answer import LONGEST_ID

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping

MEMBER: Final = "m.room.member"
ENCRYPTION: Final = "m.room.encryption"
NAME: Final = "m.room.name"
CREATE: Final = "m.room.create"
HISTORY: Final = "m.room.history_visibility"
ROOMS_AT_MOST: Final = 20_000
MEMBERS_AT_MOST: Final = 50_000
"""Of one room. It is a group by then; who is more is nobody's member."""
LONGEST_NAME: Final = 100


class JoinedRoom:
    """One room.

    Attributes:
        users: Members, and who was invited, with the names that they are shown by.
        invited_users: Those of them who were invited.
        encrypted: Once it was, nothing that the homeserver says undoes it.
        name: As it is shown; empty for none.
        version: Another one after somebody came or went.
        creator: Who made it; empty while that is not known.
        is_open: Whoever is in no room at all may read it.
    """

    def __init__(self, *, encrypted: bool) -> None:
        self.users: dict[str, str] = {}
        self.invited_users: set[str] = set()
        self.encrypted = encrypted
        self.name = ""
        self.version = 0
        self.creator = ""
        self.is_open = False

    def follow(self, source: Mapping[str, Any]) -> None:
        """Take a part of the room's state."""
        kind, key, content = source.get("type"), source.get("state_key"), source.get("content")
        if not isinstance(content, dict) or not isinstance(key, str):
            return
        if kind == MEMBER:
            self._member(key, content)
        elif kind == ENCRYPTION and not key:
            self.encrypted = True
        elif not key:
            self._described(kind, source, content)

    def _described(
        self, kind: object, source: Mapping[str, Any], content: Mapping[str, Any]
    ) -> None:
        if kind == NAME:
            self.name = shown_name(content.get("name"))
        elif kind == HISTORY:
            self.is_open = content.get("history_visibility") == "world_readable"
        elif kind == CREATE and not self.creator:
            self.creator = str(source.get("sender"))[:LONGEST_ID]

    def is_between(self, us: str, user: str) -> bool:
        """Whether one of two has made this room for both, and nobody else reads it.

        A room that somebody else made and left is none: they chose who may read it. Whoever was
        merely invited is there only if we have invited them.
        """
        if len(self.users) != 2 or user not in self.users or us not in self.users:  # noqa: PLR2004
            return False
        own = self.creator == us
        joined = user not in self.invited_users
        return (own or (joined and self.creator == user)) and (self.encrypted or not self.is_open)

    def _member(self, user: str, content: Mapping[str, Any]) -> None:
        now = content.get("membership")
        self.version += 1
        if now in {"join", "invite"} and len(user) <= LONGEST_ID:
            if user not in self.users and len(self.users) >= MEMBERS_AT_MOST:
                return
            self.users[user] = shown_name(content.get("displayname"))
            if now == "invite":
                self.invited_users.add(user)
            else:
                self.invited_users.discard(user)
        elif now in {"leave", "ban"}:
            self.users.pop(user, None)
            self.invited_users.discard(user)


class RoomTable:
    """The rooms of one account."""

    def __init__(self) -> None:
        self._encrypted: set[str] = set()
        self._rooms: dict[str, JoinedRoom] = {}

    def were_encrypted(self, rooms: Iterable[str]) -> None:
        """Take these rooms for encrypted, whatever is said of them from now on."""
        self._encrypted.update(rooms)

    def __contains__(self, room: object) -> bool:
        return room in self._rooms

    def __getitem__(self, room: str) -> JoinedRoom:
        return self._rooms[room]

    def __iter__(self) -> Iterator[str]:
        return iter(self._rooms)

    def get(self, room: str) -> JoinedRoom | None:
        """Return a room that we are in; None for any other."""
        return self._rooms.get(room)

    def entered(self, room: str) -> JoinedRoom | None:
        """Return a room that an answer says we are in; None where there are too many."""
        found = self._rooms.get(room)
        if found is None and len(self._rooms) < ROOMS_AT_MOST:
            found = self._rooms[room] = JoinedRoom(encrypted=room in self._encrypted)
        return found

    def newly_encrypted(self, room: str) -> bool:
        """Whether a room is encrypted, and was not when this was asked before."""
        found = self._rooms.get(room)
        if found is None or not found.encrypted or room in self._encrypted:
            return False
        self._encrypted.add(room)
        return True

    def left(self, room: str) -> None:
        """Forget who was in a room that we are not in any more."""
        self._rooms.pop(room, None)


def shown_name(value: object) -> str:
    """Return a name that somebody chose, cut; empty for what is none."""
    return value[:LONGEST_NAME] if isinstance(value, str) else ""
