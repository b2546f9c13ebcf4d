"""Once a day: what is kept longer than was said goes, and who was erased is erased wholly."""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING

from rosic.errors import StoreFault

if TYPE_CHECKING:
    from rosic.features.personal_data.context import ContainerContext
    from rosic.features.personal_data.erasure import ErasureCommands

log = logging.getLogger("rosic.containers")


async def tidy(holdings: ContainerContext, erasing: ErasureCommands) -> int:
    """Forget entries of archives that are too old, and finish erasing. Return how many entries.

    Goes in small steps, so that other changes pass between them.

    Raises:
        RecordUnavailable: Not all were forgotten; the rest is tried the next time.
    """
    await erasing.finish()
    try:
        await erasing.strays()
    except StoreFault:
        log.exception("not everything of people who were not let in could be erased")
    total = 0
    while True:
        async with holdings.changes.turn() as turn:
            facts = holdings.archive.outdated()
            await turn.write(facts)
        if not facts:
            return total
        total += len(facts)
