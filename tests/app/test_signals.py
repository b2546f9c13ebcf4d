"""No signal that somebody may send ends a gateway before motion is at rest."""

from __future__ import annotations

import asyncio
import os
import signal

import pytest

from rosic.app.closing import on_signals
from tests.pace import patience


@pytest.mark.parametrize("name", ["SIGTERM", "SIGHUP", "SIGUSR1", "SIGUSR2", "SIGALRM"])
async def test_a_signal_that_would_end_the_process_is_an_orderly_end(name: str) -> None:
    number, left = signal.Signals[name], asyncio.Event()
    # Where nobody else takes it, the test fails instead of ending everything.
    before = signal.signal(number, signal.SIG_IGN)
    try:
        on_signals(left.set)
        os.kill(os.getpid(), number)
        async with asyncio.timeout(5 * patience()):
            await left.wait()
    finally:
        signal.signal(number, before)
