"""A connection that failed twice in a row is made anew: as strict, to the same file, or not."""

from __future__ import annotations

import gc
import shutil
import sqlite3
from contextlib import asynccontextmanager, closing, suppress
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from rosic.core.records import Letter
from rosic.errors import Repeated, StoreFault
from rosic.stores.data_dir import StoreSettings
from rosic.stores.database import DatabaseStore
from rosic.stores.record_mark import DATABASE
from rosic.testing.clock import ManualClock
from rosic.testing.factories import ADA, a_claim, a_stop, an_id

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

LOG = f"{DATABASE}-wal"
SMALL = StoreSettings(busy_timeout_ms=20, pages_max=120)
TOO_MUCH = Letter(ADA, bytes(1_000_000))


@asynccontextmanager
async def disconnected(folder: Path) -> AsyncIterator[DatabaseStore]:
    """Open a record whose disk was full twice in a row."""
    store = DatabaseStore(folder, clock=ManualClock(), settings=SMALL)
    await store.open()
    try:
        await store.write(a_claim("before"))
        for name in ("one", "two"):
            with pytest.raises(StoreFault, match="The disk is full"):
                await store.write(a_claim(name, letter=TOO_MUCH))
        writer = store._writer
        assert writer is not None
        assert writer._connection is None
        yield store
    finally:
        await store.close()


def claimed(folder: Path) -> set[bytes]:
    with closing(sqlite3.connect(folder / DATABASE)) as database:
        return {cid for (cid,) in database.execute("SELECT cid FROM commands")}


async def test_it_heals_knows_what_was_and_is_as_strict_as_before(tmp_path: Path) -> None:
    async with disconnected(tmp_path) as store:
        await store.write(a_claim("after"))
        with pytest.raises(Repeated):
            await store.write(a_claim("before"))
        with pytest.raises(StoreFault, match="The disk is full"):
            await store.write(a_claim("three", letter=TOO_MUCH))
        await store.write(a_claim("last"))
    assert claimed(tmp_path) == {an_id(name) for name in ("before", "after", "last")}


async def test_no_file_is_kept_open_from_an_earlier_connection(tmp_path: Path) -> None:
    def held_open() -> list[str]:
        gc.collect()  # a fault keeps what it came from for as long as somebody has it
        found: list[str] = []
        for each in Path("/proc/self/fd").iterdir():
            with suppress(FileNotFoundError):  # the folder's own
                found.append(str(each.readlink()))
        return sorted(path for path in found if path.startswith(str(tmp_path)))

    async with disconnected(tmp_path) as store:
        await store.write(a_claim("after"))
        before = held_open()
        for name in ("three", "four"):
            with pytest.raises(StoreFault, match="The disk is full"):
                await store.write(a_claim(name, letter=TOO_MUCH))
        await store.write(a_claim("last"))
        assert held_open() == before
    assert held_open() == []


async def test_nothing_is_claimed_once_the_new_log_is_gone(tmp_path: Path) -> None:
    async with disconnected(tmp_path) as store:
        await store.write(a_claim("after"))
        (tmp_path / LOG).rename(tmp_path / "log")
        assert store.lost_file() == LOG
        with pytest.raises(StoreFault, match="is gone or was replaced"):
            await store.write(a_claim("lost"))
        (tmp_path / "log").rename(tmp_path / LOG)
        await store.write(a_claim("last"))


async def test_another_file_in_its_place_is_not_opened(tmp_path: Path) -> None:
    """Else it is written into, and goes on being so when the record has been put back."""
    async with disconnected(tmp_path) as store:
        (tmp_path / DATABASE).rename(tmp_path / "original")
        copy = tmp_path / DATABASE
        shutil.copy(tmp_path / "original", copy)
        before = copy.read_bytes()
        for attempt in (store.prune, lambda: store.shred(ADA), lambda: store.write(a_claim("no"))):
            with pytest.raises(StoreFault, match="is gone or was replaced"):
                await attempt()
        assert copy.read_bytes() == before
        (tmp_path / "original").rename(tmp_path / DATABASE)
        await store.write(a_claim("after"))
    assert claimed(tmp_path) == {an_id("before"), an_id("after")}


async def test_a_file_that_was_damaged_meanwhile_is_said_to_be(tmp_path: Path) -> None:
    store = DatabaseStore(tmp_path, clock=ManualClock())
    await store.open()
    await store.write(a_claim("before"))
    assert store._writer is not None
    await store._opened().call(store._writer._disconnect)
    assert not (tmp_path / LOG).exists(), "nobody has it open any more"
    (tmp_path / DATABASE).write_bytes(b"no database" * 1000)
    for attempt in (
        lambda: store.write(a_claim(1)),
        lambda: store.write(a_claim(2)),
        store.prune,
        lambda: store.shred(ADA),
        lambda: store.decisions(9),
        lambda: store.forget_decisions(1),
    ):
        with pytest.raises(StoreFault, match="The record is damaged"):
            await attempt()
    await store.close()


async def test_what_another_program_keeps_from_being_erased_is_erased_when_it_has_ended(
    tmp_path: Path,
) -> None:
    store = DatabaseStore(tmp_path, clock=ManualClock(), settings=StoreSettings(busy_timeout_ms=20))
    await store.open()
    await store.write(a_claim(1, letter=Letter(ADA, b"personal")))
    with closing(sqlite3.connect(tmp_path / DATABASE, isolation_level=None)) as other:
        ((wrapped,),) = other.execute("SELECT wrapped FROM containers WHERE container = ?", (ADA,))
        other.execute("BEGIN EXCLUSIVE")
        with pytest.raises(StoreFault, match=r"Another program holds the record\. Try again\."):
            await store.shred(ADA)
        other.execute("ROLLBACK")
        other.execute("BEGIN")
        other.execute("SELECT * FROM containers").fetchall()
        with pytest.raises(StoreFault, match="Another program is reading the record"):
            await store.shred(ADA)
        other.execute("ROLLBACK")
    await store.shred(ADA)
    assert not [name for name in (DATABASE, LOG) if wrapped in (tmp_path / name).read_bytes()]
    await store.close()


async def test_a_note_that_waits_is_written_at_the_end(tmp_path: Path) -> None:
    """The stop of somebody who then ends the gateway at once."""
    store = DatabaseStore(tmp_path, clock=ManualClock(), settings=StoreSettings(busy_timeout_ms=20))
    await store.open()
    with closing(sqlite3.connect(tmp_path / DATABASE, isolation_level=None)) as other:
        other.execute("BEGIN EXCLUSIVE")
        store.note(a_stop(3))
        with pytest.raises(StoreFault):
            await store.write(a_claim(1))
        other.execute("ROLLBACK")
    await store.close()
    with closing(sqlite3.connect(tmp_path / DATABASE)) as database:
        assert database.execute("SELECT generation, gap FROM stops").fetchall() == [(3, 1)]
