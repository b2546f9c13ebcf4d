"""What a bench leaves while it runs: how far it is, at which pace, and what it has seen so far.

A figure of one hour cannot be compared with one of another: the same commit gave 7,345 to 27,553
orders a second on one machine. So a calibration loop of fixed work is timed before and after each
turn of each case; a figure as a multiple of that time, its *pace*, can be compared.
"""

from __future__ import annotations

import hashlib
from contextlib import contextmanager
from datetime import UTC, datetime
from statistics import median
from time import perf_counter, perf_counter_ns, thread_time_ns
from typing import TYPE_CHECKING, Final, TextIO

import msgspec

from rosic import __version__
from rosic.bench.report import BenchCase, BenchReport, case_of, machine, versions

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator, Sequence

LOOPS: Final = 40
"""Together some 35 ms, so that a processor that is shared is seen to be: the system lets others
have it for some milliseconds at a time."""
ROUNDS: Final = 1_500
LINE_WIDTH: Final = 100
CLEARED: Final = "\r\x1b[K"  # to the beginning of the line, and nothing on it


def calibration_ns() -> int:
    """Return what one calibration loop takes now, in wall time: some 0.8 ms of a free processor.

    It does what a gateway does: it makes small objects, looks them up, formats and hashes texts.
    """
    begun_ns = perf_counter_ns()
    seen: dict[str, tuple[int, bytes]] = {}
    for number in range(ROUNDS):
        name = f"robot{number % 97}:{number}"
        seen[name] = (number, hashlib.blake2b(name.encode(), digest_size=16).digest())
    sorted(seen.values())
    return perf_counter_ns() - begun_ns


def pace_us() -> float:
    """Return what a calibration loop takes now, on average of `LOOPS`, in microseconds."""
    return sum(calibration_ns() for _ in range(LOOPS)) / LOOPS / 1e3


PROMISED_ROUNDS: Final = 3
PROMISED_COUNT: Final = 20_000
PROMISED_NS: Final = 7_000_000
"""What the work of `pace_of_machine` takes on the machine for which figures are promised."""


def pace_of_machine() -> float:
    """Return how many times longer this processor takes than the one figures are promised for.

    1.0 at least; of several tries the best counts, and processor time: not what others use.
    """
    return max(1.0, min(_promised_ns() for _ in range(PROMISED_ROUNDS)) / PROMISED_NS)


def _promised_ns() -> int:
    began_ns = thread_time_ns()
    seen: dict[int, str] = {}
    for number in range(PROMISED_COUNT):
        seen[number % 997] = str(number).casefold().replace("1", "one")
    return thread_time_ns() - began_ns


class BenchTurn:
    """One turn of one case.

    Args:
        pace_us: What the calibration loop takes at its beginning.

    Attributes:
        pace_us: What the calibration loop takes beside it; known once the turn is over.
    """

    def __init__(self, pace_us: float) -> None:
        self.pace_us = pace_us
        self.seen: tuple[float, Sequence[float]] | None = None

    def saw(self, rate_per_s: float, times_ns: Sequence[float]) -> None:
        """Keep what the turn came to: it counts even if the bench is interrupted later."""
        self.seen = (rate_per_s, times_ns)

    def beside(self, times_ns: Sequence[float], rate_per_s: float) -> BenchTurn:
        """Return a turn of the same moment that saw these times."""
        turn = BenchTurn(self.pace_us)
        turn.saw(rate_per_s or len(times_ns) / (sum(times_ns) / 1e9), times_ns)
        return turn

    def end(self) -> None:
        """Time the calibration loop once more; the pace is between both times."""
        self.pace_us = (self.pace_us + pace_us()) / 2


