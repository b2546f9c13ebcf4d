"""What waits to be said in one chat, and how much it matters."""

from __future__ import annotations

import asyncio
import logging
from collections import deque
from collections.abc import Callable
from typing import TYPE_CHECKING, Protocol, TypeAlias

import msgspec

from rosic.contracts.messenger import Messenger
from rosic.core import messages
from rosic.core.i18n import joined
from rosic.core.identity import CommandId, PrincipalId
from rosic.core.message import Chat, Outbound, SendPriority
from rosic.errors import ChatGone, MessageGone, MessengerFault
from rosic.gateway.order_status import OrderMessage

if TYPE_CHECKING:
    from rosic.contracts.clock import Clock
    from rosic.contracts.messenger import Turn


class OutgoingMessage(msgspec.Struct):
    """A message that stands for itself. ``cid`` and ``also`` are noted as told once it was sent.

    Attributes:
        edit_only: It says of ``edit_of`` that its time is over, no more: where that message is
            gone, nothing is said in its place. What was taken out of a chat, a secret first of
            all, stays out.
        then: Called once it was sent; it is never dropped before.
        landed: Called with the id of the message that shows it, each time it was said.
        doubted: It may have arrived already, or not.
        about: The robot or group that it speaks of, for whoever replies to it; empty for none.
        to: Who is to read it, where that is one person.
        asker: Whose message it answers, a person's id or an address: they share a chat's turns.
            Empty for what nobody has asked for.
        hops: How often it was passed on, as the chat before could be told no more.
    """

    messenger: Messenger
    outbound: Outbound
    cid: CommandId | None = None
    edit_of: str = ""
    also: tuple[CommandId, ...] = ()
    edit_only: bool = False
    then: Callable[[], None] | None = None
    landed: Callable[[str], None] | None = None
    doubted: bool = False
    about: str = ""
    to: PrincipalId = ""
    asker: str = ""
    hops: int = 0

    @property
    def where_to(self) -> tuple[str, str]:
        """Name of the messenger, and id of the chat."""
        return self.messenger.name, self.outbound.chat.id

    @property
    def messenger_and_chat(self) -> tuple[Messenger, Chat]:
        """Where it is said."""
        return self.messenger, self.outbound.chat

    def doubt(self, marked: Outbound) -> None:
        """It may have arrived already: from here on it is said with a mark."""
        self.doubted, self.outbound = True, marked

    def owe(self, to: PrincipalId, then: Callable[[], None]) -> None:
        """Take in who is to read it, and what is called once it was sent."""
        self.to, self.then = to, then

    def offer(self, outbound: Outbound, landed: Callable[[str], None] | None) -> None:
        """Say it with what is offered, and tell which message does; None: nobody asks."""
        self.outbound, self.landed = outbound, landed or self.landed

    def reword(self, text: str) -> None:
        """Say something else."""
        self.outbound = msgspec.structs.replace(self.outbound, text=text)


Item: TypeAlias = OrderMessage | OutgoingMessage
UNSAID_AT_MOST = 512
ANSWERS_AT_MOST = 64
"""Answers to one person that wait in one chat: the oldest gives way to the newest."""
ASKERS_REMEMBERED = 512
DROPPED_TOGETHER = 100
"""What finds no room is logged so often."""
FIRST_WAIT_S = 0.5

log = logging.getLogger("rosic.delivery")


class Speaker(Protocol):
    """Says what queues hand out; see `ChatSender`."""

    async def show_in_place(self, order_message: OrderMessage, queue: ChatQueue | None) -> None:
        """Show how orders are now by editing their message."""

    async def speak_once(self, item: Item, queue: ChatQueue | None = None) -> None:
        """Say one thing."""

    async def speak_again(self, item: Item) -> None:
        """Go on after a first try that failed."""

    def let_go(self, item: Item, why: ChatGone) -> None:
        """Count as told what nobody is there to be told any more."""

    def count_as_told(self, note: OutgoingMessage) -> None:
        """Note that what it answers is settled."""

    def plain(self, text: str, reader: PrincipalId) -> str:
        """Return a sentence as somebody reads it."""


