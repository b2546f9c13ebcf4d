"""Where lines come from and go to when there is no prompt: a pipe, a file, a plain terminal."""

from __future__ import annotations

import asyncio
import os
import re
import sys
from typing import TYPE_CHECKING, Protocol, Self

from rosic.errors import MessengerFault

if TYPE_CHECKING:
    from types import TracebackType

_BOLD, _DIM, _RED, _GREEN, _YELLOW, _CYAN = "1", "2", "1;31", "32", "33", "36"

# The markup of a terminal. Shown as a sign instead, a text can neither move the cursor nor change
# what stands above it.
_CONTROLS = dict.fromkeys((*range(32), *range(127, 160)), "�")
_CONTROLS |= {
    ord("\n"): "\n",
    ord("\t"): "\t",
    **{code: chr(0x2400 + code) for code in range(0x20) if chr(code) not in "\n\t"},
}

_LINE = re.compile(r"(?P<who>STOP(?: sent to)?|[^\s:\[][^:\n]{0,63}): (?P<what>.*)")
_CHOICE = re.compile(r"\[\d+\]")
_GOOD = ("done",)
_ODD = ("failed", "not ", "stopped before", "sent; ", "refused")


def harmless(text: str) -> str:
    """Return the text as a terminal may be given it: every character, no markup."""
    return text.translate(_CONTROLS)


def painted(text: str) -> str:
    """Return the text with colours: who in bold, a stop in red, how it ended in its colour."""
    return "\n".join([_line(line) for line in text.split("\n")])


def _line(line: str) -> str:
    if line.startswith("> "):
        return _in(_DIM, line)
    if line.lstrip().startswith("["):
        return _CHOICE.sub(lambda found: _in(_CYAN, found[0]), line)
    match = _LINE.match(line)
    if match is None:
        return line
    who, what = match["who"], match["what"]
    if who.startswith("STOP"):
        return f"{_in(_RED, who)}: {what}"
    if what.startswith(_GOOD):
        what = _in(_GREEN, what)
    elif what.startswith(_ODD):
        what = _in(_YELLOW, what)
    return f"{_in(_BOLD, who)}: {what}"


def _in(code: str, text: str) -> str:
    return f"\x1b[{code}m{text}\x1b[0m"


CHUNK_BYTES = 65_536
LONGEST_LINE_BYTES = 262_144
GONE = "The terminal is gone. The message was not shown."


class Interrupted(Exception):
    """Somebody pressed Ctrl-C; what they had typed so far is gone, and the next line is read."""


class Screen(Protocol):
    """One place to read lines from and to show texts in. Entered while somebody listens."""

    async def read(self) -> str | None:
        """Return the next line without its end, or None when there will be no more.

        Raises:
            Interrupted: Ctrl-C was pressed. It can be read on.
        """
        ...

    def show(self, text: str) -> None:
        """Show a text and end its line.

        Raises:
            MessengerFault: There is nobody to show it to.
        """
        ...

    def __enter__(self) -> Self: ...

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        at: TracebackType | None,
    ) -> None: ...


def write(text: str, *, colour: bool) -> None:
    """Write to standard output, whatever it is at this moment.

    Raises:
        MessengerFault: It is closed.
    """
    shown = harmless(text)
    try:
        print(painted(shown) if colour else shown, flush=True)  # noqa: T201 - this is what it is for
    except UnicodeEncodeError:
        print(shown.encode("ascii", "replace").decode(), flush=True)  # noqa: T201
    except (OSError, ValueError, AttributeError) as gone:
        raise MessengerFault(GONE) from gone


class PlainScreen:
    """Reads a descriptor line by line without a thread, writes standard output.

    Args:
        descriptor: What to read; None when standard input is closed.
        echo: Show each line that was read, so that a transcript of a script can be followed.
    """

    def __init__(self, descriptor: int | None, *, echo: bool, colour: bool) -> None:
        self._descriptor = descriptor
        self._echo = echo
        self._colour = colour
        self._pending = bytearray()
        self._over = descriptor is None

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        at: TracebackType | None,
    ) -> None:
        """Nothing to put back."""

    async def read(self) -> str | None:
        """Return the next line. Of a line longer than 256 KiB, the rest is thrown away."""
        while not self._over and b"\n" not in self._pending:
            chunk = await self._chunk()
            self._over = not chunk
            if b"\n" in chunk or len(self._pending) < LONGEST_LINE_BYTES:
                self._pending += chunk
        if not self._pending:
            return None
        line, _, rest = bytes(self._pending).partition(b"\n")
        self._pending = bytearray(rest)
        text = line[:LONGEST_LINE_BYTES].decode("utf-8", "replace").rstrip("\r")
        if self._echo and text.strip():
            self.show(f"> {text}")
        return text

    async def _chunk(self) -> bytes:
        descriptor = self._descriptor
        assert descriptor is not None  # noqa: S101 - `_over` says so
        loop = asyncio.get_running_loop()
        ready: asyncio.Future[None] = loop.create_future()
        try:
            loop.add_reader(descriptor, _resolve, ready)
        except PermissionError:
            # A file, or /dev/null: always ready, and epoll refuses to wait for it.
            await asyncio.sleep(0)
            return os.read(descriptor, CHUNK_BYTES)
        try:
            await ready
        finally:
            loop.remove_reader(descriptor)
        return os.read(descriptor, CHUNK_BYTES)

    def show(self, text: str) -> None:
        """Write a text."""
        write(text, colour=self._colour)


def _resolve(ready: asyncio.Future[None]) -> None:
    if not ready.done():
        ready.set_result(None)


def standard_input() -> int | None:
    """Return the descriptor of standard input, or None when it is closed."""
    try:
        return sys.stdin.fileno()
    except (AttributeError, ValueError, OSError):
        return None
