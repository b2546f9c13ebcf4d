"""How much of the processor each step of an event loop takes, and what the step was.

Nothing else happens between two steps: a stop that arrives during one waits for its end. Time on
the processor is counted, not time that passed: others who use the machine lengthen no step.
"""

from __future__ import annotations

import asyncio
import gc
from contextlib import contextmanager
from time import thread_time_ns
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from contextvars import Context

PACE_ROUNDS = 3
PACE_COUNT = 200_000
PACE_NS = 7_000_000
"""What `pace_of_machine` takes for its work on the machine for which figures are promised."""


class LoopStep(NamedTuple):
    """One step of the loop.

    Attributes:
        cpu_ns: Time on the processor.
        what: The callback that ran, for a report.
    """

    cpu_ns: int
    what: str


class MeteredLoop(asyncio.SelectorEventLoop):
    """An event loop that remembers its longest step.

    Attributes:
        longest: Since `reset`.
    """

    def __init__(self) -> None:
        self.longest = LoopStep(0, "")
        super().__init__()

    def reset(self) -> None:
        """Begin anew."""
        self.longest = LoopStep(0, "")

    def call_soon(
        self, callback: Callable[..., object], *args: object, context: Context | None = None
    ) -> asyncio.Handle:
        """Metered."""
        return super().call_soon(self._metered, callback, *args, context=context)

    def call_soon_threadsafe(
        self, callback: Callable[..., object], *args: object, context: Context | None = None
    ) -> asyncio.Handle:
        """Metered."""
        return super().call_soon_threadsafe(self._metered, callback, *args, context=context)

    def call_at(
        self,
        when: float,
        callback: Callable[..., object],
        *args: object,
        context: Context | None = None,
    ) -> asyncio.TimerHandle:
        """Metered."""
        return super().call_at(when, self._metered, callback, *args, context=context)

    def _add_reader(
        self, fd: int, callback: Callable[..., object], *args: object
    ) -> asyncio.Handle:
        """Metered: what comes in over a connection is read and taken apart here."""
        return super()._add_reader(fd, self._metered, callback, *args)  # type: ignore[misc, no-any-return]

    def _metered(self, callback: Callable[..., object], *args: object) -> None:
        began_ns = thread_time_ns()
        try:
            callback(*args)
        finally:
            took_ns = thread_time_ns() - began_ns
            if took_ns > self.longest.cpu_ns:
                self.longest = LoopStep(took_ns, _named(callback))


def _named(callback: Callable[..., object]) -> str:
    owner = getattr(callback, "__self__", None)
    if isinstance(owner, asyncio.Task):
        return f"{owner.get_coro()!r}"
    return repr(callback)


@contextmanager
def undisturbed() -> Iterator[None]:
    """Leave what was made before alone while inside: looking for garbage in it is no step's own."""
    gc.collect()
    gc.freeze()
    try:
        yield
    finally:
        gc.unfreeze()


def pace_of_machine() -> float:
    """Return how many times longer this processor takes than the one figures are promised for.

    1.0 at least; of several tries the best counts.
    """
    return max(1.0, min(_work_ns() for _ in range(PACE_ROUNDS)) / PACE_NS)


def _work_ns() -> int:
    began_ns = thread_time_ns()
    seen: dict[int, str] = {}
    for number in range(PACE_COUNT // 10):
        seen[number % 997] = str(number).casefold().replace("1", "one")
    return thread_time_ns() - began_ns
