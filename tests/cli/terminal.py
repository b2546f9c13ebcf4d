"""A program at a terminal of its own, as a person sits in front of it."""

from __future__ import annotations

import os
import pty
import select
import subprocess
import time
from contextlib import contextmanager
from typing import TYPE_CHECKING

from tests.cli.running import environment
from tests.cli.warm import Warmed
from tests.pace import pace

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence
    from pathlib import Path


class Terminal:
    """What a program has shown so far, and what is typed to it.

    Attributes:
        shown: Everything so far.
        process: The program.
    """

    def __init__(
        self, ours: int, process: Warmed | subprocess.Popen[bytes], log: Path | None
    ) -> None:
        self._ours = ours
        self._log = log
        self.process = process
        self.shown = ""

    def wait_for(self, text: str, within_s: float = 60) -> None:
        end_s = time.monotonic() + within_s * pace()
        while text not in self.shown:
            assert time.monotonic() < end_s, f"no {text!r}: {self.shown}{self.log()}"
            ended = self.process.poll() is not None
            self.look(0.1)
            assert not ended or text in self.shown, f"ended without {text!r}: {self.shown}"

    def type(self, line: str, end: str = "\r") -> None:
        os.write(self._ours, f"{line}{end}".encode())

    def look(self, wait_s: float = 0.0) -> None:
        """Take over what is shown by now."""
        if select.select([self._ours], [], [], wait_s)[0]:
            try:
                self.shown += os.read(self._ours, 65_536).decode(errors="replace")
            except OSError:  # the program has ended and nobody holds the other side
                time.sleep(wait_s)

    def ended(self, within_s: float = 120) -> int:
        """Wait for the end; return the exit status."""
        end_s = time.monotonic() + within_s * pace()
        while (status := self.process.poll()) is None:
            assert time.monotonic() < end_s, self.shown
            self.look(0.1)
        self.look(0.1)
        return status

    def log(self) -> str:
        """Return what went to standard error, where that is a file."""
        return "" if self._log is None else self._log.read_text()

    def end(self) -> None:
        """Ask the program to end, and see that it does."""
        self.process.terminate()
        try:
            self.process.wait(60)
        finally:
            self.process.kill()
            os.close(self._ours)


def rosic_run(config: Path, env: Mapping[str, str] | None = None, *, types: bool) -> Terminal:
    """Start ``rosic run``; its log goes to a file, and its input is the terminal or nothing."""
    ours, theirs = pty.openpty()
    log = config.with_suffix(".err")
    with log.open("w") as err, open(os.devnull) as nobody:  # noqa: PTH123 - no path of ours
        files = (theirs if types else nobody.fileno(), theirs, err.fileno())
        process = Warmed(["run", "-c", str(config)], files, None, environment(env))
    os.close(theirs)
    return Terminal(ours, process, log)


@contextmanager
def rosic_at(words: Sequence[str], folder: Path) -> Iterator[Terminal]:
    """Let a command of rosic run while inside, all of it at the terminal."""
    ours, theirs = pty.openpty()
    process = Warmed(words, (theirs, theirs, theirs), folder, environment())
    os.close(theirs)
    opened = Terminal(ours, process, None)
    try:
        yield opened
    finally:
        opened.end()


@contextmanager
def shell_at(command: Sequence[str], folder: Path, prompt: str) -> Iterator[Terminal]:
    """Let somebody's shell run while inside; it is ready when it shows its prompt."""
    ours, theirs = pty.openpty()
    process = subprocess.Popen(  # noqa: S603 - a shell that a test has found
        command,
        stdin=theirs,
        stdout=theirs,
        stderr=theirs,
        cwd=folder,
        start_new_session=True,
        env=environment({"HOME": str(folder), "TERM": "dumb", "PS1": prompt}),
    )
    os.close(theirs)
    opened = Terminal(ours, process, None)
    try:
        opened.wait_for(prompt)
        yield opened
    finally:
        process.kill()
        opened.end()
