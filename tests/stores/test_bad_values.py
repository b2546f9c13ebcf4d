"""A value in the record that ROSIC has not written is one sentence at the start, and no trace."""

from __future__ import annotations

import asyncio
import shutil
import sqlite3
from contextlib import closing, suppress
from typing import TYPE_CHECKING

import pytest

from rosic.core.records import Letter
from rosic.errors import ConfigurationError
from rosic.stores.database import DatabaseStore
from rosic.stores.record_mark import DATABASE
from rosic.testing.clock import ManualClock
from rosic.testing.factories import (
    ADA,
    a_choice,
    a_claim,
    a_conclusion,
    a_decision,
    a_fact,
    a_place,
    a_stop,
)
from tests.gateway.place import Place

if TYPE_CHECKING:
    from pathlib import Path

BAD = ("nonsense", b"\xff\xfe", -1)
SKIPPED = {"alembic_version", "sqlite_sequence"}


@pytest.fixture(scope="module")
def record(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with something in every table that a start reads."""
    folder = tmp_path_factory.mktemp("bad") / "data"

    async def fill() -> None:
        place = Place(DatabaseStore(folder, clock=ManualClock()))
        async with place.open():
            await place.say("use omni")
            await place.say("wave")
            await place.say("stop kuka1")
        store = DatabaseStore(folder, clock=ManualClock())
        await store.open()
        await store.write(a_claim(101, n=101), a_place(101, b"shown"))
        await store.write(a_claim(102, n=102), a_conclusion(102))
        await store.write(a_decision("one"), a_fact("a", letter=Letter(ADA, b"sealed")))
        await store.write(a_choice("omni"))
        await store.write(a_stop(3))
        await store.close()

    asyncio.run(fill())
    return folder


def columns(folder: Path) -> list[tuple[str, str]]:
    with closing(sqlite3.connect(folder / DATABASE)) as database:
        tables = database.execute("SELECT name FROM sqlite_master WHERE type='table'").fetchall()
        return [
            (table, row[1])
            for (table,) in tables
            if table not in SKIPPED
            for row in database.execute(f"PRAGMA table_info({table})").fetchall()
        ]


async def start(folder: Path) -> str:
    """Open a gateway on a folder and close it; return the sentence if it cannot be."""
    place = Place(DatabaseStore(folder, clock=ManualClock()))
    try:
        await place.gateway.open()
    except ConfigurationError as sentence:
        return str(sentence)
    closing_it = asyncio.create_task(place.gateway.close())
    while not closing_it.done():
        await place.clock.advance(0.01)
    return ""


async def test_every_bad_value_is_one_sentence(
    record: Path, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    refused = 0
    for number, (table, column) in enumerate(columns(record)):
        for bad in BAD:
            folder = tmp_path / f"{number}-{BAD.index(bad)}"
            shutil.copytree(record, folder)
            with closing(sqlite3.connect(folder / DATABASE)) as database:
                database.execute("PRAGMA foreign_keys=OFF")
                with suppress(sqlite3.Error):  # the database itself declines it
                    database.execute(f"UPDATE {table} SET {column}=?", (bad,))  # noqa: S608
                    database.commit()
            caplog.clear()
            said = await start(folder)
            refused += bool(said)
            if "cannot be read" in said:
                assert f"its table {table}." in said, (table, column, bad)
                assert "Put rosic.db back" in said
            traces = [r.getMessage() for r in caplog.records if r.exc_info]
            assert not traces, (table, column, bad, traces)
            shutil.rmtree(folder)
    assert refused > 30


async def test_the_value_is_named(record: Path, tmp_path: Path) -> None:
    folder = tmp_path / "data"
    shutil.copytree(record, folder)
    with closing(sqlite3.connect(folder / DATABASE)) as database:
        [(key,)] = database.execute("SELECT key FROM keys ORDER BY key LIMIT 1").fetchall()
        database.execute("UPDATE keys SET scopes='nonsense' WHERE key=?", (key,))
        database.commit()
    with pytest.raises(ConfigurationError, match=f"scopes of '{key}' in its table keys"):
        await DatabaseStore(folder, clock=ManualClock()).open()
