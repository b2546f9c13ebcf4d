"""What waits to be said in one chat, and how much it matters."""

from __future__ import annotations

import logging
from collections import deque
from collections.abc import Callable
from typing import TYPE_CHECKING, TypeAlias

import msgspec

from rosic.contracts.messenger import Messenger
from rosic.core.identity import CommandId, PrincipalId
from rosic.core.message import Chat, Outbound, SendPriority
from rosic.errors import MessageGone
from rosic.gateway.order_status import OrderMessage

if TYPE_CHECKING:
    import asyncio

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


Item: TypeAlias = OrderMessage | OutgoingMessage
UNSAID_AT_MOST = 512
ANSWERS_AT_MOST = 64
"""Answers to one person that wait in one chat: the oldest gives way to the newest."""
ASKERS_REMEMBERED = 512
DROPPED_TOGETHER = 100
"""What finds no room is logged so often."""

log = logging.getLogger("rosic.telling")

OUTCOME, QUESTION, FEEDBACK = SendPriority.OUTCOME, SendPriority.QUESTION, SendPriority.FEEDBACK


class ChatQueue:
    """What is to be said in one chat.

    Of what is equally important each person in turn is answered: whoever asks for much waits for
    it, and nobody else does.

    Attributes:
        answered: When whom, in turns; empty while no two things wait.
        turn: What its messenger asks for a turn; None: there is always room.
        asking: While it waits for a turn, and with which weight.
        dropped: How many messages found no room so far.
        left_out: How many answers to whom gave way to newer ones, and they were not told so.

    Args:
        turn: As above.
        left_out: Is told of each of these: it counts as told.
        shared: More than one person may be in the chat.
    """

    __slots__ = (
        "_count_as_told",
        "_shared",
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
        self, turn: Turn | None, left_out: Callable[[OutgoingMessage], None], *, shared: bool
    ) -> None:
        self.turn = turn
        self._shared = shared
        self.items: deque[Item] = deque()
        self.task: asyncio.Task[None] | None = None
        self.wake: asyncio.Future[None] | None = None
        self.asking: asyncio.Future[None] | None = None
        self.weight = SendPriority.FEEDBACK
        self.dropped = 0
        self.left_out: dict[str, int] = {}
        self._count_as_told = left_out
        self._turns = 0
        self.answered: dict[str, int] = {}

    def hasten(self, item: Item) -> None:
        """Have it ask anew if it asks for a turn with less weight than this deserves."""
        if self.asking is not None and weight_of(item) < self.weight:
            self.asking.cancel()

    def make_room(self, item: Item, messenger: str) -> bool:
        """Return whether something is to be said, however full the queue is.

        Where too many answers to one person wait, their oldest gives way to a new one. What answers
        somebody takes the place of the oldest thing that nobody has asked for, else of the oldest
        answer: so whoever has just written is answered.
        """
        if len(self.items) < ANSWERS_AT_MOST or self._leave_out(item, messenger):
            return True
        if len(self.items) < UNSAID_AT_MOST or matters(item):
            return True
        self._count_dropped(messenger)
        spare = [at for at, waiting in enumerate(self.items) if not matters(waiting)]
        if not spare or not is_answer(item):
            return False
        unasked = (at for at in spare if not is_answer(self.items[at]))
        del self.items[next(unasked, spare[0])]
        return True

    def _leave_out(self, item: Item, messenger: str) -> bool:
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
        self._count_dropped(messenger)
        self.left_out[asker] = self.left_out.get(asker, 0) + 1
        self._count_as_told(oldest)
        return True

    def _count_dropped(self, messenger: str) -> None:
        self.dropped += 1
        if self.dropped % DROPPED_TOGETHER == 1:
            log.warning(
                "%s: too much waits to be said in one chat: %d messages were dropped there",
                messenger,
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
    """Return how important it is now: a card grows in weight when one of its lives has ended."""
    if not isinstance(item, OrderMessage):
        return item.outbound.weight
    if item.untold:
        return OUTCOME
    return FEEDBACK if item.message and not item.adopted else QUESTION


def outbound_of(card: OrderMessage, *, endings: bool) -> Outbound:
    """Return a card as it should read now, with or without how lives ended."""
    weight = OUTCOME if card.untold else FEEDBACK if card.message and not card.adopted else QUESTION
    return Outbound(
        chat=card.chat,
        text=card.text(endings=endings),
        reply_to=card.reply_to,
        buttons=card.buttons if card.open else card.after if endings else (),
        weight=weight,
    )
