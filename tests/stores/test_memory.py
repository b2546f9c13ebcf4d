"""The bounds of the record in memory."""

from __future__ import annotations

import pytest

from rosic.core.records import Letter
from rosic.errors import Repeated, StoreFault
from rosic.stores.memory import MemoryStore
from rosic.testing.factories import ADA, a_claim, a_conclusion, a_fact, a_place, an_enrolment, told


async def test_ids_are_kept_up_to_a_horizon() -> None:
    store = MemoryStore(ids_max=100)
    await store.open()
    for name in range(1000):
        await store.write(a_claim(name))
        await store.write(told(name))
        with pytest.raises(Repeated):
            await store.write(a_claim(max(0, name - 99)))
    assert len(store._ids) + len(store._older) <= 200
    await store.write(a_claim(0))


async def test_commands_that_are_never_told_are_bounded() -> None:
    store = MemoryStore(open_orders_max=5)
    await store.open()
    for name in range(5):
        await store.write(a_claim(name))
    with pytest.raises(StoreFault, match="full"):
        await store.write(a_claim(5))
    with pytest.raises(Repeated):
        await store.write(a_claim(4))
    await store.write(told(2))
    await store.write(a_claim(5))


async def test_writing_never_suspends() -> None:
    store = MemoryStore()
    await store.open()
    writing = store.write(a_claim(1), a_conclusion(1), told(1))
    with pytest.raises(StopIteration):
        writing.send(None)


async def test_an_erased_container_is_empty() -> None:
    store = MemoryStore()
    await store.open()
    await store.write(an_enrolment(), a_claim(1), a_place(1, b"there"), a_conclusion(1))
    await store.write(a_claim(2, letter=Letter("p-bob", b"two")))
    await store.shred(ADA)
    await store.write(
        a_fact("1", letter=Letter(ADA, b"Ada")), a_fact("2", letter=Letter("p-bob", b"Bob"))
    )
    await store.shred(ADA)
    memory = await store.open()
    assert memory.enrolled == ()
    assert memory.facts["slot"] == (a_fact("1"), a_fact("2", letter=Letter("p-bob", b"Bob")))
    first, second = memory.unfinished
    assert (first.claim, first.words, first.placed) == (None, None, None)
    assert (first.ending, second.claim) == ("done", b"two")
