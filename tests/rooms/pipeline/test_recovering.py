"""What the last run did not tell is told by the next one."""

from __future__ import annotations

import pytest

from rosic.stores.memory import MemoryStore
from rosic.testing.clock import ManualClock
from tests.rooms.pipeline.place import ADA, Place


@pytest.mark.parametrize("line", ["omni move 1 m", "OMNI move 1 m", "move omni 1 m"])
async def test_an_order_that_is_told_after_a_restart_names_its_robot_once(line: str) -> None:
    store, clock = MemoryStore(), ManualClock()
    async with Place(store, clock=clock).open() as place:
        place.chat.down = True
        await place.say(line)
        place.robot("omni").finish()
        await place.quiet()

    async with Place(store, clock=clock).open() as place:
        await place.quiet()
        (told,) = [t.outbound.text for t in place.chat.told if t.outbound.chat.id == ADA]

    first = told.splitlines()[0]
    assert first == ("omni: move omni 1 m" if line.startswith("move") else "omni: move 1 m")
