"""Environments of other chat bots: one for each, made when it is first measured.

Nothing of them is installed beside ROSIC: their requirements contradict each other's and its own.
"""

from __future__ import annotations

import fcntl
import os
import subprocess
import sys
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Final, NamedTuple

from rosic.errors import ConfigurationError

if TYPE_CHECKING:
    from collections.abc import Iterator

SCRIPT: Final = Path(__file__).with_name("peer_process.py")
WITHIN_S: Final = 1_200.0
INSTALLED: Final = "installed.txt"
NOT_THERE: Final = "{name} is not installed."
FAILED: Final = "{name} could not be installed: {why}"
UVLOOP: Final = "uvloop==0.23.0"


class Peer(NamedTuple):
    """Another chat bot.

    Attributes:
        name: Of its distribution.
        requirements: What pip is asked for, with versions.
        script: Runs it; see `rosic.bench.peer_process`.
    """

    name: str
    requirements: tuple[str, ...]
    script: Path = SCRIPT


# opsdroid 0.31.0 asks for pkg_resources, which setuptools has no more, and does not say so; the
# back end in memory of errbot needs pytest.
OPSDROID: Final = Peer("opsdroid", ("opsdroid==0.31.0", "setuptools==80.9.0", UVLOOP))
ERRBOT: Final = Peer("errbot", ("errbot==6.2.1", "pytest==9.0.0"))
PTB: Final = Peer("python-telegram-bot", ("python-telegram-bot==22.8", UVLOOP))
AIOGRAM: Final = Peer("aiogram", ("aiogram==3.31.0", UVLOOP))


def default_folder() -> Path:
    """Return where environments are kept: in the user's cache."""
    home = os.environ.get("XDG_CACHE_HOME") or str(Path.home() / ".cache")
    return Path(home) / "rosic" / "peers"


def interpreter(peer: Peer, folder: Path, *, install: bool) -> Path:
    """Return the Python of a peer's environment, and make that unless it is there.

    Args:
        peer: Which one.
        folder: Where environments are kept; several processes may ask at once.
        install: Make it; else it has to be there.

    Raises:
        ConfigurationError: It is not there, or cannot be made; says pip's last words.
    """
    version = f"{sys.version_info.major}.{sys.version_info.minor}"
    environment = folder / f"{peer.name}-python{version}"
    python, mark = environment / "bin" / "python", environment / INSTALLED
    wanted = "\n".join(peer.requirements) + "\n"
    if _is_made(mark, wanted):
        return python
    if not install:
        raise ConfigurationError(NOT_THERE.format(name=peer.name))
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with _lock(folder / f"{peer.name}.lock"):
            if not _is_made(mark, wanted):
                _make(peer, environment, python)
                mark.write_text(wanted, encoding="utf-8")
    except OSError as trouble:
        why = f"{trouble.strerror}: {trouble.filename}"
        raise ConfigurationError(FAILED.format(name=peer.name, why=why)) from trouble
    return python


def _is_made(mark: Path, wanted: str) -> bool:
    return mark.is_file() and mark.read_text(encoding="utf-8") == wanted


@contextmanager
def _lock(path: Path) -> Iterator[None]:
    """Hold a lock that ends with the process, however it ends."""
    with path.open("w") as file:
        fcntl.flock(file, fcntl.LOCK_EX)
        yield


def _make(peer: Peer, environment: Path, python: Path) -> None:
    bare = () if peer.requirements else ("--without-pip",)
    _run(peer, sys.executable, "-m", "venv", "--clear", *bare, environment)
    if peer.requirements:
        pip = (python, "-m", "pip", "install", "--quiet", "--disable-pip-version-check")
        _run(peer, *pip, *peer.requirements)


def _run(peer: Peer, *command: str | Path) -> None:
    """Run a command that makes an environment.

    Raises:
        ConfigurationError: It failed, or took too long.
    """
    try:
        ran = subprocess.run(  # noqa: S603 - our own command
            command,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            timeout=WITHIN_S,
            check=False,
        )
    except subprocess.TimeoutExpired as trouble:
        why = f"it took longer than {WITHIN_S:.0f} s."
        raise ConfigurationError(FAILED.format(name=peer.name, why=why)) from trouble
    if ran.returncode:
        why = last_line(ran.stdout) or f"exit status {ran.returncode}"
        raise ConfigurationError(FAILED.format(name=peer.name, why=why))


def last_line(said: bytes) -> str:
    """Return the last line that says anything; empty where none does."""
    lines = said.decode(errors="replace").strip().splitlines()
    return lines[-1].strip() if lines else ""
