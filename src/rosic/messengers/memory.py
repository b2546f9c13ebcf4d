"""A messenger inside the process: for tests, and as the smallest example of the contract."""

from __future__ import annotations

import asyncio
from collections import deque
from typing import TYPE_CHECKING, Any, NamedTuple

from msgspec.structs import replace

from rosic.core.identity import Address
from rosic.core.language import is_urgent
from rosic.core.message import (
    Attachment,
    Button,
    Chat,
    ChatEvent,
    ChatKind,
    Inbound,
    IncomingFile,
    MessageValidity,
    Outbound,
)
from rosic.core.traffic import TrafficCount, TrafficCounter
from rosic.errors import (
    ChatGone,
    ChatNotBegun,
    ConfigurationError,
    MessageGone,
    MessengerFault,
    RosicError,
)

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Callable, Mapping

    from rosic.contracts.clock import Clock
    from rosic.contracts.messenger import Passed, Receive


# ---- files as a whole ----


async def whole(attachment: Attachment, most: int) -> Attachment:
    """Return a file with all of its content.

    Raises:
        MessengerFault: It is larger than ``most``, or not what was promised.
    """
    if attachment.size > most:
        raise MessengerFault("The file is too large for this messenger. Nothing was sent.")
    if attachment.pieces is None:
        return attachment
    try:
        content = b"".join([piece async for piece in attachment.read()])
    except RosicError as error:
        raise MessengerFault(error.sentence) from error
    return Attachment(attachment.name, attachment.media_type, content)


# ---- the messenger ----

KEEP = 10_000
"""How many of the newest messages, edits and answers are remembered."""
FILE_BYTES = 1_000_000
PIECE_BYTES = 65_536
FILES_KEPT = 100


class ShownMessage(NamedTuple):
    """Something a person was shown.

    Attributes:
        message: Id of the message; the same for each of its edits.
        edited: False for the sending, True for each edit.
    """

    message: str
    outbound: Outbound
    edited: bool


