"""The stand-in for Telegram's Bot API in a process of its own, as a network away."""

from __future__ import annotations

import asyncio
import sys
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

    from rosic.testing.telegram import Control

STARTING_S = 30.0
TOKEN = "4242424242:of-the-stand-in-alone-it-opens-nothing"  # noqa: S105 - as it says


@asynccontextmanager
async def stand_in() -> AsyncIterator[Control]:
    """Let it run while inside, with Telegram's published limits.

    `rosic.bench.command` has seen that its extras are installed.
    """
    from rosic.testing.telegram import Control as Driver  # noqa: PLC0415 - an extra brings it

    process = await asyncio.create_subprocess_exec(
        sys.executable,
        "-m",
        "rosic.testing.telegram",
        "--token",
        TOKEN,
        stdout=asyncio.subprocess.PIPE,
    )
    try:
        assert process.stdout is not None  # noqa: S101 - as asked for just above
        said = await asyncio.wait_for(process.stdout.readline(), STARTING_S)
        async with Driver(said.decode().removeprefix("ready ").strip()) as control:
            yield control
    finally:
        if process.returncode is None:
            process.terminate()
        await process.wait()
