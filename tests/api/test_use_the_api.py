"""The program in docs/howto/use-the-api.md, as it stands there, in a process of its own."""

from __future__ import annotations

import asyncio
import os
import re
import sys
from pathlib import Path

from tests.api.served import served
from tests.pace import pace

PAGE = Path(__file__).parents[2] / "docs" / "howto" / "use-the-api.md"


async def test_the_program_on_the_page_runs_and_runs_again() -> None:
    [program] = re.findall(r"```python\n(.*?)```", PAGE.read_text(), re.DOTALL)
    async with served() as place:
        there = {"ROSIC_URL": place.url, "ROSIC_KEY": await place.key("operator")}
        first = await _run(program, there)
        again = await _run(program, there)
    assert "omni free" in first
    assert again[again.index("omni stopped") + 1] == "omni is ready again."
    for lines in (first, again):
        assert "it would be: move, 0.10 m left" in lines
        assert "done" in lines
        refused = "out-of-bounds omni: one move may be at most 5 m."
        assert any(line.startswith(refused) for line in lines)
        assert lines[-1] == "at rest: True"


async def _run(program: str, there: dict[str, str]) -> list[str]:
    running = await asyncio.create_subprocess_exec(
        *(sys.executable, "-c", program),
        env={**os.environ, **there},
        stdout=asyncio.subprocess.PIPE,
        stderr=asyncio.subprocess.STDOUT,
    )
    async with asyncio.timeout(60 * pace()):
        out, _ = await running.communicate()
    lines = out.decode().splitlines()
    assert running.returncode == 0, lines
    return lines
