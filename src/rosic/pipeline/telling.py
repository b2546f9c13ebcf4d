"""Tell: what goes back to a chat, in order, newest state first, an ending never lost while we live.

One voice per chat speaks at a time, so that a chat is never overtaken by itself. A voice that has
nothing to say costs nothing. What a stop answers does not wait for any of this.
"""

from __future__ import annotations

import asyncio
import logging
from collections import deque
from typing import TYPE_CHECKING, TypeAlias

import msgspec

from rosic.contracts.messenger import Messenger
from rosic.core.identity import CommandId
from rosic.core.message import Outbound
from rosic.errors import MessageGone, MessengerFault
from rosic.pipeline.cards import Card
from rosic.pipeline.languages import Languages

if TYPE_CHECKING:
    from collections.abc import Callable

    from rosic.container.container import Containers
    from rosic.contracts.clock import Clock

TRIES = 6
ASIDE_S = 60.0
ASIDE_AT_MOST = 10_000
# Between two edits that only show progress. Seldom enough to leave room for the ending where a
# platform takes one message a second from a chat.
PROGRESS_EVERY_S = 2.0
FIRST_WAIT_S = 0.5
UNSAID_AT_MOST = 512
VOICES_AT_MOST = 10_000

log = logging.getLogger("rosic.telling")


class Note(msgspec.Struct):
    """A message that stands for itself. ``cid`` and ``also`` are noted as told once it was sent.

    Attributes:
        good_for_ns: How long its buttons are good, if that is not the usual.
    """

    messenger: Messenger
    outbound: Outbound
    cid: CommandId | None = None
    edit_of: str = ""
    also: tuple[CommandId, ...] = ()
    good_for_ns: int = 0


_Item: TypeAlias = Card | Note


class Voice:
    """What is to be said in one chat."""

    __slots__ = ("items", "task", "wake")

    def __init__(self) -> None:
        self.items: deque[_Item] = deque()
        self.task: asyncio.Task[None] | None = None
        self.wake: asyncio.Future[None] | None = None