class ChatQueue:
    """What is to be said in one chat, and the task that has it said.

    Of what is equally important each person in turn is answered: whoever asks for much waits for
    it, and nobody else does.

    Attributes:
        answered: When whom, in turns; empty while no two things wait.
        turn: What its messenger asks for a turn; None: there is always room.
        asking: While it waits for a turn; `weight` is with which weight.
        wake: While nothing is to be said; done once there is.
        dropped: How many messages found no room so far.
        left_out: How many answers to whom gave way to newer ones, and they were not told so.

    Args:
        speaker: Says it.
        messenger: Its name, for the log.
        clock: Waits where a messenger cannot tell whose turn it is.
        turn: As above.
        shared: More than one person may be in the chat.
    """

    __slots__ = (
        "_clock",
        "_messenger",
        "_shared",
        "_speaker",
        "_turns",
        "answered",
        "asking",
        "dropped",
        "items",
        "left_out",
        "task",
        "turn",
        "wake",
        "weight",
    )

    def __init__(
        self, speaker: Speaker, messenger: str, clock: Clock, turn: Turn | None, *, shared: bool
    ) -> None:
        self._speaker = speaker
        self._messenger = messenger
        self._clock = clock
        self.turn = turn
        self._shared = shared
        self.items: deque[Item] = deque()
        self.task: asyncio.Task[None] | None = None
        self.wake: asyncio.Future[None] | None = None
        self.asking: asyncio.Future[None] | None = None
        self.weight = SendPriority.FEEDBACK
        self.dropped = 0
        self.left_out: dict[str, int] = {}
        self._turns = 0
        self.answered: dict[str, int] = {}

    def put(self, item: Item) -> None:
        """Have it said when its turn comes; what waits there last is said once, as it is then."""
        items = self.items
        if items:
            if items[-1] is item:
                self.hasten(item)
                return
            if not self.make_room(item):
                return
        items.append(item)
        if self.task is None:
            self.task = asyncio.create_task(self._run())
        elif self.wake is not None and not self.wake.done():
            self.wake.set_result(None)
        elif self.asking is not None:
            self.hasten(item)

    def put_back(self, item: Item) -> None:
        """Have it said next: the rest of it is another turn."""
        self.items.appendleft(item)

    @property
    def is_asleep(self) -> bool:
        """Nothing is to be said, and its task waits until there is."""
        return self.wake is not None and not self.wake.done()

    async def _run(self) -> None:
        loop, turn, speaker = asyncio.get_running_loop(), self.turn, self._speaker
        while True:
            while self.items:
                if turn is not None:
                    await self._wait_for_turn(turn)
                alone = len(self.items) == 1 and not self.answered
                item = self.items.popleft() if alone else self._take_out()
                try:
                    if turn is None and isinstance(item, OrderMessage) and item.in_place:
                        await speaker.show_in_place(item, None)
                    else:
                        await speaker.speak_once(item, self if turn is not None else None)
                except ChatGone as why:
                    speaker.let_go(item, why)
                except MessengerFault as fault:
                    log.warning("not told yet: %s", fault)
                    await speaker.speak_again(item)
                except Exception:
                    log.exception("not told: a fault of the messenger")
                    await speaker.speak_again(item)
                del item  # or it would lie about until something else is said here
            self.wake = loop.create_future()
            await self.wake
            self.wake = None

    async def _wait_for_turn(self, turn: Turn) -> None:
        """Wait until the most important thing in the chat may be said, for as long as it takes."""
        _, chat = place_of(self.items[0])
        while True:
            self.weight = min(map(weight_of, self.items))
            self.asking = asyncio.ensure_future(turn(chat, self.weight))
            try:
                await self.asking
            except asyncio.CancelledError:
                me = asyncio.current_task()
                if me is None or me.cancelling():
                    raise
            except MessengerFault as fault:
                log.warning("no turn yet: %s", fault)
                await self._clock.sleep(FIRST_WAIT_S)
            else:
                return
            finally:
                self.asking = None

    def _take_out(self) -> Item:
        """Take out what is said next; an answer says how many before it were left out."""
        item = self.take()
        if not self.left_out or isinstance(item, OrderMessage):
            return item
        count = self.left_out.pop(item.asker, 0)
        if count:
            text = joined("\n", (messages.left_out(count), item.outbound.text))
            item.reword(self._speaker.plain(text, item.asker))
        return item

    def hasten(self, item: Item) -> None:
        """Have it ask anew if it asks for a turn with less weight than this deserves."""
        if self.asking is not None and weight_of(item) < self.weight:
            self.asking.cancel()

    def make_room(self, item: Item) -> bool:
        """Return whether something is to be said, however full the queue is.

        Where too many answers to one person wait, their oldest gives way to a new one. What answers
        somebody takes the place of the oldest thing that nobody has asked for, else of the oldest
        answer: so whoever has just written is answered.
        """
        if len(self.items) < ANSWERS_AT_MOST or self._leave_out(item):
            return True
        if len(self.items) < UNSAID_AT_MOST or matters(item):
            return True
        self._count_dropped()
        spare = [at for at, waiting in enumerate(self.items) if not matters(waiting)]
        if not spare or not is_answer(item):
            return False
        unasked = (at for at in spare if not is_answer(self.items[at]))
        del self.items[next(unasked, spare[0])]
        return True

    def _leave_out(self, item: Item) -> bool:
        """Return whether the oldest answer to whoever this answers gave way to it.

        What says how an order ended is not counted, and stays.
        """
        asker = _answered_by(item)
        if not asker:
            return False
        theirs = [at for at, waiting in enumerate(self.items) if _answered_by(waiting) == asker]
        oldest = self.items[theirs[0]] if len(theirs) >= ANSWERS_AT_MOST else None
        if not isinstance(oldest, OutgoingMessage):
            return False
        del self.items[theirs[0]]
        self._count_dropped()
        self.left_out[asker] = self.left_out.get(asker, 0) + 1
        self._speaker.count_as_told(oldest)
        return True

    def _count_dropped(self) -> None:
        self.dropped += 1
        if self.dropped % DROPPED_TOGETHER == 1:
            log.warning(
                "%s: too much waits to be said in one chat: %d messages were dropped there",
                self._messenger,
                self.dropped,
            )

    def take(self) -> Item:
        """Take out the most important thing; of several, what answers whoever waited longest."""
        items = self.items
        if len(items) == 1:
            self.answered.clear()
            return items.popleft()
        return self._take_fairly() if self._shared else self._take_weightiest()

    def _take_weightiest(self) -> Item:
        """Take out the first of the most important things; nobody else waits here."""
        items = self.items
        number, most = 0, weight_of(items[0])
        for at in range(1, len(items)):
            weight = weight_of(items[at])
            if weight < most:
                number, most = at, weight
        item = items[number]
        del items[number]
        return item

    def _take_fairly(self) -> Item:
        items = self.items
        number = min(range(len(items)), key=lambda at: self._place(items[at]))
        item = items[number]
        del items[number]
        self._turns += 1
        self.answered[asker_of(item)] = self._turns
        if len(self.answered) > ASKERS_REMEMBERED:
            waiting = set(map(asker_of, items))
            self.answered = {who: at for who, at in self.answered.items() if who in waiting}
        return item

    def _place(self, item: Item) -> tuple[SendPriority, int]:
        return weight_of(item), self.answered.get(asker_of(item), 0)


