"""Locks act at once, hold over a restart and damage, and are not undone by oneself."""

from __future__ import annotations

import pytest

from rosic.core.records import Decided, Fact
from rosic.errors import NotPermitted, NotUnderstood, StoreFault
from rosic.stores.memory import MemoryStore
from tests.authoriser.enrolment_rooms import EnrolmentRooms


@pytest.fixture
async def enrolling() -> EnrolmentRooms:
    return await EnrolmentRooms().with_admins()


async def test_a_lock_holds_until_another_admin_undoes_it(enrolling: EnrolmentRooms) -> None:
    records = enrolling.locks.lock("cy", "ada")
    assert isinstance(records[0], Decided)
    assert not enrolling.locks.locked("cy")
    await enrolling.write(records)
    again = await enrolling.restarted()
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


async def test_anybody_may_lock_themselves(enrolling: EnrolmentRooms) -> None:
    await enrolling.write(enrolling.locks.lock("ada", "ada"))
    assert enrolling.locks.locked("ada")


async def test_a_lock_that_cannot_be_read_holds(enrolling: EnrolmentRooms) -> None:
    enrolling.locks.restore([Fact(kind="lock", key="cy", body=b"\xc1")])
    assert enrolling.locks.locked("cy")
    await enrolling.write(enrolling.locks.unlock("cy", "ada", "Cy"))
    assert not enrolling.locks.locked("cy")


async def test_a_lock_that_cannot_be_written_acts_all_the_same() -> None:
    enrolling = EnrolmentRooms(store=MemoryStore())  # never opened: nothing can be written
    records = enrolling.locks.lock("cy", "ada")
    with pytest.raises(StoreFault):
        await enrolling.store.write(*records)
    enrolling.apply(records)
    assert enrolling.locks.locked("cy")
