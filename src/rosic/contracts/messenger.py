"""What a messenger owes to ROSIC."""

from __future__ import annotations

from collections.abc import AsyncIterator, Awaitable, Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Protocol, TypeAlias, runtime_checkable

from rosic.core.identity import Address
from rosic.core.message import (
    Chat,
    ChatEvent,
    Inbound,
    IncomingFile,
    Menu,
    Outbound,
    Reaction,
    SendPriority,
)
from rosic.errors import MessengerFault

if TYPE_CHECKING:
    from rosic.core.secret import Secret

Receive: TypeAlias = Callable[[Inbound], Awaitable[None]]
Turn: TypeAlias = Callable[[Chat, SendPriority], Awaitable[None]]
Alarm: TypeAlias = Callable[[MessengerFault], None]
Passed: TypeAlias = Callable[[ChatEvent], None]
Reacted: TypeAlias = Callable[[Reaction], None]
Retract: TypeAlias = Callable[[Chat, str], Awaitable[None]]
PutPicture: TypeAlias = Callable[[str, Outbound], Awaitable[None]]
React: TypeAlias = Callable[[Chat, str, str], Awaitable[None]]
Settle: TypeAlias = Callable[[float], Awaitable[bool]]
"""Waits at most so many seconds until everything received so far is on disk; whether it is."""
Admins: TypeAlias = Callable[[Chat], Awaitable[tuple[Address, ...]]]
Knows: TypeAlias = Callable[[Address], bool]
Serves: TypeAlias = Callable[[Chat], bool]
Keep: TypeAlias = Callable[[str, bytes], None]
SetMenus: TypeAlias = Callable[[Sequence[Menu]], Awaitable[None]]


class Messenger(Protocol):
    """One account on one messenger. ``rosic.testing.MessengerConformance`` is this in tests.

    Attributes:
        platform: The first half of every address it produces.
        name: Which of the configured messengers it is.
        assurance: ``provider-readable``, ``e2ee-verified`` or ``local``; shown to people.
        edits: Whether a message can be changed after it was sent.
        file_bytes: How large a file may be that goes with a message; 0: it sends none.
        fetch_bytes: How large a file may be that people send; 0: it fetches none.
        pins: Whether a message can be kept in sight.
    """

    platform: str
    name: str
    assurance: str
    edits: bool
    file_bytes: int
    fetch_bytes: int
    pins: bool

    async def run(self, receive: Receive) -> None:
        """Listen until cancelled; leave nothing running. Whom to ask and tell is named before.

        Every message is handed to ``receive`` at least once. It is confirmed to the platform
        only after ``receive`` has returned: by then it is settled or on disk. Messages of one
        chat are handed over in the order in which they were sent; a stop overtakes them, also
        those that are being received. ``receive`` raises nothing that is the messenger's business.

        Raises:
            ConfigurationError: The account cannot be used (a wrong token); nothing was received.
            MessengerFault: The account can be used no longer; what was received is settled.
        """
        ...

    async def send(self, outbound: Outbound) -> str:
        """Send, waiting for the platform's limits, and return the platform's message id.

        It arrives in the topic of its chat, or in the group itself if that topic is closed. The
        text arrives exactly as given, never read as markup. A file arrives under its name,
        byte for byte; a picture may arrive as a picture, for eyes alone.

        Raises:
            ChatGone: Not sent, and nothing more can be said there.
            MessengerFault: Not sent; trying again may succeed, but never with a file larger than
                ``file_bytes``.
        """
        ...

    async def edit(self, message: str, outbound: Outbound) -> None:
        """Make the message look like ``outbound``. Editing to the same content succeeds.

        A file that went with it stays as it is.

        Raises:
            MessageGone: There is no such message any more; say it in a new one.
            MessengerFault: Not changed, or it cannot be known whether it was.
        """
        ...

    async def pin(self, chat: Chat, message: str, *, pinned: bool = True) -> None:
        """Keep a message of ours in sight at the top of its chat, or no longer. Nobody is called.

        What is so already succeeds.

        Raises:
            MessageGone: There is no such message any more.
            MessengerFault: Not done. The sentence says so to a person, and what would help: it may
                not in this chat, or it never can.
        """
        ...

    async def answer_tap(self, inbound: Inbound, text: str) -> None:
        """Answer a tap at once; an empty text only ends the waiting. Never raises."""
        ...

    def fetch(self, enclosure: IncomingFile) -> AsyncIterator[bytes]:
        """Yield a file that somebody sent, piece by piece, byte for byte.

        Never more than ``fetch_bytes``, and never more than was said of it.

        Raises:
            MessengerFault: It cannot be had, is larger than ``fetch_bytes``, or is not as long as
                was said. What came so far is a part of it and worth nothing. Of one that is said
                to be too large, this is raised at once, and the sentence names the limit and
                what raises it.
        """
        ...


