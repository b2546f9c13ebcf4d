"""The loop that receives: asks, stamps, hands over, confirms; and freezes motion when in doubt."""

from __future__ import annotations

import logging
from asyncio import TaskGroup
from collections import Counter
from operator import itemgetter
from typing import TYPE_CHECKING, NamedTuple, TypeVar

import msgspec

from rosic.core.language import is_urgent
from rosic.core.message import Chat, ChatKind, Passage, Passing
from rosic.core.saying import said
from rosic.errors import ConfigurationError, MessengerFault
from rosic.messengers.telegram import mapping, wire
from rosic.messengers.telegram.batch import BATCH, Pause, limit_after
from rosic.messengers.telegram.line import CALL_S, polled_within_s
from rosic.messengers.telegram.listening import SECOND_NS, Listening, Moment, Outage
from rosic.messengers.telegram.trouble import Kind, Trouble
from rosic.messengers.telegram.window import AlikeLines, News, Window

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from rosic.contracts.clock import Clock
    from rosic.contracts.messenger import Receive, Settle
    from rosic.core.identity import Address
    from rosic.core.message import Inbound, Reaction
    from rosic.messengers.telegram.chats import Chats
    from rosic.messengers.telegram.line import Line

T = TypeVar("T")

PEEK_S = 0.1
"""While something is being received, we look for stops behind it this often."""
WAITS_S = (0.5, 1.0, 2.0, 4.0)
CONTESTED_WAIT_S = 2.0
LONGEST_WAIT_S = 60.0
AHEAD_NS = 2 * SECOND_NS
AWAKE_S = 5.0
"""A call that took so much longer than it may was held up here, and not by the network."""

log = logging.getLogger("rosic.messengers.telegram")


class Account(NamedTuple):
    """The bot, as Telegram knows it."""

    user_name: str
    reads_groups: bool


