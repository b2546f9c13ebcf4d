"""What takes long with a large file: done beside the chat, shown while it lasts, then answered.

Neither the next line of the chat nor how an order ended waits for two gigabytes.
"""

from __future__ import annotations

import asyncio
import logging
from contextlib import aclosing, suppress
from typing import TYPE_CHECKING, Final, TypeAlias

from msgspec.structs import replace

from rosic.container import file_messages as words
from rosic.core.message import Attachment, Outbound, StreamedContent
from rosic.errors import ChatGone, MessengerFault, RosicError, TooManyRequests
from rosic.gateway.commands import Reply

if TYPE_CHECKING:
    from collections.abc import AsyncGenerator, Awaitable, Callable

    from rosic.contracts.clock import Clock
    from rosic.core.identity import PrincipalId
    from rosic.core.message import Inbound
    from rosic.features.files.upload import Plain, Tell
    from rosic.gateway.commands import CommandContext

Work: TypeAlias = "Callable[[TransferProgress], Awaitable[Reply]]"
Saying: TypeAlias = "Callable[[int], str]"

OF_ONE: Final = 2
OF_ALL: Final = 6
SHOWN_EVERY_S: Final = 3.0

log = logging.getLogger("rosic.files")


class TransferProgress:
    """How far one file has come.

    Attributes:
        count: Bytes that have passed.
    """

    def __init__(self) -> None:
        self.count = 0

    async def counted(self, pieces: AsyncGenerator[bytes]) -> AsyncGenerator[bytes]:
        """Pass pieces on, and count."""
        self.count = 0
        async with aclosing(pieces):
            async for piece in pieces:
                yield piece
                self.count += len(piece)

    def watched(self, attachment: Attachment) -> Attachment:
        """Return the same file, counted while it is sent."""
        if attachment.pieces is None:
            return attachment
        pieces = StreamedContent(attachment.size, lambda: self.counted(attachment.read()))
        return replace(attachment, pieces=pieces)


class BackgroundTransfer:
    """Everything that is under way."""

    def __init__(self, tell: Tell, plain: Plain, clock: Clock) -> None:
        self._tell = tell
        self._plain = plain
        self._clock = clock
        self._under_way: dict[asyncio.Task[None], PrincipalId] = {}

    def begin(self, asked: CommandContext, work: Work, saying: Saying) -> Reply:
        """Begin, and answer later; until then one message shows how far it is.

        Args:
            asked: By whom, and where.
            work: Returns the answer, or raises a RosicError, whose sentence is the answer.
            saying: Says how many bytes have passed.

        Raises:
            TooManyRequests: As many are under way already. Nothing was begun.
        """
        principal = asked.caller.principal
        theirs = sum(who == principal for who in self._under_way.values())
        if theirs >= OF_ONE or len(self._under_way) >= OF_ALL:
            raise TooManyRequests(words.TOO_MANY_GOING, retry_after_s=30.0)
        task = asyncio.create_task(self._do(asked, work, saying))
        self._under_way[task] = principal
        task.add_done_callback(self._under_way.pop)
        return Reply("")

    async def _do(self, asked: CommandContext, work: Work, saying: Saying) -> None:
        progress, shown = TransferProgress(), _Shown(asked, self._plain)
        showing = asyncio.create_task(self._show(shown, progress, saying))
        gone = False
        try:
            reply = await work(progress)
        except ChatGone:
            gone, reply = True, Reply("")
        except RosicError as why:
            reply = Reply(why.sentence)
        except Exception:
            log.exception("a file did not come through")
            reply = Reply(words.NOT_THROUGH)
        finally:
            showing.cancel()
            await asyncio.wait([showing])
        if not gone:
            self._tell(asked.messenger, shown.where(), asked.caller, reply)

    async def _show(self, shown: _Shown, progress: TransferProgress, saying: Saying) -> None:
        before = -1
        with suppress(MessengerFault):
            while True:
                if progress.count != before:
                    before = progress.count
                    await shown.say(saying(before))
                await self._clock.sleep(SHOWN_EVERY_S)

    async def end(self, principal: PrincipalId) -> None:
        """Break off whatever is under way for somebody who is being erased."""
        await self._cancel([task for task, who in self._under_way.items() if who == principal])

    async def close(self) -> None:
        """Break off everything."""
        await self._cancel(list(self._under_way))

    @staticmethod
    async def _cancel(tasks: list[asyncio.Task[None]]) -> None:
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)


class _Shown:
    """The message that shows how far it is: the one that was tapped, or a new one."""

    def __init__(self, asked: CommandContext, plain: Plain) -> None:
        self._messenger = asked.messenger
        self._inbound = asked.inbound
        self._plain = plain
        self._message = asked.inbound.under

    async def say(self, text: str) -> None:
        if not self._messenger.edits:
            return
        inbound = self._inbound
        outbound = Outbound(chat=inbound.chat, text=self._plain(inbound, text))
        if self._message:
            await self._messenger.edit(self._message, outbound)
        else:
            reply_to = "" if inbound.nonce is not None else inbound.message
            self._message = await self._messenger.send(replace(outbound, reply_to=reply_to))

    def where(self) -> Inbound:
        """Return the message to answer, so that the answer replaces what was shown."""
        return replace(self._inbound, under=self._message)


async def send_file(
    asked: CommandContext,
    plain: Plain,
    attachment: Attachment,
    text: str,
    progress: TransferProgress,
) -> Reply:
    """Send a file past what waits to be said in its chat; return what is said beside it.

    Raises:
        MessengerFault: It was not sent.
    """
    inbound = asked.inbound
    outbound = Outbound(
        chat=inbound.chat, text=plain(inbound, text), attachment=progress.watched(attachment)
    )
    await asked.messenger.send(outbound)
    return Reply(words.sent_whole(attachment.name))
