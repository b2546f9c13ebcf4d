"""A messenger of programs: each is one conversation, and hears what is said because of its lines.

What programs say it over (MCP, HTTP, a WebSocket) is the business of whoever derives from it, or of
the API. Nobody reads here, so nobody confirms here: what has to be confirmed is asked of a person
elsewhere, and begun once they have agreed.
"""

from __future__ import annotations

import asyncio
import os
from itertools import count
from typing import TYPE_CHECKING, Final

import msgspec

from rosic.core.i18n import said
from rosic.core.identity import PROGRAM
from rosic.core.message import AnswerState, Chat, Inbound, IncomingFile, Outbound
from rosic.core.traffic import TrafficCount, TrafficCounter
from rosic.errors import MessengerFault
from rosic.messengers.program.calls import OpenCalls, ToolCall, UnsolicitedMessages
from rosic.messengers.program.standstill import StandstillWatch, running_ns

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

    from rosic.contracts.clock import Clock
    from rosic.contracts.messenger import Receive
    from rosic.contracts.programs import Programs
    from rosic.core.identity import Address

FETCH_BYTES: Final = 25_000_000
MOST_MB: Final = FETCH_BYTES / 1e6
NOT_RUNNING: Final = "The gateway does not listen yet, or not any more. Nothing was done."


