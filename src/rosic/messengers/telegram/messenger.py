"""The Telegram messenger: one bot account, provider-readable."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from telegram import ReactionTypeEmoji

from rosic.core.i18n import said
from rosic.core.identity import Address
from rosic.errors import MessageGone, MessengerFault
from rosic.messengers.telegram.bot_client import BotClient
from rosic.messengers.telegram.chats import Chats
from rosic.messengers.telegram.command_menu import TelegramMenus
from rosic.messengers.telegram.errors import ErrorKind, TelegramError, hide
from rosic.messengers.telegram.files import FILE_BYTES, LOCAL_BYTES, FileFetcher
from rosic.messengers.telegram.incoming import PLATFORM
from rosic.messengers.telegram.outgoing import Outgoing
from rosic.messengers.telegram.polling import Poller
from rosic.messengers.telegram.rate_limiter import PUBLISHED, BotRates, RateLimiter
from rosic.messengers.telegram.reading import UpdateHooks, follow, moved
from rosic.messengers.telegram.settings import TelegramSettings, read_settings

if TYPE_CHECKING:
    from collections import Counter
    from collections.abc import AsyncIterator, Mapping, Sequence

    from rosic.contracts.clock import Clock
    from rosic.contracts.messenger import (
        Alarm,
        Keep,
        Knows,
        Passed,
        Reacted,
        Receive,
        Serves,
        Settle,
    )
    from rosic.core.message import Chat, Inbound, IncomingFile, Menu, Outbound, SendPriority
    from rosic.core.secret import Secret
    from rosic.core.traffic import TrafficCount


# ---- reactions and retracting ----

GESTURE_S = 5.0
GONE = ("message to delete not found", "message_id_invalid")
"""Telegram's words for a message that was deleted already."""


class Reactions:
    """Makes them for one bot, each with one call.

    Telegram's limits on messages are not asked; only where Telegram has asked to wait, they wait.
    """

    def __init__(self, line: BotClient, chats: Chats, limiter: RateLimiter) -> None:
        self._limiter = limiter
        self._line = line
        self._chats = chats

    async def react(self, chat: str, message: str, emoji: str) -> None:
        """Put an emoji beside a message.

        Raises:
            MessengerFault: It is not there, or it cannot be known.
        """
        where, number = self._numbers(chat, message)
        await self._limiter.obey(str(where))
        await self._line.ask(
            lambda bot: bot.set_message_reaction(where, number, [ReactionTypeEmoji(emoji)]),
            within_s=GESTURE_S,
        )

    async def retract(self, chat: str, message: str) -> None:
        """Take a message out of a chat. One that is not there any more is out of it.

        Raises:
            MessageGone: It can never be done: it is too old, or not ours to take away.
            MessengerFault: Not done, or it cannot be known; it may succeed later.
        """
        for part in self._chats.parts(chat, message):
            where, number = self._numbers(chat, part)
            await self._limiter.obey(str(where))
            try:
                await self._line.ask(
                    lambda bot, w=where, n=number: bot.delete_message(w, n),  # type: ignore[misc]
                    within_s=GESTURE_S,
                )
            except TelegramError as trouble:
                if any(words in trouble.reason.lower() for words in GONE):
                    continue
                if trouble.kind in {ErrorKind.REFUSED, ErrorKind.GONE}:
                    raise MessageGone(str(trouble)) from None
                raise

    async def admins(self, chat: str) -> tuple[Address, ...]:
        """Return the accounts of those who look after a chat of many, anonymous ones included.

        Raises:
            MessengerFault: Telegram does not say, or not now.
        """
        where = self._chats.where(chat)
        found = await self._line.ask(
            lambda bot: bot.get_chat_administrators(where), within_s=GESTURE_S
        )
        return tuple(Address(PLATFORM, str(one.user.id)) for one in found)

    def _numbers(self, chat: str, message: str) -> tuple[int, int]:
        if self._chats.lost(chat, message):
            raise MessageGone("That message stayed behind when the group moved.")
        where = self._chats.where(chat)
        try:
            return int(where), int(message)
        except ValueError:
            raise MessengerFault("Telegram has no such message. Nothing was done.") from None


# ---- the messenger ----

CHECK_S = 4.0


def deep_link(user_name: str, code: Secret) -> str:
    """Return what opens a private chat with a bot and sends it ``/start`` with a code."""
    return f"https://t.me/{user_name}?start={code.reveal()}"


