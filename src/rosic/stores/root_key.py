"""Where the root key comes from: a file of the folder, a credential of systemd, or a passphrase.

What lies in the folder decides, so that no start without its secret makes another key:

- ``root.key``: the key itself.
- ``root.salt``: a passphrase, made into a key with it (Argon2id).
- neither, beside a record: a credential holds the key.
- neither, and no record yet: the credential that is given, else the passphrase, else a new file.

A credential is a file ``rosic.root-key`` of 32 bytes, or ``rosic.passphrase``, in the folder that
systemd names; a passphrase may also be in the file that ``ROSIC_PASSPHRASE_FILE`` names.
"""

from __future__ import annotations

import os
import stat
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Final

from nacl.pwhash import argon2id

from rosic.errors import ConfigurationError
from rosic.stores.encryption import KEY_BYTES, RootKey, fresh_key

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

ROOT_KEY: Final = "root.key"
SALT: Final = "root.salt"
CREDENTIALS: Final = "CREDENTIALS_DIRECTORY"
KEY_CREDENTIAL: Final = "rosic.root-key"
PASSPHRASE_CREDENTIAL: Final = "rosic.passphrase"  # noqa: S105 - its name
PASSPHRASE_FILE: Final = "ROSIC_PASSPHRASE_FILE"  # noqa: S105 - likewise
SHORTEST: Final = 12
LONGEST: Final = 1024

# What every record that was made with a passphrase was made with: never change them.
_OPERATIONS: Final = argon2id.OPSLIMIT_MODERATE
_MEMORY: Final = argon2id.MEMLIMIT_INTERACTIVE


def root_of(folder: Path, environ: Mapping[str, str], *, begun: bool) -> RootKey:
    """Return the root key of a folder; made when there is nothing yet that it could belong to.

    Args:
        folder: Of one gateway.
        environ: Of the process.
        begun: There is a record already.

    Raises:
        ConfigurationError: It is not there, others can read it, or it is none.
        OSError: A file of it cannot be read or made.
    """
    if (folder / ROOT_KEY).exists():
        return RootKey(read_key(folder / ROOT_KEY))
    if (folder / SALT).exists():
        return _of_passphrase(folder, _passphrase(environ))
    credential = _credential(environ, KEY_CREDENTIAL)
    if credential is not None:
        return RootKey(read_key(credential, handed_over=True))
    if begun:
        raise ConfigurationError(
            f"{folder / ROOT_KEY} is missing; without it the personal content of this record is "
            "unreadable.",
            hint="Put it back from your copy, or start with an empty data folder.",
        )
    passphrase = _passphrase(environ)
    if passphrase is not None:
        create(folder / SALT, os.urandom(argon2id.SALTBYTES))
        return _of_passphrase(folder, passphrase)
    create(folder / ROOT_KEY, fresh_key())
    return RootKey(read_key(folder / ROOT_KEY))


def _credential(environ: Mapping[str, str], name: str) -> Path | None:
    where = environ.get(CREDENTIALS, "")
    path = Path(where, name)
    return path if where and path.exists() else None


def _passphrase(environ: Mapping[str, str]) -> bytes | None:
    """Return the passphrase that was given; None if none was."""
    path, handed_over = _credential(environ, PASSPHRASE_CREDENTIAL), True
    if path is None and environ.get(PASSPHRASE_FILE):
        path, handed_over = Path(environ[PASSPHRASE_FILE]), False
    if path is None:
        return None
    said = _read(path, LONGEST + 1, handed_over=handed_over).rstrip(b"\r\n")
    if not SHORTEST <= len(said) <= LONGEST:
        raise ConfigurationError(
            f"The passphrase in {path} must have {SHORTEST} to {LONGEST} bytes.",
            hint="Some words in a row are easier to keep than a few odd letters.",
        )
    return said


def _of_passphrase(folder: Path, passphrase: bytes | None) -> RootKey:
    if passphrase is None:
        raise ConfigurationError(
            f"The record in {folder} opens with a passphrase, and none was given.",
            hint=f"Name the file that holds it in {PASSPHRASE_FILE}, or hand it over as the "
            f"systemd credential {PASSPHRASE_CREDENTIAL}.",
        )
    salt = _read(folder / SALT, argon2id.SALTBYTES + 1)
    if len(salt) != argon2id.SALTBYTES:
        raise ConfigurationError(
            f"{folder / SALT} is damaged: it must hold {argon2id.SALTBYTES} bytes.",
            hint="Put it back from your copy.",
        )
    return RootKey(
        argon2id.kdf(KEY_BYTES, passphrase, salt, opslimit=_OPERATIONS, memlimit=_MEMORY)
    )


def read_key(path: Path, *, handed_over: bool = False) -> bytes:
    """Read a key that only its owner can read.

    Args:
        path: Of the file.
        handed_over: By systemd, which sees to who can read it.

    Raises:
        ConfigurationError: Others could read it, or it is not a key.
        OSError: It cannot be read.
    """
    key = _read(path, KEY_BYTES + 1, handed_over=handed_over)
    if len(key) != KEY_BYTES:
        raise ConfigurationError(
            f"{path} is damaged: it must hold {KEY_BYTES} bytes.",
            hint="Put it back from your copy.",
        )
    return key


def _read(path: Path, most: int, *, handed_over: bool = False) -> bytes:
    descriptor = os.open(path, os.O_RDONLY | os.O_CLOEXEC | (0 if handed_over else os.O_NOFOLLOW))
    try:
        mode = os.fstat(descriptor).st_mode
        if stat.S_ISREG(mode) and mode & 0o077 and not handed_over:
            raise ConfigurationError(
                f"{path} can be read by others.",
                hint=f"Run: chmod 600 {path} (and think about who may have read it).",
            )
        return os.read(descriptor, most)
    finally:
        os.close(descriptor)


def create(path: Path, content: bytes, *, wait_for_disk: Callable[[int], None] = os.fsync) -> None:
    """Make a file for the owner alone: whole after a power cut, or not there at all.

    Args:
        path: Of the file; its folder is there.
        content: All of it.
        wait_for_disk: Returns when what is behind a descriptor would survive a power cut; asked
            for the file before it has its name, and for the folder when the name stands in it.

    Raises:
        OSError: It could not be made. Nothing stays behind.
    """
    draft = path.with_name(f"{path.name}.new")
    with suppress(FileNotFoundError):
        draft.unlink()
    descriptor = os.open(draft, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_CLOEXEC, 0o600)
    try:
        with os.fdopen(descriptor, "wb") as file:
            file.write(content)
            file.flush()
            wait_for_disk(file.fileno())
        draft.rename(path)
    except OSError:
        with suppress(OSError):
            draft.unlink()
        raise
    folder = os.open(path.parent, os.O_RDONLY | os.O_DIRECTORY | os.O_CLOEXEC)
    try:
        wait_for_disk(folder)
    finally:
        os.close(folder)
