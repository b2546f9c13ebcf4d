"""Ctrl-C in the middle of a play: robots come to rest, one line says so, and that is all."""

from __future__ import annotations

import asyncio
import re
import signal
import time

import pytest

from rosic_sim.scenarios.registry import NAMES
from tests.cli.running import ROSIC, environment
from tests.pace import patience

WITHIN_S = 5.0
ENDS_S = 60.0
# What is read once robots move.
MOVING = {
    "one-to-one": "Forest watch: goto, ",
    "class": "KUKA iiwa: grasp, ",
    "fleet": "Carrier 1: goto, ",
    "shift": "Carrier 2: goto, ",
    "swarm": ": formation, ",
}
LINE = "Interrupted. Every robot is at rest. Nothing was kept."


async def _interrupted(name: str) -> tuple[int, float, str, str]:
    """Play until robots move, then send SIGINT twice: status, seconds, what was read after, errors.

    Impatient people press it again.
    """
    pace = () if name == "swarm" else ("--fast",)  # drones take their time to come down
    process = await asyncio.create_subprocess_exec(
        *ROSIC,
        "demo",
        name,
        "--plain",
        *pace,
        stdin=asyncio.subprocess.DEVNULL,
        stdout=asyncio.subprocess.PIPE,
        stderr=asyncio.subprocess.PIPE,
        env=environment(),
    )
    assert process.stdout is not None
    try:
        while MOVING[name] not in (line := (await process.stdout.readline()).decode()):
            assert line, f"{name} ended before anything moved"
        begun_s = time.monotonic()
        process.send_signal(signal.SIGINT)
        await asyncio.sleep(0)
        process.send_signal(signal.SIGINT)
        async with asyncio.timeout(ENDS_S):
            out, err = await process.communicate()
        assert process.returncode is not None
        return process.returncode, time.monotonic() - begun_s, out.decode(), err.decode()
    finally:
        if process.returncode is None:
            process.kill()
            await process.wait()


@pytest.mark.limit(300)
async def test_every_play_can_be_interrupted() -> None:
    assert MOVING.keys() == NAMES.keys()
    ends = await asyncio.gather(*map(_interrupted, NAMES))
    for name, (status, took_s, out, err) in zip(NAMES, ends, strict=True):
        assert (status, err) == (130, ""), name
        assert took_s < WITHIN_S * patience(), name
        *before, last = out.strip("\n").splitlines()
        assert last == LINE, name
        # What was on its way may still be read. The closing is not told, and nothing summed up.
        assert not re.search("shut down|What happened|Traceback|Interrupted", "\n".join(before))
