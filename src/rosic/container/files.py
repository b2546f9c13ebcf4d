"""Files that people keep: what there is, whose it is, and how much room is left.

Their content lies in parts, sealed in the container of whoever keeps the file; here is only what is
said of it. A file that was not received to the end does not count as one, and goes at the next
start. Nothing here is ever opened, unpacked or shown: it is kept until somebody decides about it.
"""

from __future__ import annotations

import hashlib
import logging
from typing import TYPE_CHECKING, Final, NamedTuple

import msgspec

from rosic.container import file_messages as words
from rosic.container.file_types import SORTS, FileType, numbered
from rosic.core.identity import PrincipalId
from rosic.core.message import Attachment, StreamedContent
from rosic.core.records import Decided, Fact, Letter
from rosic.errors import NotUnderstood, RecordUnavailable, StoreFault, TooManyRequests

if TYPE_CHECKING:
    from collections.abc import AsyncGenerator, Iterable

    from rosic.contracts.clock import Clock
    from rosic.contracts.store import ContainerStore
    from rosic.core.records import Record

KIND: Final = "file"
PART: Final = "file-part"
PART_BYTES: Final = 262_144
FILES_MOST: Final = 50
PERSON_BYTES: Final = 100_000_000
PLACE_BYTES: Final = 2_000_000_000

log = logging.getLogger("rosic.container")


class FileQuota(msgspec.Struct, frozen=True):
    """How much may be kept.

    Attributes:
        files: Of one person.
        person_bytes: Likewise.
        place_bytes: Of everybody together.
    """

    files: int = FILES_MOST
    person_bytes: int = PERSON_BYTES
    place_bytes: int = PLACE_BYTES


class StoredFile(msgspec.Struct, frozen=True, kw_only=True):
    """One file.

    Attributes:
        sort: What it is, by its content; empty while it is being received. What is recorded here
            has one from the beginning.
        size: Bytes; while it is being received, what room is kept for.
        digest: SHA-256; empty while it is being received.
        parts: In how many parts it lies, at most.
    """

    id: str
    owner: PrincipalId
    name: str
    sort: str
    size: int
    digest: bytes
    parts: int
    at_ns: int

    @property
    def whole(self) -> bool:
        """Whether all of it is here."""
        return bool(self.digest)

    @property
    def media_type(self) -> str:
        """What messengers are told that it is."""
        sort = SORTS.get(self.sort)
        return "application/octet-stream" if sort is None else sort.media_type


class Recorded(NamedTuple):
    """A file that is made here, part by part, as long as something lasts.

    Attributes:
        sort: What it will be. Broken off, it is left to whoever makes such files.
        parts: In how many it may come to lie.
    """

    sort: str
    parts: int


class _Body(msgspec.Struct, frozen=True):
    owner: PrincipalId
    sort: str
    size: int
    digest: bytes
    parts: int
    at_ns: int


_encode = msgspec.msgpack.Encoder().encode
_read_body = msgspec.msgpack.Decoder(_Body).decode