class BenchRecorder:
    """Records a bench while it runs.

    Args:
        bench: Its name.
        quick: It shall be one short run of each case.
        progress: A terminal that shows which case runs; left out, nothing is said.
    """

    def __init__(self, bench: str, *, quick: bool = False, progress: TextIO | None = None) -> None:
        self.bench = bench
        self.quick = quick
        self._progress = progress
        self._turns: dict[str, list[BenchTurn]] = {}
        self._begun_s = perf_counter()
        self._started = datetime.now(UTC)
        self._paces_us = [pace_us()]
        self._so_far: Callable[[], BenchReport] | None = None
        self._seen: list[BenchCase] = []

    @contextmanager
    def turn(self, case: str, *, of: int = 0) -> Iterator[BenchTurn]:
        """Time the calibration loop beside a turn of a case.

        One that was cut short counts where it has said what it saw.

        Args:
            case: Its name.
            of: How many turns it shall have, where that is known: for the progress alone.
        """
        turns = self._turns.setdefault(case, [])
        self._tell(case, len(turns) + 1, of)
        turn = BenchTurn(pace_us())
        whole = False
        try:
            yield turn
            whole = True
        finally:
            if whole or turn.seen is not None:
                turn.end()
                turns.append(turn)
                self._paces_us.append(turn.pace_us)

    def keep(
        self, case: str, *, like: str, times_ns: Sequence[float], rate_per_s: float = 0.0
    ) -> None:
        """Keep times that were seen in the turns of another case, as a turn of their own.

        Args:
            case: Its name.
            like: The case in whose turns they were seen: its pace is theirs.
            times_ns: Of each.
            rate_per_s: How many a second there were; 0: they came one after another.
        """
        turns = self._turns.setdefault(case, [])
        turns.append(self._turns[like][len(turns)].beside(times_ns, rate_per_s))

    def see(self, cases: Iterable[BenchCase]) -> list[BenchCase]:
        """Return cases that are measured whole; they count even if the bench is interrupted."""
        found = [self._paced(case) for case in cases]
        self._seen += found
        return found

    def paces_us(self, case: str) -> list[float]:
        """Return what the calibration loop took beside each turn of a case so far."""
        return [turn.pace_us for turn in self._turns.get(case, ())]

    def case(self, name: str, *, tails: bool = False) -> BenchCase:
        """Return what was seen in the turns of a case.

        Raises:
            KeyError: It had none that saw anything.
        """
        turns = [turn for turn in self._turns[name] if turn.seen is not None]
        if not turns:
            raise KeyError(name)
        seen = [turn.seen for turn in turns if turn.seen is not None]
        return case_of(name, seen, [turn.pace_us for turn in turns], tails=tails)

    def cases(self, *, tails: bool = False) -> tuple[BenchCase, ...]:
        """Return every case whose turns saw something, in the order in which they began."""
        return tuple(
            self.case(name, tails=tails)
            for name, turns in self._turns.items()
            if any(turn.seen is not None for turn in turns)
        )

    def finished(self, report: BenchReport) -> BenchReport:
        """Return a report with when, of what and at which pace it was measured."""
        self._clear()
        return msgspec.structs.replace(
            report,
            cases=tuple(map(self._paced, report.cases)),
            bench=self.bench,
            version=__version__,
            versions=versions(),
            started=self._started.isoformat(timespec="seconds"),
            took_s=round(perf_counter() - self._begun_s, 1),
            pace_us=round(median([*self._paces_us, pace_us()]), 2),
        )

    def report_by(self, so_far: Callable[[], BenchReport]) -> None:
        """Let this make the report of what was seen, where the bench does not come to its end."""
        self._so_far = so_far

    def partial(self, why: str) -> BenchReport:
        """Return what was seen until now, and why there is no more."""
        if self._so_far is not None:
            found = self._so_far()
            failures = (*found.failures, why)
            return self.finished(msgspec.structs.replace(found, failures=failures))
        return self.finished(
            BenchReport(
                machine=machine(),
                method="What was measured before it ended.",
                cases=(*self.cases(tails=True), *self._seen),
                failures=(why,),
            )
        )

    def _paced(self, case: BenchCase) -> BenchCase:
        """Return a case with its pace: of its turns, or of those whose name its own begins with."""
        if case.pace_us is not None:
            return case
        names = [name for name in self._turns if case.name.startswith(name)]
        paces = self.paces_us(max(names, key=len)) if names else self._paces_us
        return msgspec.structs.replace(case, pace_us=round(median(paces or self._paces_us), 2))

    def _tell(self, case: str, turn: int, of: int) -> None:
        if self._progress is None:
            return
        so_far_s = perf_counter() - self._begun_s
        which = f" ({turn} of {of})" if of else ""
        line = f"{self.bench} {so_far_s:5.0f} s: {case}{which}"[:LINE_WIDTH]
        self._progress.write(f"{CLEARED}{line}")
        self._progress.flush()

    def _clear(self) -> None:
        if self._progress is not None:
            self._progress.write(CLEARED)
            self._progress.flush()
