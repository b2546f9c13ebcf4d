"""Inboxes and outboxes of robots: folders that the operator named, and nothing outside them.

A file appears whole or not at all, beside ``NAME.sha256`` in the form of sha256sum, and never
replaces one that is there. What lies in these folders was put there by somebody else: no link is
followed, and nothing is read but plain files with a single name.
"""

from __future__ import annotations

import asyncio
import contextlib
import os
import stat
from typing import TYPE_CHECKING, Final

from rosic.core.saying import said
from rosic.errors import RobotUnreachable

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from rosic.core.robot import Files, RobotId

LOOKED_AT: Final = 10_000
_FOLDER: Final = os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW | os.O_CLOEXEC
_NEW: Final = os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_NOFOLLOW | os.O_CLOEXEC
_READ: Final = os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC

NOT_WRITABLE = said("The robot's inbox cannot be written now. The operator has to look.")
NOT_READABLE = said("The robot's outbox cannot be read now. The operator has to look.")


class RobotFolders:
    """The folders of every robot; all work on disks is done beside the event loop."""

    def __init__(self, files: Mapping[RobotId, Files]) -> None:
        self._files = files

    async def put(self, robot: RobotId, name: str, content: bytes, digest: bytes) -> bool:
        """Put a file into an inbox. Return False when one of that name is there already.

        Raises:
            RobotUnreachable: It cannot be written; nothing is there under that name.
        """
        folder = self._files[robot].inbox
        try:
            return await asyncio.to_thread(_put, folder, name, content, digest)
        except OSError as error:
            raise RobotUnreachable(NOT_WRITABLE) from error

    async def names(self, robot: RobotId, most: int) -> tuple[tuple[str, int, int], ...]:
        """Return name, size and time (ns) of what an outbox holds, the newest first.

        Raises:
            RobotUnreachable: It cannot be read.
        """
        try:
            return await asyncio.to_thread(_names, self._files[robot].outbox, most)
        except OSError as error:
            raise RobotUnreachable(NOT_READABLE) from error

    async def get(self, robot: RobotId, name: str, most: int) -> bytes | None:
        """Return what is in a file of an outbox; None when it is larger than ``most``.

        Raises:
            RobotUnreachable: There is no plain file of that name.
        """
        try:
            return await asyncio.to_thread(_get, self._files[robot].outbox, name, most)
        except OSError as error:
            raise RobotUnreachable(NOT_READABLE) from error


@contextlib.contextmanager
def _opened(folder: str) -> Iterator[int]:
    handle = os.open(folder, _FOLDER)
    try:
        yield handle
    finally:
        os.close(handle)


def _plain(name: str) -> str:
    """Return a name that is one, and nothing hidden.

    Raises:
        OSError: It is a path, or begins with a dot.
    """
    if not name or name.startswith(".") or set(name) & set("/\0\n"):
        raise OSError("not a plain name")
    return name


def _put(folder: str, name: str, content: bytes, digest: bytes) -> bool:
    checksum = f"{_plain(name)}.sha256"
    with _opened(folder) as at:
        if _there(at, name) or _there(at, checksum):
            return False
        if not _appear(at, checksum, f"{digest.hex()}  {name}\n".encode()):
            return False
        placed = False
        try:
            placed = _appear(at, name, content)
        finally:
            if not placed:
                os.unlink(checksum, dir_fd=at)
        os.fsync(at)
    return placed


def _there(at: int, name: str) -> bool:
    try:
        os.stat(name, dir_fd=at, follow_symlinks=False)
    except FileNotFoundError:
        return False
    return True


def _appear(at: int, name: str, content: bytes) -> bool:
    """Write under a name that nobody looks at, then let the file appear under its own.

    A link never replaces anything, as a rename would.
    """
    draft = f".{name}.part"
    with contextlib.suppress(FileNotFoundError):
        os.unlink(draft, dir_fd=at)  # of a run that died; of a link, the link itself
    handle = os.open(draft, _NEW, 0o600, dir_fd=at)
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(content)
            file.flush()
            os.fsync(file.fileno())
        os.link(draft, name, src_dir_fd=at, dst_dir_fd=at, follow_symlinks=False)
    except FileExistsError:
        return False
    finally:
        os.unlink(draft, dir_fd=at)
    return True


def _names(folder: str, most: int) -> tuple[tuple[str, int, int], ...]:
    found: list[tuple[str, int, int]] = []
    with _opened(folder) as at, os.scandir(at) as entries:
        for count, entry in enumerate(entries):
            if count >= LOOKED_AT:
                break
            if entry.name.startswith(".") or not entry.is_file(follow_symlinks=False):
                continue
            about = entry.stat(follow_symlinks=False)
            if about.st_nlink == 1:
                found.append((entry.name, about.st_size, about.st_mtime_ns))
    return tuple(sorted(found, key=lambda one: -one[2])[:most])


def _get(folder: str, name: str, most: int) -> bytes | None:
    with _opened(folder) as at:
        handle = os.open(_plain(name), _READ, dir_fd=at)
    with os.fdopen(handle, "rb") as file:
        about = os.fstat(handle)
        if not stat.S_ISREG(about.st_mode) or about.st_nlink != 1:
            raise OSError("not a plain file")
        content = file.read(most + 1)
    return None if len(content) > most else content
