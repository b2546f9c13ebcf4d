"""The loop that receives: asks, stamps, hands over, confirms; and freezes motion when in doubt."""

from __future__ import annotations

import logging
from asyncio import TaskGroup
from collections import Counter
from typing import TYPE_CHECKING, Final, NamedTuple

from rosic.core.i18n import said
from rosic.core.time_units import SECOND_NS
from rosic.errors import ConfigurationError, MessengerFault
from rosic.messengers.telegram import incoming, updates
from rosic.messengers.telegram.bot_client import CALL_S, polled_within_s
from rosic.messengers.telegram.errors import ErrorKind, TelegramError
from rosic.messengers.telegram.polling_gap import Outage, PollingGap, PollMoment
from rosic.messengers.telegram.reading import BATCH, UpdateReader, limit_after
from rosic.messengers.telegram.update_window import UpdateWindow

if TYPE_CHECKING:
    from collections.abc import Callable

    from rosic.contracts.clock import Clock
    from rosic.contracts.messenger import Receive
    from rosic.messengers.telegram.bot_client import BotClient
    from rosic.messengers.telegram.chats import Chats
    from rosic.messengers.telegram.reading import UpdateHooks

PEEK_S = 0.1
"""While something is being received, we look for stops behind it this often."""
AT_ONCE_S = 0.01
"""And so often while not everything that came is read."""
FULL_S = 0.25
"""So long what fills an answer may take to be on disk before it is confirmed all the same: a stop
may stand behind it, and whoever is killed meanwhile has lost what was confirmed."""
CONFIRMED_EARLY: Final = "messages confirmed before they are on disk, for a stop may be behind them"
WAITS_S = (0.5, 1.0, 2.0, 4.0)
CONTESTED_WAIT_S = 2.0
DENIED_WAITS_S = (2.0, 5.0)
"""A token counts as denied when it is denied again after each of these."""
LONGEST_WAIT_S = 60.0
AWAKE_S = 5.0
OF_BOTFATHER = "BotFather shows it again with /mybots, or gives a new one."
OF_ANOTHER = "Its api_base leads to another server than Telegram's own: take the token of that one."
"""A call that took so much longer than it may was held up here, and not by the network."""

log = logging.getLogger("rosic.messengers.telegram")


class BotAccount(NamedTuple):
    """The bot, as Telegram knows it."""

    user_name: str
    reads_groups: bool


