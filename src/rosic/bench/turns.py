"""What one message of a robot costs in gateways of many sizes, seen in turns.

A machine that others use is now fast, now slow, for seconds at a time: sizes that were measured one
after another differ by that alone. So each gateway, when everything else about it was seen, waits
in its process; then one after another brings a few hundred messages to its robots, again and again.
"""

from __future__ import annotations

import asyncio
import sys
from contextlib import asynccontextmanager
from itertools import cycle, islice
from statistics import median
from time import perf_counter_ns
from typing import TYPE_CHECKING, cast

from rosic.bench.fed import Feed, Frames
from rosic.bench.feeding import BEATS_PER_S, Beat, frame, reports, robot_name

if TYPE_CHECKING:
    from asyncio.subprocess import Process
    from collections.abc import AsyncIterator, Sequence

MESSAGES = 600
TURNS = 300
WITHIN_S = 170.0
LONGEST_LINE_BYTES = 1 << 26
TURN = b"\n"


# ---- in the process of a gateway ----


def take_turns(feed: Feed, robots: int) -> None:
    """Bring messages whenever somebody writes a line; say what one cost, in ns, until none comes.

    It blocks, on purpose: nothing else of this gateway runs meanwhile.
    """
    frames, numbers = Frames(feed.take), cycle(range(robots))
    for _ in sys.stdin:
        some = tuple(islice(numbers, MESSAGES // (BEATS_PER_S + 1)))
        said = b"".join(frame(Beat(robot_name(n))) * BEATS_PER_S + reports(n, 1) for n in some)
        before, began_ns = feed.messages, perf_counter_ns()
        frames.data_received(said)
        each_ns = (perf_counter_ns() - began_ns) / (feed.messages - before)
        sys.stdout.write(f"{each_ns:.1f}\n")
        sys.stdout.flush()


# ---- in the process of the bench ----


class Waiting:
    """A process that says what it saw, and then waits for its turns."""

    def __init__(self, process: Process) -> None:
        self._to = cast("asyncio.StreamWriter", process.stdin)  # both are pipes
        self._from = cast("asyncio.StreamReader", process.stdout)

    async def turn(self) -> float:
        """Let it have a turn; return what one message cost, in ns."""
        self._to.write(TURN)
        return float(await self.line())

    async def line(self) -> bytes:
        """Return what it says next.

        Raises:
            RuntimeError: It has ended.
        """
        found = await asyncio.wait_for(self._from.readline(), WITHIN_S)
        if not found.endswith(TURN):
            raise RuntimeError("a gateway that was to be measured has ended")
        return found


@asynccontextmanager
async def waiting(*command: str) -> AsyncIterator[Waiting]:
    """Run a process that says a line and then takes turns; it ends when this is left."""
    process = await asyncio.create_subprocess_exec(
        *command, stdin=asyncio.subprocess.PIPE, stdout=asyncio.subprocess.PIPE,
        limit=LONGEST_LINE_BYTES,
    )  # fmt: skip
    try:
        yield Waiting(process)
        await asyncio.wait_for(process.communicate(b""), WITHIN_S)
    finally:
        if process.returncode is None:
            process.kill()
            await process.wait()


async def in_turns(processes: Sequence[Waiting], turns: int = TURNS) -> list[list[float]]:
    """Return what each process saw in its turns, in ns a message: one row for each."""
    rows: list[list[float]] = [[] for _ in processes]
    for _ in range(turns):
        for row, process in zip(rows, processes, strict=True):
            row.append(await process.turn())
    return rows


def times_as_much(some: Sequence[float], others: Sequence[float]) -> float:
    """Return how many times as much some cost as others, turn for turn."""
    return median(one / other for one, other in zip(some, others, strict=True))
