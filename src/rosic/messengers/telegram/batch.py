"""What one answer to a poll gives to do, and how it is cut into steps of the event loop.

A step is not interrupted: whatever arrives waits for its end, a stop among it.
"""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING, Final

import msgspec

from rosic.messengers.telegram import updates

if TYPE_CHECKING:
    from collections.abc import Sequence

BATCH: Final = 100
"""The most that Telegram gives at once (https://core.telegram.org/bots/api#getupdates)."""
FEWEST: Final = 10
ANSWER_BYTES: Final = 1_000_000
"""After a longer answer fewer updates are asked for at once."""
STEP_BYTES: Final = 4_096
"""So much of what came is read in one step."""
LEAST_BYTES: Final = 256
"""No update counts as less."""


class BatchPause:
    """Lets others have the loop while much is read: a stop that was found is obeyed meanwhile."""

    def __init__(self) -> None:
        self._since = 0

    async def after(self, what: object) -> bool:
        """Count what was just done, by its size; pause when it was enough for a step.

        Returns:
            Whether it was.
        """
        self._since += len(what) if isinstance(what, msgspec.Raw) else _weight(what)
        if self._since < STEP_BYTES:
            return False
        self._since = 0
        await asyncio.sleep(0)
        return True


async def turns(number: int) -> None:
    """Let others have the event loop so many times."""
    for _ in range(number):
        await asyncio.sleep(0)


def limit_after(raws: Sequence[object], limit: int) -> int:
    """Return how many updates to ask for next.

    To find where each of them begins and ends is one step, so after an answer that was long there
    are fewer.
    """
    size = sum(len(raw) for raw in raws if isinstance(raw, msgspec.Raw))
    return max(FEWEST, limit // 2) if size > ANSWER_BYTES else min(BATCH, 2 * limit)


def _weight(update: object) -> int:
    """Return how much an update gives to do, about as its length in bytes."""
    message = updates.written(update) if isinstance(update, updates.Update) else None
    text = (message.text or message.caption or "") if message is not None else ""
    return LEAST_BYTES + 4 * len(text)
