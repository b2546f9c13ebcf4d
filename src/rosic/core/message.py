"""What comes from a messenger and what goes back to it, whatever the messenger is."""

from __future__ import annotations

import enum
from collections.abc import AsyncGenerator, Callable
from contextlib import aclosing

import msgspec

from rosic.core.i18n import said
from rosic.core.identity import PAGE, PROGRAM, Address, CommandId
from rosic.core.policy.roles import Assurance

# ---- in and out ----

_NO_NAME = frozenset("/\\\0\n\r")


class ChatKind(enum.Enum):
    """How many can read along."""

    __hash__ = object.__hash__  # Enum hashes the name, in Python, every time

    PRIVATE = "private"
    GROUP = "group"
    CHANNEL = "channel"


class MessageValidity(enum.Enum):
    """Whether a message may change anything (I17). Only a fresh one may; any of them may stop."""

    __hash__ = object.__hash__  # Enum hashes the name, in Python, every time

    FRESH = "fresh"
    EDITED = "edited"
    FORWARDED = "forwarded"
    VIA_BOT = "via-bot"
    CHANNEL = "channel"
    ANONYMOUS = "anonymous"
    UNVERIFIED = "unverified"
    """Nobody can be sure that whoever it names has sent it: it may look, and changes nothing."""
    DROPPED = "dropped"
    """Its messenger could not wait for its turn any longer: it is only told of."""


class SendPriority(enum.IntEnum):
    """What goes first where a platform does not take everything at once: the lowest."""

    STOP = 0
    ALARM = 1
    OUTCOME = 2
    QUESTION = 3
    FEEDBACK = 4
    IDLE = 5


class Chat(msgspec.Struct, frozen=True, gc=False):
    """Where a conversation takes place.

    Attributes:
        id: The platform's immutable id, as text.
        topic: The part of a group that it takes place in, where a group has parts; else empty.
    """

    platform: str
    id: str
    kind: ChatKind = ChatKind.PRIVATE
    topic: str = ""


class IncomingFile(msgspec.Struct, frozen=True, gc=False, kw_only=True):
    """A file that somebody sent, as the platform describes it. None of it is checked yet.

    Attributes:
        id: What the messenger fetches it by; opaque.
        name: As its sender calls it; empty where the platform gives none (a photo).
        media_type: As its sender claims.
        size: Bytes, as claimed; 0 where nobody says.
    """

    id: str
    name: str = ""
    media_type: str = ""
    size: int = 0

    def __repr__(self) -> str:
        return f"Enclosure({self.size} bytes)"


class GeoPoint(msgspec.Struct, frozen=True, gc=False):
    """A place on Earth that somebody sent: degrees, WGS 84."""

    latitude: float
    longitude: float


class Inbound(msgspec.Struct, frozen=True, gc=False, kw_only=True):
    """One message or one tap on a button, as an adapter received it.

    Attributes:
        message: The platform's immutable id of the message, unique in its chat.
        text: What was written; empty for a tap.
        written: The same before the names of bots, and lines for another bot, were taken out; line
            by line. Empty where nothing was.
        links: Where words lead, which whoever reads them may follow: none that stand in the text.
        nonce: What the tapped button carried; None for a text.
        sent_ns: The platform's send time, wall clock. A tap carries none: the receive time then.
        received_ns: Our wall clock.
        listening_since_ns: The adapter has listened without a gap since this wall time. What was
            sent earlier is backlog: motion in it is not carried out, buttons shown before are dead.
        tap: The platform's handle for answering a tap; empty for a text.
        under: Id of the message whose button was tapped; empty for a text.
        answers: Id of the message in this chat that it replies to; empty for none.
        answers_us: What it replies to, in this chat or another, is a message of ours, or the
            platform does not tell that a person wrote it.
        shown_as: How the platform shows the sender. For showing somebody new; never compared.
        locale: What the sender's messenger is set to, where the platform says so: ``de``. Only the
            default for whoever has not chosen a language.
        addressed: In a group: it names us, or replies to what we said.
        enclosed: A file that came with it; the text is then what was written beneath.
        place: A place that was sent instead of words.
        live: What it orders is steered by samples from then on; only where ROSIC itself asks people
            or programs to steer, never by what somebody writes.
        network_away: It was sent while the network between the platform and us was away, as the
            adapter has seen; where it cannot tell, it was not.
        account: Which of our own accounts there received it, where its number is that account's
            own count; empty where the whole chat shares the number, or there is one account only.
        shared: What every account of ours that is in the chat knows it by, where its number is one
            account's own; empty where nothing is, or there is one account only.
        assurance: What the way that it came is worth, where that is told of each message; None:
            what its messenger is worth.
        remedy: Of one whose sender nobody can be sure of: what its author can do about that, in a
            sentence; empty: nothing is known.
    """

    sender: Address
    chat: Chat
    message: str
    text: str
    sent_ns: int
    received_ns: int
    listening_since_ns: int = 0
    standing: MessageValidity = MessageValidity.FRESH
    nonce: str | None = None
    tap: str = ""
    under: str = ""
    answers: str = ""
    answers_us: bool = False
    shown_as: str = ""
    locale: str = ""
    addressed: bool = False
    enclosed: IncomingFile | None = None
    place: GeoPoint | None = None
    account: str = ""
    shared: str = ""
    network_away: bool = False
    written: str = ""
    links: tuple[str, ...] = ()
    live: bool = False
    assurance: Assurance | None = None
    remedy: str = ""

    @property
    def awaits_answer(self) -> bool:
        """Whether what sent it waits until it is answered: a program does, and the page."""
        return self.sender.platform in {PROGRAM, PAGE}


