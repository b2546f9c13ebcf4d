"""Answers to what was sent while nobody listened: few of them as they are, many as one.

A chat takes about one message a second; fifty people's impatience during an outage would keep it
busy for minutes, and nobody reads the fortieth "nothing was done". So answers to what had piled up
wait until no more of it comes, and each chat is then told once.
"""

from __future__ import annotations

import asyncio
import logging
from collections import deque
from typing import TYPE_CHECKING, Final

from rosic.contracts.background_tasks import BackgroundTasks
from rosic.contracts.messenger import waits_for_disk
from rosic.core.i18n import joined, said, said_n
from rosic.core.message import Outbound, SendPriority
from rosic.errors import Expired
from rosic.gateway.delivery.sender import ChatSender, OutgoingMessage

if TYPE_CHECKING:
    from collections.abc import Coroutine

    from rosic.contracts.clock import Clock
    from rosic.contracts.messenger import Messenger
    from rosic.core.i18n import Catalogue
    from rosic.core.identity import CommandId
    from rosic.core.message import Button, Chat
    from rosic.errors import Refusal

log = logging.getLogger("rosic.pipeline")

QUIET_S: Final = 0.5
"""So long nothing must have come that was sent while nobody listened, in any chat."""
SINGLY: Final = 2
OFFERED: Final = 3
ANSWERS_KEPT: Final = 3


class _Heap:
    """What one chat is to be told.

    Attributes:
        refused: Answers that say that nothing was done, as long as they are few.
        cids: Of all commands that were refused.
        offers: The newest commands that came too late, by what they say.
        answers: The newest other answers.
        catalogue: Of whoever wrote last.
        away: The network was, when each of the commands was sent.
    """

    def __init__(self, messenger: Messenger, chat: Chat) -> None:
        self.messenger = messenger
        self.chat = chat
        self.refused: list[OutgoingMessage] = []
        self.cids: list[CommandId] = []
        self.offers: dict[str, tuple[Button, ...]] = {}
        self.answers: deque[OutgoingMessage] = deque(maxlen=ANSWERS_KEPT)
        self.catalogue: Catalogue | None = None
        self.away = True


class BacklogReplies:
    """Keeps answers back while a backlog is drained."""

    def __init__(self, chat_sender: ChatSender, clock: Clock) -> None:
        self._chat_sender = chat_sender
        self._clock = clock
        self._heaps: dict[tuple[str, str], _Heap] = {}
        self._writing: BackgroundTasks[None] = BackgroundTasks()
        self._last_ns = 0
        self._waiting: asyncio.Task[None] | None = None

    @property
    def quiet(self) -> bool:
        """Whether nothing is kept back."""
        return not self._heaps and not self._writing

    def keep(
        self,
        note: OutgoingMessage,
        refusal: Refusal | None,
        catalogue: Catalogue | None,
        *,
        away: bool,
    ) -> None:
        """Keep an answer back.

        Args:
            note: As it would be said by itself.
            refusal: Why nothing was done; None for an answer to a question.
            catalogue: Of whoever is answered.
            away: The network was, when it was sent.
        """
        heap = self._heap(note)
        heap.catalogue = catalogue
        if refusal is None or note.cid is None:
            heap.answers.append(note)
            return
        heap.cids.append(note.cid)
        heap.away = heap.away and away
        if len(heap.refused) <= SINGLY:
            heap.refused.append(note)
        if isinstance(refusal, Expired) and note.outbound.buttons:
            row = note.outbound.buttons[0]
            heap.offers.pop(row[0].label, None)
            heap.offers[row[0].label] = row
            if len(heap.offers) > OFFERED:
                del heap.offers[next(iter(heap.offers))]

    # ---- writing ----

    def settles(self, messenger: Messenger) -> bool:
        """Whether a messenger waits for what is begun here before it confirms anything."""
        return waits_for_disk(messenger)

    def begin(self, writing: Coroutine[object, object, None]) -> None:
        """Write an answer down beside the next message of its chat, in the order begun.

        A commit takes as long as the disk takes; one after the other, a day of them takes minutes.
        """
        self._writing.begin(self._write(writing))

    @staticmethod
    async def _write(writing: Coroutine[object, object, None]) -> None:
        try:
            await writing
        except Exception:
            log.exception("what was refused could not be told")

    async def settled(self, within_s: float) -> bool:
        """Wait until everything begun so far is written; return whether it is."""
        if not self._writing:
            return True
        _, left = await asyncio.wait(tuple(self._writing), timeout=within_s)
        return not left

    # ---- telling ----

    def flush(self) -> None:
        """Say everything now."""
        heaps, self._heaps = self._heaps, {}
        for heap in heaps.values():
            self._say(heap)
        if self._waiting is not None:
            self._waiting.cancel()
            self._waiting = None

    def _heap(self, note: OutgoingMessage) -> _Heap:
        self._last_ns = self._clock.monotonic_ns()
        if self._waiting is None:
            self._waiting = asyncio.create_task(self._wait())
        messenger, chat = note.messenger_and_chat
        return self._heaps.setdefault((messenger.name, chat.id), _Heap(messenger, chat))

    async def _wait(self) -> None:
        quiet_ns = int(QUIET_S * 1e9)
        while (left_ns := self._last_ns + quiet_ns - self._clock.monotonic_ns()) > 0:
            await self._clock.sleep(left_ns / 1e9)
        self._waiting = None
        self.flush()

    def _say(self, heap: _Heap) -> None:
        if len(heap.cids) <= SINGLY:
            for note in heap.refused:
                self._chat_sender.say(note)
        else:
            self._chat_sender.say(
                together(
                    heap.messenger,
                    heap.chat,
                    heap.cids,
                    tuple(heap.offers.values()),
                    away=heap.away,
                )
            )
        for note in heap.answers:
            self._chat_sender.say(note)


def together(
    messenger: Messenger,
    chat: Chat,
    cids: list[CommandId],
    offers: tuple[tuple[Button, ...], ...] = (),
    *,
    away: bool = False,
) -> OutgoingMessage:
    """Return one answer to many commands of a chat, of which none was carried out."""
    text: str = _network_away(len(cids)) if away else _unheard(len(cids))
    if offers:
        text = joined("\n", [text, said("What you still want, tap to send it again.")])
    outbound = Outbound(chat=chat, text=text, buttons=offers, weight=SendPriority.OUTCOME)
    first, *also = cids
    return OutgoingMessage(messenger, outbound, first, also=tuple(also))


def _unheard(n: int) -> str:
    return said_n(
        "While I could not listen, {n} command came in here. It was not carried out.",
        "While I could not listen, {n} commands came in here. None of them was carried out.",
        n,
    )


def _network_away(n: int) -> str:
    return said_n(
        "While the network was away, {n} command came in here. It was not carried out.",
        "While the network was away, {n} commands came in here. None of them was carried out.",
        n,
    )
