"""What a file is, by what is in it, and what it may be called. Nothing here opens one.

A claim counts for nothing: a name and a media type come from whoever sent it. Of a few kinds the
content shows which it is; every other file is not taken.
"""

from __future__ import annotations

import codecs
import re
from typing import Final, NamedTuple

from rosic.core.language.sanitise import clean, normalised

LONGEST_NAME: Final = 100
LOOKED_AT: Final = 4 * LONGEST_NAME
"""In bytes; what is kept of an ending goes on top of nothing."""
HEAD_BYTES: Final = 512
LONGEST_ENDING: Final = 8


class FileType(NamedTuple):
    """One kind of file.

    Attributes:
        name: As profiles write it: ``png``.
        endings: How its names end; the first where a name has none of them.
    """

    name: str
    media_type: str
    endings: tuple[str, ...]


TEXT: Final = FileType("text", "text/plain", ("txt", "log", "md"))
_TEXTS: Final = (
    FileType("yaml", "application/yaml", ("yaml", "yml")),
    FileType("json", "application/json", ("json", "jsonl")),
    FileType("csv", "text/csv", ("csv",)),
    TEXT,
)
_BY_HEAD: Final = (
    (re.compile(rb"\x89PNG\r\n\x1a\n"), FileType("png", "image/png", ("png",))),
    (re.compile(rb"\xff\xd8\xff"), FileType("jpeg", "image/jpeg", ("jpg", "jpeg"))),
    (re.compile(rb"%PDF-\d"), FileType("pdf", "application/pdf", ("pdf",))),
    (
        re.compile(rb"P[1-6]\s+(?:#[^\n]*\n\s*)*\d+\s+\d+\s"),
        FileType("pgm", "image/x-portable-anymap", ("pgm", "pbm", "ppm")),
    ),
    (re.compile(rb"PK(?:\x03\x04|\x05\x06)"), FileType("zip", "application/zip", ("zip",))),
    (re.compile(rb"\x1f\x8b\x08"), FileType("gzip", "application/gzip", ("gz", "tgz"))),
    (re.compile(rb"\x89MCAP0\r\n"), FileType("mcap", "application/octet-stream", ("mcap",))),
    (re.compile(rb"SQLite format 3\0"), FileType("db3", "application/octet-stream", ("db3",))),
)
SORTS: Final = {sort.name: sort for sort in (*(sort for _, sort in _BY_HEAD), *_TEXTS)}

_NO_TEXT: Final = re.compile(r"[\x00-\x08\x0e-\x1f\x7f]")
_NOT_IN_NAMES: Final = re.compile(r'[<>:"|?*\\/%$`\'&;]')
_DEVICES: Final = re.compile(r"(?:con|prn|aux|nul|com\d|lpt\d)(?:\..*)?\Z", re.IGNORECASE)


class Sniffer:
    """Finds out what a file is while it passes."""

    def __init__(self) -> None:
        self._head = b""
        self._decoder = codecs.getincrementaldecoder("utf-8")()
        self._is_text = True

    def feed(self, piece: bytes) -> None:
        """Look at the next piece."""
        if len(self._head) < HEAD_BYTES:
            self._head += piece[: HEAD_BYTES - len(self._head)]
        if self._is_text:
            self._read(piece, final=False)

    def _read(self, piece: bytes, *, final: bool) -> None:
        try:
            self._is_text = _NO_TEXT.search(self._decoder.decode(piece, final)) is None
        except UnicodeDecodeError:
            self._is_text = False

    def sort(self, name: str) -> FileType | None:
        """Return what it is, after all of it has passed; None for what is not taken.

        Args:
            name: As its sender calls it; says which kind of text a text is.
        """
        for head, sort in _BY_HEAD:
            if head.match(self._head):
                return sort
        if self._is_text:
            self._read(b"", final=True)
        if not self._is_text or not self._head:
            return None
        ending = _ending(name)
        return next((sort for sort in _TEXTS if ending in sort.endings), TEXT)


def file_name(said: str, sort: FileType) -> str:
    """Return what a file is called here: no path, nothing invisible, and an ending of its kind.

    Total: whatever was said, the result is a plain name of at most 100 bytes.
    """
    last = re.split(r"[\\/]", said[-LOOKED_AT:])[-1]
    plain = normalised(clean(last).replace("\n", " "))
    plain = " ".join(_NOT_IN_NAMES.sub("_", plain).split()).strip(". -")
    stem, dot, ending = plain.rpartition(".")
    if not dot or ending.casefold() not in sort.endings:
        stem, ending = plain, sort.endings[0]
    stem = _cut(stem.strip(". "), LONGEST_NAME - len(ending) - 1).rstrip(". ")
    if not stem or _DEVICES.match(stem):
        stem = f"file{stem and '-'}{stem}"
    return f"{stem}.{ending}"


def numbered(name: str, number: int) -> str:
    """Return another name for a second file of a name: ``map (2).png``."""
    stem, _, ending = name.rpartition(".")
    room = LONGEST_NAME - len(ending) - 1 - len(f" ({number})")
    return f"{_cut(stem, room)} ({number}).{ending}"


def _cut(text: str, most: int) -> str:
    return text.encode(errors="ignore")[:most].decode(errors="ignore")


def _ending(name: str) -> str:
    _, dot, ending = name.rpartition(".")
    return ending.casefold() if dot and len(ending) <= LONGEST_ENDING else ""
