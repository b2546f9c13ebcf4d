"""Time and chance that a test owns."""

from __future__ import annotations

import asyncio
import heapq
from hashlib import blake2b
from itertools import count

SETTLE_TURNS = 20
IDLE_TURNS = 2
START_WALL_NS = 1_700_000_000_000_000_000


class ManualClock:
    """Both clocks stand still until ``advance``; sleepers wake in order, each at its own time.

    ``suspend`` is a machine that sleeps: the clocks run on and sleepers do not. A virtual machine
    that was paused is ``jump_wall``: afterwards the wall clock is set right and no other.
    """

    def __init__(self, wall_ns: int = START_WALL_NS) -> None:
        self._wall_ns = wall_ns
        self._loop_ns = 1_000_000_000  # what the event loop goes by: stands still in suspend
        self._suspended_ns = 0
        self._sleepers: list[tuple[int, int, asyncio.Future[None]]] = []
        self._order = count()

    def wall_ns(self) -> int:
        """Return the wall clock."""
        return self._wall_ns

    def monotonic_ns(self) -> int:
        """Return the monotonic clock."""
        return self._loop_ns + self._suspended_ns

    def jump_wall(self, seconds: float) -> None:
        """Set the wall clock forward or back; the monotonic one does not notice."""
        self._wall_ns += int(seconds * 1e9)

    def suspend(self, seconds: float) -> None:
        """Let the machine sleep: both clocks run on, and nobody's waiting becomes shorter."""
        self._suspended_ns += int(seconds * 1e9)
        self._wall_ns += int(seconds * 1e9)

    async def sleep(self, seconds: float) -> None:
        """Wait until the test has advanced far enough: by a nanosecond at least.

        Whoever waits for what is left of a time would otherwise wait for ever at one moment.
        """
        if seconds <= 0:
            await asyncio.sleep(0)
            return
        future: asyncio.Future[None] = asyncio.get_running_loop().create_future()
        wake_ns = self._loop_ns + max(1, int(seconds * 1e9))
        heapq.heappush(self._sleepers, (wake_ns, next(self._order), future))
        await future

    async def advance(self, seconds: float) -> None:
        """Let time pass, waking sleepers one after another and letting each run."""
        end_ns = self._loop_ns + int(seconds * 1e9)
        await settle()
        while self._sleepers and self._sleepers[0][0] <= end_ns:
            wake_ns, _, future = heapq.heappop(self._sleepers)
            self._move_to(max(wake_ns, self._loop_ns))
            if not future.done():
                future.set_result(None)
            await settle()
        self._move_to(end_ns)
        await settle()

    def _move_to(self, loop_ns: int) -> None:
        self._wall_ns += loop_ns - self._loop_ns
        self._loop_ns = loop_ns


async def settle() -> None:
    """Let everything run that can run without time passing."""
    # Where the loop shows what it has to run, two turns in which that was nothing are enough: the
    # first also took in what had come from outside. It is a tenth of the time of many a test.
    ready = getattr(asyncio.get_running_loop(), "_ready", None)
    idle = 0
    for _ in range(SETTLE_TURNS):
        await asyncio.sleep(0)
        idle = idle + 1 if ready is not None and not ready else 0
        if idle == IDLE_TURNS:
            break


class SeededEntropy:
    """The same tokens every time."""

    def __init__(self, seed: int = 0) -> None:
        self._seed = seed
        self._count = count()

    def token(self, length: int) -> bytes:
        """Return the next token of the sequence."""
        text = f"{self._seed}:{next(self._count)}".encode()
        return blake2b(text, digest_size=64).digest()[:length].ljust(length, b"\0")