# ---- what a messenger may be able to do besides ----


@runtime_checkable
class TakesTurns(Protocol):
    """Its platform takes only so much at a time; see `turn_of`."""

    async def turn(self, chat: Chat, weight: SendPriority) -> None:
        """Wait until something of this weight may be said in this chat."""


@runtime_checkable
class RaisesAlarms(Protocol):
    """It can be taken over; see `alarm_to`."""

    def alarm_with(self, alarm: Alarm) -> None:
        """Tell this from now on."""


@runtime_checkable
class AsksToConfirm(Protocol):
    """It asks before it confirms anything to its platform; see `settle_with`."""

    def settle_with(self, settle: Settle) -> None:
        """Ask this from now on."""


@runtime_checkable
class WaitsForDisk(Protocol):
    """It says whether it confirms only what is on disk; see `waits_for_disk`."""

    settles: bool


@runtime_checkable
class NamesAdmins(Protocol):
    """It can say who looks after a chat of many; see `admins_of`."""

    async def admins(self, chat: Chat) -> tuple[Address, ...]:
        """Return the accounts of those people."""


@runtime_checkable
class HasAccount(Protocol):
    """It has an account with an id; see `account_of`."""

    @property
    def account(self) -> str:
        """Return the platform's immutable id."""


@runtime_checkable
class HasHandle(Protocol):
    """Its account has a name that others find it by; see `handle_of`."""

    @property
    def handle(self) -> str:
        """Return that name."""


@runtime_checkable
class InviteLinks(Protocol):
    """A link can open a chat with it and hand a code in; see `invite_link_of`."""

    def invite_link(self, code: Secret) -> str:
        """Return that link, which shows the code."""


@runtime_checkable
class ExplainsHearing(Protocol):
    """In groups it may be passed only a part, and knows what changes that; see `hearing_of`."""

    def hearing(self, *, everywhere: bool) -> str:
        """Say to an admin what is not heard, and how to change that."""


@runtime_checkable
class DatesAccount(Protocol):
    """Identities of its messages hold its account, or once did not; see `account_since`."""

    def account_since(self, since_ns: int, *, several: bool) -> None:
        """Name the account in what was sent since."""


@runtime_checkable
class KeepsPace(Protocol):
    """Its platform counts what is said; see `keep_pace_with`."""

    def keep_pace(self, kept: Mapping[str, bytes], keep: Keep) -> None:
        """Go on with what an earlier run has said."""


@runtime_checkable
class ReadsKnownFirst(Protocol):
    """It receives much at once; see `know_with`."""

    def know_with(self, known: Knows) -> None:
        """Read first what people known here sent."""


@runtime_checkable
class ServesChats(Protocol):
    """It receives from chats where nobody is known; see `serve_with`."""

    def serve_with(self, serves: Serves) -> None:
        """Read last what names nobody in chats where nobody known here was met."""


@runtime_checkable
class CatchesUp(Protocol):
    """It brings what was sent while it did not listen; see `catching_up`."""

    def catching_up(self) -> bool:
        """Return whether such messages may still come."""


@runtime_checkable
class ChecksAccounts(Protocol):
    """It can tell that an account cannot exist; see `is_account`."""

    def is_account(self, account: str) -> bool:
        """Return whether one can, by its id alone."""


@runtime_checkable
class WatchesChats(Protocol):
    """It has chats of many; see `watch_chats`."""

    def watch_chats(self, passed: Passed) -> None:
        """Tell what happens to them."""


@runtime_checkable
class WatchesReactions(Protocol):
    """People react to messages there; see `watch_reactions`."""

    def watch_reactions(self, reacted: Reacted) -> None:
        """Tell when they do."""