class ChatEventKind(enum.Enum):
    """What happens to a chat besides what is said in it."""

    __hash__ = object.__hash__  # Enum hashes the name, in Python, every time

    ADDED = "added"
    REMOVED = "removed"
    HEARING = "hearing"
    DEAF = "deaf"
    LEFT = "left"
    MOVED = "moved"


class ChatEvent(msgspec.Struct, frozen=True, gc=False, kw_only=True):
    """Something that happened to a chat, as an adapter heard of it. It changes nobody's rights.

    Attributes:
        chat: Where; with an empty id, wherever this account is.
        what: We were ``ADDED`` or ``REMOVED``; from now on we are ``HEARING`` everything that is
            said there, or ``DEAF`` to all that is not addressed to us; somebody has ``LEFT``; it
            has ``MOVED`` to another id.
        who: Who left; or who brought any of this about, where the platform tells.
        title: How the chat is called. For showing only.
        deaf: We hear only what is addressed to us there.
        new_id: Where it is now.
    """

    chat: Chat
    what: ChatEventKind
    who: Address | None = None
    title: str = ""
    deaf: bool = False
    new_id: str = ""


class Reaction(msgspec.Struct, frozen=True, gc=False, kw_only=True):
    """Somebody put an emoji beside a message. It says nothing but that.

    Attributes:
        message: To which message in that chat.
        who: None where the platform does not tell: nobody then.
        emoji: What was put there now; what was there before, or was taken away, is not in it.
    """

    chat: Chat
    message: str
    who: Address | None
    emoji: tuple[str, ...]


class Button(msgspec.Struct, frozen=True, gc=False):
    """A button under a message.

    Attributes:
        label: What the person reads.
        command: What a tap says, as if typed.
        nonce: What travels through the messenger instead of the command; empty until issued.
        good_for_ns: For how long it is good, where that is not the usual; only for one that moves
            nothing.
        act: Digest of what whoever taps it agrees to; empty: a tap agrees to nothing.
        asked: Of a button that confirms a command: which one. What a tap does has that identity,
            whoever taps and however often it was asked about (I1).
    """

    label: str
    command: str
    nonce: str = ""
    good_for_ns: int = 0
    act: bytes = b""
    asked: CommandId = b""


class AnswerState(enum.Enum):
    """What a message comes to, for whoever does not read it: a program.

    ``FINAL``: an answer, and all of it. ``GOES_ON``: more is said about the same. ``ASKED``: it
    has buttons, and nothing is done before one is tapped; or it has none, and more is said once
    somebody else was asked. ``AGREED``: they agree, and its first button does it.
    ``DONE``: what was ordered is done. ``NOT_DONE``: it is not, or nobody knows; the text says so.
    """

    __hash__ = object.__hash__  # Enum hashes the name, in Python, every time

    FINAL = "final"
    GOES_ON = "goes-on"
    ASKED = "asked"
    AGREED = "agreed"
    DONE = "done"
    NOT_DONE = "not-done"


