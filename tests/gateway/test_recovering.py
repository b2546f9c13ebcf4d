"""What the last run did not tell is told by the next one."""

from __future__ import annotations

import pytest

from rosic.stores.memory import MemoryStore
from rosic.stores.stop_latch import MemoryLatch
from rosic.testing.clock import ManualClock
from rosic.testing.factories import a_claim
from tests.gateway.place import ADA, Place


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


async def test_a_robot_in_doubt_stays_held_when_its_order_is_settled_and_it_starts_again() -> None:
    store, latch, clock = MemoryStore(), MemoryLatch(), ManualClock()
    await store.open()
    await store.write(a_claim("an order of a run that died"))
    for run in ("that finds it", "that finds it settled"):
        async with Place(store, latch, clock=clock).open() as place:
            await place.quiet()
            assert place.robot("omni").gate.latched, run
            assert "omni is stopped" in await place.say("omni move 1 m", message=run), run
            assert place.acted() == 0
    assert not (await store.open()).unfinished
