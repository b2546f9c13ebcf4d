"""What is kept of an account: for its owner alone, and all of it or what was there before."""

from __future__ import annotations

import stat
from typing import TYPE_CHECKING

import pytest

from rosic.errors import ConfigurationError
from rosic.messengers.matrix.sealed_folder import KEY_FILE, SealedFolder

if TYPE_CHECKING:
    from pathlib import Path


def mode(path: Path) -> int:
    return stat.S_IMODE(path.stat().st_mode)


def test_nobody_else_may_look_into_it_however_it_was_made(tmp_path: Path) -> None:
    path = tmp_path / "matrix"
    path.mkdir(mode=0o755)
    (path / "sessions.db").write_bytes(b"")
    (path / "sessions.db").chmod(0o644)
    folder = SealedFolder(path)
    folder.open()
    folder.write("book.sealed", b"compared")
    assert mode(path) == 0o700
    assert {mode(file) for file in path.iterdir()} == {0o600}


def test_what_was_left_of_a_write_is_in_the_way_of_none(tmp_path: Path) -> None:
    folder = SealedFolder(tmp_path)
    folder.open()
    (tmp_path / "elsewhere").write_bytes(b"kept")
    (tmp_path / "book.new").symlink_to(tmp_path / "elsewhere")
    folder.write("book.sealed", b"compared")
    assert folder.read("book.sealed") == b"compared"
    assert (tmp_path / "elsewhere").read_bytes() == b"kept"
    assert mode(tmp_path / "book.sealed") == 0o600


def test_what_was_changed_is_refused(tmp_path: Path) -> None:
    folder = SealedFolder(tmp_path)
    folder.open()
    folder.write("book.sealed", b"compared")
    sealed = (tmp_path / "book.sealed").read_bytes()
    (tmp_path / "book.sealed").write_bytes(sealed[:-1] + bytes([sealed[-1] ^ 1]))
    with pytest.raises(ConfigurationError):
        folder.read("book.sealed")
    (tmp_path / KEY_FILE).write_bytes(b"short")
    with pytest.raises(ConfigurationError):
        SealedFolder(tmp_path).open()