class StreamedContent(msgspec.Struct, frozen=True):
    """A content that is read while it is sent, so that it is never in memory as a whole.

    Attributes:
        size: Bytes.
        read: Begins to read from the start, each time. What turns out not to be what was promised
            raises a RosicError before its last piece: whoever sends it has then sent nothing.
    """

    size: int
    read: Callable[[], AsyncGenerator[bytes]]


class Attachment(msgspec.Struct, frozen=True):
    """A file that goes with a message. Its content is never shown in a log.

    Attributes:
        name: What whoever receives it may call it: ``rosic-data.jsonl``; no path.
        media_type: ``image/png`` is shown as a picture where a messenger can.
        content: Empty for a file that comes in pieces.
        pieces: Instead of the content, for what is large. It is never shown as a picture.
    """

    name: str
    media_type: str
    content: bytes = b""
    pieces: StreamedContent | None = None

    def __post_init__(self) -> None:
        if bool(self.content) == (self.pieces is not None) or not self.size:
            raise ValueError("a file needs a content, in one way")
        if not self.name.strip(". ") or set(self.name) & _NO_NAME:
            raise ValueError("a file needs a plain name")

    @property
    def size(self) -> int:
        """How many bytes it has."""
        return len(self.content) if self.pieces is None else self.pieces.size

    async def read(self) -> AsyncGenerator[bytes]:
        """Yield the content, piece by piece.

        Raises:
            RosicError: It is not what was promised; what came so far is worth nothing.
        """
        if self.pieces is None:
            yield self.content
            return
        async with aclosing(self.pieces.read()) as pieces:
            async for piece in pieces:
                yield piece

    def __repr__(self) -> str:
        return f"Attachment({self.name!r}, {self.media_type!r}, {self.size} bytes)"


LIES_IN = said("It lies in {path}: only you can read it. Delete it when you are done.")


class Outbound(msgspec.Struct, frozen=True, gc=False, kw_only=True):
    """A message to a chat. The text is plain: an adapter never reads markup out of it.

    Attributes:
        reply_to: Id of the message it answers; empty for none.
        buttons: Rows of buttons.
        weight: Whether it overtakes what waits to be said elsewhere, or is overtaken.
        attachment: A file that goes with it; only for a messenger that sends files of its size.
        lies_in: `LIES_IN` as its reader reads it, ``{path}`` unfilled, for a messenger that puts
            the file into a folder; empty for English.
        cause: Id of the message or the tap because of which it is said, a tap's too; empty where
            nobody asked. Nobody is shown it.
        state: What it comes to.
        code: Of the refusal that it says, as programs read it; empty: it says none.
        offers: What a refusal would accept instead, as it would be typed.
        retry_after_s: Seconds until a refusal may be none; None: time alone changes nothing.
    """

    chat: Chat
    text: str
    reply_to: str = ""
    buttons: tuple[tuple[Button, ...], ...] = ()
    weight: SendPriority = SendPriority.QUESTION
    attachment: Attachment | None = None
    lies_in: str = ""
    cause: str = ""
    state: AnswerState = AnswerState.FINAL
    code: str = ""
    offers: tuple[str, ...] = ()
    retry_after_s: float | None = None

    @property
    def urgent(self) -> bool:
        """Whether it waits for nothing else in its own chat (a stop's answer, an alarm)."""
        return self.weight <= SendPriority.ALARM


# ---- menus of commands ----


class MenuScope(enum.Enum):
    """In which chats a menu is shown."""

    PRIVATE = "private"
    GROUPS = "groups"
    CHAT = "chat"


class Menu(msgspec.Struct, frozen=True):
    """Commands, in one language, for some chats. Showing one gives nobody a right to it.

    Attributes:
        commands: Name without a slash, and what it does; none takes the menu away.
        locale: For whom: ``de``; empty for everybody whose language has no menu.
        chat: Id of the one chat that it is for.
    """

    where: MenuScope
    commands: tuple[tuple[str, str], ...]
    locale: str = ""
    chat: str = ""

    @property
    def key(self) -> tuple[str, str, str]:
        """What tells it from every other menu."""
        return self.where.value, self.chat, self.locale
