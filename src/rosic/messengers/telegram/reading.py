"""What one answer to a poll holds: stops first, then people known here, strangers last of all.

What strangers sent is read when nothing more is to be fetched. Where it fills Telegram's answers it
is confirmed before: nobody known here wrote it, and a stop of theirs may be behind it.
"""

from __future__ import annotations

import asyncio
import logging
from bisect import insort
from operator import itemgetter
from typing import TYPE_CHECKING, Final, NamedTuple, TypeVar

import msgspec

from rosic.core.language import is_urgent
from rosic.core.message import Chat, ChatEvent, ChatEventKind, ChatKind
from rosic.core.time_units import SECOND_NS
from rosic.messengers.telegram import incoming, updates
from rosic.messengers.telegram.update_window import AdmittedUpdate, AlikeLines

if TYPE_CHECKING:
    from asyncio import Task, TaskGroup
    from collections import Counter
    from collections.abc import Callable, Sequence

    from rosic.contracts.messenger import Knows, Passed, Reacted, Serves, Settle
    from rosic.core.message import Inbound
    from rosic.messengers.telegram.chats import Chats
    from rosic.messengers.telegram.update_window import UpdateWindow


# ---- batch ----

# What one answer to a poll gives to do, and how it is cut into steps of the event loop.
#
# A step is not interrupted: whatever arrives waits for its end, a stop among it.

BATCH: Final = 100
"""The most that Telegram gives at once (https://core.telegram.org/bots/api#getupdates)."""
FEWEST: Final = 10
ANSWER_BYTES: Final = 1_000_000
"""After a longer answer fewer updates are asked for at once."""
STEP_BYTES: Final = 4_096
"""So much of what came is read in one step."""
LEAST_BYTES: Final = 256
"""No update counts as less."""


class BatchPause:
    """Lets others have the loop while much is read: a stop that was found is obeyed meanwhile."""

    def __init__(self) -> None:
        self._since = 0

    async def after(self, what: object) -> bool:
        """Count what was just done, by its size; pause when it was enough for a step.

        Returns:
            Whether it was.
        """
        self._since += len(what) if isinstance(what, msgspec.Raw) else _weight(what)
        if self._since < STEP_BYTES:
            return False
        self._since = 0
        await asyncio.sleep(0)
        return True


async def turns(number: int) -> None:
    """Let others have the event loop so many times."""
    for _ in range(number):
        await asyncio.sleep(0)