class ProgramMessenger:
    """Each program is one conversation.

    Args:
        name: Of the messenger.
        clock: The gateway's.
        standstill: Whether this process stood still; messengers of one process may share it.

    Attributes:
        calls: What was said, and is not answered yet.
        unsolicited: What was said to programs and answers nothing that they said.
    """

    platform = PROGRAM
    assurance = "local"
    edits = True
    pins = False
    file_bytes = 0
    fetch_bytes = FETCH_BYTES

    def __init__(self, name: str, clock: Clock, standstill: StandstillWatch | None = None) -> None:
        self.name = name
        self.calls = OpenCalls()
        self.unsolicited = UnsolicitedMessages()
        self._clock = clock
        self._programs: Programs | None = None
        self._receive: Receive | None = None
        self._handing_over: asyncio.TaskGroup | None = None
        self._serial = count(1)
        self._traffic = TrafficCounter()
        self._standstill = standstill or StandstillWatch(running_ns)
        self._uploads: dict[str, AsyncIterator[bytes]] = {}
        # Ids must not come again in another run: the record remembers them (I1).
        self._run_id = f"{clock.wall_ns():x}-{os.getpid()}"
        self._since_ns = 0

    # ---- what programs say ----

    def serve_programs(self, programs: Programs) -> None:
        """Ask this who they are, and what they may say."""
        self._programs = programs

    @property
    def programs(self) -> Programs:
        """Who knows programs.

        Raises:
            MessengerFault: Nobody yet.
        """
        if self._programs is None:
            raise MessengerFault(NOT_RUNNING)
        return self._programs

    @property
    def traffic(self) -> TrafficCount:
        """Return how much programs have said, and were told."""
        return self._traffic.count

    @property
    def listens(self) -> bool:
        """Whether what is said here is heard."""
        return self._handing_over is not None

    def begin(self, inbound: Inbound, robot: str = "") -> ToolCall:
        """Say something; what is said because of it is told to the call, until it is closed.

        Args:
            inbound: As `inbound` makes it.
            robot: Whose order it is; empty for what orders nothing.

        Raises:
            MessengerFault: Nobody listens. Nothing was said.
        """
        call = ToolCall(inbound.sender, robot)
        self.calls.open(inbound.message, call)
        try:
            self.hand_over(inbound)
        except MessengerFault:
            self.calls.close(call)
            raise
        return call

    def begin_agreed(self, call: ToolCall, message: str, outbound: Outbound) -> None:
        """Begin what a person has agreed to: that alone is ever tapped for a program."""
        button = outbound.buttons[0][0]
        inbound = self.inbound(call.address, "")
        tapped = msgspec.structs.replace(
            inbound, nonce=button.nonce, tap=inbound.message, under=message
        )
        self.calls.open(tapped.message, call)
        self.hand_over(tapped)

    def begin_file(
        self, address: Address, name: str, size: int, pieces: AsyncIterator[bytes]
    ) -> tuple[ToolCall, Inbound]:
        """Send a file, as one encloses it in a message; it is read while it is taken in.

        Args:
            address: Who sends it.
            name: Of the file.
            size: As it is said; 0: nobody knows.
            pieces: Its content.

        Returns:
            The call, and the message. Whoever closes the call drops the file, too.

        Raises:
            MessengerFault: Nobody listens. Nothing was sent.
        """
        plain = self.inbound(address, "")
        enclosure = IncomingFile(id=plain.message, name=name, size=size)
        inbound = msgspec.structs.replace(plain, enclosed=enclosure)
        self._uploads[plain.message] = pieces
        try:
            return self.begin(inbound), inbound
        except MessengerFault:
            self.drop_file(inbound)
            raise

    def drop_file(self, inbound: Inbound) -> None:
        """Give a file out no more."""
        self._uploads.pop(inbound.message, None)

    def inbound(self, address: Address, text: str, message: str = "") -> Inbound:
        """Return a line of a program as a message that comes in now.

        Args:
            address: Of the program.
            text: A line of the grammar.
            message: What it is known by for ever: the same again is the same message. Left out, it
                is a new one.
        """
        now_ns = self._clock.wall_ns()
        return Inbound(
            sender=address,
            chat=Chat(self.platform, address.account),
            message=message or self.next_id(),
            text=text,
            sent_ns=now_ns - self.waited_ns(),
            received_ns=now_ns,
            # A clock that was set back makes no line older than it is: nothing waits here unread.
            listening_since_ns=min(self._since_ns, now_ns),
        )

    def waited_ns(self) -> int:
        """Return for how long at most what is read now has waited for this process to go on."""
        return self._standstill.waited_ns()

    def hand_over(self, inbound: Inbound) -> None:
        """Hand a message over; one after another of a conversation is the pipeline's business.

        Raises:
            MessengerFault: Nobody listens.
        """
        if self._handing_over is None or self._receive is None:
            raise MessengerFault(NOT_RUNNING)
        self._traffic.came(len(inbound.text.encode(errors="replace")))
        received = _received(self._receive, inbound)
        try:
            self._handing_over.create_task(received)
        except RuntimeError:  # it is leaving off at this moment
            received.close()
            raise MessengerFault(NOT_RUNNING) from None

    def next_id(self) -> str:
        """Return the id of a new message."""
        return f"{self._run_id}-{next(self._serial)}"

    # ---- the gateway's side: contracts.messenger.Messenger ----

    async def run(self, receive: Receive) -> None:
        """Listen until cancelled. See the contract."""
        self._since_ns = self._clock.wall_ns()
        try:
            async with asyncio.TaskGroup() as group:
                self._receive, self._handing_over = receive, group
                watching = group.create_task(self._standstill.run())
                try:
                    await self._listen()
                finally:
                    watching.cancel()
        except ExceptionGroup as several:
            raise several.exceptions[0] from None
        finally:
            self._receive = self._handing_over = None

    async def _listen(self) -> None:
        """Listen for programs until cancelled; here somebody else does."""
        await asyncio.Event().wait()

    async def send(self, outbound: Outbound) -> str:
        """Tell the call because of which it is said; what no call waits for, the next one."""
        if outbound.attachment is not None:
            raise MessengerFault("A program is sent no files.")
        message = self.next_id()
        if not self._tell(message, outbound):
            self.unsolicited.put(outbound.chat.id, outbound.text)
        return message

    async def edit(self, message: str, outbound: Outbound) -> None:
        """Tell how it is now, likewise."""
        self._tell(message, outbound)

    def _tell(self, message: str, outbound: Outbound) -> bool:
        attached = 0 if outbound.attachment is None else outbound.attachment.size
        self._traffic.went(len(outbound.text.encode(errors="replace")) + attached)
        call = self.calls[outbound.cause] if outbound.cause else None
        if call is None or call.address.account != outbound.chat.id:
            return False
        call.told(message, outbound)
        return True

    async def pin(self, chat: Chat, message: str, *, pinned: bool = True) -> None:  # noqa: ARG002
        """Refuse: a program keeps nothing in sight.

        Raises:
            MessengerFault: Always.
        """
        raise MessengerFault("A program keeps no message in sight.")

    async def answer_tap(self, inbound: Inbound, text: str) -> None:
        """Tell the call for which it was tapped why that is void; an empty text says nothing."""
        call = self.calls[inbound.message]
        if text and call is not None:
            void = Outbound(chat=inbound.chat, text=text, state=AnswerState.NOT_DONE)
            call.told(inbound.message, void)

    async def fetch(self, enclosure: IncomingFile) -> AsyncIterator[bytes]:
        """Yield a file that is being sent, once.

        Raises:
            MessengerFault: It is not being sent, is too large, or not as long as was said.
        """
        if enclosure.size > self.fetch_bytes:
            raise MessengerFault(said("Files of up to {most:.0f} MB are taken here.", most=MOST_MB))
        pieces, count = self._uploads.pop(enclosure.id, None), 0
        if pieces is None:
            raise MessengerFault(said("The file is not there any more. Send it again."))
        async for piece in pieces:
            count += len(piece)
            if count > self.fetch_bytes:
                raise MessengerFault(
                    said("Files of up to {most:.0f} MB are taken here.", most=MOST_MB)
                )
            if piece:
                yield piece
        if enclosure.size not in {0, count}:
            raise MessengerFault(said("The file is not as long as was said. Send it again."))


async def _received(receive: Receive, inbound: Inbound) -> None:
    await receive(inbound)