async def edit_or_send(note: OutgoingMessage) -> str:
    """Return which message shows a note now; empty if it was to change only one that is gone.

    Raises:
        MessengerFault: Not said, or it cannot be known.
    """
    if note.edit_of and note.messenger.edits:
        try:
            await note.messenger.edit(note.edit_of, note.outbound)
        except MessageGone:
            if note.edit_only:
                return ""
        else:
            return note.edit_of
    return await note.messenger.send(note.outbound)


def place_of(item: Item) -> tuple[Messenger, Chat]:
    """Return where it is said."""
    return (
        (item.messenger, item.chat) if isinstance(item, OrderMessage) else item.messenger_and_chat
    )


def matters(item: Item) -> bool:
    """Whether it must be said even when there is too much to say: how something ended."""
    if isinstance(item, OrderMessage):
        return not item.open
    return item.cid is not None or item.then is not None


def asker_of(item: Item) -> str:
    """Return whom it answers; empty for nobody."""
    return item.principal if isinstance(item, OrderMessage) else item.asker


def _answered_by(item: Item) -> str:
    """Return whom it answers, unless it tells how an order ended, or somebody must hear of it."""
    return item.asker if isinstance(item, OutgoingMessage) and item.then is None else ""


def is_answer(item: Item) -> bool:
    """Whether somebody waits for it who has just written or tapped."""
    return isinstance(item, OrderMessage) or bool(item.outbound.reply_to or item.edit_of)


def weight_of(item: Item) -> SendPriority:
    """Return how important it is now: more so once an order of its message has ended."""
    return item.weight if isinstance(item, OrderMessage) else item.outbound.weight
