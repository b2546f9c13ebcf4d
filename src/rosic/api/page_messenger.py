"""The messenger of the page: each person who is signed in has one conversation, in memory.

What was said while nobody looked is there when they look, as far as it is kept; what must reach
somebody goes to their own messenger.
"""

from __future__ import annotations

from collections import OrderedDict
from typing import TYPE_CHECKING, Final

import msgspec

from rosic.api.schemas import PageButton, PageFile, PageMessage
from rosic.core.identity import PAGE
from rosic.core.message import Attachment, Outbound
from rosic.core.signal import Signal
from rosic.errors import MessageGone, MessengerFault
from rosic.messengers.program.messenger import ProgramMessenger

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rosic.contracts.clock import Clock
    from rosic.core.identity import Address
    from rosic.core.message import Chat, Inbound
    from rosic.messengers.program.calls import ToolCall
    from rosic.messengers.program.standstill import StandstillWatch

MESSAGES_KEPT: Final = 200
PEOPLE_KEPT: Final = 1_000
FILES_KEPT: Final = 10
FILE_BYTES: Final = 20_000_000
LINES_KEPT: Final = 10_000
"""Messages and taps of which it is known what line they go back to."""


class Conversation:
    """What one person and ROSIC have said to each other on the page: the newest of it."""

    def __init__(self) -> None:
        self._messages: OrderedDict[str, PageMessage] = OrderedDict()
        self._files: OrderedDict[str, Attachment] = OrderedDict()

    def __getitem__(self, message: str) -> PageMessage | None:
        return self._messages.get(message)

    def all(self) -> Sequence[PageMessage]:
        """Return the messages, oldest first."""
        return tuple(self._messages.values())

    def put(self, message: PageMessage) -> None:
        """Keep a message, or what it looks like now."""
        self._messages[message.id] = message
        if len(self._messages) > MESSAGES_KEPT:
            gone, _ = self._messages.popitem(last=False)
            self._files.pop(gone, None)

    def keep_file(self, message: str, attachment: Attachment) -> None:
        """Keep the file of a message, as one of the newest."""
        self._files[message] = attachment
        if len(self._files) > FILES_KEPT:
            self._files.popitem(last=False)

    def file(self, message: str) -> Attachment | None:
        """Return the file that came with a message; None: there is none, or none any more."""
        return self._files.get(message)


class PageMessenger(ProgramMessenger):
    """By it people speak on the page.

    Attributes:
        news: Somebody's conversation has a new message, or one has changed.
    """

    platform = PAGE
    # A session may have been begun by a code that a messenger's provider could read.
    assurance = "provider-readable"
    pins = True
    file_bytes = FILE_BYTES

    def __init__(self, name: str, clock: Clock, standstill: StandstillWatch | None = None) -> None:
        super().__init__(name, clock, standstill)
        self.news: Signal[[str, PageMessage]] = Signal()
        self._conversations: OrderedDict[str, Conversation] = OrderedDict()
        self._lines: OrderedDict[str, str] = OrderedDict()

    def conversation(self, account: str) -> Conversation:
        """Return somebody's conversation; an empty one where nothing was said."""
        found = self._conversations.get(account)
        if found is None:
            found = self._conversations[account] = Conversation()
            if len(self._conversations) > PEOPLE_KEPT:
                self._conversations.popitem(last=False)
        return found

    def line_of(self, message: str) -> str:
        """Return the id of the line that a message goes back to, over all taps; empty: of none."""
        return self._lines.get(message, "")

    def _goes_back(self, message: str, line: str) -> None:
        if not line:
            return
        self._lines[message] = line
        if len(self._lines) > LINES_KEPT:
            self._lines.popitem(last=False)

    def forget(self, account: str) -> None:
        """Let go of what was said to somebody."""
        self._conversations.pop(account, None)

    def begin(self, inbound: Inbound, robot: str = "") -> ToolCall:
        """Say something for a person, who sees it in their conversation.

        Raises:
            MessengerFault: Nobody listens. Nothing was said.
        """
        call = super().begin(inbound, robot)
        tapped = inbound.nonce is not None
        self._goes_back(inbound.message, self.line_of(inbound.under) if tapped else inbound.message)
        if not (tapped or inbound.live):
            account, text = inbound.sender.account, inbound.text
            self._put(account, PageMessage(inbound.message, inbound.sent_ns, text, own=True))
        return call

    def tap(self, address: Address, message: str, nonce: str) -> ToolCall:
        """Tap a button for a person.

        Raises:
            MessageGone: There is no such button under that message. Nothing was said.
            MessengerFault: Nobody listens. Nothing was said.
        """
        shown = self.conversation(address.account)[message]
        nonces = (b.nonce for row in shown.buttons for b in row) if shown is not None else ()
        if nonce not in nonces:
            raise MessageGone("There is no such button there any more. Nothing was done.")
        inbound = self.inbound(address, "")
        tapped: Inbound = msgspec.structs.replace(
            inbound, nonce=nonce, tap=inbound.message, under=message
        )
        return self.begin(tapped)

    # ---- the gateway's side ----

    async def send(self, outbound: Outbound) -> str:
        """Put it into the conversation, and tell the call because of which it is said."""
        message, there = self.next_id(), self.conversation(outbound.chat.id)
        self._goes_back(message, self.line_of(outbound.cause))
        shown = _shown(message, outbound, self._clock.wall_ns())
        if (attachment := outbound.attachment) is not None:
            attachment = await _whole(attachment)
            there.keep_file(message, attachment)
            described = PageFile(message, attachment.name, attachment.media_type, attachment.size)
            shown = msgspec.structs.replace(shown, file=described)
        self._put(outbound.chat.id, shown)
        self._tell(message, outbound)
        return message

    async def edit(self, message: str, outbound: Outbound) -> None:
        """Make a message look like this.

        Raises:
            MessageGone: It is not kept any more.
        """
        before = self.conversation(outbound.chat.id)[message]
        if before is None:
            raise MessageGone("That message is not there any more.")
        shown = _shown(message, outbound, before.sent_ns)
        self._put(
            outbound.chat.id,
            msgspec.structs.replace(
                shown, file=before.file, changed=before.changed + 1, pinned=before.pinned
            ),
        )
        self._tell(message, outbound)

    async def pin(self, chat: Chat, message: str, *, pinned: bool = True) -> None:
        """Keep a message in sight, or no longer.

        Raises:
            MessageGone: It is not kept any more.
        """
        shown = self.conversation(chat.id)[message]
        if shown is None:
            raise MessageGone("That message is not there any more.")
        self._put(chat.id, msgspec.structs.replace(shown, pinned=pinned))

    def _put(self, account: str, message: PageMessage) -> None:
        self.conversation(account).put(message)
        self.news.emit(account, message)


def _shown(message: str, outbound: Outbound, sent_ns: int) -> PageMessage:
    return PageMessage(
        id=message,
        sent_ns=sent_ns,
        text=outbound.text,
        buttons=tuple(
            tuple(PageButton(button.label, button.nonce) for button in row)
            for row in outbound.buttons
        ),
        state=outbound.state.value,
        code=outbound.code,
        reply_to=outbound.reply_to,
    )


async def _whole(attachment: Attachment) -> Attachment:
    """Return a file with its content at hand.

    Raises:
        MessengerFault: It is larger than the page takes.
    """
    if attachment.size > FILE_BYTES:
        raise MessengerFault("This file is too large for the page.")
    if attachment.pieces is None:
        return attachment
    content = b"".join([piece async for piece in attachment.read()])
    return Attachment(attachment.name, attachment.media_type, content)
