"""Inboxes and outboxes of robots: folders that the operator named, and nothing outside them.

A file appears whole or not at all, beside ``NAME.sha256`` in the form of sha256sum, and never
replaces one that is there. What lies in these folders was put there by somebody else: no link is
followed, and nothing is read but plain files with a single name.
"""

from __future__ import annotations

import asyncio
import contextlib
import hashlib
import os
import stat
from typing import TYPE_CHECKING, Final

from rosic.core.i18n import said
from rosic.errors import RobotUnreachable

if TYPE_CHECKING:
    from collections.abc import AsyncGenerator, Iterator, Mapping
    from typing import BinaryIO

    from rosic.core.robot.profile import Files, RobotId

LOOKED_AT: Final = 10_000
PIECE_BYTES: Final = 262_144
_FOLDER: Final = os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW | os.O_CLOEXEC
_NEW: Final = os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_NOFOLLOW | os.O_CLOEXEC
_READ: Final = os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC

NOT_WRITABLE = said("The robot's inbox cannot be written now. The operator has to look.")
NOT_READABLE = said("The robot's outbox cannot be read now. The operator has to look.")


class RobotFolders:
    """The folders of every robot; all work on disks is done beside the event loop."""

    def __init__(self, files: Mapping[RobotId, Files]) -> None:
        self._files = dict(files)

    def add_robot(self, robot: RobotId, files: Files) -> None:
        """Know the folders of one more robot."""
        self._files[robot] = files

    def path(self, robot: RobotId, name: str) -> str:
        """Return where a file of an inbox lies; empty where the robot has none."""
        folder = self._files[robot].inbox
        return f"{folder.rstrip('/')}/{name}" if folder else ""

    async def put(
        self, robot: RobotId, name: str, pieces: AsyncGenerator[bytes], digest: bytes
    ) -> bool:
        """Put a file into an inbox, as it comes; False when one of that name is there already.

        Raises:
            RobotUnreachable: It cannot be written; nothing is there under that name.
            RosicError: The pieces are not what was promised; likewise.
        """
        folder = self._files[robot].inbox
        try:
            draft = await asyncio.to_thread(_Draft, folder, name)
            try:
                async with contextlib.aclosing(pieces):
                    async for piece in pieces:
                        await asyncio.to_thread(draft.write, piece)
                return await asyncio.to_thread(draft.appear, digest)
            finally:
                await asyncio.shield(asyncio.to_thread(draft.close))
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

    async def read(self, robot: RobotId, name: str) -> AsyncGenerator[bytes]:
        """Yield what is in a file of an outbox, piece by piece.

        Raises:
            RobotUnreachable: There is no plain file of that name, or it cannot be read.
        """
        try:
            file = await asyncio.to_thread(_opened_plain, self._files[robot].outbox, name)
            try:
                while piece := await asyncio.to_thread(file.read, PIECE_BYTES):
                    yield piece
            finally:
                file.close()
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


class _Draft:
    """A file that is being written under a name that nobody looks at, with its checksum beside it.

    Args:
        folder: Where.
        name: What it will be called.

    Raises:
        OSError: It cannot be written there.
    """

    def __init__(self, folder: str, name: str) -> None:
        self._name = _plain(name)
        self._draft = f".{name}.part"
        self._digest = hashlib.sha256()
        self._at = os.open(folder, _FOLDER)
        try:
            self._file = self._begun()
        except OSError:
            os.close(self._at)
            raise

    def _begun(self) -> BinaryIO:
        with contextlib.suppress(FileNotFoundError):
            os.unlink(self._draft, dir_fd=self._at)  # of a run that died; of a link, the link
        return os.fdopen(os.open(self._draft, _NEW, 0o600, dir_fd=self._at), "wb")

    def write(self, piece: bytes) -> None:
        """Write on."""
        self._digest.update(piece)
        self._file.write(piece)

    def appear(self, digest: bytes) -> bool:
        """Let it appear whole, after its checksum; False when there is one of that name.

        A link never replaces anything, as a rename would.
        """
        if self._digest.digest() != digest:
            raise OSError("what was written is not what was meant")
        self._file.flush()
        os.fsync(self._file.fileno())
        checksum = f"{self._name}.sha256"
        if _there(self._at, self._name) or _there(self._at, checksum):
            return False
        if not _appear(self._at, checksum, f"{digest.hex()}  {self._name}\n".encode()):
            return False
        placed = False
        try:
            placed = _linked(self._at, self._draft, self._name)
        finally:
            if not placed:
                os.unlink(checksum, dir_fd=self._at)
        os.fsync(self._at)
        return placed

    def close(self) -> None:
        """Leave nothing of the draft behind."""
        try:
            self._file.close()
            os.unlink(self._draft, dir_fd=self._at)
        finally:
            os.close(self._at)


def _linked(at: int, draft: str, name: str) -> bool:
    try:
        os.link(draft, name, src_dir_fd=at, dst_dir_fd=at, follow_symlinks=False)
    except FileExistsError:
        return False
    return True


def _there(at: int, name: str) -> bool:
    try:
        os.stat(name, dir_fd=at, follow_symlinks=False)
    except FileNotFoundError:
        return False
    return True


def _appear(at: int, name: str, content: bytes) -> bool:
    """Let a small file appear whole; False when there is one of that name."""
    draft = f".{name}.part"
    with contextlib.suppress(FileNotFoundError):
        os.unlink(draft, dir_fd=at)
    handle = os.open(draft, _NEW, 0o600, dir_fd=at)
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(content)
            file.flush()
            os.fsync(file.fileno())
        return _linked(at, draft, name)
    finally:
        os.unlink(draft, dir_fd=at)


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


def _opened_plain(folder: str, name: str) -> BinaryIO:
    with _opened(folder) as at:
        handle = os.open(_plain(name), _READ, dir_fd=at)
    about = os.fstat(handle)
    if not stat.S_ISREG(about.st_mode) or about.st_nlink != 1:
        os.close(handle)
        raise OSError("not a plain file")
    return os.fdopen(handle, "rb")
