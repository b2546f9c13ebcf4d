"""Locks act at once, hold over a restart and damage, and are not undone by oneself."""

from __future__ import annotations

import pytest

from rosic.core.records import Decided, Fact
from rosic.errors import NotPermitted, NotUnderstood, StoreFault
from rosic.stores.memory import MemoryStore
from tests.authoriser.office import Office


@pytest.fixture
async def office() -> Office:
    return await Office().with_admins()


async def test_a_lock_holds_until_another_admin_undoes_it(office: Office) -> None:
    records = office.locks.lock("cy", "ada")
    assert isinstance(records[0], Decided)
    assert not office.locks.locked("cy")
    await office.write(records)
    again = await office.restarted()
    assert again.locks.locked("cy")
    assert again.locks.all()["cy"].by == "ada"
    assert list(again.locks.everybody()) == ["cy"]
    with pytest.raises(NotPermitted, match="Another admin"):
        again.locks.unlock("cy", "cy", "Cy")
    await again.write(again.locks.unlock("cy", "bo", "Cy"))
    assert not again.locks.locked("cy")
    assert not (await again.restarted()).locks.locked("cy")
    with pytest.raises(NotUnderstood, match="Cy is not locked"):
        again.locks.unlock("cy", "bo", "Cy")


async def test_anybody_may_lock_themselves(office: Office) -> None:
    await office.write(office.locks.lock("ada", "ada"))
    assert office.locks.locked("ada")


async def test_a_lock_that_cannot_be_read_holds(office: Office) -> None:
    office.locks.restore([Fact(kind="lock", key="cy", body=b"\xc1")])
    assert office.locks.locked("cy")
    await office.write(office.locks.unlock("cy", "ada", "Cy"))
    assert not office.locks.locked("cy")


async def test_a_lock_that_cannot_be_written_acts_all_the_same() -> None:
    office = Office(store=MemoryStore())  # never opened: nothing can be written
    records = office.locks.lock("cy", "ada")
    with pytest.raises(StoreFault):
        await office.store.write(*records)
    office.apply(records)
    assert office.locks.locked("cy")
