"""The life of an order as people read it: accepted, sent, received, running, ended."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

from rosic.core.order import Ending, Outcome, Report, Stage

Face: TypeAlias = Callable[[int], str]
"""Wall clock nanoseconds to what a clock on the wall shows: ``14:02:07``."""

STEP = {
    Stage.ACCEPTED: "accepted",
    Stage.QUEUED: "waiting its turn",
    Stage.SENT: "sent",
    Stage.RECEIVED: "received by the robot",
}
ENDED = {
    Ending.DONE: "done",
    Ending.FAILED: "failed",
    Ending.CANCELLED: "stopped before it ended",
    Ending.SENT: "sent; this robot does not acknowledge",
    Ending.UNKNOWN: "not known whether it was carried out",
    Ending.REFUSED: "not done",
}


class Life:
    """One order's life, growing step by step; knows how it reads, not where.

    Attributes:
        where: The robot, as people read it.
        title: ``omni: move, 0.50 m left``.
    """

    __slots__ = (
        "_accepted_ns", "_ending", "_face", "_fraction", "_note", "_steps", "title", "where",
    )  # fmt: skip

    def __init__(self, where: str, title: str, face: Face, at_ns: int) -> None:
        self.where = where
        self.title = title
        self._face = face
        self._accepted_ns = at_ns
        self._steps = ""
        self._fraction: float | None = None
        self._note = ""
        self._ending = ""

    def step(self, report: Report, at_ns: int) -> bool:
        """Take a report in. Return whether a person would want to see it now."""
        stage = report.stage
        if stage is not Stage.RUNNING:
            word = f"{STEP[stage]} {self._face(at_ns)}"
            self._steps = f"{self._steps} · {word}" if self._steps else word
            return True
        news = report.note != self._note or self._fraction is None
        self._note = report.note
        if report.fraction is not None:
            self._fraction = max(report.fraction, self._fraction or 0.0)
        return news

    def wording(self, outcome: Outcome, at_ns: int) -> str:
        """Return how an outcome reads; the life goes on."""
        return ended(outcome, self._face(at_ns))

    def end(self, words: str) -> None:
        """The life is over; what comes later does not change it."""
        self._ending = self._ending or words

    def progress(self) -> str:
        """Return the running line: ``approaching 40 %``; empty before it runs."""
        if self._fraction is None and not self._note:
            return ""
        share = "" if self._fraction is None else f"{round(self._fraction * 100)} %"
        return " ".join(part for part in (self._note or "running", share) if part)

    def text(self, *, ending: bool = True) -> str:
        """Return the whole life as one message, with or without how it ended."""
        # That it was accepted says nothing more once it was sent.
        steps = self._steps or f"{STEP[Stage.ACCEPTED]} {self._face(self._accepted_ns)}"
        begun = f"{self.title}\n{steps}"
        if self._ending:
            return f"{begun}\n{self._ending}" if ending else begun
        progress = self.progress() if self._note or self._fraction is not None else ""
        return f"{begun} · {progress}" if progress else begun

    def line(self, report: Report) -> str:
        """Return one step as a line of its own, for a messenger that cannot edit."""
        if report.stage is Stage.ACCEPTED:
            return f"{self.title}: accepted"
        if report.stage is Stage.RUNNING:
            return f"{self.where}: {self.progress()}"
        return f"{self.where}: {STEP[report.stage]}"


def ended(outcome: Outcome, time_of_day: str) -> str:
    """Return how an order ended: ``done 14:02:13: object held``."""
    word = ENDED[outcome.ending]
    if outcome.ending is Ending.UNKNOWN:
        return f"{word} ({time_of_day}). {outcome.note or 'Please look.'}"
    if outcome.ending is Ending.REFUSED:
        return outcome.note or word
    return f"{word} {time_of_day}: {outcome.note}" if outcome.note else f"{word} {time_of_day}"