class Poller:
    """Receives for one bot.

    Args:
        name: Of the messenger, for the log.
        poll_timeout_s: How long an empty poll stays open.
        alarm: Told when motion is frozen because somebody else receives, and when that has ended;
            and that the token is denied, before it ends.

    Attributes:
        reading: Reads what is received, from when Telegram has said who we are.
        counts: ``received``, ``passed-over``, ``given-up`` and ``malformed`` updates;
            ``confirmed-early``: before they were on disk, or received to the end;
            ``clock-behind``: messages that came from the future.
    """

    def __init__(
        self,
        name: str,
        line: BotClient,
        chats: Chats,
        clock: Clock,
        poll_timeout_s: int,
        alarm: Callable[[MessengerFault], None],
    ) -> None:
        self.counts: Counter[str] = Counter()
        self.reading = UpdateReader(name, chats, self.counts)
        self._name = name
        self._line = line
        self._clock = clock
        self._poll_timeout_s = poll_timeout_s
        self._alarm = alarm
        self._listening = PollingGap()
        self._outage = Outage()
        self._limit = BATCH
        self._full_ns: int | None = None
        self._failures = 0
        self._answered = self._contested = False

    @property
    def catching_up(self) -> bool:
        """Whether what was sent while nobody listened may still come."""
        return self._listening.frozen

    @property
    def is_connected(self) -> bool:
        """Whether the last poll was answered, and nobody else receives."""
        return self._answered and not (self._failures or self._contested)

    async def run(self, receive: Receive, hooks: UpdateHooks) -> None:
        """Listen until cancelled.

        Args:
            receive: Takes each message.
            hooks: What else is asked and told meanwhile.

        Raises:
            ConfigurationError: Telegram does not accept the token. Nothing was received.
            MessengerFault: It no longer accepts the token. What was not received to the end is
                given out again once it does.
        """
        self._listening, self._outage, self._full_ns = PollingGap(), Outage(), None
        self._answered = False
        async with self._line.held():
            account = await self._meet()
            self.reading.begin(hooks, own_name=account.user_name, hears_groups=account.reads_groups)
            try:
                async with TaskGroup() as group:
                    window = UpdateWindow(
                        group, receive, self._clock, self.counts, self.reading.go_on
                    )
                    while True:
                        await self._poll(group, window, hooks)
            except ExceptionGroup as several:
                raise several.exceptions[0] from None

    # ---- the beginning ----

    async def ask_account(self, *, within_s: float = CALL_S) -> BotAccount:
        """Ask once who we are.

        Raises:
            ConfigurationError: Telegram does not accept the token.
            TelegramError: Telegram did not say.
        """
        try:
            me = await self._line.ask(lambda bot: bot.get_me(), within_s=within_s)
        except TelegramError as trouble:
            if trouble.kind is ErrorKind.UNUSABLE:
                raise ConfigurationError(
                    f"Telegram does not accept the token of the messenger {self._name}.",
                    hint=OF_BOTFATHER if self._line.to_telegram else OF_ANOTHER,
                ) from trouble
            raise
        return BotAccount(me.username or "", bool(me.can_read_all_group_messages))

    async def _meet(self) -> BotAccount:
        """Ask who we are, for as long as it takes.

        Raises:
            ConfigurationError: Telegram does not accept the token, however often it is asked.
        """
        account: BotAccount | None = None
        denied = 0
        while account is None:
            asked = self._now()
            try:
                account = await self.ask_account()
            except ConfigurationError as refusal:
                await self._doubt(refusal, denied)
                denied += 1
            except TelegramError as trouble:
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

    async def _poll(self, group: TaskGroup, window: UpdateWindow, hooks: UpdateHooks) -> None:
        listening = self._listening
        offset, settled = await self._confirmable(window, hooks)
        asked = self._now()
        more = window.busy or self.reading.hurried
        at_once = more or not settled or (listening.frozen and listening.calm(asked))
        timeout_s = 0 if at_once else self._poll_timeout_s
        try:
            raws = await self._line.updates(offset, timeout_s, updates.KINDS, self._limit)
        except TelegramError as trouble:
            self._outage.failed(
                asked, self._now(), trouble.network, polled_within_s(timeout_s) + AWAKE_S
            )
            await self._cope(trouble)
            return
        now = self._now()
        listening.answered(now)
        self._answered = True
        self._outage.answered(asked)
        self._recovered()
        window.confirmed(offset)
        full = len(raws) >= self._limit
        self._limit = limit_after(raws, self._limit)
        received = self._received(now, hooks.account_since_ns)
        fresh = await self.reading.take_in(group, window, raws, received)
        self._full_ns = self._clock.monotonic_ns() if full else None
        self.reading.hurry(on=full and fresh > 0)
        if raws and not fresh and not window.busy and window.offset is None:
            await self._clock.sleep(WAITS_S[0])  # nothing but updates without a number
        await self._make_way(window, fresh=fresh > 0)
        if listening.drained(asked, empty=not fresh, full=full):
            self._thawed()

    async def _confirmable(
        self, window: UpdateWindow, hooks: UpdateHooks
    ) -> tuple[int | None, bool]:
        """Return what the next poll confirms, and whether all of that is on disk."""
        offset = window.offset
        settled = offset is None or await hooks.settle(self._settles_within_s())
        if not settled and self._full_ns is None:
            return None, False  # it is given out again; a stop among the same hundred is still seen
        if early := window.confirmed_early(offset, settled=settled):
            self.counts["confirmed-early"] += early
            log.warning("%s: %s: %d", self._name, CONFIRMED_EARLY, early)
        return offset, settled

    async def _make_way(self, window: UpdateWindow, *, fresh: bool) -> None:
        """Wait for what is received, but not for long; have a poll bring what is behind it.

        Behind an answer that is full may be a stop, which waits for nobody's record.
        """
        if self._full_ns is None:
            await window.idle(AT_ONCE_S if self.reading.behind else PEEK_S)
            return
        window.clear_the_way()
        await window.idle(AT_ONCE_S if self.reading.behind else FULL_S if fresh else PEEK_S)
        window.relieve()

    def _settles_within_s(self) -> float:
        """Return how long to wait for the disk before something is confirmed."""
        if self._full_ns is None:
            return PEEK_S
        return max(0.0, FULL_S - (self._clock.monotonic_ns() - self._full_ns) / SECOND_NS)

    def _thawed(self) -> None:
        self._outage.over()
        log.info("%s: listening", self._name)
        if self._contested:
            self._contested = False
            self._alarm(MessengerFault(_acquittal(self._name)))

    def _received(self, now: PollMoment, account_since_ns: int) -> incoming.ReceivedAt:
        since_ns, account = self._listening.stamp(now.wall_ns), self._line.account
        return incoming.ReceivedAt(
            now.wall_ns, since_ns, account, account_since_ns, self._outage.covers
        )

    # ---- trouble ----

    async def _cope(self, trouble: TelegramError) -> None:
        """Wait and let the loop go on.

        Raises:
            MessengerFault: The account cannot be used any more.
        """
        if trouble.kind is ErrorKind.UNUSABLE:
            await self._denied(trouble)
        elif trouble.kind is ErrorKind.CONFLICT:
            await self._contest(trouble)
        else:
            await self._wait_out(trouble)

    async def _denied(self, trouble: TelegramError) -> None:
        """Ask who we are before one answer is believed: the gateway ends with it.

        Raises:
            MessengerFault: It is denied again and again.
        """
        fault = MessengerFault(
            f"Telegram no longer accepts the token of the messenger {self._name}."
        )
        for times in range(len(DENIED_WAITS_S)):
            await self._doubt(fault, times)
            try:
                await self.ask_account()
            except ConfigurationError:
                continue
            except TelegramError as other:
                await self._wait_out(other)
            return
        self._alarm(fault)
        raise fault from trouble

    async def _doubt(self, refusal: MessengerFault | ConfigurationError, times: int) -> None:
        """Wait before the token is tried once more.

        Raises:
            ConfigurationError: It was tried often enough.
        """
        if times == len(DENIED_WAITS_S):
            self._alarm(MessengerFault(str(refusal)))
            raise refusal
        wait_s = DENIED_WAITS_S[times]
        log.error("%s: %s It is tried again in %g s.", self._name, refusal, wait_s)
        await self._clock.sleep(wait_s)

    async def _contest(self, trouble: TelegramError) -> None:
        self._listening.contested(self._now())
        if not self._contested:
            self._contested = True
            fault = MessengerFault(_accusation(self._name, trouble.reason))
            log.error("%s (%s)", fault, trouble.reason)
            self._alarm(fault)
        await self._clock.sleep(CONTESTED_WAIT_S)

    async def _wait_out(self, trouble: TelegramError) -> None:
        if not self._failures:
            log.warning("%s: %s (%s)", self._name, trouble, trouble.reason)
        wait_s = WAITS_S[min(self._failures, len(WAITS_S) - 1)]
        self._failures += 1
        await self._clock.sleep(min(max(wait_s, trouble.wait_s), LONGEST_WAIT_S))

    def _recovered(self) -> None:
        if self._failures:
            log.info("%s: Telegram answers again, after %d failures", self._name, self._failures)
            self._failures = 0

    def _now(self) -> PollMoment:
        return PollMoment(self._clock.wall_ns(), self._clock.monotonic_ns())


def _acquittal(name: str) -> str:
    return said(
        "Nobody else receives the messages of the bot of {name} any more."
        " Robots take motion from it again. What was sent meanwhile may never have arrived.",
        name=name,
    )


def _accusation(name: str, reason: str) -> str:
    if "webhook" in reason.casefold():
        return said(
            "The messages of the bot of {name} go to another address (a webhook is set)."
            " Robots take no motion from it until that ends, and a stop may not arrive:"
            " stop them another way. If nobody here set it, the token is known to somebody:"
            " have BotFather replace it.",
            name=name,
        )
    return said(
        "Another program receives the messages of the bot of {name}."
        " Robots take no motion from it until that ends, and a stop may not arrive:"
        " stop them another way. If it is none of yours, the token is known to somebody:"
        " have BotFather replace it.",
        name=name,
    )