def limit_after(raws: Sequence[object], limit: int) -> int:
    """Return how many updates to ask for next.

    To find where each of them begins and ends is one step, so after an answer that was long there
    are fewer.
    """
    size = sum(len(raw) for raw in raws if isinstance(raw, msgspec.Raw))
    return max(FEWEST, limit // 2) if size > ANSWER_BYTES else min(BATCH, 2 * limit)


def _weight(update: object) -> int:
    """Return how much an update gives to do, about as its length in bytes."""
    message = updates.written(update) if isinstance(update, updates.Update) else None
    text = (message.text or message.caption or "") if message is not None else ""
    return LEAST_BYTES + 4 * len(text)


# ---- reading ----

T = TypeVar("T")

AHEAD_NS = 2 * SECOND_NS
TURNS = 4
"""Of the event loop, for each step of reading on: whatever is to be done has several."""
KNOWN, UNNAMED, UNMET_STOP, STRANGER, UNMET = range(5)
"""In this order updates are read. Of somebody unnamed only a stop counts (I17), of a stranger
nothing; anybody may send any number of either. Last is what is unnamed where nobody known here was
met: to look for a stop takes longest of all, and hardly ever one counts there. Where it is short,
that is found out at once, and what is a stop is neither put off nor left unread."""
SHORT: Final = 16
"""No stop word is longer; a hundred such texts are searched within a step."""
UNNAMED_SIGNS: Final = 256
"""A longer text without a name is read last where somebody was met, too: anybody who may post there
could send any number, and to look for a stop in 4,096 signs takes 7 ms."""
UNREAD_AT_MOST: Final = 1_000
"""Of what strangers sent. Of more, the newest of the last rank is not read at all."""

log = logging.getLogger("rosic.messengers.telegram")


class UnreadUpdate(NamedTuple):
    """An update that waits for those that are read before it.

    Attributes:
        since: The lowest number that came with it.
    """

    rank: int
    number: int
    since: int
    update: updates.Update
    received: incoming.ReceivedAt


class UpdateHooks(NamedTuple):
    """What is asked and told while updates are received. It stays for as long as a run lasts.

    Attributes:
        settle: Asked before anything is confirmed.
        known: Whether somebody at an address may be known here: what they sent is read first.
        serves: Whether somebody known here was met in a chat.
        passed: Told what happens to chats.
        reacted: Told what people put beside messages.
        account_since_ns: What was sent earlier, by Telegram's clock, goes without the bot's id.
        one_of_several: This gateway has other bots: what both hear in a small group is one message.
    """

    settle: Settle
    known: Knows
    serves: Serves
    passed: Passed
    reacted: Reacted
    account_since_ns: int
    one_of_several: bool


class UpdateReader:
    """Reads updates for one bot, once it was told by `begin` for whom.

    Args:
        name: Of the messenger, for the log.

    Attributes:
        own_name: The bot's, without the @; empty until it is known.
        hurried: More is to be fetched before anything of strangers is read.
    """

    _hooks: UpdateHooks  # by `begin`: until then there is nothing that could be asked instead
    _hears_groups: bool

    def __init__(self, name: str, chats: Chats, counts: Counter[str]) -> None:
        self.own_name = ""
        self._name = name
        self._chats = chats
        self._counts = counts
        self._alike = AlikeLines()
        self._unread: list[UnreadUpdate] = []
        self._taking = False
        self._later: Task[None] | None = None
        self.hurried = False
        self._wake = asyncio.Event()

    def begin(self, hooks: UpdateHooks, *, own_name: str, hears_groups: bool) -> None:
        """Begin a run: forget what an earlier one did not come to, and say what is heard.

        Args:
            hooks: Asked and told until the next run begins.
            own_name: The bot's, without the @.
            hears_groups: The bot hears everything in groups.
        """
        self._hooks, self.own_name, self._hears_groups = hooks, own_name, hears_groups
        self._unread, self._later, self.hurried = [], None, False
        what = ChatEventKind.HEARING if hears_groups else ChatEventKind.DEAF
        self._passes(ChatEvent(chat=Chat(incoming.PLATFORM, ""), what=what))

    @property
    def behind(self) -> bool:
        """Whether something that came is not read yet: of the unnamed or of strangers."""
        return bool(self._unread)

    def hurry(self, *, on: bool) -> None:
        """Read nothing of strangers while more is to be fetched."""
        self.hurried = on
        self.go_on()

    def go_on(self) -> None:
        """Look whether more may be read now."""
        self._wake.set()

    async def take_in(
        self,
        group: TaskGroup,
        window: UpdateWindow,
        raws: Sequence[object],
        received: incoming.ReceivedAt,
    ) -> int:
        """Look for stops in everything that people known here sent; read the rest beside polling.

        A hundred updates are many steps of the loop, so that a stop among them is obeyed while the
        rest is still read, and one behind them is fetched. Nothing is followed before all has been
        read that may hold a stop. What was given out before is not read again.

        Returns:
            How many had not been given out before.
        """
        self._taking = True
        pause = BatchPause()
        parsed: dict[int, updates.Update | None] = {}
        for raw in raws:
            number = updates.update_id(raw)
            if number is not None and number not in parsed and not window.knows(number):
                parsed[number] = self.parsed(raw)
                await pause.after(raw)
        since = min(parsed, default=0)
        for number, update in sorted(parsed.items(), key=itemgetter(0)):
            if update is not None and (rank := self._rank(update)) != KNOWN:
                window.expect(number, light=rank != UNNAMED)
                insort(self._unread, UnreadUpdate(rank, number, since, update, received))
            else:
                window.admit(self.news(number, update, received))
                await pause.after(update)
        self._taking = False
        self._release(window)
        self._pass_over(window)
        if self._unread and self._later is None:
            self._later = group.create_task(self._read_on(window))
        self.go_on()
        return len(parsed)

    async def _read_on(self, window: UpdateWindow) -> None:
        pause = BatchPause()
        while self._unread:
            if self._unread[0].rank > UNMET_STOP and (self.hurried or not window.has_room):
                self._wake.clear()
                await self._wake.wait()
                continue
            rank, number, _, update, received = self._unread.pop(0)
            window.admit(self.news(number, update, received, of_stranger=rank == STRANGER))
            self._release(window)
            if await pause.after(update):
                await turns(TURNS)
        self._later = None

    def _release(self, window: UpdateWindow) -> None:
        """Have followed what was read, unless what may hold a stop and came with it is not yet.

        Nor does it wait for what came after it: somebody may go on sending that for ever.
        """
        if not self._taking:
            waited_for = self._unread and self._unread[0].rank == UNNAMED
            window.release(self._unread[0].since if waited_for else None)

    def _pass_over(self, window: UpdateWindow) -> None:
        """Do not read at all what is too much of strangers."""
        while len(self._unread) > UNREAD_AT_MOST and self._unread[-1].rank > UNMET_STOP:
            window.admit(AdmittedUpdate(self._unread.pop().number, None))
            self._counts["unread"] += 1
            if self._counts["unread"] % UNREAD_AT_MOST == 1:
                log.warning("%s: strangers send more than can be read", self._name)

    def parsed(self, raw: object) -> updates.Update | None:
        """Return an update as Telegram documents it; None for one that is malformed."""
        try:
            return updates.parse(raw)
        except msgspec.ValidationError as error:
            self._counts["malformed"] += 1
            log.warning("%s: a malformed update was passed over: %s", self._name, error)
            return None

    def _rank(self, update: updates.Update) -> int:
        who = incoming.author(update)
        if who is None:
            message = updates.written(update)
            if message is None:
                return KNOWN
            text = message.text or message.caption or ""
            if self._hooks.serves(Chat(incoming.PLATFORM, str(message.chat.id))):
                return UNNAMED if len(text) <= UNNAMED_SIGNS else UNMET
            return UNMET_STOP if len(text) <= SHORT and self._says_stop(text) else UNMET
        return KNOWN if self._hooks.known(who) else STRANGER

    def news(
        self,
        number: int,
        update: updates.Update | None,
        received: incoming.ReceivedAt,
        *,
        of_stranger: bool = False,
    ) -> AdmittedUpdate:
        """Read an update."""
        if update is None:
            return AdmittedUpdate(number, None)
        if (move := incoming.moved(update)) is not None:
            self._chats.moved(*move)
        passing = incoming.passing(update, hears_groups=self._hears_groups)
        if passing is not None:
            self._passes(passing)
        if (reaction := incoming.reaction(update)) is not None:
            follow(self._name, self._hooks.reacted, reaction)
        inbound = incoming.read(update, self.own_name, received, may_stop=not of_stranger)
        if inbound is None:
            return AdmittedUpdate(number, None)
        if self._hooks.one_of_several and (message := updates.written(update)) is not None:
            text = message.text or message.caption or ""
            inbound = self._alike.named(inbound, message.date, text)
        self._chats.back(inbound.chat.id)
        self._check_clock(inbound, update)
        # Whom nobody knows stops nothing, whatever they say.
        return AdmittedUpdate(number, inbound, not of_stranger and self._is_stop(inbound))

    def _passes(self, passing: ChatEvent) -> None:
        """Take in what happened to a chat, and pass it on; nothing that comes of it stops us."""
        if passing.what is ChatEventKind.REMOVED:
            self._chats.left(passing.chat.id)
        elif passing.what is ChatEventKind.ADDED:
            self._chats.back(passing.chat.id)
        follow(self._name, self._hooks.passed, passing)

    def _is_stop(self, inbound: Inbound) -> bool:
        return self._says_stop(inbound.text if inbound.nonce is None else inbound.nonce)

    def _says_stop(self, said: str) -> bool:
        return is_urgent(said) or self._chats.stops(said)

    def _check_clock(self, inbound: Inbound, update: updates.Update) -> None:
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


def moved(old: str, new: str) -> ChatEvent:
    """Return that a group has moved: seen, or found by speaking, before it could be seen."""
    group = Chat(incoming.PLATFORM, old, ChatKind.GROUP)
    return ChatEvent(chat=group, what=ChatEventKind.MOVED, new_id=new)


def follow(name: str, watcher: Callable[[T], None], what: T) -> None:
    """Tell a watcher what happened in a chat; what goes wrong there holds up nothing here.

    Args:
        name: Of the messenger, for the log.
        watcher: Who is told.
        what: What happened.
    """
    try:
        watcher(what)
    except Exception:
        log.exception("%s: what happened in a chat was not followed", name)
