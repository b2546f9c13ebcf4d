"""Sends what goes back to chats: newest state first, an ending never lost while we live.

Each chat has a queue, emptied by one task. An empty queue costs nothing. Where a platform takes
only so much, the task waits for its turn first and chooses what to send then: the most important
message that waits, as it is at that moment. What a stop answers does not wait for any of this.
"""

from __future__ import annotations

import asyncio
import logging
from typing import TYPE_CHECKING

import msgspec

from rosic.contracts.background_tasks import BackgroundTasks
from rosic.contracts.messenger import turn_of
from rosic.core import messages
from rosic.core.i18n import in_language
from rosic.core.identity import Address
from rosic.core.message import ChatKind, Outbound
from rosic.core.signal import Signal
from rosic.errors import ChatGone, MessageGone, MessengerFault
from rosic.gateway.delivery.chat_queue import (
    FIRST_WAIT_S,
    ChatQueue,
    Item,
    OutgoingMessage,
    edit_or_send,
    matters,
    place_of,
)
from rosic.gateway.delivery.translation import ChatLanguages
from rosic.gateway.order_status import OrderMessage
from rosic.gateway.reply_context import ReplyTargets

__all__ = ["ChatSender", "OutgoingMessage"]

if TYPE_CHECKING:
    from collections.abc import Callable

    from rosic.container.container import Containers
    from rosic.contracts.clock import Clock
    from rosic.contracts.messenger import Messenger, Turn
    from rosic.core.i18n import Catalogue
    from rosic.core.identity import PrincipalId

TRIES = 6
ASIDE_S = 60.0
ASIDE_AT_MOST = 10_000
# Between two edits that only show progress. Seldom enough to leave room for the ending where a
# platform takes one message a second from a chat.
PROGRESS_EVERY_S = 2.0
QUEUES_AT_MOST = 10_000

log = logging.getLogger("rosic.delivery")


