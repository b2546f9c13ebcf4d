"""`rosic init` at a real terminal does not show the token."""

from __future__ import annotations

import os
import pty
import select
import sys
import time
from typing import TYPE_CHECKING

from tests.cli.running import environment
from tests.pace import pace

if TYPE_CHECKING:
    from pathlib import Path

TOKEN = "4242424242:AAabcdefghijklmnopqrstuvwxyz012345"  # noqa: S105 - nobody's
INIT = (
    "-m",
    "rosic",
    "init",
    "--name",
    "lab",
    "--zone",
    "UTC",
    "--robot",
    "omni",
    "--link",
    "simulated",
    "--admin",
    "code",
)


def _said(terminal: int, until: str) -> str:
    said, end_s = "", time.monotonic() + 60 * pace()
    while until not in said:
        assert time.monotonic() < end_s, said
        if select.select([terminal], [], [], 0.1)[0]:
            try:
                said += os.read(terminal, 4096).decode()
            except OSError:
                break
    return said


def test_the_token_is_not_shown(tmp_path: Path) -> None:
    process, terminal = pty.fork()
    if not process:
        os.chdir(tmp_path)
        os.execve(sys.executable, [sys.executable, *INIT], environment())  # noqa: S606 - ours
    try:
        said = _said(terminal, "leave empty to try without):")
        assert "Nothing is shown while you type" in said
        os.write(terminal, f"{TOKEN}\n".encode())
        said += _said(terminal, "Start with: rosic run")
    finally:
        os.close(terminal)
        os.waitpid(process, 0)
    assert TOKEN not in said
    assert TOKEN in (tmp_path / "telegram-token.txt").read_text()
