"""What is asked of a homeserver about one room."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final
from urllib.parse import quote, urlencode

from rosic.messengers.matrix.connection import API
from rosic.messengers.matrix.errors import MatrixError, MatrixErrorKind
from rosic.messengers.matrix.olm_machine import EventDecryptionError
from rosic.messengers.matrix.sync_answer import earlier_part, event_of

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rosic.messengers.matrix.client import MatrixClient

ENCRYPTION: Final = "m.room.encryption"
MEGOLM: Final = "m.megolm.v1.aes-sha2"


class RoomCalls:
    """Makes them for one account."""

    def __init__(self, client: MatrixClient) -> None:
        self._client = client

    async def state(self, room: str, kind: str) -> dict[str, Any]:
        """Return a part of a room's state; empty where there is none.

        Raises:
            MatrixError: It cannot be known.
        """
        path = f"{API}/rooms/{quote(room, safe='')}/state/{quote(kind, safe='')}"
        try:
            found: dict[str, Any] = await self._client.persist(
                lambda: self._client.call("GET", path)
            )
        except MatrixError as error:
            if error.kind is MatrixErrorKind.NOT_FOUND:
                return {}
            raise
        return found

    async def set_state(self, room: str, kind: str, content: Mapping[str, Any]) -> None:
        """Change a part of a room's state.

        Raises:
            MatrixError: Not changed, or it cannot be known.
        """
        path = f"{API}/rooms/{quote(room, safe='')}/state/{quote(kind, safe='')}"
        await self._client.persist(lambda: self._client.call("PUT", path, content))

    async def read_own(self, room: str, message: str) -> dict[str, Any] | None:
        """Return what a message of ours was sent with; None where there is none, or no more.

        Raises:
            MatrixError: It cannot be known.
        """
        path = f"{API}/rooms/{quote(room, safe='')}/event/{quote(message, safe='')}"
        try:
            found = await self._client.persist(lambda: self._client.call("GET", path))
        except MatrixError as error:
            if error.kind in {
                MatrixErrorKind.NOT_FOUND,
                MatrixErrorKind.FORBIDDEN,
                MatrixErrorKind.REFUSED,
            }:
                return None
            raise
        if found.get("sender") != self._client.user:
            return None
        try:
            event = self._client.machine.open_room_event(room, found, 0, note=False)
        except EventDecryptionError:
            return None
        content = event.source.get("content")
        return content if isinstance(content, dict) and "body" in content else None

    async def create_private(self, user: str) -> str:
        """Make an encrypted room for somebody and us alone, invite them, and return its id.

        Raises:
            MatrixError: Not made, or it cannot be known.
        """
        encryption = {"type": ENCRYPTION, "content": {"algorithm": MEGOLM}}
        asked = {
            "invite": [user],
            "is_direct": True,
            "preset": "trusted_private_chat",
            "initial_state": [{**encryption, "state_key": ""}],
        }
        # Asked once: a room that was made though nobody answered would be made again.
        made = await self._client.call("POST", f"{API}/createRoom", asked)
        return str(made.get("room_id"))

    async def join(self, room: str) -> None:
        """Join a room that we were invited to, or that anybody may join.

        Raises:
            MatrixError: We are not in it, or it cannot be known.
        """
        await self._client.persist(
            lambda: self._client.call("POST", f"{API}/join/{quote(room, safe='')}", {})
        )

    async def leave(self, room: str) -> None:
        """Leave a room, or decline to join it.

        Raises:
            MatrixError: Not done, or it cannot be known.
        """
        path = f"{API}/rooms/{quote(room, safe='')}/leave"
        await self._client.persist(lambda: self._client.call("POST", path, {}))

    async def earlier(
        self, room: str, before: str, until: str, limit: int
    ) -> tuple[list[dict[str, Any]], str]:
        """Return events from before a point, newest first, and the point that they reach back to.

        Raises:
            MatrixError: They cannot be had.
        """
        asked = {"dir": "b", "limit": str(limit)}
        asked |= {"from": before} if before else {}
        asked |= {"to": until} if until else {}
        path = f"{API}/rooms/{quote(room, safe='')}/messages?{urlencode(asked)}"
        body = await self._client.persist(lambda: self._client.get(path))
        try:
            pieces, end = earlier_part(body)
        except ValueError as error:
            raise MatrixError(
                "The homeserver answers with nonsense.", MatrixErrorKind.LOST, str(error)
            ) from None
        found = []
        for piece in pieces:
            source = event_of(piece)
            if source is not None:
                found.append(source)
            await self._client.steps.give_way()
        return found, end
