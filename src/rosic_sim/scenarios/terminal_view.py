"""How a play looks in a terminal: who says what, and what each of them is told."""

from __future__ import annotations

import sys
import textwrap
from typing import TYPE_CHECKING, Final

from rosic.messengers.terminal.screen import harmless, painted

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from rosic.core.message import Outbound

WIDTH: Final = 100
LEAST: Final = 20
MARGIN: Final = "    "
COLOURS: Final = ("1;36", "1;35", "1;33", "1;34", "1;32")
DIM: Final = "2"
BOLD: Final = "1"


class TerminalView:
    """Writes a play, line by line.

    Args:
        people: Names in the order of their colours.
        colour: Whether there are any.
        now_s: Seconds since the play began.
        columns: Of the terminal; 0: lines are as long as they are.

    Attributes:
        now_s: The same.
    """

    def __init__(
        self, people: Iterable[str], now_s: Callable[[], float], *, colour: bool, columns: int = 0
    ) -> None:
        self._colour = colour
        self._columns = columns
        self.now_s = now_s
        self._colours = {name: COLOURS[at % len(COLOURS)] for at, name in enumerate(people)}
        self._told = ""

    def title(self, text: str) -> None:
        """Write a heading."""
        self._write(f"\n{self._in(BOLD, text)}")

    def aside(self, text: str) -> None:
        """Write what an onlooker would say."""
        self._told = ""
        lines = textwrap.wrap(text, min(self._columns or WIDTH, WIDTH) - 2)
        self._write("\n" + "\n".join(self._in(DIM, f"  {line}") for line in lines))

    def says(self, who: str, text: str) -> None:
        """Write what a person types or taps."""
        self._told = ""
        at = self._in(DIM, f"{self.now_s():5.1f} s")
        self._write(f"\n{at}  {self._name(who)} {self._in(BOLD, '>')} {harmless(text)}")

    def told(self, who: str, outbound: Outbound) -> None:
        """Write what a person reads."""
        lines = harmless(outbound.text).split("\n")
        buttons = "  ".join(f"[ {b.label} ]" for row in outbound.buttons for b in row)
        if outbound.attachment is not None:
            size = len(outbound.attachment.content) / 1000
            lines.append(f"({outbound.attachment.name}, {size:.0f} kB)")
        shown = [self._folded(line) for line in filter(None, (*lines, harmless(buttons)))]
        text = "\n".join(shown)
        head = "" if who == self._told else f"{self._name(who)} {self._in(DIM, 'reads')}\n"
        self._told = who
        self._write(textwrap.indent(head, MARGIN * 2) + textwrap.indent(text, MARGIN * 3))

    def plain(self, text: str) -> None:
        """Write as it is."""
        self._told = ""
        lines = harmless(text).split("\n")
        self._write("\n".join("\n".join(self._fold(line, self._columns)) for line in lines))

    def _folded(self, line: str) -> str:
        first, *more = self._fold(line, self._columns - len(MARGIN) * 3)
        return "\n".join((painted(first) if self._colour else first, *more))

    def _fold(self, line: str, columns: int) -> list[str]:
        """Break a line between words, where it is longer than the terminal is wide."""
        if not self._columns or len(line) < columns:
            return [line]
        return textwrap.wrap(
            line,
            max(columns - 1, LEAST),
            subsequent_indent="  ",
            break_long_words=False,
            break_on_hyphens=False,
            replace_whitespace=False,
        )

    def _name(self, who: str) -> str:
        return self._in(self._colours.get(who, BOLD), who)

    def _in(self, code: str, text: str) -> str:
        return f"\x1b[{code}m{text}\x1b[0m" if self._colour else text

    def _write(self, text: str) -> None:
        encoding = sys.stdout.encoding or "ascii"
        shown = text.encode(encoding, "replace").decode(encoding)
        print(shown, flush=True)  # noqa: T201 - this is what it is for