@runtime_checkable
class Reacts(Protocol):
    """It can react to a message itself; see `reactions_of`."""

    async def react(self, chat: Chat, message: str, emoji: str) -> None:
        """Put an emoji beside a message."""


@runtime_checkable
class PutsPictures(Protocol):
    """A message of it can be made to show a picture; see `pictures_of`."""

    async def put_picture(self, message: str, outbound: Outbound) -> None:
        """Make a message show one."""


@runtime_checkable
class Retracts(Protocol):
    """It can take messages out of a chat; see `retract_of`."""

    async def retract(self, chat: Chat, message: str) -> None:
        """Take one out."""


@runtime_checkable
class OffersMenus(Protocol):
    """It offers commands while somebody types; see `menus_of`."""

    async def set_menus(self, menus: Sequence[Menu]) -> None:
        """Make each of these menus look as given."""


def turn_of(messenger: Messenger) -> Turn | None:
    """Return what a messenger calls ``turn``, if its platform takes only so much at a time.

    It waits until something of this weight may be said in this chat. What is sent or edited there
    next waits for nothing more, so its words can be chosen last. It raises ``MessengerFault`` when
    there was no room in time; cancelling it takes no turn. None: there is always room.
    """
    return messenger.turn if isinstance(messenger, TakesTurns) else None


def alarm_to(messenger: Messenger, alarm: Alarm) -> None:
    """Have a messenger that can be taken over say so: somebody else acts in its name.

    Called once per occurrence, on the event loop, after its motion was frozen, and when that ends.
    """
    if isinstance(messenger, RaisesAlarms):
        messenger.alarm_with(alarm)


def settle_with(messenger: Messenger, settle: Settle) -> bool:
    """Have a messenger ask, before it confirms anything to its platform, whether it may.

    What is received may then return before it is on disk; the messenger confirms only what was
    received before it asked, and nothing when the answer is False. It may refuse to run while
    it has nobody to ask. Return whether it will ask: one that does not is given nothing that is
    not settled.
    """
    if not isinstance(messenger, AsksToConfirm):
        return False
    messenger.settle_with(settle)
    return True


def waits_for_disk(messenger: Messenger) -> bool:
    """Whether a messenger waits for what is being written before it confirms what it received."""
    return isinstance(messenger, WaitsForDisk) and messenger.settles


def admins_of(messenger: Messenger) -> Admins | None:
    """Return what a messenger calls ``admins``, if it can say who looks after a chat of many.

    It takes a chat and returns the accounts of people, those who stay anonymous there included. It
    raises ``MessengerFault`` when that is not told, or cannot be known now.
    """
    return messenger.admins if isinstance(messenger, NamesAdmins) else None


def account_of(messenger: Messenger) -> str:
    """Return our own account there, by the platform's immutable id; empty: there is one only."""
    return messenger.account if isinstance(messenger, HasAccount) else ""


def handle_of(messenger: Messenger) -> str:
    """Return the name that others find our account by; empty: there is none, or none yet."""
    return messenger.handle if isinstance(messenger, HasHandle) else ""


def invite_link_of(messenger: Messenger, code: Secret) -> str:
    """Return the link that opens a private chat with our account and hands a code in.

    It shows the code. Empty: no link can, or the account's name is not known yet.
    """
    return messenger.invite_link(code) if isinstance(messenger, InviteLinks) else ""


def hearing_of(messenger: Messenger, *, everywhere: bool) -> str:
    """Return what an admin is told of an account that hears only a part of what a group says.

    Args:
        messenger: Which.
        everywhere: It is so in all groups; otherwise in one that was just named.

    Returns:
        What is not heard, and how to change that; empty: it does not know.
    """
    return (
        messenger.hearing(everywhere=everywhere) if isinstance(messenger, ExplainsHearing) else ""
    )


def account_since(messenger: Messenger, since_ns: int, *, several: bool) -> None:
    """Have a messenger name its account in what was sent since, by the platform's clock.

    A message's identity is for ever. One that was followed when identities did not hold the account
    may be brought once more: then it must be known again.

    Args:
        messenger: Which.
        since_ns: Wall clock of the platform.
        several: This gateway has other accounts on its platform: what two of them hear is one
            message, whatever number each of them gives it.
    """
    if isinstance(messenger, DatesAccount):
        messenger.account_since(since_ns, several=several)


