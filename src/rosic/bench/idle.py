"""What a gateway needs of a processor while nobody does anything, and a page is open.

A whole gateway with six simulated robots in a process of its own; no ROS 2 is needed. On a machine
that others use too a processor does less in the same time, so the same piece of work is done
beside each window: what it took longer than the quickest of them is taken out.
"""

from __future__ import annotations

import time
from contextlib import contextmanager
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory
from threading import Thread
from typing import TYPE_CHECKING, Final, NamedTuple

from websockets.exceptions import ConnectionClosed
from websockets.sync.client import connect

from rosic.bench.gateway_process import (
    LOCAL,
    busy_s,
    free_port,
    gateway_process,
    key_headers,
)
from rosic.bench.report import BenchCase, BenchReport, machine

if TYPE_CHECKING:
    import subprocess
    from collections.abc import Iterator

    from websockets.sync.client import ClientConnection

    from rosic.bench.recorder import BenchRecorder


ROBOTS: Final = ("omni", "kuka1", "yumi", "cf1", "cf2", "cf3")
CONFIG: Final = """\
[gateway]
name = "bench"
data = "data"

[[messenger]]
kind = "terminal"

[role.bench]
scopes = ["*:read"]

[api]
listen = "{listen}"
"""
ROBOT: Final = """
[[robot]]
profile = "{name}"
link = "simulated"
"""
SUBSCRIBE: Final = '{"op": "subscribe", "topics": ["robots", "orders", "chat", "rates"]}'
PING: Final = '{"op": "ping", "id": ""}'
PING_EVERY_S: Final = 1.0
WINDOWS, QUICK_WINDOWS = 12, 2
LASTS_S, QUICK_LASTS_S = 5.0, 1.0
SETTLES_S: Final = 5.0
WORK: Final = 200_000
MOST: Final = 0.01

METHOD: Final = (
    "A whole gateway with {robots} simulated robots at rest and its record on disk, in a process "
    "of its own; {windows} windows of {lasts:g} s each without a page and with one open, in turns. "
    "p50, p99: processor time a second. Beside each window the same work is done; what that took "
    "longer than the quickest, others on the machine have cost, and it is taken out."
)
OPEN: Final = (
    "With a page open: {share:.2%} of a processor ({raw:.2%} as measured, {least:.2%} in the "
    "quietest window), promised is under {most:.0%}; with nobody {alone:.2%}."
)


class IdleWindow(NamedTuple):
    """One window.

    Attributes:
        share: Of a processor, as measured.
        work_s: What the same work took of a processor beside it.
    """

    share: float
    work_s: float


def work_s() -> float:
    """Return what a piece of work takes of a processor that is always the same."""
    begun_s = time.thread_time()
    total = 0
    for number in range(WORK):
        total += number % 7
    return time.thread_time() - begun_s


def corrected(windows: list[IdleWindow], quickest_s: float) -> list[float]:
    """Return the shares as they would be where nobody else works."""
    return [each.share * quickest_s / each.work_s for each in windows]


def measure(recorder: BenchRecorder) -> BenchReport:
    """Measure it.

    Args:
        recorder: Hears how far it is.

    Raises:
        ConfigurationError: The gateway does not start.
    """
    windows, lasts_s = (QUICK_WINDOWS, QUICK_LASTS_S) if recorder.quick else (WINDOWS, LASTS_S)
    alone: list[IdleWindow] = []
    opened: list[IdleWindow] = []
    with TemporaryDirectory(prefix="rosic-idle-") as folder, _gateway(Path(folder)) as running:
        process, url, headers = running
        time.sleep(SETTLES_S)
        for _ in range(windows):
            with recorder.turn("nobody", of=windows) as turn:
                alone.append(_window(process.pid, lasts_s))
                turn.saw(1.0, [alone[-1].share * 1e9])
            with connect(url, additional_headers=headers) as page:
                listening = Thread(target=_listen, args=(page,))
                listening.start()
                time.sleep(1.0)
                with recorder.turn("a page open", of=windows) as turn:
                    opened.append(_window(process.pid, lasts_s))
                    turn.saw(1.0, [opened[-1].share * 1e9])
                page.close()
                listening.join()
    return report_of(alone, opened, lasts_s)


def report_of(alone: list[IdleWindow], opened: list[IdleWindow], lasts_s: float) -> BenchReport:
    """Return what follows from the windows."""
    quickest_s = min(each.work_s for each in (*alone, *opened))
    told = OPEN.format(
        share=median(corrected(opened, quickest_s)),
        raw=median(each.share for each in opened),
        least=min(each.share for each in opened),
        most=MOST,
        alone=median(corrected(alone, quickest_s)),
    )
    failed = median(corrected(opened, quickest_s)) > MOST
    return BenchReport(
        machine=machine(),
        method=METHOD.format(robots=len(ROBOTS), windows=len(opened), lasts=lasts_s),
        cases=(
            _case("nobody", corrected(alone, quickest_s)),
            _case("a page open", corrected(opened, quickest_s)),
        ),
        findings=(told,),
        failures=(told,) if failed else (),
    )


def _case(name: str, shares: list[float]) -> BenchCase:
    return BenchCase(
        name=name,
        rate_per_s=1.0,
        p50_us=round(median(shares) * 1e6, 1),
        p99_us=round(max(shares) * 1e6, 1),
    )


def _window(pid: int, lasts_s: float) -> IdleWindow:
    before_s, begun_s = busy_s(pid), time.monotonic()
    works = [work_s()]
    time.sleep(lasts_s)
    works.append(work_s())
    share = (busy_s(pid) - before_s) / (time.monotonic() - begun_s)
    return IdleWindow(share, median(works))


def _listen(page: ClientConnection) -> None:
    """Do what a page does: hear everything, and ask once a second whether anybody is there."""
    page.send(SUBSCRIBE)
    due_s = time.monotonic()
    try:
        while True:
            due_s += PING_EVERY_S
            page.send(PING)
            while (left_s := due_s - time.monotonic()) > 0:
                try:
                    page.recv(timeout=left_s)
                except TimeoutError:
                    break
    except ConnectionClosed:
        return


@contextmanager
def _gateway(folder: Path) -> Iterator[tuple[subprocess.Popen[bytes], str, dict[str, str]]]:
    """Run one; yield its process, the address of its events and the headers of a key."""
    port = free_port()
    config = CONFIG.format(listen=f"{LOCAL}:{port}")
    config += "".join(ROBOT.format(name=name) for name in ROBOTS)
    with gateway_process(folder, config, port) as process:
        yield process, f"ws://{LOCAL}:{port}/v1/events", key_headers(folder / "rosic.toml")
