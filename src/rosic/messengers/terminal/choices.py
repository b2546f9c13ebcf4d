"""Buttons in a terminal: numbered choices, and the number that taps one."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from rosic.core.message import Button, Outbound

# A button is good for 60 s. Until something else is said its number means nothing else for twice
# that, so that a number typed a moment too late never taps a button that has just been shown.
RESERVED_NS = 120_000_000_000
AT_MOST = 99
# Nobody has read and answered something else in so short a time.
TYPED_WITHIN_NS = 1_000_000_000


class Choice(NamedTuple):
    """A button that was shown.

    Attributes:
        message: The message it stood under.
        shown_ns: Monotonic clock.
    """

    button: Button
    message: str
    shown_ns: int


class Choices:
    """Numbers of the buttons that can still be tapped. Bounded: the oldest message goes first."""

    def __init__(self) -> None:
        self._shown: dict[int, Choice] = {}
        self._numbered = 0
        self._last = 0

    def show(self, message: str, outbound: Outbound, now_ns: int) -> str:
        """Number a message's buttons. Return the lines that show them; empty without buttons."""
        rows = []
        for row in outbound.buttons:
            labels = [f"[{self._number(b, message, now_ns)}] {b.label}" for b in row]
            rows.append(f"  {'  '.join(labels)}")
        return "\n".join(rows)

    def _number(self, button: Button, message: str, now_ns: int) -> int:
        for number, choice in list(self._shown.items()):
            if now_ns - choice.shown_ns > RESERVED_NS:
                del self._shown[number]
        if not self._shown:
            self._last = 0
        self._last = self._last % AT_MOST + 1
        self._numbered = max(self._numbered, self._last)
        self._shown.pop(self._last, None)
        self._shown[self._last] = Choice(button, message, now_ns)
        return self._last

    def retire(self, now_ns: int) -> None:
        """Let what was shown before be no choice any more: something else was said since.

        What is answered to that begins with 1 again, and no number on the screen above means it.
        What appeared while it was being typed stays a choice.
        """
        for number, choice in list(self._shown.items()):
            if now_ns - choice.shown_ns > TYPED_WITHIN_NS:
                del self._shown[number]
        if not self._shown:
            self._last = 0

    def take(self, text: str) -> Choice | None:
        """Return the button whose number was typed. Its neighbours are answered with it."""
        taken = self._shown.get(_number_in(text))
        if taken is not None:
            for number, choice in list(self._shown.items()):
                if choice.message == taken.message:
                    del self._shown[number]
        return taken

    def over(self, text: str) -> bool:
        """Whether a number is typed that once stood before a button, and is no choice any more."""
        number = _number_in(text)
        return 0 < number <= self._numbered and number not in self._shown


def _number_in(text: str) -> int:
    """Return the number that a line is; 0 for anything else."""
    word = text.strip()
    if word.isascii() and word.isdecimal() and len(word) <= len(str(AT_MOST)):
        return int(word)
    return 0
