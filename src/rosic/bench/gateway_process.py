"""Whole gateways, and servers beside them, in processes of their own: what benches share."""

from __future__ import annotations

import re
import socket
import subprocess
import sys
import time
from contextlib import contextmanager
from typing import TYPE_CHECKING, Final

from rosic.errors import ConfigurationError

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from pathlib import Path

LOCAL: Final = "127.0.0.1"
STARTED_WITHIN_S: Final = 120.0
LOOK_S: Final = 0.05
CPU_CLOCK: Final = 2
"""Of a process, as Linux numbers clocks: what it used of processors, all of its threads."""


def free_port() -> int:
    """Return a port of this machine that nobody listens on."""
    with socket.socket() as probe:
        probe.bind((LOCAL, 0))
        return int(probe.getsockname()[1])


def is_listening(port: int, runs: Callable[[], bool]) -> bool:
    """Wait until something listens on a port; False where it ended before, or takes too long."""
    end_s = time.monotonic() + STARTED_WITHIN_S
    while time.monotonic() < end_s and runs():
        with socket.socket() as probe:
            if probe.connect_ex((LOCAL, port)) == 0:
                return True
        time.sleep(LOOK_S)
    return False


def busy_s(pid: int) -> float:
    """Return how much of a processor a process has used so far."""
    return time.clock_gettime((~pid << 3) | CPU_CLOCK)


@contextmanager
def gateway_process(folder: Path, config: str, port: int) -> Iterator[subprocess.Popen[bytes]]:
    """Run ``rosic run`` while inside.

    Args:
        folder: Where its configuration, its record and what it says are.
        config: Written there as ``rosic.toml``.
        port: One that it listens on once it works.

    Raises:
        ConfigurationError: It does not start; says its last words.
    """
    file, words = folder / "rosic.toml", folder / "said"
    file.write_text(config, encoding="utf-8")
    with words.open("wb") as said:
        process = subprocess.Popen(  # noqa: S603 - our own command
            (sys.executable, "-m", "rosic", "run", "-c", str(file)),
            stdin=subprocess.DEVNULL,
            stdout=said,
            stderr=subprocess.STDOUT,
        )
    try:
        if not is_listening(port, lambda: process.poll() is None):
            last = words.read_text(encoding="utf-8", errors="replace")[-400:]
            raise ConfigurationError(f"The gateway of the bench did not start: {last}")
        yield process
    finally:
        process.terminate()
        try:
            process.wait(STARTED_WITHIN_S)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()


def key_headers(config: Path, name: str = "bench", *more: str) -> dict[str, str]:
    """Make a key of the role ``bench`` at a gateway that runs; return what shows it.

    Args:
        config: Of the gateway.
        name: Of the program that it is for.
        more: Options of ``rosic key create``.
    """
    made = subprocess.run(  # noqa: S603 - our own command
        (
            *(sys.executable, "-m", "rosic", "key", "create", name),
            *("--role", "bench", *more, "-c", str(config)),
        ),
        capture_output=True,
        text=True,
        timeout=STARTED_WITHIN_S,
        check=True,
    )
    key = re.search(r"rosic_\S+", made.stdout)
    assert key is not None, made.stdout  # noqa: S101 - of our own command
    return {"Authorization": f"Bearer {key[0]}"}