def keep_pace_with(messenger: Messenger, kept: Mapping[str, bytes], keep: Keep) -> None:
    """Have a messenger whose platform counts what is said go on with what an earlier run has said.

    Args:
        messenger: Which.
        kept: What it kept, by a name that says nothing of the chat.
        keep: Keeps something under a name, soon and in order; nothing: forgets it.
    """
    if isinstance(messenger, KeepsPace):
        messenger.keep_pace(kept, keep)


def know_with(messenger: Messenger, known: Knows) -> None:
    """Have a messenger that receives much at once read first what people known here sent.

    Whom it asks about is a look-up. Nothing is lost or given up by it: what strangers sent comes
    later, so that however much that is, nobody's stop waits behind it.
    """
    if isinstance(messenger, ReadsKnownFirst):
        messenger.know_with(known)


def serve_with(messenger: Messenger, serves: Serves) -> None:
    """Have such a messenger ask in which chats somebody known here was met.

    What carries nobody's name there may be a stop that counts (I17), and is waited for; elsewhere
    it is looked at after everything else.
    """
    if isinstance(messenger, ServesChats):
        messenger.serve_with(serves)


def catching_up(messenger: Messenger) -> bool:
    """Whether a messenger may still bring what was sent while it did not listen: a stop, perhaps.

    One that cannot say brings nothing of the kind.
    """
    return isinstance(messenger, CatchesUp) and messenger.catching_up()


def is_account(messenger: Messenger, account: str) -> bool:
    """Whether an account can exist there, as far as a messenger can tell by its id alone."""
    return not isinstance(messenger, ChecksAccounts) or messenger.is_account(account)


def watch_chats(messenger: Messenger, passed: Passed) -> None:
    """Have a messenger with chats of many say what happens to them; see `ChatEvent`.

    Called on the event loop while the messenger listens, each time at least once; first, after
    every start of listening, with whether this account hears everything in groups.
    """
    if isinstance(messenger, WatchesChats):
        messenger.watch_chats(passed)


def watch_reactions(messenger: Messenger, reacted: Reacted) -> None:
    """Have a messenger on which people react to messages say so; see `Reaction`.

    Called on the event loop while the messenger listens, each time at least once, as soon as it
    arrives: nothing that must not be lost, and nothing that moves, may hang on it.
    """
    if isinstance(messenger, WatchesReactions):
        messenger.watch_reactions(reacted)


def reactions_of(messenger: Messenger) -> React | None:
    """Return what a messenger calls ``react``, if this account can react to a message itself.

    It takes a chat, the id of a message there and an emoji, and raises ``MessengerFault`` when the
    emoji is not there afterwards, or it cannot be known: then say it in words.
    """
    return messenger.react if isinstance(messenger, Reacts) else None


def pictures_of(messenger: Messenger) -> PutPicture | None:
    """Return what a messenger calls ``put_picture``, if a message can be made to show a picture.

    It takes the id of a message of ours, which may have been words alone, and how it is to look:
    a picture and the text beneath it. Once a message shows one it does so for good, and holds no
    more text than goes beneath a picture. It raises what ``Messenger.edit`` raises.
    """
    return messenger.put_picture if isinstance(messenger, PutsPictures) else None


def retract_of(messenger: Messenger) -> Retract | None:
    """Return what a messenger calls ``retract``, if messages can be taken out of a chat.

    It takes a chat and the id of a message there, anybody's. One that is not there any more is out
    of it. It raises ``MessageGone`` when it can never be done (too old, or this account may not
    take away what others wrote there), and ``MessengerFault`` when it may succeed later. Whoever
    has read it has read it: nothing may hang on its being gone.
    """
    return messenger.retract if isinstance(messenger, Retracts) else None


def menus_of(messenger: Messenger) -> SetMenus | None:
    """Return what a messenger calls ``set_menus``, if it offers commands while somebody types.

    It makes each of these menus look as given, with one call to the platform for each that does
    not look so already, and leaves all others alone. It never raises: a menu is a convenience.
    """
    return messenger.set_menus if isinstance(messenger, OffersMenus) else None
