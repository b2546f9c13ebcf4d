"""Administrative acts: kept for ever on disk, the newest in memory, and read without a wait."""

from __future__ import annotations

import asyncio
import sqlite3
from contextlib import closing
from typing import TYPE_CHECKING

import pytest

from rosic.errors import Repeated, StoreFault
from rosic.stores.data_dir import StoreSettings
from rosic.stores.database import AT_ONCE, DatabaseStore
from rosic.stores.memory import MemoryStore
from rosic.stores.record_mark import DATABASE
from rosic.testing.clock import ManualClock
from rosic.testing.factories import ADA, a_claim, a_decision, a_fact, an_enrolment

if TYPE_CHECKING:
    from pathlib import Path

QUICK = StoreSettings(busy_timeout_ms=20)


def a_store(folder: Path) -> DatabaseStore:
    return DatabaseStore(folder, clock=ManualClock(), settings=QUICK)


@pytest.fixture(params=["disk", "memory"])
def store(request: pytest.FixtureRequest, tmp_path: Path) -> DatabaseStore | MemoryStore:
    return a_store(tmp_path) if request.param == "disk" else MemoryStore()


async def test_the_newest_acts_come_first(store: DatabaseStore | MemoryStore) -> None:
    await store.open()
    assert await store.decisions(5) == ()
    acts = [a_decision(f"p{index}", at_ns=index // 2) for index in range(6)]
    await store.write(acts[0], acts[1])
    await store.write(acts[2], a_fact("1"))
    store.note(acts[3])
    store.keep(acts[4], lambda: None)
    await store.write(acts[5])
    assert await store.decisions(100) == tuple(acts[::-1])
    assert await store.decisions(2) == (acts[5], acts[4])
    assert await store.decisions(0) == ()
    assert await store.decisions(-1) == ()
    await store.close()


async def test_the_same_act_twice_is_two_acts(store: DatabaseStore | MemoryStore) -> None:
    await store.open()
    await store.write(a_decision("p"), a_decision("p"))
    await store.write(a_decision("p"))
    assert await store.decisions(9) == (a_decision("p"),) * 3
    await store.close()


async def test_an_act_of_a_repeated_call_did_not_happen(store: DatabaseStore | MemoryStore) -> None:
    await store.open()
    await store.write(a_claim(1))
    given = await asyncio.gather(
        store.write(a_decision("first")),
        store.write(a_decision("never"), a_claim(1)),
        store.write(a_decision("last")),
        return_exceptions=True,
    )
    assert isinstance(given[1], Repeated)
    assert [act.about for act in await store.decisions(9)] == ["last", "first"]
    await store.close()


async def test_a_closed_record_tells_nothing(store: DatabaseStore | MemoryStore) -> None:
    with pytest.raises(StoreFault):
        await store.decisions(1)
    await store.open()
    await store.close()
    with pytest.raises(StoreFault):
        await store.decisions(1)


async def test_acts_outlive_the_process_and_whoever_they_name(tmp_path: Path) -> None:
    store = a_store(tmp_path)
    await store.open()
    await store.write(a_decision(ADA), an_enrolment())
    await store.shred(ADA)
    await store.close()
    store = a_store(tmp_path)
    await store.open()
    await store.prune()
    assert await store.decisions(9) == (a_decision(ADA),)
    await store.close()


async def test_a_long_list_is_read_in_steps_between_which_others_write(tmp_path: Path) -> None:
    store = a_store(tmp_path)
    await store.open()
    acts = [a_decision(str(index)) for index in range(3 * AT_ONCE)]
    await store.write(*acts)
    reading = asyncio.create_task(store.decisions(len(acts)))
    await asyncio.sleep(0)
    await store.write(a_decision("meanwhile"))
    assert not reading.done()
    assert await reading == tuple(acts[::-1])
    assert await store.decisions(AT_ONCE) == (a_decision("meanwhile"), *acts[:-AT_ONCE:-1])
    await store.close()


async def test_reading_needs_no_right_to_write(tmp_path: Path) -> None:
    store = a_store(tmp_path)
    await store.open()
    await store.write(a_decision("p"))
    with closing(sqlite3.connect(tmp_path / DATABASE, isolation_level=None)) as rival:
        rival.execute("BEGIN EXCLUSIVE")
        assert await store.decisions(9) == (a_decision("p"),)
        with pytest.raises(StoreFault):
            await store.write(a_decision("q"))
        assert await store.decisions(9) == (a_decision("p"),)
        rival.execute("ROLLBACK")
    await store.close()


async def test_reading_leaves_nothing_open(tmp_path: Path) -> None:
    """One half-read statement, and an erased key would stay in the log file."""
    store = a_store(tmp_path)
    await store.open()
    await store.write(an_enrolment(), *(a_decision(str(index)) for index in range(50)))
    assert len(await store.decisions(3)) == 3
    await store.shred(ADA)
    assert not (tmp_path / f"{DATABASE}-wal").stat().st_size
    await store.close()


async def test_memory_keeps_the_newest_only() -> None:
    store = MemoryStore(decisions_max=10)
    await store.open()
    for index in range(100):
        await store.write(a_decision(str(index)))
    assert [act.about for act in await store.decisions(99)] == [str(99 - i) for i in range(10)]
    assert len(store._decisions) == 10
