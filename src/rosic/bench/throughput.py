"""Algorithm 10 of the paper: how many messages go through in a time, and how many bytes."""

from __future__ import annotations

import asyncio
import time
from typing import TYPE_CHECKING, Final, NamedTuple

from rosic.app import runtime
from rosic.bench.accounts import METHODS, STAND_IN, sender
from rosic.bench.report import BenchReport, BenchTable, machine

if TYPE_CHECKING:
    from rosic.bench.accounts import MessageSender
    from rosic.bench.recorder import BenchRecorder

DURATION_S: Final = 10.0
QUICK_DURATION_S: Final = 3.0
INTERVAL_S: Final = 0.1
CONTENT: Final = "Testing throughput of ROSIC"
SENDING: Final = "messages one after another"
METHOD: Final = (
    "Algorithm 10 as printed: {content} bytes each, for {duration:g} s, with {interval:g} s "
    "between two; what does not go through is said and counted. {where} Bytes are those of the "
    "content alone, as the paper counts them."
)
NOTHING_SENT: Final = "None of {attempted} messages was sent."
COLUMNS: Final = ("", "attempted", "successful", "success rate, %", "throughput, B/s")
PAPER: Final = ("the paper", 51, 51, 100.0, 195.12)


class ThroughputFigures(NamedTuple):
    """What Algorithm 10 prints, and how long each sending took."""

    attempted: int
    successful: int
    size: int
    lasted_s: float
    times_ns: list[int]
    said: list[str]

    @property
    def success_percent(self) -> float:
        """Line 18."""
        return self.successful / self.attempted * 100 if self.attempted else 0.0

    @property
    def bytes_per_s(self) -> float:
        """Line 19."""
        return self.size / self.lasted_s


def measure(
    recorder: BenchRecorder,
    *,
    over: str = STAND_IN,
    duration: float = 0.0,
    interval: float = INTERVAL_S,
) -> BenchReport:
    """Measure it.

    Args:
        recorder: Hears how far it is.
        over: By what the messages go.
        duration: In seconds; 0: ten, or three.
        interval: Between two, in seconds.

    Raises:
        ConfigurationError: Something is not set or not installed, or nobody answers.
    """
    duration = duration or (QUICK_DURATION_S if recorder.quick else DURATION_S)
    with recorder.turn(SENDING) as turn:
        seen = runtime.run(_sent(over, duration, interval))
        if seen.times_ns:
            turn.saw(seen.successful / seen.lasted_s, seen.times_ns)
    ours = (
        "ours",
        seen.attempted,
        seen.successful,
        round(seen.success_percent, 1),
        round(seen.bytes_per_s, 2),
    )
    method = METHOD.format(
        content=len(CONTENT), duration=duration, interval=interval, where=METHODS[over]
    )
    return BenchReport(
        machine=machine(),
        method=method,
        cases=recorder.cases(tails=True),
        findings=tuple(dict.fromkeys(seen.said)),
        failures=() if seen.successful else (NOTHING_SENT.format(attempted=seen.attempted),),
        tables=(BenchTable(title="Algorithm 10", columns=COLUMNS, rows=(ours, PAPER)),),
    )


async def _sent(over: str, duration_s: float, interval_s: float) -> ThroughputFigures:
    async with sender(over) as account:
        await account.connect()
        try:
            return await sent_for(account, duration_s, interval_s)
        finally:
            await account.disconnect()


async def sent_for(
    account: MessageSender, duration_s: float, interval_s: float
) -> ThroughputFigures:
    """Send one message after another for so long: lines 5 to 19 of Algorithm 10."""
    begun_s = time.monotonic()
    end_s = begun_s + duration_s
    attempted = 0
    times_ns: list[int] = []
    said: list[str] = []
    while time.monotonic() < end_s:
        began_ns = time.perf_counter_ns()
        try:
            await account.send(CONTENT)
        except ConnectionError as trouble:
            said.append(str(trouble))
        else:
            times_ns.append(time.perf_counter_ns() - began_ns)
        attempted += 1
        await asyncio.sleep(interval_s)
    lasted_s = time.monotonic() - begun_s
    size = len(CONTENT.encode()) * len(times_ns)
    return ThroughputFigures(attempted, len(times_ns), size, lasted_s, times_ns, said)
