"""The rooms that we have with one person alone: which it is, and making one where there is none."""

from __future__ import annotations

import asyncio
from collections import OrderedDict
from typing import TYPE_CHECKING, Final

from rosic.errors import MessengerFault
from rosic.messengers.matrix.room_calls import RoomCalls

if TYPE_CHECKING:
    from rosic.messengers.matrix.client import MatrixClient

SPOKE_AT_MOST: Final = 10_000
"""People whose room is remembered; of whoever is forgotten it is looked for again."""
SEEN_WITHIN_S: Final = 30.0
"""Until a sync brings a room that was just made."""


class PrivateRooms:
    """Finds them for one account. A private room is one of two, which one of both has made.

    Args:
        name: Of the messenger.
        encrypted_only: A room without encryption is none: whoever runs the homeserver makes those
            at will, and reads what is told there.
    """

    def __init__(self, name: str, client: MatrixClient, *, encrypted_only: bool) -> None:
        self._name = name
        self._client = client
        self._calls = RoomCalls(client)
        self._encrypted_only = encrypted_only
        self._spoke_in: OrderedDict[str, str] = OrderedDict()
        self._opening = asyncio.Lock()
        self._awaited: dict[str, asyncio.Event] = {}

    def spoke(self, user: str, room: str) -> None:
        """Note in which room somebody has written last."""
        if self._spoke_in.get(user) == room or not self._is_with(user, room):
            return
        self._spoke_in[user] = room
        self._spoke_in.move_to_end(user)
        while len(self._spoke_in) > SPOKE_AT_MOST:
            self._spoke_in.popitem(last=False)

    def find(self, user: str) -> str:
        """Return the room that we have with somebody alone; empty: there is none.

        It is where they wrote last; an encrypted one goes before any other. All rooms are looked
        through only while they have written in none that is.
        """
        last = self._spoke_in.get(user, "")
        if self._client.is_encrypted(last) and self._is_with(user, last):
            return last
        found = [room for room in self._client.rooms if self._is_with(user, room)]
        encrypted = [room for room in found if self._client.is_encrypted(room)]
        if encrypted or self._encrypted_only:
            return max(encrypted, default="")
        return last if last in found else max(found, default="")

    def _is_with(self, user: str, room: str) -> bool:
        known = self._client.rooms.get(room)
        return known is not None and known.is_between(self._client.user, user)

    async def open(self, user: str) -> str:
        """Return the room that we have with somebody alone; make an encrypted one if there is none.

        Raises:
            MessengerFault: There is none, or it cannot be known.
        """
        async with self._opening:
            return self.find(user) or await self._made(user)

    async def _made(self, user: str) -> str:
        room = await self._calls.create_private(user)
        seen = self._awaited.setdefault(room, asyncio.Event())
        try:
            async with asyncio.timeout(SEEN_WITHIN_S):
                # Several syncs may bring it, the invitation last.
                while not (self._is_with(user, room) and self._client.is_encrypted(room)):
                    await seen.wait()
                    seen.clear()
        except TimeoutError:
            raise MessengerFault(
                f"The messenger {self._name} does not see the room that it made. Nothing was sent."
            ) from None
        finally:
            del self._awaited[room]
        await self._client.upkeep()  # of whoever is invited, to read what is said before they join
        return room

    def appeared(self, room: str) -> None:
        """Hear of something that a sync has brought of a room."""
        seen = self._awaited.get(room)
        if seen is not None:
            seen.set()
