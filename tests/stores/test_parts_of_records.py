"""I13: a database and the log over it belong together, and to what was last used here."""

from __future__ import annotations

import shutil
import sqlite3
from contextlib import closing
from typing import TYPE_CHECKING

import pytest

from rosic.errors import ConfigurationError, Repeated
from rosic.stores.database import DatabaseStore
from rosic.stores.record_guard import MARK_EVERY_NS
from rosic.stores.record_mark import DATABASE, LOG, MARK, RecordMark
from rosic.testing.clock import ManualClock
from rosic.testing.factories import a_claim, a_decision, a_fact

if TYPE_CHECKING:
    from pathlib import Path

PARTS = (DATABASE, LOG, MARK)


def a_store(folder: Path, clock: ManualClock | None = None) -> DatabaseStore:
    return DatabaseStore(folder, clock=clock or ManualClock())


def copied(folder: Path, to: Path) -> Path:
    """Copy a record as it is under a running gateway, or after its sudden end."""
    to.mkdir()
    for path in folder.iterdir():
        if path.is_file() and path.name != f"{DATABASE}-shm":
            shutil.copy(path, to)
    return to


def content(folder: Path) -> dict[str, bytes]:
    return {name: (folder / name).read_bytes() for name in PARTS if (folder / name).exists()}


async def refused(folder: Path, match: str) -> None:
    """Expect that a start is refused, again and again, and changes nothing."""
    before = content(folder)
    for _ in range(2):
        with pytest.raises(ConfigurationError, match=match):
            await a_store(folder).open()
        assert content(folder) == before, "a refused start has changed something"


@pytest.fixture
async def older(tmp_path: Path) -> Path:
    """Return a record in which something was decided, after a sudden end."""
    store = a_store(tmp_path / "data")
    await store.open()
    await store.write(a_decision("one"))
    older = copied(tmp_path / "data", tmp_path / "older")
    await store.close()
    return older


@pytest.fixture
async def newer(tmp_path: Path, older: Path) -> Path:
    """Return the same record a run later, after a sudden end; its log holds the last decision."""
    assert (older / LOG).stat().st_size
    store = a_store(tmp_path / "data")
    await store.open()
    await store.write(a_decision("two"))
    newer = copied(tmp_path / "data", tmp_path / "newer")
    await store.close()
    assert (newer / LOG).stat().st_size
    return newer


async def test_what_ended_suddenly_starts_again(newer: Path) -> None:
    for _ in range(2):
        store = a_store(newer)
        await store.open()
        assert len(await store.decisions(9)) == 2
        await store.close()


async def test_an_older_database_beneath_a_newer_log_is_refused(older: Path, newer: Path) -> None:
    shutil.copy(older / DATABASE, newer / DATABASE)
    await refused(newer, rf"without {LOG} it is older than record\.mark")


@pytest.mark.parametrize("with_mark", [True, False])
async def test_an_older_log_over_a_newer_database_is_refused(
    older: Path, newer: Path, *, with_mark: bool
) -> None:
    shutil.copy(older / LOG, newer / LOG)
    if with_mark:
        shutil.copy(older / MARK, newer / MARK)
        await refused(newer, f"{LOG} is older than {DATABASE}")
    else:
        await refused(newer, r"older than record\.mark")


async def test_a_log_that_is_gone_is_missed(newer: Path) -> None:
    (newer / LOG).unlink()
    await refused(newer, r"older than record\.mark")


async def test_the_log_of_another_folder_is_refused(newer: Path, tmp_path: Path) -> None:
    store = a_store(tmp_path / "other")
    await store.open()
    for number in range(9):
        await store.write(a_decision(str(number)))
    other = copied(tmp_path / "other", tmp_path / "of another")
    await store.close()
    shutil.copy(other / LOG, newer / LOG)
    await refused(newer, "belongs to another one")


