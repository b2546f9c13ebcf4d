"""Reading with a memory: people repeat themselves, and buttons always say the same.

Recognising a stop and understanding are pure, so what was read once need not be read again. The
memory is bounded and thrown away whole; a text it does not hold costs one look-up more.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosic.core.language.ast import Cancel, Halt, LineContext
from rosic.core.language.cancelling import hears_cancel
from rosic.core.language.parser import understand
from rosic.core.language.stop_detection import hears_stop

if TYPE_CHECKING:
    from rosic.core.language.ast import Line
    from rosic.core.language.vocabulary import Vocabulary
    from rosic.core.robot.profile import RobotId

REMEMBERED = 8_192
LONGEST_REMEMBERED = 200


class LanguageReader:
    """`hears_stop`, `hears_cancel` and `understand` over one vocabulary."""

    __slots__ = ("_lines", "_urgent", "vocabulary")

    def __init__(self, vocabulary: Vocabulary) -> None:
        self.vocabulary = vocabulary
        self._urgent: dict[str, Halt | Cancel | None] = {}
        self._lines: dict[tuple[str, str, frozenset[RobotId]], tuple[Line, ...]] = {}

    def urgent(self, text: str) -> Halt | Cancel | None:
        """Return what a text stops or ends before anything else is read; None for nothing."""
        known = self._urgent
        if text in known:
            return known[text]
        heard = self._heard(text)
        if len(text) <= LONGEST_REMEMBERED:
            if len(known) >= REMEMBERED:
                known.clear()
            known[text] = heard
        return heard

    def _heard(self, text: str) -> Halt | Cancel | None:
        names = hears_stop(text, self.vocabulary.known)
        if names is not None:
            return Halt(names)
        names = hears_cancel(text, self.vocabulary.known)
        return None if names is None else Cancel(names)

    def forget(self) -> None:
        """Read everything anew from now on: the vocabulary has changed."""
        self._urgent.clear()
        self._lines.clear()

    def lines(self, text: str, selected: str, visible: frozenset[RobotId]) -> tuple[Line, ...]:
        """Return what `understand` does for somebody who sees and chose this."""
        key = (text, selected, visible)
        read = self._lines.get(key)
        if read is None:
            read = understand(text, self.vocabulary, LineContext(selected, visible))
            if len(text) <= LONGEST_REMEMBERED:
                if len(self._lines) >= REMEMBERED:
                    self._lines.clear()
                self._lines[key] = read
        return read
