"""Every sentence about files that people keep."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosic.core.language.cleaning import quote
from rosic.core.language.suggestions import listed
from rosic.core.saying import joined, said, said_n

if TYPE_CHECKING:
    from collections.abc import Iterable

MB = 1_000_000
KB = 1_000

HOW = said(
    "Send me a photo or a document and I keep it for you, sealed. /files lists what I keep; "
    "/files get NAME, /files delete NAME, /files send NAME to ROBOT, /files from ROBOT."
)
NONE = said("I keep no file of yours. Send me a photo or a document and I keep it, sealed.")
NOT_HERE = said("I cannot take files over this messenger.")
PLACE_FULL = said(
    "There is no room for files here any more. The operator has to make some. Nothing was kept."
)
TOO_MANY_COMING = said("I am still taking in files of yours. Send this one when they are here.")
EMPTY = said("The file is empty. Nothing was kept.")
DAMAGED = said("The file does not read as it was kept. Delete it, and send it again.")
NOT_NOW = said("I cannot write the file down now, so nothing was kept. The operator has to look.")
BROKEN = said("Something went wrong while I took the file in. Nothing was kept. Send it again.")


def amount(count: int) -> str:
    """Return a number of bytes as messengers count them."""
    if count >= MB:
        return f"{count / MB:.1f} MB"
    return f"{count / KB:.0f} KB" if count >= KB else f"{count} bytes"


def no_such_file(name: str) -> str:
    """Return that somebody has no file of a name."""
    return said("You have no file {name} here.", name=quote(name))


def too_many_files(most: int) -> str:
    """Return that somebody keeps too many files."""
    return said_n(
        "I keep {n} file for each person at most. Delete one first; nothing was kept.",
        "I keep {n} files for each person at most. Delete one first; nothing was kept.",
        most,
    )


def no_room(size: int, left: int) -> str:
    """Return that a file does not find room."""
    return said(
        "The file has {size}, and you have {left} left here. Delete something first; "
        "nothing was kept.",
        size=amount(size),
        left=amount(left),
    )


def unknown(kinds: Iterable[str]) -> str:
    """Return that a file is none of the kinds that are taken."""
    return said(
        "By its content this is none of the kinds that I take ({kinds}). Nothing was kept.",
        kinds=listed(tuple(kinds)),
    )


def coming(size: int, done: int) -> str:
    """Return how far a file has come."""
    if not size:
        return said("Taking the file in: {done} so far.", done=amount(done))
    part = min(100 * done // size, 100)
    return said("Taking the file in: {part} % of {size}.", part=part, size=amount(size))


def kept(name: str, sort: str, size: int, digest: bytes) -> str:
    """Return that a file is kept, and that nothing else was done with it."""
    return said(
        "{name} ({sort}, {size}) is kept for you, sealed. Nothing was done with it.\n"
        "SHA-256 {digest}",
        name=name,
        sort=sort,
        size=amount(size),
        digest=digest.hex(),
    )


def not_whole(name: str) -> str:
    """Return that a file was interrupted by a restart."""
    return said("{name} had not come whole when I was restarted. Send it again.", name=name)


def line(name: str, sort: str, size: int, ago: str, digest: bytes) -> str:
    """Return one line of the list."""
    return said(
        "{name}: {sort}, {size}, {ago}, SHA-256 {digest}...",
        name=name,
        sort=sort,
        size=amount(size),
        ago=ago,
        digest=digest.hex()[:8],
    )


def listing(lines: Iterable[str], used: int, most: int) -> str:
    """Return somebody's files."""
    total = said("{used} of {most} used.", used=amount(used), most=amount(most))
    return joined("\n", [said("Your files:"), *lines, total])


def handed(name: str, size: int, digest: bytes) -> str:
    """Return what is said with a file that is given back."""
    return said(
        "{name}, {size}, SHA-256 {digest}", name=name, size=amount(size), digest=digest.hex()
    )


def too_large_to_send(name: str, size: int, most: int) -> str:
    """Return that a messenger does not take a file so large."""
    if not most:
        return said("I cannot send files over this messenger.")
    return said(
        "{name} has {size}; I can send files of up to {most} here.",
        name=name,
        size=amount(size),
        most=amount(most),
    )


def deleted(name: str) -> str:
    """Return that a file is gone."""
    return said("{name} is deleted.", name=name)