class Teller:
    """All voices.

    Attributes:
        on_buttons: Hears which message shows a note now.
        languages: Who reads which language; what is handed over here to be said is plain already.
    """

    def __init__(
        self, containers: Containers, clock: Clock, languages: Languages | None = None
    ) -> None:
        self.languages = Languages() if languages is None else languages
        self._containers = containers
        self._clock = clock
        self._voices: dict[tuple[str, str], Voice] = {}
        self._urgent: set[asyncio.Task[None]] = set()
        self._aside: set[asyncio.Task[None]] = set()
        self._due: dict[Card, None] = {}
        self._ticking: asyncio.Task[None] | None = None
        self.on_buttons: Callable[[Note, str], None] = _nobody_looks

    def say(self, note: Note) -> None:
        """Say something after everything said before in its chat; an urgent one at once."""
        if note.outbound.urgent:
            task = asyncio.create_task(self._speak(note))
            self._urgent.add(task)
            task.add_done_callback(self._urgent.discard)
        else:
            self._enqueue((note.messenger.name, note.outbound.chat.id), note)

    def show(self, card: Card) -> None:
        """Bring a chat up to date with a card."""
        self._enqueue(card.where, card)

    def update(self, card: Card) -> None:
        """Show progress: line by line at once, or by an edit when the next one is due."""
        if card.lines:
            self._enqueue(card.where, card)
        elif card.dirty:
            self._due[card] = None
            if self._ticking is None:
                self._ticking = asyncio.create_task(self._tick())

    async def _tick(self) -> None:
        """Show what has changed, for all chats together, so that progress costs no timers."""
        while self._due:
            await self._clock.sleep(PROGRESS_EVERY_S)
            due, self._due = self._due, {}
            for card in due:
                if card.dirty and card.open:
                    self._enqueue(card.where, card)
        self._ticking = None

    def _enqueue(self, where: tuple[str, str], item: _Item) -> None:
        voice = self._voices.get(where)
        if voice is None:
            self._retire()
            voice = self._voices[where] = Voice()
        items = voice.items
        if items:
            if items[-1] is item:
                return  # it will be read when it is its turn, as it is then
            if len(items) >= UNSAID_AT_MOST and not _matters(item):
                return
        items.append(item)
        if voice.task is None:
            voice.task = asyncio.create_task(self._run(voice))
        elif voice.wake is not None and not voice.wake.done():
            voice.wake.set_result(None)

    def _retire(self) -> None:
        """Keep the number of voices bounded: the oldest ones that have nothing to say go."""
        if len(self._voices) < VOICES_AT_MOST:
            return
        for where, voice in list(self._voices.items())[: VOICES_AT_MOST // 2]:
            if voice.task is not None and voice.wake is not None and not voice.wake.done():
                voice.task.cancel()
                del self._voices[where]

    async def _run(self, voice: Voice) -> None:
        loop = asyncio.get_running_loop()
        while True:
            while voice.items:
                item = voice.items.popleft()
                try:
                    await self._speak_once(item)
                except MessengerFault as fault:
                    log.warning("not told yet: %s", fault)
                    await self._speak_again(item)
                except Exception:
                    log.exception("not told: a fault of the messenger")
                    await self._speak_again(item)
            voice.wake = loop.create_future()
            await voice.wake

    async def _speak(self, item: _Item, *, tries: int = TRIES) -> None:
        """Say one thing, or lay it aside: one message that is not taken silences no chat."""
        wait_s = FIRST_WAIT_S * 2 ** (TRIES - tries)
        for _ in range(tries):
            try:
                await self._speak_once(item)
            except MessengerFault as fault:
                log.warning("not told yet: %s", fault)
            except Exception:
                log.exception("not told: a fault of the messenger")
            else:
                return
            await self._clock.sleep(wait_s)
            wait_s *= 2
        if _matters(item) and len(self._aside) < ASIDE_AT_MOST:
            task = asyncio.create_task(self._speak_later(item))
            self._aside.add(task)
            task.add_done_callback(self._aside.discard)

    async def _speak_again(self, item: _Item) -> None:
        """Go on after a first try that failed."""
        await self._clock.sleep(FIRST_WAIT_S)
        await self._speak(item, tries=TRIES - 1)

    async def _speak_later(self, item: _Item) -> None:
        """Try what matters again after a while, behind what was said meanwhile."""
        await self._clock.sleep(ASIDE_S)
        if isinstance(item, Card):
            self._enqueue(item.where, item)
        else:
            self._enqueue((item.messenger.name, item.outbound.chat.id), item)

    async def _speak_once(self, item: _Item) -> None:
        if not isinstance(item, Card):
            await self._say(item)
        elif item.in_place:
            await self._show_in_place(item)
        else:
            await self._show_line_by_line(item)

    async def _say(self, note: Note) -> None:
        message = note.edit_of if note.messenger.edits else ""
        try:
            if message:
                await note.messenger.edit(message, note.outbound)
            else:
                message = await note.messenger.send(note.outbound)
        except MessageGone:
            message = await note.messenger.send(note.outbound)
        self.on_buttons(note, message)
        if note.cid is not None:
            self._containers.told(note.cid, *note.also)

    async def _show_line_by_line(self, card: Card) -> None:
        while card.lines:
            text = card.lines[0]
            await card.messenger.send(Outbound(chat=card.chat, text=text))
            card.lines.pop(0)
        if not card.open and card.untold:
            self._containers.told(*card.untold)
            card.untold = []

    async def _show_in_place(self, card: Card) -> None:
        """Send once, write down which message it is, and say an ending only by editing it.

        So an ending is said exactly once, whenever this process may die: what was not noted as
        told is said again by an edit to the same content.
        """
        if not card.message or card.adopted:
            card.dirty = bool(card.untold)
            await self._begin_in_place(card)
            if card.ending:
                await self._containers.place(card.cids, card.principal, card.message)
            else:
                # Nobody waits for it: an ending is written later, and so after it.
                self._containers.note_place(card.cids, card.principal, card.message)
        if not card.dirty:
            return
        ended, card.untold = card.untold, []
        card.dirty = False
        try:
            await card.messenger.edit(card.message, _outbound(card, endings=True))
        except MessengerFault as fault:
            card.dirty = True
            card.untold = ended + card.untold
            if isinstance(fault, MessageGone):
                card.message = ""  # the person deleted it; the life goes on in a new one
            raise
        if card.dirty or card.open:
            # A later run knows only lives that are not noted as told, and says them together.
            card.untold = ended + card.untold
        elif ended:
            self._containers.told(*ended)

    async def _begin_in_place(self, card: Card) -> None:
        """Show a card for the first time: in a message of its own, or where it was asked for."""
        outbound = _outbound(card, endings=False)
        if card.adopted:
            adopted, card.adopted = card.message, False
            card.message = ""  # should this fail, it is said in a message of its own
            self.on_buttons(Note(card.messenger, outbound), adopted)
            await card.messenger.edit(adopted, outbound)
            card.message = adopted
        else:
            card.message = await card.messenger.send(outbound)

    async def flush(self, seconds: float) -> None:
        """Wait until everything is said, or the time is over; then fall silent."""
        tasks = [voice.task for voice in self._voices.values() if voice.task is not None]
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
            voice.items or (voice.wake is not None and voice.wake.done()) or voice.wake is None
            for voice in self._voices.values()
            if voice.task is not None
        )
        return not speaking and not self._urgent


def _nobody_looks(_note: Note, _message: str) -> None:
    """Nobody wants to know which message shows a note."""


def _matters(item: _Item) -> bool:
    """Whether it must be said even when there is too much to say: how something ended."""
    return not item.open if isinstance(item, Card) else item.cid is not None


def _outbound(card: Card, *, endings: bool) -> Outbound:
    return Outbound(
        chat=card.chat,
        text=card.text(endings=endings),
        reply_to=card.reply_to,
        buttons=card.buttons if card.open else (),
    )
