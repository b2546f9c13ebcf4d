"""The life of an order as people read it: accepted, sent, received, running, ended."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import lru_cache
from typing import TypeAlias, TypeVar

import msgspec

from rosic.core.i18n import Catalogue, in_language, joined, said
from rosic.core.order import OrderEnding, OrderStage, Outcome, StageReport
from rosic.core.units import in_units_of

Face: TypeAlias = Callable[[int], str]
"""Wall clock nanoseconds to what a clock on the wall shows: ``14:02:07``."""
BETWEEN = " · "

K = TypeVar("K")

# To look a member up in its class costs as much as three calls, and lives ask for every order.
RUNNING, UNKNOWN, REFUSED = OrderStage.RUNNING, OrderEnding.UNKNOWN, OrderEnding.REFUSED
_GOOD = frozenset((OrderEnding.DONE, OrderEnding.SENT))

_STEP = {
    OrderStage.ACCEPTED: said("accepted"),
    OrderStage.QUEUED: said("waiting its turn"),
    OrderStage.SENT: said("sent"),
    OrderStage.RECEIVED: said("received by the robot"),
}
_BRIEFLY = _STEP | {OrderStage.RECEIVED: said("received")}
_ENDED = {
    OrderEnding.DONE: said("done"),
    OrderEnding.FAILED: said("failed"),
    OrderEnding.CANCELLED: said("stopped before it ended"),
    OrderEnding.SENT: said("sent; this robot does not acknowledge"),
    OrderEnding.UNKNOWN: said("not known whether it was carried out"),
    OrderEnding.REFUSED: said("not done"),
}
_RUNNING = said("running")
_LOOK = said("Please look.")


SHOWN_PARTS = 4
"""Where nothing can be changed that was said, progress is said anew with each quarter."""


class StatusTexts(msgspec.Struct, frozen=True):
    """The words of lives in one language, plain, so that no life has to translate them.

    Attributes:
        catalogue: For what a robot or a refusal says.
    """

    catalogue: Catalogue | None
    step: Mapping[OrderStage, str]
    ended: Mapping[OrderEnding, str]
    running: str
    look: str


def ended_as(ending: str) -> str:
    """Return how an end reads, from its name on the record."""
    return _ENDED[OrderEnding(ending)]


@lru_cache(maxsize=32)
def wording_in(catalogue: Catalogue | None) -> StatusTexts:
    """Return the words in a language; None for English."""
    return StatusTexts(
        catalogue,
        {stage: in_language(word, catalogue) for stage, word in _STEP.items()},
        {ending: in_language(word, catalogue) for ending, word in _ENDED.items()},
        in_language(_RUNNING, catalogue),
        in_language(_LOOK, catalogue),
    )


ENGLISH = wording_in(None)


class OrderStatus:
    """One order's life, growing step by step; knows how it reads, not where.

    Attributes:
        where: The robot, as people read it.
        title: ``omni: move, 0.50 m left``.
        result: How its outcome reads, once there is one; shown from `end` on.
        good: It is done, or sent to a robot that does not acknowledge.
        words: In the language of whoever reads it.
    """

    __slots__ = (
        "_accepted_ns",
        "_ending",
        "_face",
        "_fraction",
        "_note",
        "_steps",
        "good",
        "result",
        "title",
        "where",
        "words",
    )

    def __init__(
        self, where: str, title: str, face: Face, at_ns: int, words: StatusTexts = ENGLISH
    ) -> None:
        self.where = where
        self.title = title
        self.words = words
        self._face = face
        self._accepted_ns = at_ns
        self._steps = ""
        self._fraction: float | None = None
        self._note = ""
        self._ending = self.result = ""
        self.good = False

    def step(self, report: StageReport, at_ns: int) -> bool:
        """Take a report in. Return whether a person would want to see it now."""
        stage = report.stage
        if stage is not RUNNING:
            word = f"{self.words.step[stage]} {self._face(at_ns)}"
            self._steps = f"{self._steps}{BETWEEN}{word}" if self._steps else word
            return True
        news = report.note != self._note or self._fraction is None
        self._note = report.note
        if report.fraction is not None:
            before, self._fraction = self._fraction or 0.0, report.fraction
            if report.fraction < before:
                self._fraction = before
            elif int(report.fraction * SHOWN_PARTS) > int(before * SHOWN_PARTS):
                news = True
        return news and bool(self.progress())  # what says neither what nor how far is no news

    def wording(self, outcome: Outcome, at_ns: int) -> str:
        """Take in its outcome. Return how it reads: ``done 14:02:13: object held``."""
        time_of_day, words = self._face(at_ns), self.words
        word = words.ended[outcome.ending]
        self.good = outcome.ending in _GOOD
        note = _noted(outcome.note, words.catalogue) if outcome.note else ""
        if outcome.ending is UNKNOWN:
            self.result = f"{word} ({time_of_day}). {note or words.look}"
        elif outcome.ending is REFUSED:
            self.result = note or word
        else:
            self.result = f"{word} {time_of_day}: {note}" if note else f"{word} {time_of_day}"
        return self.result

    def end(self, words: str) -> None:
        """The life is over; what comes later does not change it."""
        self._ending = self._ending or words

    def progress(self) -> str:
        """Return the running line: ``approaching 40 %``; empty before it runs."""
        if self._fraction is None and not self._note:
            return ""
        share = "" if self._fraction is None else f"{round(self._fraction * 100)} %"
        note = _noted(self._note, self.words.catalogue) if self._note else self.words.running
        return f"{note} {share}" if share else note

    @property
    def steps(self) -> tuple[str, ...]:
        """Return the steps so far, each with its time, for readers of any language."""
        parts = self._steps.split(BETWEEN) if self._steps else ()
        return tuple(_anew(part, self.words.step, _BRIEFLY) for part in parts)

    def now(self, *, briefly: bool = False) -> str:
        """Return how it ended, or else what runs, likewise; empty before it runs.

        Args:
            briefly: Without what is noted about its end: that may name somebody.
        """
        if self._ending and briefly:
            first = self._ending.partition(": ")[0].partition(". ")[0]
            return _anew(first, self.words.ended, _ENDED)
        if self._ending:
            return _anew(self._ending, self.words.ended, _ENDED)
        if self._fraction is None and not self._note:
            return ""
        share = "" if self._fraction is None else f" {round(self._fraction * 100)} %"
        return joined("", (self._note or _RUNNING, share))

    def text(self, *, ending: bool = True) -> str:
        """Return the whole life as one message, with or without how it ended."""
        # That it was accepted says nothing more once it was sent.
        steps = self._steps
        if not steps:
            steps = f"{self.words.step[OrderStage.ACCEPTED]} {self._face(self._accepted_ns)}"
        begun = f"{self.title}\n{steps}"
        if self._ending:
            return f"{begun}\n{self._ending}" if ending else begun
        progress = self.progress() if self._note or self._fraction is not None else ""
        return f"{begun} · {progress}" if progress else begun

    def line(self, report: StageReport) -> str:
        """Return one step as a line of its own, for a messenger that cannot edit."""
        if report.stage is OrderStage.ACCEPTED:
            return f"{self.title}: {self.words.step[OrderStage.ACCEPTED]}"
        if report.stage is OrderStage.RUNNING:
            return f"{self.where}: {self.progress()}"
        return f"{self.where}: {self.words.step[report.stage]}"


def _noted(note: str, catalogue: Catalogue | None) -> str:
    return in_units_of(in_language(note, catalogue), catalogue)


def _anew(text: str, told: Mapping[K, str], words: Mapping[K, str]) -> str:
    """Return what was told in one language so that it can be said in others: its first words."""
    for what, word in told.items():
        if text.startswith(word) and text[len(word) : len(word) + 1] in {" ", ""}:
            return joined("", (words[what], text[len(word) :]))
    return text
