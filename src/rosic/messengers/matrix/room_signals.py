"""What people see of ROSIC while they wait: that it has read what they wrote, and is deciding.

Both are a convenience: nothing waits for them, and what the homeserver does not take is lost. Only
people known here are shown them.
"""

from __future__ import annotations

import asyncio
import logging
from collections import OrderedDict
from contextlib import contextmanager
from typing import TYPE_CHECKING, Final
from urllib.parse import quote

from rosic.core.message import MessageValidity
from rosic.errors import MessengerFault
from rosic.messengers.matrix.connection import API

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from rosic.contracts.clock import Clock
    from rosic.contracts.messenger import Knows, Receive, Settle
    from rosic.core.message import Inbound
    from rosic.messengers.matrix.client import MatrixClient

SHOWN_AFTER_S: Final = 0.5
"""What is decided sooner needs no notice."""
SHOWN_FOR_MS: Final = 30_000
GATHERED_S: Final = 1.0
"""Receipts of a room within it are one: the last."""
SETTLES_WITHIN_S: Final = 10.0
ROOMS_AT_MOST: Final = 1_000

log = logging.getLogger("rosic.messengers.matrix")


class RoomSignals:
    """Shows both for one account.

    Args:
        name: Of the messenger, for the log.
    """

    def __init__(self, name: str, client: MatrixClient, clock: Clock) -> None:
        self._name = name
        self._client = client
        self._clock = clock
        self._read: OrderedDict[str, str] = OrderedDict()
        self._typing: OrderedDict[str, bool] = OrderedDict()
        self._shown: set[str] = set()
        self._deciding: dict[str, int] = {}
        self._read_more, self._type_more = asyncio.Event(), asyncio.Event()
        self._settle: Settle = _at_once

    def around(self, receive: Receive, known: Knows, settle: Settle) -> Receive:
        """Return what receives messages like ``receive``, and shows what becomes of them.

        Args:
            receive: Takes a message.
            known: Whether somebody is known here.
            settle: Waits until everything received so far is on disk.
        """
        self._settle = settle

        async def received(inbound: Inbound) -> None:
            if inbound.standing is not MessageValidity.FRESH or not known(inbound.sender):
                await receive(inbound)
                return
            with self._deciding_in(inbound.chat.id):
                await receive(inbound)
            self._read[inbound.chat.id] = inbound.message
            if len(self._read) > ROOMS_AT_MOST:
                self._read.popitem(last=False)
            self._read_more.set()

        return received

    # ---- typing ----

    @contextmanager
    def _deciding_in(self, room: str) -> Iterator[None]:
        """Show that ROSIC writes there, if it takes a while."""
        later = asyncio.get_running_loop().call_later(SHOWN_AFTER_S, self._type, room, True)
        self._deciding[room] = self._deciding.get(room, 0) + 1
        try:
            yield
        finally:
            later.cancel()
            self._deciding[room] -= 1
            if not self._deciding[room]:
                del self._deciding[room]
                if room in self._shown:
                    self._type(room, False)
                else:
                    self._typing.pop(room, None)

    def _type(self, room: str, shown: bool) -> None:
        if len(self._typing) < ROOMS_AT_MOST:
            self._typing[room] = shown
            self._type_more.set()

    async def follow_typing(self) -> None:
        """Show it, until cancelled."""
        while True:
            await self._type_more.wait()
            self._type_more.clear()
            while self._typing:
                room, shown = self._typing.popitem(last=False)
                (self._shown.add if shown else self._shown.discard)(room)
                path = f"rooms/{quote(room, safe='')}/typing/{quote(self._client.user, safe='')}"
                content = {"typing": True, "timeout": SHOWN_FOR_MS} if shown else {"typing": False}
                await self._attempt("PUT", path, content)

    # ---- receipts ----

    async def follow_receipts(self) -> None:
        """Say what was read and is settled, the last of each room, until cancelled."""
        while True:
            await self._read_more.wait()
            await self._clock.sleep(GATHERED_S)
            self._read_more.clear()
            read, self._read = self._read, OrderedDict()
            if not await self._settle(SETTLES_WITHIN_S):
                continue  # what is not on disk may be brought once more
            for room, event in read.items():
                about = f"rooms/{quote(room, safe='')}/receipt/m.read/{quote(event, safe='')}"
                await self._attempt("POST", about, {})

    async def _attempt(self, method: str, path: str, content: Mapping[str, object]) -> None:
        try:
            await self._client.call(method, f"{API}/{path}", dict(content))
        except MessengerFault as fault:
            log.debug("%s: a room was not shown something: %s", self._name, fault)


async def _at_once(_within_s: float) -> bool:
    return True
