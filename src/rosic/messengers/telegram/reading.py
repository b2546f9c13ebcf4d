"""What one answer to a poll holds: stops first, then people known here, strangers last of all."""

from __future__ import annotations

import logging
from heapq import heappop, heappush
from operator import itemgetter
from typing import TYPE_CHECKING, NamedTuple, TypeVar

import msgspec

from rosic.core.language import is_urgent
from rosic.core.message import Chat, ChatKind, Passage, Passing
from rosic.messengers.telegram import mapping, wire
from rosic.messengers.telegram.batch import Pause, turns
from rosic.messengers.telegram.listening import SECOND_NS
from rosic.messengers.telegram.window import AlikeLines, News

if TYPE_CHECKING:
    from asyncio import Task, TaskGroup
    from collections import Counter
    from collections.abc import Callable, Sequence

    from rosic.core.identity import Address
    from rosic.core.message import Inbound, Reaction
    from rosic.messengers.telegram.chats import Chats
    from rosic.messengers.telegram.window import Window

T = TypeVar("T")

AHEAD_NS = 2 * SECOND_NS
TURNS = 4
"""Of the event loop, for each step of reading on: whatever is to be done has several."""
KNOWN, UNNAMED, STRANGER = range(3)
"""In this order updates are read. Of somebody unnamed only a stop counts (I17), of a stranger
nothing; anybody may send a hundred of either."""

log = logging.getLogger("rosic.messengers.telegram")


class Unread(NamedTuple):
    """An update that waits for those that are read before it."""

    rank: int
    number: int
    update: wire.Update
    received: mapping.Received