async def fold(store: DatabaseStore) -> None:
    """Let the log be brought into the database, as SQLite does when it has grown."""
    writer = store._writer
    assert writer is not None

    def folded() -> tuple[int, int, int]:
        assert writer._connection is not None
        driver = writer._connection.connection.cursor()
        row: tuple[int, int, int] = driver.execute("PRAGMA wal_checkpoint(PASSIVE)").fetchone()
        return row

    busy, frames, moved = await store._opened().call(folded)
    assert not busy
    assert 0 < frames == moved


@pytest.mark.parametrize("name", [DATABASE, LOG])
async def test_a_part_from_before_a_log_was_folded_in_is_refused(tmp_path: Path, name: str) -> None:
    """Within one run, within a minute, and though nothing was decided since."""
    store = a_store(tmp_path / "data")
    await store.open()
    await store.write(a_claim(1, n=1))
    older = copied(tmp_path / "data", tmp_path / "older")
    await store.write(a_claim(2, n=2))
    await fold(store)
    for number in range(3, 6):
        await store.write(a_claim(number, n=number))
    newer = copied(tmp_path / "data", tmp_path / "newer")
    await store.close()
    started = a_store(copied(newer, tmp_path / "as it was"))
    assert len((await started.open()).unfinished) == 5
    await started.close()
    shutil.copy(older / name, newer / name)
    await refused(newer, r"older than record\.mark")


async def test_what_the_mark_says_outlives_a_power_cut_while_a_log_is_folded_in(
    tmp_path: Path,
) -> None:
    """The file never says more than what has to be on disk by then."""
    store = a_store(tmp_path)
    await store.open()
    for number in range(1, 4):
        await store.write(a_decision(str(number)))
        before = (tmp_path / DATABASE).read_bytes()
        await fold(store)
        mark = RecordMark(tmp_path, begin_anew=False)._read()
        assert mark is not None
        assert int.from_bytes(before[60:64], "big") >= mark.folded
    await store.close()


@pytest.mark.parametrize("how", ["whole", "by halves"])
async def test_what_is_decided_beside_something_unfit_marks_the_record(
    tmp_path: Path, how: str
) -> None:
    """A group of which one cannot be written is written by halves, and is as decided as others."""
    store = a_store(tmp_path / "data")
    await store.open()
    await store.write(a_claim(1, n=1))
    older = copied(tmp_path / "data", tmp_path / "older")
    store.note(a_decision("revoked"))
    if how == "by halves":
        with pytest.raises(Repeated):
            await store.write(a_claim(1, n=1))
    else:
        await store.write(a_claim(2, n=2))
    await store.close()
    for name in (DATABASE, LOG):
        shutil.copy(older / name, tmp_path / "data")
    await refused(tmp_path / "data", r"older than record\.mark")


async def test_after_something_unfit_the_record_starts_again(tmp_path: Path) -> None:
    """Its file would say more than it does, if only one of them were marked."""
    store = a_store(tmp_path)
    await store.open()
    await store.write(a_claim(1, n=1))
    store.note(a_decision("revoked"))
    with pytest.raises(Repeated):
        await store.write(a_claim(1, n=1))
    await store.close()
    await store.open()
    await store.close()


async def test_the_mark_says_what_the_record_says(tmp_path: Path) -> None:
    clock = ManualClock()
    store = a_store(tmp_path, clock)
    await store.open()
    for number in range(1, 4):
        await clock.advance(MARK_EVERY_NS / 1e9 + 1)
        store.note(a_fact(f"fact {number}"))
        await store.write(a_claim(number, n=number))
        await store.write(a_decision(str(number)))
        await fold(store)
    await store.close()
    with closing(sqlite3.connect(tmp_path / DATABASE)) as database:
        ((number,),) = database.execute("PRAGMA user_version").fetchall()
    mark = RecordMark(tmp_path, begin_anew=False)._read()
    assert mark is not None
    assert mark.folded < mark.number == number
