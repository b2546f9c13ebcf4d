"""Facts on disk: the same as in memory, whatever happens, and found without a search."""

from __future__ import annotations

import asyncio
import random
import sqlite3
from contextlib import closing
from typing import TYPE_CHECKING

import pytest

from rosic.core.records import Letter
from rosic.errors import Repeated, StoreFault
from rosic.stores import sqlite
from rosic.stores.data_dir import StoreSettings
from rosic.stores.database import DatabaseStore
from rosic.stores.memory import MemoryStore
from rosic.stores.record_mark import DATABASE
from rosic.stores.statements import DeletePairs
from rosic.stores.tables import facts
from rosic.testing.clock import ManualClock
from rosic.testing.factories import ADA, a_claim, a_fact

if TYPE_CHECKING:
    from pathlib import Path

    from rosic.core.records import Record

SMALL_GROUPS = StoreSettings(group_max=8, busy_timeout_ms=20)
PEOPLE = (ADA, "p-bob", "omni")


def a_store(folder: Path, settings: StoreSettings = SMALL_GROUPS) -> DatabaseStore:
    return DatabaseStore(folder, clock=ManualClock(), settings=settings)


def rows(folder: Path, query: str) -> list[tuple[object, ...]]:
    with closing(sqlite3.connect(folder / DATABASE)) as database:
        return database.execute(query).fetchall()


def something(chance: random.Random) -> tuple[Record, ...]:
    """Return a call that says one thing or several, and now and then is refused as a whole."""
    said: list[Record] = []
    for _ in range(chance.randint(1, 4)):
        letter = chance.choice((None, Letter(chance.choice(PEOPLE), chance.randbytes(3))))
        body = chance.choice((b"", chance.randbytes(2)))
        key, kind = str(chance.randrange(6)), chance.choice(("slot", "grant"))
        said.append(a_fact(key, body, kind=kind, letter=letter))
    if chance.random() < 0.2:
        said.append(a_claim(chance.randrange(20)))
    return tuple(said)


async def answers(store: DatabaseStore | MemoryStore, calls: list[tuple[Record, ...]]) -> list[str]:
    """Ask for everything in one turn of the loop, so that it shares groups."""
    given = await asyncio.gather(*(store.write(*call) for call in calls), return_exceptions=True)
    return [type(answer).__name__ for answer in given]


@pytest.mark.parametrize("seed", range(15))
async def test_whatever_happens_the_same_is_so_as_in_memory(tmp_path: Path, seed: int) -> None:
    chance = random.Random(seed)  # noqa: S311 - a repeatable history, not a secret
    expected, store = MemoryStore(), a_store(tmp_path)
    await expected.open()
    await store.open()
    for _ in range(40):
        calls = [something(chance) for _ in range(chance.randint(1, 12))]
        noted = something(chance)
        for place in (expected, store):
            place.note(*noted)
        assert await answers(expected, calls) == await answers(store, calls)
        if chance.random() < 0.1:
            person = chance.choice(PEOPLE)
            await expected.shred(person)
            await store.shred(person)
        if chance.random() < 0.2:
            await store.close()
            store = a_store(tmp_path)
            found, wanted = (await store.open()).facts, (await expected.open()).facts
            assert list(found.items()) == list(wanted.items())
    await store.close()
    assert rows(tmp_path, "SELECT count(*) FROM facts WHERE body = x''") == [(0,)]


async def test_facts_wait_for_the_disk_in_order(tmp_path: Path) -> None:
    store = a_store(tmp_path)
    await store.open()
    await store.write(a_fact("1"), a_fact("2"))
    with closing(sqlite3.connect(tmp_path / DATABASE, isolation_level=None)) as rival:
        rival.execute("BEGIN EXCLUSIVE")
        store.note(a_fact("1", b""), a_fact("3", b"noted"))
        with pytest.raises(StoreFault):
            await store.write(a_fact("2", b"never"))
        rival.execute("ROLLBACK")
    await store.write(a_fact("3", b"written"))
    await store.close()
    store = a_store(tmp_path)
    facts = (await store.open()).facts
    assert facts == {"slot": (a_fact("2"), a_fact("3", b"written"))}
    await store.close()


async def test_what_cannot_be_written_spoils_nobody_elses(tmp_path: Path) -> None:
    store = a_store(tmp_path)
    await store.open()
    calls: list[tuple[Record, ...]] = [(a_fact(str(index)),) for index in range(6)]
    calls[2] = (a_fact("no text \ud800"),)
    calls[4] = (a_fact("0", b""), a_fact("no text", letter=Letter("\ud800", b"")))
    assert await answers(store, calls) == [
        "NoneType",
        "NoneType",
        "StoreFault",
        "NoneType",
        "StoreFault",
        "NoneType",
    ]
    await store.close()
    store = a_store(tmp_path)
    assert [fact.key for fact in (await store.open()).facts["slot"]] == ["0", "1", "3", "5"]
    await store.close()


async def test_many_are_taken_back_at_once(tmp_path: Path) -> None:
    store = a_store(tmp_path)
    await store.open()
    everything = [a_fact(f"{index:04}") for index in range(1_000)]
    await store.write(*everything)
    await store.write(*(a_fact(f"{index:04}", b"") for index in range(1_000) if index % 3))
    await store.close()
    store = a_store(tmp_path)
    assert (await store.open()).facts == {"slot": tuple(everything[::3])}
    await store.close()


async def test_a_fact_is_found_by_its_index_and_read_in_its_order(tmp_path: Path) -> None:
    store = a_store(tmp_path)
    await store.open()
    await store.close()
    with sqlite.engine_for(tmp_path / DATABASE, StoreSettings()).connect() as connection:
        take = DeletePairs(connection.dialect, facts.c.kind, facts.c.key)
        take.run(connection.connection.cursor(), ["slot", "x"] * 128)
        with closing(sqlite3.connect(tmp_path / DATABASE)) as database:
            for count, text in take._texts.items():
                plan = database.execute(f"EXPLAIN QUERY PLAN {text}", ["a", "b"] * count)
                steps = [step for *_, step in plan if "facts" in step]
                assert len(steps) == count == 128
                assert all(step.startswith("SEARCH facts USING") for step in steps)
    assert not rows(tmp_path, "SELECT * FROM facts")


async def test_a_command_that_says_nothing_touches_no_fact(tmp_path: Path) -> None:
    """An order pays nothing for them: not one statement."""
    store = a_store(tmp_path)
    await store.open()
    await store.write(a_claim(1))
    asked: list[str] = []
    assert store._writer is not None
    writer = store._writer

    def listen() -> None:
        assert writer._connection is not None
        driver = writer._connection.connection.driver_connection
        assert isinstance(driver, sqlite3.Connection)
        driver.set_trace_callback(asked.append)

    assert store._lane is not None
    await store._lane.call(listen)
    await store.write(a_claim(2))
    with pytest.raises(Repeated):
        await store.write(a_claim(2))
    assert any("commands" in statement for statement in asked)
    assert not any("facts" in text or "decisions" in text for text in asked)
    await store.write(a_claim(3), a_fact("1"))
    assert any("facts" in statement for statement in asked)
    await store.close()
