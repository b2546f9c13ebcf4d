"""A file that somebody sent, on its way into their container: read, looked at, sealed, told.

It is quarantine: the file is never opened, unpacked or handed on by itself. One that is interrupted
in any way leaves nothing behind, and whoever sent it is told.
"""

from __future__ import annotations

import asyncio
import hashlib
import logging
from collections.abc import AsyncGenerator
from contextlib import nullcontext, suppress
from typing import TYPE_CHECKING, Final, TypeAlias

from msgspec.structs import replace

from rosic.container import file_messages as words
from rosic.container.file_types import SORTS, Sniffer, file_name
from rosic.container.files import PART_BYTES
from rosic.core.message import Button, Outbound
from rosic.core.time_units import SECOND_NS
from rosic.errors import (
    MessengerFault,
    NotPermitted,
    NotUnderstood,
    OutOfBounds,
    RecordUnavailable,
    Refusal,
    TooManyRequests,
)
from rosic.gateway.button_rows import rows
from rosic.gateway.commands import Reply
from rosic.gateway.requests import FILE, line_id

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Callable

    from rosic.container.files import StoredFile
    from rosic.contracts.messenger import Messenger
    from rosic.core.identity import Caller, PrincipalId
    from rosic.core.message import Inbound, IncomingFile
    from rosic.gateway.container_context import ContainerContext

Tell: TypeAlias = "Callable[[Messenger, Inbound, Caller, Reply], None]"
Plain: TypeAlias = "Callable[[Inbound, str], str]"
Offer: TypeAlias = "Callable[[PrincipalId, StoredFile], list[Button]]"

AT_ONCE: Final = 3
COMING_OF_ONE: Final = 10
COMING_OF_ALL: Final = 100
SHOWN_FROM_BYTES: Final = 1_000_000
PROGRESS_EVERY_NS: Final = 2 * SECOND_NS
SLOWEST_S: Final = 600.0
SLOWEST_BYTES_S: Final = 500_000

log = logging.getLogger("rosic.files")


class FileUpload:
    """Takes in what people send."""

    def __init__(self, data_context: ContainerContext, tell: Tell, plain: Plain) -> None:
        self._data_context = data_context
        self._plain = plain
        self._tell = tell
        self._offers: list[Offer] = []
        self._coming: dict[str, tuple[PrincipalId, asyncio.Task[None]]] = {}
        self._few = asyncio.Semaphore(AT_ONCE)

    def offer_too(self, offer: Offer) -> None:
        """Offer more that may be done with a file that is here, after what is offered so far."""
        self._offers.append(offer)

    def take(self, messenger: Messenger, inbound: Inbound, caller: Caller) -> None:
        """Begin to take in the file of a message; the same message again begins nothing.

        Raises:
            Refusal: It is not taken, and why. Nothing was kept, nothing was fetched.
        """
        enclosure, principal = inbound.enclosed, caller.principal
        file = _file_id(inbound)
        if enclosure is None or file in self._coming or self._data_context.files.knows(file):
            return
        if not messenger.fetch_bytes:
            raise NotPermitted(words.NOT_HERE)
        if enclosure.size <= messenger.fetch_bytes:  # else the messenger says why not
            self._data_context.files.check_room(principal, enclosure.size)
        theirs = sum(who == principal for who, _ in self._coming.values())
        if theirs >= COMING_OF_ONE or len(self._coming) >= COMING_OF_ALL:
            raise TooManyRequests(words.TOO_MANY_COMING, retry_after_s=10.0)
        arrival = _Arrival(self._data_context, messenger, inbound, principal, self._plain)
        task = asyncio.create_task(self._take(arrival, caller, enclosure))
        self._coming[file] = (principal, task)
        task.add_done_callback(lambda _: self._coming.pop(file, None))

    async def _take(self, arrival: _Arrival, caller: Caller, enclosure: IncomingFile) -> None:
        """Take one file in, and say what became of it."""
        try:
            # What is too large is refused at once, whatever else is coming.
            refused = enclosure.size > arrival.messenger.fetch_bytes
            async with (
                nullcontext() if refused else self._few,
                asyncio.timeout(SLOWEST_S + enclosure.size / SLOWEST_BYTES_S),
            ):
                filed = await arrival.take(enclosure)
        except (Refusal, MessengerFault) as why:
            unwritable = isinstance(why, RecordUnavailable)
            reply = Reply(words.NOT_NOW if unwritable else why.sentence)
        except Exception as error:
            if not isinstance(error, TimeoutError):
                log.exception("a file could not be taken in")
            reply = Reply(words.BROKEN)
        else:
            reply = self._here(caller.principal, filed)
        inbound = replace(arrival.inbound, under=arrival.shown)
        self._tell(arrival.messenger, inbound, caller, reply)

    def _here(self, principal: PrincipalId, filed: StoredFile) -> Reply:
        text = words.kept(filed.name, filed.sort, filed.size, filed.digest)
        buttons = [
            *(button for offer in self._offers for button in offer(principal, filed)),
            Button(words.DELETE, f"/files delete {filed.name}"),
        ]
        return Reply(text, rows(buttons))

    async def finish(self) -> None:
        """Take away what the last run had not received to the end, and say so."""
        data_context = self._data_context
        for filed in data_context.files.unfinished():
            if filed.id in self._coming:
                continue
            with suppress(RecordUnavailable):
                async with data_context.changes.turn() as turn:
                    await turn.write(data_context.files.drop(filed.id))
                data_context.tell((filed.owner,), words.not_whole(filed.name))

    async def end(self, principal: PrincipalId) -> None:
        """Take in nothing more of somebody who is being erased."""
        await self._cancel([task for who, task in self._coming.values() if who == principal])

    async def close(self) -> None:
        """Break off whatever is coming; its parts go away, now or at the next start."""
        await self._cancel([task for _, task in self._coming.values()])

    @staticmethod
    async def _cancel(tasks: list[asyncio.Task[None]]) -> None:
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)


