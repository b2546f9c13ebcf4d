"""A bench that is interrupted as soon as it has seen something, as by Ctrl-C."""

from __future__ import annotations

import os
import signal
import time
from contextlib import contextmanager, suppress
from threading import Thread
from typing import TYPE_CHECKING

from rosic.bench.command import BENCHES
from rosic.bench.recorder import BenchRecorder

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator

    from rosic.bench.recorder import BenchTurn
    from rosic.bench.report import BenchCase, BenchReport


class InterruptedRecorder(BenchRecorder):
    """Interrupts its bench once something has been seen."""

    def see(self, cases: Iterable[BenchCase]) -> list[BenchCase]:
        super().see(cases)
        raise KeyboardInterrupt

    @contextmanager
    def turn(self, case: str, *, of: int = 0) -> Iterator[BenchTurn]:
        with super().turn(case, of=of) as turn:
            yield turn
        if turn.seen is not None:
            raise KeyboardInterrupt

    def report_by(self, so_far: Callable[[], BenchReport]) -> None:
        super().report_by(so_far)
        Thread(target=_interrupt_once, args=(so_far,), daemon=True).start()


def _interrupt_once(so_far: Callable[[], BenchReport]) -> None:
    """Interrupt the process once there are cases."""
    while True:
        with suppress(RuntimeError):  # while one is taken in
            if so_far().cases:
                os.kill(os.getpid(), signal.SIGINT)
                return
        time.sleep(0.01)


def cases_kept(name: str) -> list[str]:
    """Run a short bench until it is interrupted; return which cases its report has.

    Raises:
        AssertionError: It came to its end.
    """
    recorder = InterruptedRecorder(name, quick=True)
    try:
        BENCHES[name].measure(name, recorder, {})
    except KeyboardInterrupt:
        return [case.name for case in recorder.partial("It was interrupted.").cases]
    raise AssertionError(f"{name} came to its end")