class Listener:
    """Receives for one bot.

    Args:
        name: Of the messenger, for the log.
        poll_timeout_s: How long an empty poll stays open.
        alarm: Told when motion is frozen because somebody else receives.

    Attributes:
        passed: Told, while it listens, what happens to chats; once at its beginning, of the
            account: whether it hears everything in groups.
        reacted: Told, while it listens, what people put beside messages.
        settle: Asked before anything is confirmed.
        account_since_ns: What was sent earlier, by Telegram's clock, goes without the bot's id.
        one_of_several: This gateway has other bots: what both hear in a small group is one message.
        known: Whether somebody at an address may be known here: what they sent is read first.
        counts: ``received``, ``passed-over``, ``given-up`` and ``malformed`` updates;
            ``clock-behind``: messages that came from the future.
    """

    def __init__(
        self,
        name: str,
        line: Line,
        chats: Chats,
        clock: Clock,
        poll_timeout_s: int,
        alarm: Callable[[MessengerFault], None],
    ) -> None:
        self.passed: Callable[[Passing], None] = _nobody_watches
        self.reacted: Callable[[Reaction], None] = _nobody_watches
        self.settle: Settle = _settled
        self.known: Callable[[Address], bool] = _anybody
        self.account_since_ns = 0
        self.one_of_several = False
        self._alike = AlikeLines()
        self._name = name
        self._line = line
        self._chats = chats
        chats.on_moved = self._moved
        self._clock = clock
        self._poll_timeout_s = poll_timeout_s
        self._alarm = alarm
        self._listening = Listening()
        self._outage = Outage()
        self.own_name = ""
        self._hears_groups = False
        self._limit = BATCH
        self._failures = 0
        self._contested = False
        self.counts: Counter[str] = Counter()

    @property
    def catching_up(self) -> bool:
        """Whether what was sent while nobody listened may still come."""
        return self._listening.frozen

    async def run(self, receive: Receive) -> None:
        """Listen until cancelled.

        Raises:
            ConfigurationError: Telegram does not accept the token. Nothing was received.
            MessengerFault: It no longer accepts the token. What was not received to the end is
                given out again once it does.
        """
        self._listening, self._outage = Listening(), Outage()
        async with self._line.held():
            account = await self._meet()
            self.own_name = account.user_name
            self._hears_groups = account.reads_groups
            what = Passage.HEARING if account.reads_groups else Passage.DEAF
            self._pass(Passing(chat=Chat(mapping.PLATFORM, ""), what=what))
            try:
                async with TaskGroup() as group:
                    window = Window(group, receive, self._clock, self.counts)
                    while True:
                        await self._poll(window)
            except ExceptionGroup as several:
                raise several.exceptions[0] from None

    # ---- the beginning ----

    async def ask_account(self, *, within_s: float = CALL_S) -> Account:
        """Ask once who we are.

        Raises:
            ConfigurationError: Telegram does not accept the token.
            Trouble: Telegram did not say.
        """
        try:
            me = await self._line.ask(lambda bot: bot.get_me(), within_s=within_s)
        except Trouble as trouble:
            if trouble.kind is Kind.UNUSABLE:
                raise ConfigurationError(
                    f"Telegram does not accept the token of the messenger {self._name}.",
                    hint="BotFather shows it again with /mybots, or gives a new one.",
                ) from trouble
            raise
        return Account(me.username or "", bool(me.can_read_all_group_messages))

    async def _meet(self) -> Account:
        """Ask who we are, for as long as it takes.

        Raises:
            ConfigurationError: Telegram does not accept the token.
        """
        account: Account | None = None
        while account is None:
            asked = self._now()
            try:
                account = await self.ask_account()
            except Trouble as trouble:
                self._outage.failed(asked, self._now(), trouble.network, CALL_S + AWAKE_S)
                await self._wait_out(trouble)
        log.info("%s: this is @%s", self._name, account.user_name)
        if not account.reads_groups:
            log.warning(
                "%s: in groups Telegram gives this bot only commands, replies to it and mentions:"
                " a plain stop does not arrive there. Switch the privacy mode off with BotFather"
                " (/setprivacy), or make the bot an admin of the group.",
                self._name,
            )
        return account

    # ---- the loop ----

    async def _poll(self, window: Window) -> None:
        listening, offset = self._listening, window.offset
        settled = offset is None or await self.settle(PEEK_S)
        if not settled:  # it is given out once more; a stop among the same hundred is still seen
            offset = None
        asked = self._now()
        at_once = window.busy or not settled or (listening.frozen and listening.calm(asked))
        timeout_s = 0 if at_once else self._poll_timeout_s
        try:
            raws = await self._line.updates(offset, timeout_s, wire.KINDS, self._limit)
        except Trouble as trouble:
            self._outage.failed(
                asked, self._now(), trouble.network, polled_within_s(timeout_s) + AWAKE_S
            )
            await self._cope(trouble)
            return
        now = self._now()
        listening.answered(now)
        self._outage.answered(asked)
        self._recovered()
        window.confirmed(offset)
        full = len(raws) >= self._limit
        self._limit = limit_after(raws, self._limit)
        fresh = await self._take_in(window, raws, now)
        if raws and not fresh and not window.busy and window.offset is None:
            await self._clock.sleep(WAITS_S[0])  # nothing but updates without a number
        await window.idle(PEEK_S)
        if listening.drained(asked, empty=not fresh, full=full):
            self._outage.over()
            self._contested = False
            log.info("%s: listening", self._name)

    async def _take_in(self, window: Window, raws: Sequence[object], now: Moment) -> int:
        """Look for stops in everything that came, those of people known here first; then begin.

        A hundred updates are many steps of the loop, so that a stop among them is obeyed while the
        rest is still read. What was given out before is not read again.

        Returns:
            How many had not been given out before.
        """
        since_ns, account = self._listening.stamp(now.wall_ns), self._line.account
        received = mapping.Received(
            now.wall_ns, since_ns, account, self.account_since_ns, self._outage.covers
        )
        pause = Pause()
        parsed: dict[int, wire.Update | None] = {}
        for raw in raws:
            number = wire.update_id(raw)
            if number is not None and number not in parsed and not window.knows(number):
                parsed[number] = self._parsed(raw)
                await pause.after(raw)
        ranked = ((self._is_strangers(u), number, u) for number, u in parsed.items())
        by_rank = sorted(ranked, key=itemgetter(0, 1))
        for of_stranger, number, update in by_rank:
            window.admit(self._news(number, update, received, of_stranger=of_stranger))
            await pause.after(update)
        window.release()
        return len(parsed)

    def _parsed(self, raw: object) -> wire.Update | None:
        """Return an update as Telegram documents it; None for one that is malformed."""
        try:
            return wire.parse(raw)
        except msgspec.ValidationError as error:
            self.counts["malformed"] += 1
            log.warning("%s: a malformed update was passed over: %s", self._name, error)
            return None

    def _is_strangers(self, update: wire.Update | None) -> bool:
        """Whether it is known who sent an update, and that nobody here knows them."""
        who = None if update is None else mapping.author(update)
        return who is not None and not self.known(who)

    def _news(
        self,
        number: int,
        update: wire.Update | None,
        received: mapping.Received,
        *,
        of_stranger: bool,
    ) -> News:
        if update is None:
            return News(number, None)
        if (move := mapping.moved(update)) is not None:
            self._chats.moved(*move)
        passing = mapping.passing(update, hears_groups=self._hears_groups)
        if passing is not None:
            self._pass(passing)
        if (reaction := mapping.reaction(update)) is not None:
            self._follow(self.reacted, reaction)
        inbound = mapping.read(update, self.own_name, received)
        if inbound is None:
            return News(number, None)
        if self.one_of_several:
            inbound = self._alike.named(inbound)
        self._chats.back(inbound.chat.id)
        self._check_clock(inbound, update)
        # Whom nobody knows stops nothing, whatever they say.
        return News(number, inbound, not of_stranger and self._is_stop(inbound))

    def _moved(self, old: str, new: str) -> None:
        """A group has moved: seen, or found by speaking, before it could be seen."""
        group = Chat(mapping.PLATFORM, old, ChatKind.GROUP)
        self._pass(Passing(chat=group, what=Passage.MOVED, new_id=new))

    def _pass(self, passing: Passing) -> None:
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
            self.counts["clock-behind"] += 1
            if self.counts["clock-behind"] % 100 != 1:
                return
            log.warning(
                "%s: this machine's clock is at least %.0f s behind Telegram's. Late messages"
                " cannot be recognised; set the clock.",
                self._name,
                ahead_ns / SECOND_NS,
            )

    # ---- trouble ----

    async def _cope(self, trouble: Trouble) -> None:
        """Wait and let the loop go on.

        Raises:
            MessengerFault: The account cannot be used any more.
        """
        if trouble.kind is Kind.UNUSABLE:
            raise MessengerFault(
                f"Telegram no longer accepts the token of the messenger {self._name}."
            ) from trouble
        if trouble.kind is Kind.CONFLICT:
            await self._contest(trouble)
        else:
            await self._wait_out(trouble)

    async def _contest(self, trouble: Trouble) -> None:
        self._listening.contested(self._now())
        if not self._contested:
            self._contested = True
            fault = MessengerFault(_accusation(self._name, trouble.reason))
            log.error("%s (%s)", fault, trouble.reason)
            self._alarm(fault)
        await self._clock.sleep(CONTESTED_WAIT_S)

    async def _wait_out(self, trouble: Trouble) -> None:
        if not self._failures:
            log.warning("%s: %s (%s)", self._name, trouble, trouble.reason)
        wait_s = WAITS_S[min(self._failures, len(WAITS_S) - 1)]
        self._failures += 1
        await self._clock.sleep(min(max(wait_s, trouble.wait_s), LONGEST_WAIT_S))

    def _recovered(self) -> None:
        if self._failures:
            log.info("%s: Telegram answers again, after %d failures", self._name, self._failures)
            self._failures = 0

    def _now(self) -> Moment:
        return Moment(self._clock.wall_ns(), self._clock.monotonic_ns())


async def _settled(_within_s: float) -> bool:
    """Say that what was received is settled: nobody put anything off."""
    return True


def _anybody(_address: Address) -> bool:
    """Nobody has said who is known: everything is read in the order in which it was sent."""
    return True


def _nobody_watches(_what: object) -> None:
    """Nobody wants to know what happens in chats."""


def _accusation(name: str, reason: str) -> str:
    if "webhook" in reason.casefold():
        return said(
            "The messages of the bot of {name} go to another address (a webhook is set)."
            " Robots take no motion from it until that ends. If nobody here set it, the token is"
            " known to somebody: have BotFather replace it.",
            name=name,
        )
    return said(
        "Another program receives the messages of the bot of {name}."
        " Robots take no motion from it until that ends. If it is none of yours, the token is"
        " known to somebody: have BotFather replace it.",
        name=name,
    )
