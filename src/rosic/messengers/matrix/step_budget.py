"""Work of any length in short steps: the event loop, and with it a stop, comes in between."""

from __future__ import annotations

import asyncio
from time import perf_counter
from typing import Final

STEP_S: Final = 0.004
"""After so long others come first. What a single piece takes comes on top of it."""


class StepBudget:
    """Counts from when the event loop was last given way to.

    One belongs to whatever is done by one task, and not to each of its parts: many short ones are
    as long as one.
    """

    def __init__(self) -> None:
        self._since_s = perf_counter()

    async def give_way(self) -> None:
        """Let others run, where this has run for long enough; to be called between pieces."""
        if perf_counter() - self._since_s >= STEP_S:
            await asyncio.sleep(0)
            self._since_s = perf_counter()
