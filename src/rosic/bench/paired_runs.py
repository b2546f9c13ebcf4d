"""What one message costs in gateways of many sizes, seen in turns.

A machine that others use is now fast, now slow, for seconds at a time: sizes that were measured one
after another differ by that alone. So each gateway, when everything else about it was seen, waits
in its process; then one after another carries out some commands, or brings a few hundred messages
to its robots, again and again.
"""

from __future__ import annotations

import asyncio
import sys
from contextlib import asynccontextmanager, suppress
from itertools import cycle, islice
from statistics import median
from time import perf_counter_ns
from typing import TYPE_CHECKING, TypeVar, cast

import msgspec

from rosic.bench.load_generator import BEATS_PER_S, RobotHeartbeat, frame, reports, robot_name
from rosic.bench.reporting_robots import FrameProtocol, ReportDelivery

if TYPE_CHECKING:
    from asyncio.subprocess import Process
    from collections.abc import AsyncIterator, Awaitable, Callable, Iterator, Mapping, Sequence
    from typing import IO

Seen = TypeVar("Seen")

SETTLING_S = 0.3
MESSAGES = 600
TURNS = 300
WITHIN_S = 170.0
LONGEST_LINE_BYTES = 1 << 26
REPORTS, COMMANDS, STOPS = "reports", "commands", "stops"


# ---- in the gateway's process ----


async def take_turns(
    feed: ReportDelivery, robots: int, ways: Mapping[str, Callable[[], Awaitable[object]]]
) -> None:
    """Do what a line asks for, until none comes, and say in a line what it cost.

    While it waits it blocks, on purpose: nothing else of this gateway runs meanwhile.

    Args:
        feed: Brings messages of so many robots.
        robots: Called by number; after the last comes the first.
        ways: What else may be asked for; returns what it saw.
    """
    numbers = cycle(range(robots))
    for kind in sys.stdin:
        seen: object
        if (way := ways.get(kind.strip())) is None:
            seen = _bring(feed, numbers)
        else:
            await asyncio.sleep(SETTLING_S)  # what it has put off is done before
            seen = await way()
        sys.stdout.write(msgspec.json.encode(seen).decode() + "\n")
        sys.stdout.flush()


def _bring(feed: ReportDelivery, numbers: Iterator[int]) -> float:
    """Return what one message costs, in ns, when so many wait that waking up costs nothing."""
    some = tuple(islice(numbers, MESSAGES // (BEATS_PER_S + 1)))
    said = b"".join(
        frame(RobotHeartbeat(robot_name(n))) * BEATS_PER_S + reports(n, 1) for n in some
    )
    frames, before, began_ns = FrameProtocol(feed.take), feed.messages, perf_counter_ns()
    frames.data_received(said)
    return (perf_counter_ns() - began_ns) / (feed.messages - before)


# ---- in the bench's process ----


class PairedProcess:
    """A process that says what it saw, and then waits for its turns."""

    def __init__(self, process: Process) -> None:
        self._to = cast("asyncio.StreamWriter", process.stdin)  # both are pipes
        self._from = cast("asyncio.StreamReader", process.stdout)

    async def turn(self, kind: str) -> bytes:
        """Let it have a turn; return what it says of it.

        Raises:
            RuntimeError: It has ended.
        """
        self._to.write(f"{kind}\n".encode())
        return await self.line()

    async def line(self) -> bytes:
        """Return what it says next.

        Raises:
            RuntimeError: It has ended.
        """
        found = await asyncio.wait_for(self._from.readline(), WITHIN_S)
        if not found.endswith(b"\n"):
            raise RuntimeError("what was to be measured has ended")
        return found


@asynccontextmanager
async def waiting(*command: str, errors: IO[bytes] | None = None) -> AsyncIterator[PairedProcess]:
    """Run a process that says a line and then takes turns; it ends when this is left.

    Args:
        command: Runs it.
        errors: Takes its standard error; None: the terminal.
    """
    process = await asyncio.create_subprocess_exec(
        *command,
        stdin=asyncio.subprocess.PIPE,
        stdout=asyncio.subprocess.PIPE,
        stderr=errors,
        limit=LONGEST_LINE_BYTES,
    )
    try:
        yield PairedProcess(process)
        if process.stdin is not None and not process.stdin.is_closing():  # it has not ended before
            with suppress(TimeoutError, RuntimeError, OSError):  # what was measured stays so
                await asyncio.wait_for(process.communicate(b""), WITHIN_S)
    finally:
        if process.returncode is None:
            process.kill()
            await process.wait()


async def in_turns(
    processes: Sequence[PairedProcess], kind: str, turns: int, seen: type[Seen]
) -> list[list[Seen]]:
    """Return what each process saw in its turns: one row for each.

    The first turn is not counted: what a gateway has put off while it waited is done then.
    """
    rows: list[list[Seen]] = [[] for _ in processes]
    for _ in range(turns + 1):
        for row, process in zip(rows, processes, strict=True):
            row.append(msgspec.json.decode(await process.turn(kind), type=seen))
    return [row[1:] for row in rows]


def times_as_much(some: Sequence[float], others: Sequence[float]) -> float:
    """Return how many times as much some cost as others, turn for turn."""
    return median(one / other for one, other in zip(some, others, strict=True))
