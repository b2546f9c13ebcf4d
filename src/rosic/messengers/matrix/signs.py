"""The signs beneath our messages: reactions that people tap, put there beside everything else."""

from __future__ import annotations

import asyncio
import logging
from collections import OrderedDict
from typing import TYPE_CHECKING, Final

from rosic.errors import MessengerFault
from rosic.messengers.matrix.errors import MatrixError
from rosic.messengers.matrix.incoming import REACTION

if TYPE_CHECKING:
    from rosic.messengers.matrix.client import MatrixClient

KEYS: Final = (
    *("1️⃣", "2️⃣", "3️⃣", "4️⃣", "5️⃣", "6️⃣", "7️⃣", "8️⃣", "9️⃣", "🔟"),
    *(chr(0x1F1E6 + letter) for letter in range(16)),
)
"""Numbers, then letters from A on."""
REMEMBERED: Final = 4_096
AT_ONCE: Final = 5
"""Messages that signs are put beneath at the same time."""

log = logging.getLogger("rosic.messengers.matrix")


class Signs:
    """Keeps as many signs beneath each message as it has buttons. Bounded: old ones are forgotten.

    It needs several calls for each message, and nobody waits for them: the numbers beneath a text
    can be replied with at once.
    """

    def __init__(self, client: MatrixClient) -> None:
        self._client = client
        self._there: OrderedDict[tuple[str, str], list[str]] = OrderedDict()
        self._wanted: OrderedDict[tuple[str, str], int] = OrderedDict()
        self._tapped: list[tuple[str, str]] = []
        self._due = asyncio.Event()

    def want(self, room: str, message: str, number: int) -> None:
        """Have so many signs beneath a message, soon."""
        if not number and (room, message) not in self._there:
            return
        self._wanted.pop((room, message), None)
        self._wanted[room, message] = number
        while len(self._wanted) > REMEMBERED:
            self._wanted.popitem(last=False)
        self._due.set()

    def tapped(self, room: str, reaction: str) -> None:
        """Take a reaction away that was followed, so that the same sign can be tapped again.

        That takes a power that this account may not have; then whoever tapped does it.
        """
        if len(self._tapped) < REMEMBERED:
            self._tapped.append((room, reaction))
            self._due.set()

    async def follow(self) -> None:
        """Put signs there, and take them away, until cancelled."""
        while True:
            await self._due.wait()
            self._due.clear()
            while self._wanted or self._tapped:
                tapped, self._tapped = self._tapped, []
                some = [self._wanted.popitem() for _ in range(min(AT_ONCE, len(self._wanted)))]
                await asyncio.gather(
                    *[self._redact(*one) for one in tapped],
                    *[self._keep(*where, number) for where, number in some],
                )

    async def _keep(self, room: str, message: str, number: int) -> None:
        there = self._there.setdefault((room, message), [])
        self._there.move_to_end((room, message))
        try:
            while len(there) > number:
                await self._redact(room, there.pop())
            for key in KEYS[len(there) : number]:
                if (room, message) in self._wanted:
                    return  # it has other buttons by now
                there.append(await self.put(room, message, key))
        except MessengerFault as fault:
            log.info("not all buttons stand beneath a message: %s", fault)
        if not there:
            self._there.pop((room, message), None)
        while len(self._there) > REMEMBERED:
            self._there.popitem(last=False)

    async def _redact(self, room: str, event: str) -> None:
        try:
            if event:
                await self._client.redact(room, event)
        except MessengerFault as fault:
            log.info("a sign was not taken away: %s", fault)

    async def put(self, room: str, message: str, key: str) -> str:
        """Put an emoji beside a message; return its event, which is not known if it was there.

        Raises:
            MatrixError: It is not there, or it cannot be known.
        """
        link = {"rel_type": "m.annotation", "event_id": message, "key": key}
        try:
            return await self._client.send(room, REACTION, {"m.relates_to": link})
        except MatrixError as error:
            if error.errcode != "M_DUPLICATE_ANNOTATION":
                raise
            return ""
