"""Install what a file of requirements names, then ROSIC itself, and show how far that is.

    python -m tests.install core    run by make, with the Python of the environment

In a terminal one line counts the packages; anywhere else, as in a log, nothing but the first line
is written. Pip's warnings and errors are shown as they are.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
import threading
from pathlib import Path
from typing import TYPE_CHECKING, Final, TextIO

if TYPE_CHECKING:
    from collections.abc import Iterable

REQUIREMENTS: Final = Path(__file__).parents[1] / "requirements"
# Unbuffered, or it would be told late how far that is.
PIP: Final = (sys.executable, "-u", "-m", "pip", "install")
LASTS: Final = {"core": "about a minute", "dev": "a minute or two"}
_PINNED: Final = re.compile(r"^[A-Za-z0-9][\w.-]*==", re.MULTILINE)
_FOUND: Final = ("Collecting ", "Processing ", "Requirement already satisfied: ")
_ANOTHER_PLATFORM: Final = "Ignoring "
_IN_PLACE: Final = "Installing collected packages"


class Progress:
    """Tells how far an installation is, by what pip prints."""

    def __init__(self, packages: int, out: TextIO) -> None:
        self._packages = packages
        self._found = 0
        self._out = out
        self._shown = 0
        self._writing = threading.Lock()

    def follow(self, lines: Iterable[str]) -> None:
        """Take in what pip prints, line by line."""
        for line in lines:
            if line.startswith(_ANOTHER_PLATFORM):
                self._packages -= 1
            elif line.startswith(_FOUND):
                self._found += 1
                self.show(
                    f"{min(self._found, self._packages)} of {self._packages} packages fetched"
                )
            elif line.startswith(_IN_PLACE):
                self.show(f"putting {self._found} packages in place")

    def warn(self, lines: Iterable[str]) -> None:
        """Pass on what pip warns of, on lines of its own."""
        for line in lines:
            with self._writing:
                self._write("")
                sys.stderr.write(line)
                sys.stderr.flush()

    def show(self, text: str) -> None:
        """Write over what was shown before; in a terminal alone."""
        with self._writing:
            self._write(text)

    def _write(self, text: str) -> None:
        if self._out.isatty():
            self._out.write(f"\r{' ' * self._shown}\r{text}")
            self._out.flush()
            self._shown = len(text)


def pip(progress: Progress, *arguments: str) -> int:
    """Run one installation; return pip's exit status."""
    command = [*PIP, "--progress-bar", "off", *arguments]
    process = subprocess.Popen(  # noqa: S603 - the Python that runs this
        command,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    assert process.stdout is not None
    assert process.stderr is not None
    with process:
        warnings = threading.Thread(target=progress.warn, args=(process.stderr,))
        warnings.start()
        progress.follow(process.stdout)
        warnings.join()
    return process.returncode


def install(size: str, out: TextIO) -> int:
    """Install one of the two sizes of the environment; return an exit status."""
    required = REQUIREMENTS / f"{size}.txt"
    packages = len(_PINNED.findall(required.read_text(encoding="utf-8")))
    where = os.path.relpath(sys.prefix)
    out.write(
        f"Installing {packages} packages of requirements/{size}.txt into {where}: "
        f"{LASTS[size]}, once.\n"
    )
    out.flush()
    progress = Progress(packages, out)
    # Hashes hold for everything that comes from outside. The project itself is then built with
    # what was just installed.
    progress.show("asking for them")
    failed = pip(progress, "--require-hashes", "--requirement", str(required))
    if not failed:
        progress.show("building ROSIC itself")
        itself = ("--quiet", "--no-deps", "--no-build-isolation", "--editable", ".")
        failed = pip(progress, *itself)
    progress.show("")
    return failed


if __name__ == "__main__":
    sys.exit(install(sys.argv[1], sys.stdout))