class _Arrival:
    """One file that is coming.

    Attributes:
        shown: Id of the message that shows how far it has come; empty for none.
    """

    def __init__(
        self,
        data_context: ContainerContext,
        messenger: Messenger,
        inbound: Inbound,
        owner: PrincipalId,
        plain: Plain,
    ) -> None:
        self._plain = plain
        self.messenger = messenger
        self.inbound = inbound
        self.shown = ""
        self._data_context = data_context
        self._owner = owner
        self._file = _file_id(inbound)
        self._shown_ns = 0

    async def take(self, enclosure: IncomingFile) -> StoredFile:
        """Fetch, look, seal.

        Raises:
            Refusal, MessengerFault: Why not; nothing of it is left.
        """
        pieces = self.messenger.fetch(enclosure)
        first = await anext(pieces, b"")  # what cannot be fetched takes no room
        if not first:
            raise NotUnderstood(words.EMPTY)
        most = enclosure.size or self.messenger.fetch_bytes
        try:
            return await self._keep(enclosure, pieces, first, most)
        except BaseException:
            await asyncio.shield(asyncio.ensure_future(self._drop()))
            raise
        finally:
            if isinstance(pieces, AsyncGenerator):
                await pieces.aclose()

    async def _keep(
        self, enclosure: IncomingFile, pieces: AsyncIterator[bytes], first: bytes, most: int
    ) -> StoredFile:
        data_context, files = self._data_context, self._data_context.files
        called = file_name(enclosure.name, SORTS["text"])
        async with data_context.changes.turn() as turn:
            await turn.write(files.begin(self._owner, self._file, called, most))
        sniffer, digest, count, number, held = Sniffer(), hashlib.sha256(), 0, 0, bytearray()
        piece = first
        while piece:
            count += len(piece)
            if count > most:  # whatever the messenger promised
                raise OutOfBounds(words.BROKEN)
            sniffer.feed(piece)
            digest.update(piece)
            held += piece
            while len(held) >= PART_BYTES:
                await self._write(number, bytes(held[:PART_BYTES]))
                number += 1
                del held[:PART_BYTES]
            await self._show(enclosure.size, count)
            piece = await anext(pieces, b"")
        if held:
            await self._write(number, bytes(held))
        sort = sniffer.sort(enclosure.name)
        if sort is None:
            raise NotUnderstood(words.unknown(sorted(SORTS)))
        name = file_name(enclosure.name or sort.name, sort)
        async with data_context.changes.turn() as turn:
            if not files.knows(self._file):  # its owner was erased meanwhile
                raise NotPermitted(words.BROKEN)
            await turn.write(files.finish(self._file, name, sort, count, digest.digest()))
        return next(one for one in files.of(self._owner) if one.id == self._file)

    async def _write(self, number: int, content: bytes) -> None:
        files = self._data_context.files
        async with self._data_context.changes.turn() as turn:
            if not files.knows(self._file):
                raise NotPermitted(words.BROKEN)
            await turn.write((files.part(self._owner, self._file, number, content),))

    async def _drop(self) -> None:
        with suppress(RecordUnavailable):
            async with self._data_context.changes.turn() as turn:
                await turn.write(self._data_context.files.drop(self._file))

    async def _show(self, size: int, count: int) -> None:
        """Show how far a large file has come, by editing one message, now and then."""
        now_ns = self._data_context.clock.monotonic_ns()
        if max(size, count) < SHOWN_FROM_BYTES or not self.messenger.edits:
            return
        if self.shown and now_ns - self._shown_ns < PROGRESS_EVERY_NS:
            return
        self._shown_ns = now_ns
        text = self._plain(self.inbound, words.coming(size, count))
        outbound = Outbound(chat=self.inbound.chat, text=text)
        with suppress(MessengerFault):
            if self.shown:
                await self.messenger.edit(self.shown, outbound)
            else:
                self.shown = await self.messenger.send(
                    replace(outbound, reply_to=self.inbound.message)
                )


def _file_id(inbound: Inbound) -> str:
    """Return the id of a message's file: the same message, the same file."""
    return line_id(inbound, FILE).hex()[:32]
