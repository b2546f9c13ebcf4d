"""I13: what is lost, emptied, swapped, copied or taken away is recognised, and claims nothing."""

from __future__ import annotations

import shutil
import sqlite3
from contextlib import closing
from typing import TYPE_CHECKING

import pytest

from rosic.errors import ConfigurationError, StoreFault
from rosic.stores.data_dir import LOCK
from rosic.stores.database import DatabaseStore
from rosic.stores.record_files import KeptFiles
from rosic.stores.record_guard import MARK_EVERY_NS
from rosic.stores.record_mark import DATABASE, MARK, STOPS
from rosic.stores.root_key import ROOT_KEY
from rosic.stores.stop_latch import FileLatch
from rosic.testing.clock import ManualClock
from rosic.testing.factories import a_claim, a_decision, a_fact

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

LOG = f"{DATABASE}-wal"


def a_store(folder: Path, *, begin_anew: bool = False) -> DatabaseStore:
    return DatabaseStore(folder, clock=ManualClock(), begin_anew=begin_anew)


async def opened_and_closed(folder: Path, *, begin_anew: bool = False) -> None:
    store = a_store(folder, begin_anew=begin_anew)
    await store.open()
    await store.close()


@pytest.fixture
async def folder(tmp_path: Path) -> Path:
    """Return a folder with a record that was written, and a stop file."""
    store, latch = a_store(tmp_path), FileLatch(tmp_path / STOPS)
    await store.open()
    latch.read()
    await store.write(a_decision("one"))
    await store.close()
    await latch.close()
    return tmp_path


def without_database(folder: Path) -> None:
    for path in folder.glob(f"{DATABASE}*"):
        path.unlink()


def emptied(folder: Path) -> None:
    without_database(folder)
    (folder / DATABASE).touch(0o600)


def without_tables(folder: Path) -> None:
    """Leave a good database of some pages, in which nothing stands."""
    without_database(folder)
    with closing(sqlite3.connect(folder / DATABASE)) as database:
        database.execute("PRAGMA journal_mode=WAL")
        database.execute("CREATE TABLE one (number)")
        database.execute("DROP TABLE one")
    (folder / DATABASE).chmod(0o600)
    assert (folder / DATABASE).stat().st_size


def without_tables_and_mark(folder: Path) -> None:
    without_tables(folder)
    (folder / MARK).unlink()


def only_the_stop_file(folder: Path) -> None:
    without_database(folder)
    (folder / ROOT_KEY).unlink()
    (folder / MARK).unlink()


def only_the_key(folder: Path) -> None:
    without_database(folder)
    (folder / STOPS).unlink()
    (folder / MARK).unlink()


def without_its_mark(folder: Path) -> None:
    (folder / MARK).unlink()


def with_a_damaged_mark(folder: Path) -> None:
    (folder / MARK).write_bytes(b"\1" * 64)


LOSSES = (
    without_database,
    emptied,
    without_tables,
    without_tables_and_mark,
    only_the_stop_file,
    only_the_key,
    without_its_mark,
    with_a_damaged_mark,
)


def content(folder: Path) -> dict[str, bytes]:
    return {p.name: p.read_bytes() for p in folder.iterdir() if p.is_file() and p.name != LOCK}


@pytest.mark.parametrize("lose", LOSSES)
async def test_a_lost_record_is_not_begun_anew_by_itself(
    folder: Path, lose: Callable[[Path], None]
) -> None:
    lose(folder)
    before = content(folder)
    with pytest.raises(ConfigurationError, match="rosic run --begin-anew"):
        await a_store(folder).open()
    assert content(folder) == before, "a refused start has changed something"
    await opened_and_closed(folder, begin_anew=True)
    await opened_and_closed(folder)


async def test_a_record_of_another_run_is_older(folder: Path, tmp_path: Path) -> None:
    older = shutil.copy(folder / DATABASE, tmp_path / "older")
    await opened_and_closed(folder)
    shutil.copy(older, folder / DATABASE)
    with pytest.raises(ConfigurationError, match=r"older than record\.mark"):
        await a_store(folder).open()
    await opened_and_closed(folder, begin_anew=True)
    await opened_and_closed(folder)


