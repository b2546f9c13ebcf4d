"""How long a stop waits behind people known here: Telegram gives out a hundred at once."""

from __future__ import annotations

import asyncio
from time import monotonic
from typing import TYPE_CHECKING

import pytest

from rosic.bench.sites import CLOCK
from rosic.stores.database import DatabaseStore
from tests.gateway.received import ADA, BO, receiving
from tests.pace import pace

if TYPE_CHECKING:
    from pathlib import Path

WITHIN_S = 5.0
"""Of 500 messages, without limits of what a person may send; 2 s were measured."""


@pytest.mark.parametrize("said", ["omni move 1 m", "omni look", "/wish omni"])
async def test_a_stop_behind_five_hundred_messages_of_known_people_is_bounded(
    said: str, tmp_path: Path
) -> None:
    async with receiving(DatabaseStore(tmp_path / "data", clock=CLOCK)) as place:
        place.give(place.message(ADA, "status"))
        await place.drained()
        began_s = monotonic()
        place.give(*(place.message(BO, said) for _ in range(500)), place.message(ADA, "stop"))
        async with asyncio.timeout(60 * pace()):
            while not place.gateway.rooms.stops["omni"].latched:  # noqa: ASYNC110 - nobody is told
                await asyncio.sleep(0.005)
        took_s = monotonic() - began_s
        await place.drained()
    assert took_s < WITHIN_S * pace()
