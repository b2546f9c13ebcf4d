"""Whether the record of a folder is the newest that was there: a number that only grows.

The number stands in the record and, written after it, in a small file beside it. A record that was
lost, emptied, put back from an old copy or swapped for another one does not have it (I13).

A record is a database and the log that lies over it, and each may be put back without the other:
the number grows with every log that is begun, and the file knows, too, what the database says
without its log. What cannot be seen: a whole folder, this file included, that was put back as it
once was; and a log that was put back from between two numbers, less than a minute apart.
"""

from __future__ import annotations

import os
import struct
from typing import TYPE_CHECKING, Final

import msgspec

from rosic.errors import ConfigurationError
from rosic.stores import slots
from rosic.stores.root_key import ROOT_KEY, SALT, create

if TYPE_CHECKING:
    from pathlib import Path

MARK: Final = "record.mark"
STOPS: Final = "stops"
DATABASE: Final = "rosic.db"
LOG: Final = "rosic.db-wal"
NUMBERS: Final = struct.Struct("<II")  # identity, folded
MAGIC: Final = b"rosic record mark 1"
KIND: Final = b"mark"
WITNESSES: Final = (ROOT_KEY, SALT, STOPS)
BEGIN_ANEW: Final = "rosic run --begin-anew"


class RecordNumber(msgspec.Struct, frozen=True):
    """What the record and the file beside it both say.

    Attributes:
        identity: Of the record; 0 for one that has never been marked.
        number: Only grows; 0 in the file until the first record is made.
        folded: What the database says without its log is not lower; only the file says that.
    """

    identity: int = 0
    number: int = 0
    folded: int = 0


class RecordMark:
    """The file beside the record.

    Args:
        folder: Of one gateway.
        begin_anew: The owner has said that a lost record is to be begun anew, and an older or
            foreign one taken as it is.
    """

    def __init__(self, folder: Path, *, begin_anew: bool) -> None:
        self.path = folder / MARK
        self._folder = folder
        self._begin_anew = begin_anew
        self._known: RecordNumber | None = None

    def look(self) -> None:
        """See that a record which was once here is here; before anything is made.

        Raises:
            ConfigurationError: It is not. Nothing was changed.
            OSError: The folder cannot be used.
        """
        self._known = self._read()
        database = self._folder / DATABASE
        if database.exists() and database.stat().st_size:
            return
        self.refuse_empty(f"{DATABASE} is gone or empty")
        if self._known is None:  # a start that is cut off from here on has begun nothing yet
            self._known = RecordNumber(_new_identity(), 0)
            self.write(self._known)

    def refuse_empty(self, what: str) -> None:
        """Refuse to fill an empty record, if there was one here before.

        Raises:
            ConfigurationError: There was.
        """
        if self._known is None:
            begun = next((name for name in WITNESSES if (self._folder / name).exists()), "")
        else:
            begun = MARK if self._known.number else ""
        if begun and not self._begin_anew:
            raise ConfigurationError(
                f"The record in {self._folder} is lost: {begun} is there, and {what}.",
                hint=f"Put {DATABASE} back from your copy, or begin anew: {BEGIN_ANEW}. Then "
                "nobody is known any more but whom the configuration names: they are let in "
                "again, also whoever was revoked or locked, and bookings are forgotten.",
            )

    def compare(self, found: RecordNumber, alone: RecordNumber) -> RecordNumber:
        """Compare with what a record says of itself; return what both are to say from now on.

        Args:
            found: What the database says with its log.
            alone: What it says without.

        Raises:
            ConfigurationError: The record, or one of its two files, is older than the file, of
                another folder, or a copy without its file. Nothing was changed.
        """
        known = self._known or RecordNumber()
        why = self._why_not(found) or self._why_not_together(found, alone)
        if why and not self._begin_anew:
            raise ConfigurationError(
                f"The record in {self._folder} is not the one that was last used here: {why}.",
                hint=f"Put {DATABASE}, {LOG} and {MARK} back as they were last, or take this "
                f"record as it is: {BEGIN_ANEW}. Then whatever was decided after it was copied is "
                "forgotten: who was revoked or locked since may come in again.",
            )
        identity = found.identity or known.identity or _new_identity()
        number = max(found.number, alone.number, known.number) + 1
        return RecordNumber(identity, number, min(known.folded, alone.number))

    def _why_not(self, found: RecordNumber) -> str:
        known = self._known
        if known is None:
            return f"{MARK} is missing beside it" if found.number else ""
        if found.number < known.number:
            return f"it is older than {MARK}"
        if found.number and found.identity != known.identity:
            return f"{MARK} belongs to another one"
        return ""

    def _why_not_together(self, found: RecordNumber, alone: RecordNumber) -> str:
        known = self._known or RecordNumber()
        if alone.number < known.folded:
            return f"without {LOG} it is older than {MARK}"
        if alone.number > found.number:
            return f"{LOG} is older than {DATABASE}"
        if alone.number and alone.identity != found.identity:
            return f"{LOG} belongs to another one"
        return ""

    def write(self, mark: RecordNumber) -> None:
        """Say it in the file, too. On return it would survive a power cut.

        Raises:
            OSError: It may say what it said before; a record that is newer than it is good.
        """
        content = packed(mark)
        if not os.path.lexists(self.path):
            create(self.path, content)
            return
        descriptor = os.open(self.path, os.O_WRONLY | os.O_CLOEXEC | os.O_NOFOLLOW)
        try:
            os.pwrite(descriptor, content, 0)
            os.ftruncate(descriptor, len(content))
            os.fdatasync(descriptor)
        finally:
            os.close(descriptor)

    def _read(self) -> RecordNumber | None:
        try:
            found = slots.unpack(KIND, self.path.read_bytes())
        except FileNotFoundError:
            return None
        except (slots.DamagedSlot, ValueError) as damaged:
            if self._begin_anew:
                return None
            raise ConfigurationError(
                f"{self.path} is damaged.",
                hint=f"Put it back from your copy, or take the record as it is: {BEGIN_ANEW}.",
            ) from damaged
        if found is None or found[0] != MAGIC:
            return None
        numbers = found[2].ljust(NUMBERS.size, b"\0")
        identity, folded = NUMBERS.unpack(numbers)
        return RecordNumber(identity, found[1], folded)


def packed(mark: RecordNumber) -> bytes:
    """Return what the file is to hold."""
    return slots.pack(KIND, MAGIC, mark.number, NUMBERS.pack(mark.identity, mark.folded))


def _new_identity() -> int:
    return int.from_bytes(os.urandom(4), "little") % (2**31 - 1) + 1


def was_begun(folder: Path) -> bool:
    """Whether a folder has, or once had, a record."""
    return any((folder / name).exists() for name in (DATABASE, MARK, *WITNESSES))
