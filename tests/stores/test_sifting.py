"""Which commands are open: known after every restart, at a cost that no history raises."""

from __future__ import annotations

import random
import sqlite3
from contextlib import closing
from typing import TYPE_CHECKING

import pytest

from rosic.core.records import Letter, Record
from rosic.errors import Repeated
from rosic.stores.data_dir import StoreSettings
from rosic.stores.database import DatabaseStore
from rosic.stores.memory import MemoryStore
from rosic.stores.record_mark import DATABASE
from rosic.testing.clock import ManualClock
from rosic.testing.factories import (
    ADA,
    a_claim,
    a_conclusion,
    a_place,
    a_refusal,
    a_resumption,
    an_id,
    told,
)

if TYPE_CHECKING:
    from pathlib import Path

DEFAULTS = StoreSettings()
EVERY_FEW = StoreSettings(unsifted=4)
NAMES = 60


def a_store(folder: Path, settings: StoreSettings = DEFAULTS) -> DatabaseStore:
    return DatabaseStore(folder, clock=ManualClock(), settings=settings)


def count(folder: Path, rows: str) -> int:
    with closing(sqlite3.connect(folder / DATABASE)) as database:
        [[found]] = database.execute(f"SELECT count(*) FROM {rows}").fetchall()  # noqa: S608
        return int(found)


async def live(store: DatabaseStore, first: int, last: int) -> None:
    """Have commands live their lives, many in a call."""
    for start in range(first, last, 250):
        names = range(start, start + 250)
        await store.write(*map(a_claim, names))
        await store.write(*(a_place(name, b"shown") for name in names))
        await store.write(*map(a_conclusion, names))
        await store.write(*map(told, names))


async def test_a_command_that_stays_open_ruins_no_start(tmp_path: Path) -> None:
    store = a_store(tmp_path)
    await store.open()
    await store.write(a_claim("old"), a_place("old", b"message 8"))
    await live(store, 0, 4_000)
    await store.write(a_claim("middle"))
    await live(store, 4_000, 10_000)
    await store.write(a_claim("young"))
    await store.close()

    assert count(tmp_path, "open_lives") == 2
    looked_through = "commands WHERE seq >= (SELECT below FROM sifted)"
    assert count(tmp_path, looked_through) <= 2 * DEFAULTS.unsifted + 250
    store = a_store(tmp_path)
    open_orders = (await store.open()).unfinished
    assert [open_order.cid for open_order in open_orders] == [
        an_id("old"),
        an_id("middle"),
        an_id("young"),
    ]
    assert [open_order.placed for open_order in open_orders] == [b"message 8", None, None]
    await store.write(told("old"), a_conclusion("middle", words=None))
    await store.close()

    assert count(tmp_path, "open_lives") == 0
    store = a_store(tmp_path)
    assert [open_order.cid for open_order in (await store.open()).unfinished] == [an_id("young")]
    with pytest.raises(Repeated):
        await store.write(a_claim("old"))
    await store.close()


@pytest.mark.parametrize("together", [True, False])
async def test_an_outcome_without_words_takes_back_that_there_is_something_to_tell(
    tmp_path: Path, *, together: bool
) -> None:
    store = a_store(tmp_path)
    await store.open()
    await store.write(a_claim(1))
    outcomes = a_conclusion(1, "failed", b"no object"), a_conclusion(1, "done", words=None)
    for call in (outcomes,) if together else ((outcome,) for outcome in outcomes):
        await store.write(*call)
    await store.close()
    assert count(tmp_path, "endings WHERE ending = 'failed' AND sealed IS NULL") == 1
    store = a_store(tmp_path)
    assert (await store.open()).unfinished == ()
    await store.close()


async def test_a_usual_life_costs_four_rows(tmp_path: Path) -> None:
    """Its claim, where it is shown, how it ended and that it was told; letters stand in them."""
    store = a_store(tmp_path)
    await store.open()
    await store.write(a_claim("first"))
    await store.close()
    with closing(sqlite3.connect(tmp_path / DATABASE)) as database:
        tables = [
            name
            for (name,) in database.execute("SELECT name FROM sqlite_schema WHERE type = 'table'")
        ]
    before = {table: count(tmp_path, table) for table in tables}
    store = a_store(tmp_path)
    await store.open()
    await live(store, 0, 250)
    await store.close()
    grown = {table: count(tmp_path, table) - before[table] for table in tables}
    assert {table: rows for table, rows in grown.items() if rows} == dict.fromkeys(
        ("commands", "places", "endings", "tellings"), 250
    )


def something(chance: random.Random, name: int) -> Record:
    """Return anything that can be written of a command, sensible or not."""
    letter = chance.choice((None, Letter(ADA, b"chat 7")))
    return chance.choice(
        (
            a_claim(name, letter=letter),
            a_claim(name),
            a_refusal(name, letter),
            a_resumption(name),
            a_place(name, chance.randbytes(4)),
            a_place(name, chance.randbytes(4)),
            a_conclusion(name, words=chance.randbytes(4)),
            a_conclusion(name, words=None),
            told(name),
        )
    )


@pytest.mark.parametrize("seed", range(12))
async def test_whatever_happens_the_same_commands_are_open_as_in_memory(
    tmp_path: Path, seed: int
) -> None:
    chance = random.Random(seed)  # noqa: S311 - a repeatable history, not a secret
    expected = MemoryStore()
    await expected.open()
    store = a_store(tmp_path, EVERY_FEW)
    await store.open()
    for step in range(150):
        newest = step * NAMES // 150
        names = [chance.randrange(max(0, newest - 12), newest + 2) for _ in range(3)]
        records = [something(chance, name) for name in names[: chance.randint(1, 3)]]
        answers: list[type[Exception] | None] = []
        for place in (expected, store):
            try:
                await place.write(*records)
                answers.append(None)
            except Repeated:
                answers.append(Repeated)
        assert answers[0] == answers[1]
        if chance.random() < 0.1:
            await store.close()
            store = a_store(tmp_path, EVERY_FEW)
            assert (await store.open()).unfinished == (await expected.open()).unfinished
    await store.close()
    assert count(tmp_path, "sifted WHERE below > 1") == 1