class TelegramMessenger:
    """Implements `contracts.messenger.Messenger` over the Bot API.

    Sending works whether or not it runs; connections are open only while they are needed.

    Args:
        line: Another way to the Bot API, for measuring.
        rates: Other limits than Telegram's published ones.
        spoke_before: An earlier run may have spoken until just now.
    """

    platform = "telegram"
    assurance = "provider-readable"
    edits = True
    pins = True

    def __init__(
        self,
        name: str,
        settings: TelegramSettings,
        clock: Clock,
        *,
        line: BotClient | None = None,
        rates: BotRates = PUBLISHED,
        spoke_before: bool = False,
    ) -> None:
        hide(settings.token)
        if settings.proxy is not None:
            hide(settings.proxy)
        self.name = name
        self._alarm: Alarm = _nobody_is_told
        self._settle: Settle | None = None
        self._known: Knows = _anybody
        self._serves: Serves = _anywhere
        self._passed: Passed = _nobody_is_told
        self._reacted: Reacted = _nobody_is_told
        self._account_since_ns = 0
        self._one_of_several = False
        self._line, chats = line or BotClient(settings), Chats(self._group_moved)
        poll_timeout_s = settings.poll_timeout_s
        self._listener = Poller(name, self._line, chats, clock, poll_timeout_s, self._raise_alarm)
        self.file_bytes = LOCAL_BYTES if settings.local_mode else FILE_BYTES
        self._limiter = limiter = RateLimiter(clock, rates, spoke_before=spoke_before)
        self._speaker = Outgoing(self._line, limiter, chats, clock, self.file_bytes)
        self._gestures = Reactions(self._line, chats, limiter)
        self._menus = TelegramMenus(name, self._line, clock)
        self._fetcher = FileFetcher(self._line, settings)
        self.fetch_bytes = self._fetcher.most
        self._running = False
        self._checked_name = ""

    def __repr__(self) -> str:
        return f"TelegramMessenger({self.name!r})"

    @property
    def handle(self) -> str:
        """The bot's username, with its @; empty until Telegram has told."""
        return f"@{self._user_name}" if self._user_name else ""

    def invite_link(self, code: Secret) -> str:
        """Return the deep link that opens the bot's chat and hands a code in.

        Args:
            code: Within the alphabet of such links and their 64 characters.
        """
        return deep_link(self._user_name, code) if self._user_name else ""

    @property
    def _user_name(self) -> str:
        return self._listener.reading.own_name or self._checked_name

    def hearing(self, *, everywhere: bool) -> str:
        """Say what privacy mode keeps from the bot; see ``contracts.messenger.hearing_of``."""
        if everywhere:
            return said(
                "In groups the messenger {name} passes me only commands, replies to me and messages"
                " that name me. /stop and a reply with stop do arrive there; stop without a slash"
                " does not. To change that, make me an admin of the group, or say /setprivacy to"
                " BotFather.",
                name=self.name,
            )
        return said(
            "There I hear only commands, replies to me and messages that name me; stop without a"
            " slash does not arrive. To change that, make me an admin of the group; or say"
            " /setprivacy to BotFather, then take me out of the group and put me in again."
        )

    @property
    def account(self) -> str:
        """The bot's id; see ``contracts.messenger``."""
        return self._line.account

    def account_since(self, since_ns: int, *, several: bool) -> None:
        """Name the account in what was sent since; see ``contracts.messenger``."""
        self._account_since_ns, self._one_of_several = since_ns, several

    def keep_pace(self, kept: Mapping[str, bytes], keep: Keep) -> None:
        """Go on with what an earlier run said in groups; see ``contracts.messenger``."""
        self._limiter.keep_pace(kept, keep)

    async def admins(self, chat: Chat) -> tuple[Address, ...]:
        """Return who looks after a group or a channel; see ``contracts.messenger``.

        Raises:
            MessengerFault: Telegram does not say, or not now.
        """
        return await self._gestures.admins(chat.id)

    @property
    def counts(self) -> Counter[str]:
        """What became of updates; see `Poller`."""
        return self._listener.counts

    @property
    def traffic(self) -> TrafficCount:
        """Return how much has passed the Bot API: calls, updates and their bytes."""
        return self._line.traffic.count

    def alarm_with(self, alarm: Alarm) -> None:
        """Have somebody told when another receives for this bot; see ``contracts.messenger``.

        For telling the admins elsewhere; the log has it in any case.
        """
        self._alarm = alarm

    def _raise_alarm(self, fault: MessengerFault) -> None:
        self._alarm(fault)

    def _group_moved(self, old: str, new: str) -> None:
        """Tell whoever watches chats, also while nothing is received: speaking may find it."""
        follow(self.name, self._passed, moved(old, new))

    async def check(self, *, within_s: float = CHECK_S) -> str:
        """Ask Telegram once, without listening, and return whose account this is.

        Raises:
            ConfigurationError: Telegram does not accept the token, or the proxy cannot be used.
            MessengerFault: Telegram did not answer in time; it may work later.
        """
        async with self._line.held():
            account = await self._listener.ask_account(within_s=within_s)
        self._checked_name = account.user_name
        return f"@{account.user_name} answers"

    async def run(self, receive: Receive) -> None:
        """Listen until cancelled. Whom it asks and tells is who was named before it began.

        Raises:
            ConfigurationError: Telegram does not accept the token. Nothing was received.
            MessengerFault: It runs already, or Telegram no longer accepts the token; or nobody
                said what may be confirmed, and nothing was received.
        """
        if self._running:
            raise MessengerFault(f"The messenger {self.name} is listening already.")
        if self._settle is None:
            raise MessengerFault(
                f"The messenger {self.name} was not told what is on disk, so it receives nothing."
            )
        hooks = UpdateHooks(
            settle=self._settle,
            known=self._known,
            serves=self._serves,
            passed=self._passed,
            reacted=self._reacted,
            account_since_ns=self._account_since_ns,
            one_of_several=self._one_of_several,
        )
        self._running = True
        try:
            await self._listener.run(receive, hooks)
        finally:
            self._running = False

    async def turn(self, chat: Chat, weight: SendPriority) -> None:
        """Wait until something may be said in a chat; see ``contracts.messenger.turn_of``.

        Raises:
            MessengerFault: There was no room in time.
        """
        await self._speaker.turn(chat, weight)

    def settle_with(self, settle: Settle) -> None:
        """Ask before anything is confirmed; see ``contracts.messenger``."""
        self._settle = settle

    def know_with(self, known: Knows) -> None:
        """Read first what people known here sent; see ``contracts.messenger``."""
        self._known = known

    def serve_with(self, serves: Serves) -> None:
        """Wait for what carries nobody's name in chats of ours; see ``contracts.messenger``."""
        self._serves = serves

    def catching_up(self) -> bool:
        """Return whether backlog may still come; see ``contracts.messenger``."""
        return self._listener.catching_up

    def is_connected(self) -> bool:
        """Return whether Telegram answers us; see ``contracts.messenger``."""
        return self._running and self._listener.is_connected

    def watch_chats(self, passed: Passed) -> None:
        """Have somebody told what happens to chats; see ``contracts.messenger``."""
        self._passed = passed

    def watch_reactions(self, reacted: Reacted) -> None:
        """Have somebody told what people put beside messages; see ``contracts.messenger``."""
        self._reacted = reacted

    @staticmethod
    def is_account(account: str) -> bool:
        """Telegram's ids are numbers; anything else is a username, which passes to others."""
        return account.isascii() and account.isdecimal()

    async def react(self, chat: Chat, message: str, emoji: str) -> None:
        """Put one of Telegram's reactions beside a message, without waiting for the limits.

        Raises:
            MessengerFault: It is not there, or it cannot be known.
        """
        await self._gestures.react(chat.id, message, emoji)

    async def put_picture(self, message: str, outbound: Outbound) -> None:
        """Make a message of ours show a picture; see ``contracts.messenger``.

        Raises:
            MessageGone: There is no such message any more.
            MessengerFault: Not changed, or it cannot be known whether it was.
        """
        await self._speaker.put_picture(message, outbound)

    async def retract(self, chat: Chat, message: str) -> None:
        """Take a message of anybody out of a chat; see ``contracts.messenger``.

        Raises:
            MessageGone: It can never be done.
            MessengerFault: Not done, or it cannot be known.
        """
        await self._gestures.retract(chat.id, message)

    async def set_menus(self, menus: Sequence[Menu]) -> None:
        """Offer commands while people type. Never raises."""
        await self._menus.set(menus)

    async def send(self, outbound: Outbound) -> str:
        """Send, at the pace Telegram allows, and return the id of the (last) message.

        Raises:
            MessengerFault: Not sent; or, when the connection broke before the answer, perhaps sent:
                trying again may then show it twice.
        """
        return await self._speaker.send(outbound)

    async def edit(self, message: str, outbound: Outbound) -> None:
        """Edit in place.

        Raises:
            MessengerFault: Not changed, or it cannot be known whether it was.
        """
        await self._speaker.edit(message, outbound)

    async def pin(self, chat: Chat, message: str, *, pinned: bool = True) -> None:
        """Pin without a sound, or unpin.

        Raises:
            MessengerFault: Not done; in a group only an administrator who may pin can do it.
        """
        await self._speaker.pin(chat.id, message, pinned=pinned)

    async def answer_tap(self, inbound: Inbound, text: str) -> None:
        """Answer a tap at once, without waiting for the limits. Never raises."""
        await self._speaker.answer(inbound, text)

    def fetch(self, enclosure: IncomingFile) -> AsyncIterator[bytes]:
        """Yield what somebody sent; see `FileFetcher`.

        Raises:
            MessengerFault: As the contract says.
        """
        return self._fetcher.fetch(enclosure)


def _anybody(_address: Address) -> bool:
    """Nobody has said who is known: everything is read in the order in which it was sent."""
    return True


def _anywhere(_chat: Chat) -> bool:
    """Nobody has said where they were met: what is unnamed is waited for wherever it is."""
    return True


def _nobody_is_told(_what: object) -> None:
    """Nobody wants to know."""


def telegram_messenger(name: str, settings: Mapping[str, Any], clock: Clock) -> TelegramMessenger:
    """Make it from its table in the configuration. Nothing is opened.

    Raises:
        ConfigurationError: A setting is missing, unknown or wrong; the sentence names it.
    """
    return TelegramMessenger(name, read_settings(name, settings), clock, spoke_before=True)