class FileStore:
    """Everybody's files; no answer about one person looks at another's (I11)."""

    def __init__(self, clock: Clock, room: FileQuota | None = None) -> None:
        self._clock = clock
        self.room = room or FileQuota()
        self._files: dict[PrincipalId, dict[str, StoredFile]] = {}
        self._owners: dict[str, PrincipalId] = {}
        self._bytes = 0

    # ---- reading ----

    def knows(self, file: str) -> bool:
        """Whether there is a file of an id, whole or not."""
        return file in self._owners

    def of(self, owner: PrincipalId) -> tuple[StoredFile, ...]:
        """Return somebody's files, by name."""
        whole = (one for one in self._files.get(owner, {}).values() if one.whole)
        return tuple(sorted(whole, key=lambda one: one.name.casefold()))

    def find(self, owner: PrincipalId, name: str) -> StoredFile:
        """Return a file by its name.

        Raises:
            NotUnderstood: They have none of that name.
        """
        wanted = " ".join(name.split()).casefold()
        found = next((one for one in self.of(owner) if one.name.casefold() == wanted), None)
        if found is None:
            raise NotUnderstood(words.no_such_file(name), offers=("/files",))
        return found

    def used(self, owner: PrincipalId) -> tuple[int, int]:
        """Return how many files somebody has here, and how many bytes."""
        files = self._files.get(owner, {}).values()
        return len(files), sum(one.size for one in files)

    def check_room(self, owner: PrincipalId, size: int) -> None:
        """See that a further file finds room.

        Raises:
            TooManyRequests: It does not. Nothing has changed.
        """
        count, used = self.used(owner)
        if count >= self.room.files:
            raise TooManyRequests(words.too_many_files(self.room.files), retry_after_s=0.0)
        if used + size > self.room.person_bytes:
            left = max(self.room.person_bytes - used, 0)
            raise TooManyRequests(words.no_room(size, left), retry_after_s=0.0)
        if self._bytes + size > self.room.place_bytes:
            raise TooManyRequests(words.PLACE_FULL, retry_after_s=0.0)

    # ---- deciding ----

    def begin(
        self, owner: PrincipalId, file: str, name: str, most: int, recorded: Recorded | None = None
    ) -> tuple[Fact, ...]:
        """Keep room for a file that is coming.

        Args:
            owner: Whose it is.
            file: Its id.
            name: How it is called so far.
            most: Bytes that it may come to.
            recorded: It is made here, and not received.

        Raises:
            TooManyRequests: There is none.
        """
        self.check_room(owner, most)
        kind = recorded or Recorded("", -(-most // PART_BYTES))
        body = _Body(owner, kind.sort, most, b"", kind.parts, self._clock.wall_ns())
        return (_fact(file, body, name),)

    def part(self, owner: PrincipalId, file: str, number: int, content: bytes) -> Fact:
        """Return one part of a file's content."""
        return Fact(kind=PART, key=part_key(file, number), body=b"1", letter=Letter(owner, content))

    def finish(
        self, file: str, name: str, sort: FileType, size: int, digest: bytes, parts: int = 0
    ) -> tuple[Record, ...]:
        """Decide that a file is here, under a name of its own.

        Args:
            file: Its id.
            name: As whoever sent it calls it.
            sort: What it is.
            size: How many bytes it has.
            digest: SHA-256 of its content.
            parts: In how many it lies, if they are not all as large as parts are.
        """
        owner = self._owners[file]
        taken = {one.name.casefold() for one in self.of(owner)}
        free, number = name, 1
        while free.casefold() in taken:
            number += 1
            free = numbered(name, number)
        now_ns = self._clock.wall_ns()
        body = _Body(owner, sort.name, size, digest, parts or -(-size // PART_BYTES), now_ns)
        decided = Decided(act="file", by=owner, about=file, at_ns=now_ns, digest=digest)
        return (decided, _fact(file, body, free))

    def drop(self, file: str) -> tuple[Fact, ...]:
        """Return what takes a file away, with all its parts."""
        owner = self._owners.get(file)
        if owner is None:
            return ()
        parts = range(self._files[owner][file].parts)
        gone = (Fact(kind=PART, key=part_key(file, number), body=b"") for number in parts)
        return (Fact(kind=KIND, key=file, body=b""), *gone)

    def end_all(self, owner: PrincipalId) -> tuple[Fact, ...]:
        """Return what takes all of somebody's files away."""
        return tuple(fact for file in self._files.get(owner, {}) for fact in self.drop(file))

    def unfinished(self, *, recorded: bool = False) -> tuple[StoredFile, ...]:
        """Return what was not received to the end; or else what was not recorded to the end."""
        every = (one for files in self._files.values() for one in files.values())
        return tuple(one for one in every if not one.whole and bool(one.sort) is recorded)

    # ---- what is so ----

    def restore(self, facts: Iterable[Fact]) -> None:
        """Take over what earlier runs wrote."""
        for fact in facts:
            self.apply(fact)

    def apply(self, fact: Fact) -> None:
        """Let a fact be so. One that cannot be read, or is erased, is no file."""
        self._forget(fact.key)
        if not fact.body or fact.letter is None:
            return
        try:
            body = _read_body(fact.body)
            name = fact.letter.content.decode()
        except (msgspec.MsgspecError, UnicodeDecodeError):
            log.warning("a file cannot be read; it is left out")
            return
        filed = StoredFile(
            id=fact.key,
            owner=body.owner,
            name=name,
            sort=body.sort,
            size=body.size,
            digest=body.digest,
            parts=body.parts,
            at_ns=body.at_ns,
        )
        self._files.setdefault(body.owner, {})[fact.key] = filed
        self._owners[fact.key] = body.owner
        self._bytes += filed.size

    def _forget(self, file: str) -> None:
        owner = self._owners.pop(file, None)
        if owner is None:
            return
        files = self._files[owner]
        self._bytes -= files.pop(file).size
        if not files:
            del self._files[owner]


def part_key(file: str, number: int) -> str:
    """Return where a part lies; parts of a file are in order."""
    return f"{file}.{number:06d}"


def _fact(file: str, body: _Body, name: str) -> Fact:
    letter = Letter(body.owner, name.encode(errors="ignore"))
    return Fact(kind=KIND, key=file, body=_encode(body), letter=letter)


# ---- file content ----

# The content of a file, read from its parts and checked against its digest.

AT_ONCE: Final = 4
IN_PIECES_FROM: Final = 1_000_000
"""What is larger is never in memory as a whole, and its way is shown."""


async def pieces_of(container_store: ContainerStore, filed: StoredFile) -> AsyncGenerator[bytes]:
    """Yield what is in a file; a few parts at a time, so that writes pass between.

    Raises:
        RecordUnavailable: It cannot be read now, or is not what was kept; before the last piece.
    """
    digest, count, after, held = hashlib.sha256(), 0, f"{filed.id}.", b""
    while count < filed.size:
        try:
            page = await container_store.facts(PART, after, AT_ONCE)
        except StoreFault as fault:
            raise RecordUnavailable(words.DAMAGED) from fault
        ours = [one for one in page if one.key.startswith(f"{filed.id}.") and one.letter]
        if not ours:
            break
        for fact in ours:
            assert fact.letter is not None  # noqa: S101 - for the type checker
            if held:
                yield held
            held = fact.letter.content
            digest.update(held)
            count += len(held)
        after = ours[-1].key
    if digest.digest() != filed.digest:
        raise RecordUnavailable(words.DAMAGED)
    yield held


async def parts_of(container_store: ContainerStore, file: str) -> AsyncGenerator[bytes]:
    """Yield the parts of a file that is not whole, as far as they are there; unchecked.

    Raises:
        RecordUnavailable: They cannot be read now.
    """
    after, ours = f"{file}.", True
    while ours:
        try:
            page = await container_store.facts(PART, after, AT_ONCE)
        except StoreFault as fault:
            raise RecordUnavailable(words.DAMAGED) from fault
        page = tuple(one for one in page if one.key.startswith(f"{file}."))
        ours = bool(page)
        for fact in page:
            after = fact.key
            if fact.letter is not None:
                yield fact.letter.content


async def content_of(container_store: ContainerStore, filed: StoredFile) -> bytes:
    """Return what is in a small file.

    Raises:
        RecordUnavailable: It cannot be read now, or is not what was kept.
    """
    return b"".join([piece async for piece in pieces_of(container_store, filed)])


async def attachment_of(container_store: ContainerStore, filed: StoredFile) -> Attachment:
    """Return a file as it goes with a message: a large one is read only while it is sent.

    Raises:
        RecordUnavailable: A small one cannot be read now, or is not what was kept.
    """
    if filed.size <= IN_PIECES_FROM:
        return Attachment(filed.name, filed.media_type, await content_of(container_store, filed))
    pieces = StreamedContent(filed.size, lambda: pieces_of(container_store, filed))
    return Attachment(filed.name, filed.media_type, pieces=pieces)
