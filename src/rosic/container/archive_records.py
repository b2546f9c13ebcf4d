"""What an archive is made of, as it is written down: switches and entries, each a fact."""

from __future__ import annotations

from collections import OrderedDict
from hashlib import blake2b
from typing import TYPE_CHECKING, Final, Literal, TypeAlias

import msgspec

from rosic.core.identity import DIGEST_BYTES, PrincipalId
from rosic.core.message import Chat
from rosic.core.records import Fact, Letter

if TYPE_CHECKING:
    from rosic.core.message import Inbound

SWITCH: Final = "archive"
ENTRY: Final = "archived"
_DIGITS: Final = 9

ChatKey: TypeAlias = str
"""What stands for a chat in the open: a digest."""
Way: TypeAlias = Literal["in", "out", "gap", "lost"]
"""in: somebody wrote. out: ROSIC wrote. gap: nobody listened. lost: it could not be written."""


class ArchiveSwitch(msgspec.Struct, frozen=True, kw_only=True):
    """Body of the fact that says that a chat is kept. Its key stands for the chat.

    Attributes:
        on: Whether messages are kept now; entries stay when it ends, for as long as they would.
        by: Who said so last.
        at_ns: Since when it is on, or off.
        days: How long an entry stays.
        next_n: Number of the next entry at least.
    """

    on: bool
    by: PrincipalId
    at_ns: int
    days: int
    next_n: int = 1


class ArchivedChat(msgspec.Struct, frozen=True):
    """Letter of the same fact: which chat it is, sealed in the chat's own container."""

    messenger: str
    chat: Chat


class ArchiveEntry(msgspec.Struct, frozen=True, gc=False, kw_only=True):
    """Body of one entry: ids, numbers and digests.

    Attributes:
        at_ns: When it was received or sent, our wall clock.
        who: Who wrote it, or whom it answered; empty: nobody known.
        identity: Digest of the message's identity; empty for a gap.
        size: Bytes of the letter.
        since_ns: The adapter had listened since then; 0 if it never says.
        backlog: It was received late, after an interruption.
        until_ns: Of a gap, when it was over.
    """

    at_ns: int
    way: Way
    who: PrincipalId = ""
    identity: bytes = b""
    size: int = 0
    since_ns: int = 0
    backlog: bool = False
    until_ns: int = 0


class EntryContent(msgspec.Struct, frozen=True, array_like=True):
    """Letter of one entry.

    Attributes:
        account: The platform's id of the sender; empty for ROSIC.
        name: How they were called then; empty: nobody known.
        text: As it was received or sent.
        note: What else there is to say: ``edited``, ``forwarded``, ``button``.
        message: The platform's id of the message.
    """

    account: str
    name: str
    text: str
    note: str
    message: str


class ArchiveKeeping:
    """The index of one chat's archive.

    Attributes:
        switch: Whether it is on, since when, by whom.
        venue: Which chat; None after it was erased.
        entries: By number, the oldest first.
        size: Bytes of all letters.
        unwritten_ns: When the first began that did not reach the disk; 0: all did.
    """

    __slots__ = ("entries", "found", "heard", "next_n", "size", "switch", "unwritten_ns", "venue")

    def __init__(self, switch: ArchiveSwitch) -> None:
        self.switch = switch
        self.venue: ArchivedChat | None = None
        self.entries: OrderedDict[int, ArchiveEntry] = OrderedDict()
        self.found: dict[bytes, int] = {}
        self.heard: ArchiveEntry | None = None  # the newest that was received
        self.next_n = switch.next_n
        self.size = 0
        self.unwritten_ns = 0

    def put(self, n: int, entry: ArchiveEntry) -> None:
        """Take an entry into the index."""
        before = self.entries.get(n)
        self.size += entry.size - (0 if before is None else before.size)
        self.entries[n] = entry
        if entry.identity:
            self.found[entry.identity] = n
        if entry.way == "in":
            self.heard = entry
        self.next_n = max(self.next_n, n + 1)

    def drop(self, n: int) -> None:
        """Take an entry out of the index."""
        entry = self.entries.pop(n, None)
        if entry is not None:
            self.size -= entry.size
            self.found.pop(entry.identity, None)

    def lose(self, n: int, now_ns: int) -> None:
        """An entry did not reach the disk."""
        entry = self.entries.get(n)
        self.drop(n)
        begin_ns = now_ns if entry is None else entry.at_ns
        self.unwritten_ns = min(self.unwritten_ns or begin_ns, begin_ns)

    def lost(self, now_ns: int) -> ArchiveEntry:
        """Return the entry that says what did not reach the disk until now; it is said once."""
        begin_ns, self.unwritten_ns = self.unwritten_ns, 0
        return ArchiveEntry(at_ns=begin_ns, way="lost", until_ns=now_ns)


encode = msgspec.msgpack.Encoder().encode
read_switch = msgspec.msgpack.Decoder(ArchiveSwitch).decode
read_venue = msgspec.msgpack.Decoder(ArchivedChat).decode
read_entry = msgspec.msgpack.Decoder(ArchiveEntry).decode
read_content = msgspec.msgpack.Decoder(EntryContent).decode


def chat_key(chat: Chat) -> ChatKey:
    """Return what stands for a chat in the open."""
    said = ascii((chat.platform, chat.id)).encode()
    return blake2b(said, digest_size=DIGEST_BYTES).hexdigest()


def container_of(key: ChatKey) -> str:
    """Return the container of what belongs to a chat and to nobody in it."""
    return f"chat-{key}"


def entry_key(chat: ChatKey, n: int) -> str:
    """Return the key of an entry; keys stand in the order of their numbers."""
    return f"{chat}.{n:0{_DIGITS}}"


def place_of(key: str) -> tuple[ChatKey, int]:
    """Return the chat and the number that a key says.

    Raises:
        ValueError: It is no key of an entry.
    """
    chat, _, number = key.partition(".")
    return chat, int(number)


def no_more(chat: ChatKey, n: int) -> Fact:
    """Return what ends an entry."""
    return Fact(kind=ENTRY, key=entry_key(chat, n), body=b"")


def entry_fact(chat: ChatKey, n: int, entry: ArchiveEntry, letter: Letter | None) -> Fact:
    """Return an entry as it is written down."""
    return Fact(kind=ENTRY, key=entry_key(chat, n), body=encode(entry), letter=letter)


def identity_of(inbound: Inbound) -> bytes:
    """Return the identity of a message: received again, it is the same. An edit is another."""
    if inbound.nonce is not None:
        return digest("tap", inbound.chat, inbound.tap or inbound.nonce)
    edited = inbound.text if inbound.standing.value == "edited" else ""
    return received_digest(inbound.chat, inbound.message, inbound.account, edited)


def received_digest(chat: Chat, message: str, account: str, edited: str = "") -> bytes:
    """Return the identity of what was received; the account counts where `Inbound` has one."""
    return digest("in", chat, message, edited, *((account,) if account else ()))


def sent_digest(chat: Chat, message: str, account: str) -> bytes:
    """Return the identity of what was sent: each account counts what it sends by itself."""
    return digest("out", chat, message, *((account,) if account else ()))


def digest(*parts: str | Chat) -> bytes:
    """Return a digest that stands for these parts."""
    said = [f"{p.platform}:{p.id}" if isinstance(p, Chat) else p for p in parts]
    return blake2b(ascii(said).encode(), digest_size=DIGEST_BYTES).digest()