class Reading:
    """Reads updates for one bot.

    Args:
        name: Of the messenger, for the log.

    Attributes:
        passed: Told what happens to chats.
        reacted: Told what people put beside messages.
        known: Whether somebody at an address may be known here: what they sent is read first.
        own_name: The bot's, without the @.
        hears_groups: The bot hears everything in groups.
        one_of_several: This gateway has other bots: what both hear in a small group is one message.
    """

    def __init__(self, name: str, chats: Chats, counts: Counter[str]) -> None:
        self.passed: Callable[[Passing], None] = _nobody_watches
        self.reacted: Callable[[Reaction], None] = _nobody_watches
        self.known: Callable[[Address], bool] = _anybody
        self.own_name = ""
        self.hears_groups = False
        self.one_of_several = False
        self._name = name
        self._chats = chats
        chats.on_moved = self._moved
        self._counts = counts
        self._alike = AlikeLines()
        self._unread: list[Unread] = []
        self._taking = False
        self._later: Task[None] | None = None

    def begin(self) -> None:
        """Forget what an earlier run did not come to."""
        self._unread, self._later = [], None

    @property
    def behind(self) -> bool:
        """Whether something that came is not read yet: of the unnamed or of strangers."""
        return bool(self._unread)

    async def take_in(
        self,
        group: TaskGroup,
        window: Window,
        raws: Sequence[object],
        received: mapping.Received,
    ) -> int:
        """Look for stops in everything that people known here sent; read the rest beside polling.

        A hundred updates are many steps of the loop, so that a stop among them is obeyed while the
        rest is still read, and one behind them is fetched. Nothing is followed before all has been
        read that may hold a stop. What was given out before is not read again.

        Returns:
            How many had not been given out before.
        """
        self._taking = True
        pause = Pause()
        parsed: dict[int, wire.Update | None] = {}
        for raw in raws:
            number = wire.update_id(raw)
            if number is not None and number not in parsed and not window.knows(number):
                parsed[number] = self.parsed(raw)
                await pause.after(raw)
        for number, update in sorted(parsed.items(), key=itemgetter(0)):
            if update is not None and (rank := self._rank(update)) != KNOWN:
                window.expect(number)
                heappush(self._unread, Unread(rank, number, update, received))
            else:
                window.admit(self.news(number, update, received))
                await pause.after(update)
        self._taking = False
        self._release(window)
        if self._unread and self._later is None:
            self._later = group.create_task(self._read_on(window))
        return len(parsed)

    async def _read_on(self, window: Window) -> None:
        pause = Pause()
        while self._unread:
            rank, number, update, received = heappop(self._unread)
            window.admit(self.news(number, update, received, of_stranger=rank == STRANGER))
            self._release(window)
            if await pause.after(update):
                await turns(TURNS)
        self._later = None

    def _release(self, window: Window) -> None:
        """Have followed what was read, unless what may hold a stop is still to be read."""
        if not self._taking and (not self._unread or self._unread[0].rank == STRANGER):
            window.release()

    def parsed(self, raw: object) -> wire.Update | None:
        """Return an update as Telegram documents it; None for one that is malformed."""
        try:
            return wire.parse(raw)
        except msgspec.ValidationError as error:
            self._counts["malformed"] += 1
            log.warning("%s: a malformed update was passed over: %s", self._name, error)
            return None

    def _rank(self, update: wire.Update) -> int:
        who = mapping.author(update)
        if who is None:
            return KNOWN if wire.written(update) is None else UNNAMED
        return KNOWN if self.known(who) else STRANGER

    def news(
        self,
        number: int,
        update: wire.Update | None,
        received: mapping.Received,
        *,
        of_stranger: bool = False,
    ) -> News:
        """Read an update."""
        if update is None:
            return News(number, None)
        if (move := mapping.moved(update)) is not None:
            self._chats.moved(*move)
        passing = mapping.passing(update, hears_groups=self.hears_groups)
        if passing is not None:
            self.passes(passing)
        if (reaction := mapping.reaction(update)) is not None:
            self._follow(self.reacted, reaction)
        inbound = mapping.read(update, self.own_name, received, may_stop=not of_stranger)
        if inbound is None:
            return News(number, None)
        if self.one_of_several and (message := wire.written(update)) is not None:
            text = message.text or message.caption or ""
            inbound = self._alike.named(inbound, message.date, text)
        self._chats.back(inbound.chat.id)
        self._check_clock(inbound, update)
        # Whom nobody knows stops nothing, whatever they say.
        return News(number, inbound, not of_stranger and self._is_stop(inbound))

    def _moved(self, old: str, new: str) -> None:
        """A group has moved: seen, or found by speaking, before it could be seen."""
        group = Chat(mapping.PLATFORM, old, ChatKind.GROUP)
        self.passes(Passing(chat=group, what=Passage.MOVED, new_id=new))

    def passes(self, passing: Passing) -> None:
        """Take in what happened to a chat, and pass it on; nothing that comes of it stops us."""
        if passing.what is Passage.REMOVED:
            self._chats.left(passing.chat.id)
        elif passing.what is Passage.ADDED:
            self._chats.back(passing.chat.id)
        self._follow(self.passed, passing)

    def _follow(self, watcher: Callable[[T], None], what: T) -> None:
        try:
            watcher(what)
        except Exception:
            log.exception("%s: what happened in a chat was not followed", self._name)

    def _is_stop(self, inbound: Inbound) -> bool:
        said = inbound.text if inbound.nonce is None else inbound.nonce
        return is_urgent(said) or self._chats.stops(said)

    def _check_clock(self, inbound: Inbound, update: wire.Update) -> None:
        """Say so when a message comes from the future: then lateness cannot be told either."""
        date = update.message.date if update.message is not None else 0
        ahead_ns = date * SECOND_NS - inbound.received_ns
        if ahead_ns > AHEAD_NS:
            self._counts["clock-behind"] += 1
            if self._counts["clock-behind"] % 100 != 1:
                return
            log.warning(
                "%s: this machine's clock is at least %.0f s behind Telegram's. Late messages"
                " cannot be recognised; set the clock.",
                self._name,
                ahead_ns / SECOND_NS,
            )


def _anybody(_address: Address) -> bool:
    """Nobody has said who is known: everything is read in the order in which it was sent."""
    return True


def _nobody_watches(_what: object) -> None:
    """Nobody wants to know what happens in chats."""