class ChatSender:
    """Sends messages to every chat, each from a queue of its own.

    Attributes:
        on_buttons: Tells which message shows a note now.
        languages: Who reads which language; what is handed over here to be said is plain already.
        reply_targets: Of which robot each message speaks.

    Args:
        gone: Passes on what a chat can be told no more, before it counts as told.
    """

    def __init__(
        self,
        containers: Containers,
        clock: Clock,
        gone: Callable[[Item, ChatGone], None],
        languages: ChatLanguages | None = None,
    ) -> None:
        self.languages = ChatLanguages() if languages is None else languages
        self._containers = containers
        self._clock = clock
        self._queues: dict[tuple[str, str], ChatQueue] = {}
        # Asking a messenger what it can do costs as much as half an order: each is asked once.
        self._turns: dict[str, Turn | None] = {}
        self._urgent: BackgroundTasks[None] = BackgroundTasks()
        self._aside: BackgroundTasks[None] = BackgroundTasks()
        self._due: dict[OrderMessage, None] = {}
        self._ticking: asyncio.Task[None] | None = None
        self._gone = gone
        self.on_buttons: Signal[[OutgoingMessage, str]] = Signal()
        self.reply_targets = ReplyTargets()

    def say(self, note: OutgoingMessage) -> None:
        """Say something after everything said before in its chat; an urgent one at once."""
        if note.outbound.urgent:
            self._urgent.begin(self._speak(note))
        else:
            self._queue(note.where_to, note).put(note)

    def show(self, order_message: OrderMessage) -> None:
        """Bring a chat up to date with the message of some orders."""
        queue = self._queues.get(order_message.where)
        if queue is None:
            queue = self._queue(order_message.where, order_message)
        queue.put(order_message)

    def update(self, order_message: OrderMessage) -> None:
        """Show progress: line by line at once, or by an edit when the next one is due."""
        if order_message.lines:
            self.show(order_message)
        elif order_message.dirty:
            self._due[order_message] = None
            if self._ticking is None:
                self._ticking = asyncio.create_task(self._tick())

    async def _tick(self) -> None:
        """Show what has changed, for all chats together, so that progress costs no timers."""
        while self._due:
            await self._clock.sleep(PROGRESS_EVERY_S)
            due, self._due = self._due, {}
            for order_message in due:
                if order_message.dirty and order_message.open:
                    self.show(order_message)
        self._ticking = None

    def _turn_of(self, messenger: Messenger) -> Turn | None:
        name = messenger.name
        if name not in self._turns:
            self._turns[name] = turn_of(messenger)
        return self._turns[name]

    def _queue(self, where: tuple[str, str], item: Item) -> ChatQueue:
        """Return the queue of a chat in which something is to be said."""
        queue = self._queues.get(where)
        if queue is None:
            self._retire()
            messenger, chat = place_of(item)
            queue = self._queues[where] = ChatQueue(
                self,
                where[0],
                self._clock,
                self._turn_of(messenger),
                shared=chat.kind is not ChatKind.PRIVATE,
            )
        return queue

    def _retire(self) -> None:
        """Keep the number of queues bounded: the oldest ones that are empty go."""
        if len(self._queues) < QUEUES_AT_MOST:
            return
        for where, queue in list(self._queues.items())[: QUEUES_AT_MOST // 2]:
            if queue.task is not None and queue.is_asleep:
                queue.task.cancel()
                del self._queues[where]

    async def _speak(self, item: Item, *, tries: int = TRIES) -> None:
        """Say one thing, or lay it aside: one message that is not taken silences no chat."""
        wait_s = FIRST_WAIT_S * 2 ** (TRIES - tries)
        for _ in range(tries):
            try:
                await self.speak_once(item)
            except ChatGone as why:
                self.let_go(item, why)
                return
            except MessengerFault as fault:
                log.warning("not told yet: %s", fault)
            except Exception:
                log.exception("not told: a fault of the messenger")
            else:
                return
            await self._clock.sleep(wait_s)
            wait_s *= 2
        if matters(item) and len(self._aside) < ASIDE_AT_MOST:
            self._aside.begin(self._speak_later(item))

    def let_go(self, item: Item, why: ChatGone) -> None:
        """Nobody is there to be told any more: it counts as told, and is tried no further."""
        self._gone(item, why)
        if not isinstance(item, OrderMessage):
            if item.then is not None:
                item.then()
            self.count_as_told(item)
        elif told := item.settle():
            self._containers.told(*told)

    def count_as_told(self, note: OutgoingMessage) -> None:
        """Note that whoever asked for it has nothing more to hear."""
        if note.cid is not None:
            self._containers.told(note.cid, *note.also)

    def plain(self, text: str, reader: PrincipalId) -> str:
        """Return a sentence as somebody reads it."""
        return in_language(text, self.languages.of(reader))

    async def speak_again(self, item: Item) -> None:
        """Go on after a first try that failed."""
        await self._clock.sleep(FIRST_WAIT_S)
        await self._speak(item, tries=TRIES - 1)

    async def _speak_later(self, item: Item) -> None:
        """Try what matters again after a while, behind what was said meanwhile."""
        await self._clock.sleep(ASIDE_S)
        where = item.where if isinstance(item, OrderMessage) else item.where_to
        self._queue(where, item).put(item)

    async def speak_once(self, item: Item, queue: ChatQueue | None = None) -> None:
        """Say one thing, with whatever may be said in one turn.

        Args:
            item: What to say.
            queue: If it has waited for a turn; what is left is given back to it.
        """
        if not isinstance(item, OrderMessage):
            await self._say(item)
        elif not item.in_place:
            await self._show_line_by_line(item)
        elif queue is not None and queue.items and item.is_over_unseen:
            await self._show_at_once(item)
        else:
            await self.show_in_place(item, queue)

    async def _say(self, note: OutgoingMessage) -> None:
        try:
            message = await edit_or_send(note)
        except MessengerFault as fault:
            # An edit may be made twice; a message that is sent twice says so.
            if fault.perhaps_sent and not note.edit_of and not note.doubted:
                address = Address(note.outbound.chat.platform, note.outbound.chat.id)
                note.doubt(_marked(note.outbound, self.languages.of_address(address)))
            raise
        if not message:
            return
        self.on_buttons.emit(note, message)
        self.reply_targets.note(note.messenger.name, note.outbound.chat, message, note.about)
        self.count_as_told(note)
        if note.landed is not None:
            note.landed(message)
        if note.then is not None:
            note.then()

    async def _show_line_by_line(self, order_message: OrderMessage) -> None:
        while order_message.lines:
            text, last = (
                order_message.lines[0],
                len(order_message.lines) == 1 and not order_message.open,
            )
            buttons = order_message.after if last else ()
            await order_message.messenger.send(
                Outbound(chat=order_message.chat, text=text, buttons=buttons)
            )
            order_message.line_said()
        if not order_message.open and order_message.untold:
            self._containers.told(*order_message.settle())

    async def _show_at_once(self, order_message: OrderMessage) -> None:
        """Say a life that is over in one message, where more waits than the platform takes.

        Half the calls, so twice as many people hear how their orders ended. Should this process
        die before it is noted as told, the next says it again, marked (`gateway/recovery.py`).
        """
        try:
            order_message.stands_in(
                await order_message.messenger.send(order_message.read(endings=True))
            )
        except MessengerFault as fault:
            if fault.perhaps_sent:
                order_message.doubt()
            raise
        self.reply_targets.note(
            order_message.messenger.name,
            order_message.chat,
            order_message.message,
            order_message.about,
        )
        self._containers.told(*order_message.settle())

    async def show_in_place(self, order_message: OrderMessage, queue: ChatQueue | None) -> None:
        """Send once, write down which message it is, and say an ending only by editing it.

        So an ending is said exactly once, whenever this process may die: what was not noted as
        told is said again by an edit to the same content.
        """
        if not order_message.message or order_message.adopted:
            await self._place(order_message)
            if queue is not None and order_message.dirty:
                queue.put_back(order_message)
                return
        if not order_message.dirty:
            return
        shown = order_message.read(endings=True)
        if order_message.doubted:
            shown = _marked(shown, self.languages.of(order_message.principal))
        self._due.pop(order_message, None)  # a life that is over would lie there until the tick
        try:
            await order_message.messenger.edit(order_message.message, shown)
        except Exception as fault:
            order_message.not_edited(gone=isinstance(fault, MessageGone))
            raise
        # A later run knows only lives that are not noted as told, and says them together.
        if order_message.untold and not order_message.dirty and not order_message.open:
            self._containers.told(*order_message.settle())

    async def _place(self, order_message: OrderMessage) -> None:
        """Show a life for the first time, and write down which message shows it."""
        if order_message.adopted:
            await self._adopt(order_message)
        else:
            try:
                order_message.stands_in(
                    await order_message.messenger.send(order_message.read(endings=False))
                )
            except MessengerFault as fault:
                if fault.perhaps_sent:
                    order_message.doubt()
                raise
        self.reply_targets.note(
            order_message.messenger.name,
            order_message.chat,
            order_message.message,
            order_message.about,
        )
        if order_message.ending:
            await self._containers.place(
                order_message.cids, order_message.principal, order_message.message
            )
        else:
            # Nobody waits for it: an ending is written later, and so after it.
            self._containers.note_place(
                order_message.cids, order_message.principal, order_message.message
            )

    async def _adopt(self, order_message: OrderMessage) -> None:
        """Show the message of some orders for the first time, where it was asked for."""
        outbound, question = order_message.read(endings=False), order_message.take_place()
        self.on_buttons.emit(OutgoingMessage(order_message.messenger, outbound), question)
        await order_message.messenger.edit(question, outbound)
        order_message.stands_in(question)

    async def flush(self, seconds: float) -> None:
        """Wait until everything is said, or the time is over; then fall silent."""
        tasks = [queue.task for queue in self._queues.values() if queue.task is not None]
        deadline_ns = self._clock.monotonic_ns() + int(seconds * 1e9)
        while not self.quiet and self._clock.monotonic_ns() < deadline_ns:
            await self._clock.sleep(0.01)
        ticking = (self._ticking,) if self._ticking is not None else ()
        everything = (*tasks, *self._urgent, *self._aside, *ticking)
        for task in everything:
            task.cancel()
        await asyncio.gather(*everything, return_exceptions=True)

    @property
    def quiet(self) -> bool:
        """Whether everything has been said."""
        speaking = any(
            queue.items or not queue.is_asleep
            for queue in self._queues.values()
            if queue.task is not None
        )
        return not speaking and not self._urgent


def _marked(outbound: Outbound, catalogue: Catalogue | None) -> Outbound:
    """Return what may have arrived already, saying so."""
    text = in_language(messages.perhaps_twice(outbound.text), catalogue)
    return msgspec.structs.replace(outbound, text=text)