class MemoryMessenger:
    """People are method calls: `say` and `tap` speak, `told` is what they read.

    Args:
        edits: False makes it a messenger that cannot change a message once sent, nor pin one.
        file_bytes: How large a file it takes, and fetches; 0 makes it one without files.
        keep: How much of the past is remembered; what waits to be received is bounded by it too.

    Attributes:
        told: Messages and edits, oldest first.
        answers: How taps were answered: the tap's handle and the text.
        pinned: Which messages are kept in sight, by chat, the newest last.
        may_pin: Clear it, and pinning is refused as in a group whose admin the bot is not.
        down: Set it, and sending and editing fail as if the platform were away.
        gone: Ids of chats in which nothing can be said any more.
        refused: How often somebody tried all the same.
        passed: Told what happens to chats; a test calls it.
        listening_since_ns: Stamped on what is said from now on; see `Inbound`.
        catching_up: Returns whether backlog may still come; a test says otherwise than no.
    """

    platform = "memory"
    assurance = "local"

    def __init__(
        self,
        name: str = "memory",
        *,
        clock: Clock,
        edits: bool = True,
        keep: int = KEEP,
        file_bytes: int = FILE_BYTES,
    ) -> None:
        self.name = name
        self.edits = self.pins = edits
        self.file_bytes = self.fetch_bytes = file_bytes
        self.told: deque[ShownMessage] = deque(maxlen=keep)
        self.answers: deque[tuple[str, str]] = deque(maxlen=keep)
        self.pinned: dict[str, list[str]] = {}
        self.may_pin = True
        self.down = False
        self.gone: set[str] = set()
        self.not_begun: set[str] = set()
        self.refused = 0
        self.passed: Passed = _nobody_watches
        self.listening_since_ns = 0
        self.catching_up: Callable[[], bool] = bool
        self._clock = clock
        self._keep = keep
        self._traffic = TrafficCounter()
        self._serial = self._told_ever = self._unconfirmed = 0
        self._shown: dict[str, Outbound] = {}
        self._files: dict[str, bytes] = {}
        self._waiting: dict[Chat, deque[Inbound]] = {}
        self._stops: dict[int, Inbound] = {}
        self._under_way: set[Chat | int] = set()
        self._changed = asyncio.Event()

    # ---- the person's side ----

    def say(  # noqa: PLR0913  (a test says only what matters to it)
        self,
        text: str,
        *,
        account: str = "1",
        chat: str = "1",
        kind: ChatKind = ChatKind.PRIVATE,
        standing: MessageValidity = MessageValidity.FRESH,
        message: str | None = None,
        sent_ns: int | None = None,
        answers: str = "",
        topic: str = "",
    ) -> Inbound:
        """Write a message, now unless `sent_ns` says otherwise, and return what will be seen."""
        inbound = self._inbound(account, Chat(self.platform, chat, kind, topic), message, sent_ns)
        shown = self._shown.get(answers)
        ours = shown is not None and shown.chat.id == chat
        heard = replace(inbound, text=text, standing=standing)
        return self.deliver(replace(heard, answers=answers, answers_us=ours, addressed=ours))

    def enclose(  # noqa: PLR0913 - as `say`
        self,
        name: str,
        content: bytes,
        *,
        text: str = "",
        account: str = "1",
        chat: str = "1",
        kind: ChatKind = ChatKind.PRIVATE,
        standing: MessageValidity = MessageValidity.FRESH,
    ) -> Inbound:
        """Send a file, with something written beneath."""
        inbound = self._inbound(account, Chat(self.platform, chat, kind), None, None)
        enclosure = IncomingFile(id=f"file-{inbound.message}", name=name, size=len(content))
        self._files[enclosure.id] = content
        while len(self._files) > FILES_KEPT:
            del self._files[next(iter(self._files))]
        return self.deliver(replace(inbound, text=text, standing=standing, enclosed=enclosure))

    def tap(self, button: Button, *, under: str = "", account: str = "1") -> Inbound:
        """Tap a button of the message `under`. It carries what the button carried, and no time."""
        chat = self._shown[under].chat if under else Chat(self.platform, "1")
        inbound = self._inbound(account, chat, None, None)
        tapped = replace(inbound, nonce=button.nonce, tap=f"tap-{inbound.message}", under=under)
        stop = any(map(is_urgent, (button.command, button.nonce)))
        return self._queue(tapped, stop=stop)

    def deliver(self, inbound: Inbound) -> Inbound:
        """Hand in a message made elsewhere; twice makes it a duplicate.

        Raises:
            OverflowError: Nobody receives, and as many wait as are remembered.
        """
        return self._queue(inbound, stop=is_urgent(inbound.text))

    def delete(self, message: str) -> None:
        """Delete a message, as people do; it cannot be edited any more."""
        del self._shown[message]

    def gap(self) -> None:
        """Pretend that listening was interrupted until now: what was sent earlier is backlog."""
        self.listening_since_ns = self._clock.wall_ns()

    def unconfirmed(self) -> tuple[Inbound, ...]:
        """Return what has not been received to the end; another `run` would hand it over again."""
        return (*self._stops.values(), *(one for lane in self._waiting.values() for one in lane))

    def shown(self, message: str) -> Outbound:
        """Return how a message looks now."""
        return self._shown[message]

    async def wait_for(
        self, predicate: Callable[[ShownMessage], bool], *, timeout_s: float = 5.0, after: int = 0
    ) -> ShownMessage:
        """Return the first thing told that fits, waiting for it if need be.

        Args:
            predicate: Called with each thing told, once.
            timeout_s: Of real time, whatever the clock says.
            after: Skip that many, counted from the first thing ever told.

        Raises:
            TimeoutError: Nothing fitted in time; the error lists the newest things told.
        """
        seen = after
        try:
            async with asyncio.timeout(timeout_s):
                while True:
                    fresh = self._told_ever - seen
                    for told in list(self.told)[-fresh:] if fresh > 0 else ():
                        if predicate(told):
                            return told
                    seen = max(seen, self._told_ever)
                    await self._change()
        except TimeoutError:
            lines = "; ".join(told.outbound.text for told in list(self.told)[-10:])
            raise TimeoutError(f"nothing fitting was told; the newest: {lines}") from None

    async def wait_until_received(self, *, timeout_s: float = 5.0) -> None:
        """Wait until everything said has been received to the end.

        Raises:
            TimeoutError: Something is still waiting or under way.
        """
        async with asyncio.timeout(timeout_s):
            while self._unconfirmed:
                await self._change()

    # ---- the gateway's side: contracts.messenger.Messenger ----

    @property
    def traffic(self) -> TrafficCount:
        """Return how much people have said, and were shown."""
        return self._traffic.count

    async def run(self, receive: Receive) -> None:
        """Hand over: stops at once, each chat in order, chats side by side.

        An exception from `receive` ends it and is raised as it is; what was not received waits
        for the next `run`.
        """
        self._under_way.clear()
        try:
            async with asyncio.TaskGroup() as group:
                while True:
                    self._start(group, receive)
                    await self._change()
        except ExceptionGroup as several:
            raise several.exceptions[0] from None

    async def send(self, outbound: Outbound) -> str:
        """Show a message.

        Raises:
            MessengerFault: `down` is set, or the file is too large; nothing was shown.
        """
        self._check_up(outbound.chat)
        if (file := outbound.attachment) is not None:
            outbound = replace(outbound, attachment=await whole(file, self.file_bytes))
        message = self._next_id()
        self._show(ShownMessage(message, outbound, edited=False))
        return message

    async def edit(self, message: str, outbound: Outbound) -> None:
        """Show a message anew.

        Raises:
            MessengerFault: `down` is set, this messenger cannot edit, or there is no such message.
        """
        self._check_up(outbound.chat)
        if not self.edits:
            raise MessengerFault("This messenger cannot change a message once it is sent.")
        if message not in self._shown:
            raise MessageGone("The message to be changed does not exist.")
        if self._shown[message] != outbound:
            self._show(ShownMessage(message, outbound, edited=True))

    async def pin(self, chat: Chat, message: str, *, pinned: bool = True) -> None:
        """Remember that it is kept in sight, or forget it.

        Raises:
            MessengerFault: `down` is set, it may not or cannot, or there is no such message.
        """
        self._check_up(chat)
        if not (self.pins and self.may_pin):
            raise MessengerFault("I may not pin messages here. An admin of this chat can help.")
        if pinned and message not in self._shown:
            raise MessageGone("The message to be pinned does not exist.")
        kept = [one for one in self.pinned.get(chat.id, ()) if one != message]
        self.pinned[chat.id] = [*kept, message] if pinned else kept
        self._announce()

    async def answer_tap(self, inbound: Inbound, text: str) -> None:
        """Remember the answer."""
        self.answers.append((inbound.tap, text))
        self._announce()

    async def fetch(self, enclosure: IncomingFile) -> AsyncIterator[bytes]:
        """Yield what somebody sent.

        Raises:
            MessengerFault: `down` is set, it is too large, forgotten, or not as long as was said.
        """
        self._check_up(None)
        content = self._files.get(enclosure.id)
        if max(enclosure.size, len(content or b"")) > self.fetch_bytes:
            raise MessengerFault(f"This messenger takes files of up to {self.fetch_bytes} bytes.")
        if content is None:
            raise MessengerFault("The file is not there any more. Send it again.")
        if enclosure.size not in {0, len(content)}:
            raise MessengerFault("The file is not as long as was said. Send it again.")
        for start in range(0, len(content), PIECE_BYTES):
            await asyncio.sleep(0)
            self._check_up(None)
            yield content[start : start + PIECE_BYTES]

    # ---- inside ----

    def _inbound(
        self, account: str, chat: Chat, message: str | None, sent_ns: int | None
    ) -> Inbound:
        now_ns = self._clock.wall_ns()
        return Inbound(
            sender=Address(self.platform, account),
            chat=chat,
            message=self._next_id() if message is None else message,
            text="",
            sent_ns=now_ns if sent_ns is None else min(sent_ns, now_ns),
            received_ns=now_ns,
            listening_since_ns=self.listening_since_ns,
        )

    def _queue(self, inbound: Inbound, *, stop: bool) -> Inbound:
        if self._unconfirmed >= self._keep:
            raise OverflowError("too many messages wait to be received")
        self._unconfirmed += 1
        self._traffic.came(len(inbound.text.encode(errors="replace")))
        if stop:
            self._serial += 1
            self._stops[self._serial] = inbound
        else:
            self._waiting.setdefault(inbound.chat, deque()).append(inbound)
        self._announce()
        return inbound

    def _next_id(self) -> str:
        self._serial += 1
        return str(self._serial)

    def _start(self, group: asyncio.TaskGroup, receive: Receive) -> None:
        """Give every stop a task of its own, and every chat with something to say a lane."""
        for number in [one for one in self._stops if one not in self._under_way]:
            self._under_way.add(number)
            group.create_task(self._hand_over_stop(number, receive))
        for chat in [one for one in self._waiting if one not in self._under_way]:
            self._under_way.add(chat)
            group.create_task(self._hand_over_chat(chat, receive))

    async def _hand_over_stop(self, number: int, receive: Receive) -> None:
        await receive(self._stops[number])
        del self._stops[number]
        self._under_way.discard(number)
        self._confirm()

    async def _hand_over_chat(self, chat: Chat, receive: Receive) -> None:
        lane = self._waiting[chat]
        while lane:
            await receive(lane[0])
            lane.popleft()
            self._confirm()
        del self._waiting[chat]
        self._under_way.discard(chat)

    def _confirm(self) -> None:
        self._unconfirmed -= 1
        self._announce()

    def watch_chats(self, passed: Passed) -> None:
        """Have somebody told what happens to chats."""
        self.passed = passed

    def _check_up(self, chat: Chat | None) -> None:
        if chat is not None and chat.id in self.gone | self.not_begun:
            self.refused += 1
            raise (ChatGone if chat.id in self.gone else ChatNotBegun)("Nobody hears it there.")
        if self.down:
            raise MessengerFault("The messenger is away. The message was not delivered.")

    def _show(self, told: ShownMessage) -> None:
        self._shown[told.message] = told.outbound
        while len(self._shown) > self._keep:
            del self._shown[next(iter(self._shown))]
        self.told.append(told)
        self._traffic.went(len(told.outbound.text.encode(errors="replace")))
        self._told_ever += 1
        self._announce()

    def _announce(self) -> None:
        """Wake everybody who waits for something to change."""
        self._changed.set()
        self._changed = asyncio.Event()

    async def _change(self) -> None:
        await self._changed.wait()


def _nobody_watches(_passing: ChatEvent) -> None:
    """Nobody wants to know what happens to chats."""


def memory_messenger(name: str, settings: Mapping[str, Any], clock: Clock) -> MemoryMessenger:
    """Make it from its table in the configuration: `edits = false` is all there is to set.

    Raises:
        ConfigurationError: There is a setting it does not know; the sentence names it.
    """
    unknown = sorted(set(settings) - {"kind", "name", "edits"})
    if unknown:
        raise ConfigurationError(f"The messenger {name} does not know the setting {unknown[0]}.")
    return MemoryMessenger(name, clock=clock, edits=bool(settings.get("edits", True)))
