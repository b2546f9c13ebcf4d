"""What people often ask for outlives a restart, and goes when they are forgotten."""

from __future__ import annotations

from rosic.stores.memory import MemoryStore
from tests.gateway.place import Place

OFTEN = "★ move, 0.50 m left"


def _offered(place: Place) -> list[str]:
    return [button.label for row in place.last()[1].buttons for button in row]


async def _often(store: MemoryStore) -> None:
    async with Place(store).open() as place:
        for _ in range(3):
            await place.say("omni move 0.5 m left")
        await place.say("omni wave")
        await place.quiet()


async def test_they_outlive_a_restart() -> None:
    store = MemoryStore()
    await _often(store)
    async with Place(store).open() as place:
        await place.say("use omni")
        assert _offered(place)[0] == OFTEN
        assert "★ wave" not in _offered(place), "once is no habit"


async def test_they_are_sealed_in_the_persons_container() -> None:
    store = MemoryStore()
    await _often(store)
    async with Place(store).open():
        [fact] = await store.facts("habits", "", 10)
    assert b"left" not in fact.body
    assert fact.letter is not None
    assert fact.letter.container == fact.key


async def test_they_are_written_within_a_minute_and_only_when_they_change() -> None:
    store = MemoryStore()
    async with Place(store).open() as place:
        for _ in range(2):
            await place.say("omni wave")
        await place.clock.advance(61.0)
        await place.quiet()
        assert await store.facts("habits", "", 10)
        await place.say("omni wave")
        assert place.gateway.pipeline.command_history.unwritten() == ()