@pytest.mark.parametrize("passed_ns", [0, MARK_EVERY_NS + 1])
async def test_a_record_of_the_same_run_is_older(tmp_path: Path, passed_ns: int) -> None:
    """At once after an act of an administrator, after a minute by whatever was written."""
    folder, clock = tmp_path / "data", ManualClock()
    store = DatabaseStore(folder, clock=clock)
    await store.open()
    older = tmp_path / "older"
    shutil.copytree(folder, older)
    await clock.advance(passed_ns / 1e9)
    await store.write(a_claim(1, n=1) if passed_ns else a_decision("revoked"))
    await store.close()
    without_database(folder)
    for path in older.glob(f"{DATABASE}*"):
        shutil.copy(path, folder)
    with pytest.raises(ConfigurationError, match=r"older than record\.mark"):
        await a_store(folder).open()


async def test_the_record_of_another_folder_is_not_taken(folder: Path, tmp_path: Path) -> None:
    other = tmp_path / "other"
    other.mkdir()
    shutil.copy(folder / ROOT_KEY, other)
    await opened_and_closed(other, begin_anew=True)
    for _ in range(5):
        await opened_and_closed(other)
    shutil.copy(other / DATABASE, folder)
    with pytest.raises(ConfigurationError, match="belongs to another one"):
        await a_store(folder).open()


async def test_a_first_start_that_was_cut_off_is_no_loss(tmp_path: Path) -> None:
    store = a_store(tmp_path)
    await store.open()
    await store.close()
    fresh = tmp_path / "fresh"
    fresh.mkdir()
    shutil.copy(tmp_path / ROOT_KEY, fresh / "spare")
    cut_off = DatabaseStore(fresh, clock=ManualClock())
    cut_off._folder.take()
    cut_off._folder.mark.look()
    cut_off._folder.root()
    cut_off._folder.give_back()
    assert (fresh / ROOT_KEY).exists()
    await opened_and_closed(fresh)


def remove(path: Path, original: Path) -> None:
    path.rename(original)


def replace(path: Path, original: Path) -> None:
    path.rename(original)
    shutil.copy(original, path)


@pytest.mark.parametrize("take_away", [remove, replace])
@pytest.mark.parametrize("name", [DATABASE, LOG, STOPS, LOCK, MARK])
async def test_nothing_is_claimed_while_a_file_is_gone(
    tmp_path: Path, name: str, take_away: Callable[[Path, Path], None]
) -> None:
    folder, kept = tmp_path / "data", KeptFiles()
    store = DatabaseStore(folder, clock=ManualClock(), kept=kept)
    latch = FileLatch(folder / STOPS, kept=kept)
    await store.open()
    latch.read()
    await store.write(a_claim(1, n=1))
    assert store.lost_file() == ""
    take_away(folder / name, tmp_path / "original")
    assert store.lost_file() == name
    with pytest.raises(StoreFault, match=f"^{name} is gone or was replaced"):
        await store.write(a_claim(2, n=2))
    if name == STOPS:
        with pytest.raises(StoreFault, match="could not be kept on disk"):
            await latch.write("omni", 1, latched=True)
    else:
        await latch.write("omni", 1, latched=True)
    if name in {STOPS, LOCK, MARK}:
        await store.write(a_fact("what is no motion is written down"))
    (tmp_path / "original").rename(folder / name)
    assert store.lost_file() == ""
    await store.write(a_claim(3, n=3))
    await latch.write("omni", 2, latched=True)
    await store.close()
    await latch.close()
    assert FileLatch(folder / STOPS).read()["omni"] == (2, True)


async def test_the_lock_holds_though_its_file_is_gone(tmp_path: Path) -> None:
    store = a_store(tmp_path)
    await store.open()
    (tmp_path / LOCK).unlink()
    with pytest.raises(ConfigurationError, match="Another gateway"):
        await a_store(tmp_path).open()
    await store.close()
    await opened_and_closed(tmp_path)


async def test_what_is_written_while_it_vanishes_is_refused(tmp_path: Path) -> None:
    """Between the look before a commit and the one after it."""
    kept = KeptFiles()
    store = DatabaseStore(tmp_path, clock=ManualClock(), kept=kept)
    await store.open()
    looks = iter(["", str(tmp_path / LOCK)])
    kept.lost = lambda: next(looks, "")  # type: ignore[method-assign]
    with pytest.raises(StoreFault, match=f"^{LOCK} is gone or was replaced"):
        await store.write(a_claim(1, n=1))
    await store.close()
