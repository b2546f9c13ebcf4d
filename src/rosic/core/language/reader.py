"""Reading with a memory: people repeat themselves, and buttons always say the same.

Recognising a stop and understanding are pure, so what was read once need not be read again. The
memory is bounded and thrown away whole; a text it does not hold costs one look-up more.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosic.core.language.grammar import understand
from rosic.core.language.lines import Context
from rosic.core.language.stopping import hears_stop

if TYPE_CHECKING:
    from rosic.core.language.lines import Line
    from rosic.core.language.vocabulary import Vocabulary
    from rosic.core.robot import RobotId

REMEMBERED = 8_192
LONGEST_REMEMBERED = 200


class Reader:
    """`hears_stop` and `understand` over one vocabulary."""

    __slots__ = ("_lines", "_stops", "vocabulary")

    def __init__(self, vocabulary: Vocabulary) -> None:
        self.vocabulary = vocabulary
        self._stops: dict[str, tuple[str, ...] | None] = {}
        self._lines: dict[tuple[str, str, frozenset[RobotId]], tuple[Line, ...]] = {}

    def stop(self, text: str) -> tuple[str, ...] | None:
        """Return what `hears_stop` does."""
        stops = self._stops
        if text in stops:
            return stops[text]
        heard = hears_stop(text, self.vocabulary.known)
        if len(text) <= LONGEST_REMEMBERED:
            if len(stops) >= REMEMBERED:
                stops.clear()
            stops[text] = heard
        return heard

    def forget(self) -> None:
        """Read everything anew from now on: the vocabulary has changed."""
        self._stops.clear()
        self._lines.clear()

    def lines(self, text: str, selected: str, visible: frozenset[RobotId]) -> tuple[Line, ...]:
        """Return what `understand` does for somebody who sees and chose this."""
        key = (text, selected, visible)
        read = self._lines.get(key)
        if read is None:
            read = understand(text, self.vocabulary, Context(selected, visible))
            if len(text) <= LONGEST_REMEMBERED:
                if len(self._lines) >= REMEMBERED:
                    self._lines.clear()
                self._lines[key] = read
        return read
