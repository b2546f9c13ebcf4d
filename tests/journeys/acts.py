"""Several stories in one place at a time: each is a test of its own, and none waits for another."""

from __future__ import annotations

import asyncio
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Coroutine, Mapping


@asynccontextmanager
async def side_by_side(
    stories: Mapping[str, Coroutine[object, object, None]],
) -> AsyncIterator[dict[str, asyncio.Task[None]]]:
    """Begin all of them; what still goes on at the end of the block is broken off."""
    acts = {name: asyncio.create_task(story) for name, story in stories.items()}
    try:
        yield acts
    finally:
        for act in acts.values():
            act.cancel()
        await asyncio.gather(*acts.values(), return_exceptions=True)
