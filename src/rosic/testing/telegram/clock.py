"""The server's own time: the machine's, moved forwards or backwards by a test."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable


class ServerClock:
    """Wall time of the pretended Telegram.

    Args:
        wall_s: Unix time in seconds, with a fraction.
        shift_s: How far this server is ahead of it.
    """

    def __init__(self, wall_s: Callable[[], float], shift_s: float = 0.0) -> None:
        self._wall_s = wall_s
        self.shift_s = shift_s
        self.date_shift_s = 0.0

    def now_s(self) -> float:
        """Return the server's time in seconds; retention and limits run on it."""
        return self._wall_s() + self.shift_s

    def date(self) -> int:
        """Return the date that Telegram puts on a message now, in whole seconds."""
        return int(self.now_s() + self.date_shift_s)

    def advance(self, seconds: float) -> None:
        """Move the server's time, backwards too. Waiting polls keep waiting."""
        self.shift_s += seconds
