"""What is emptied or written over in place under a running gateway is noticed; stops go on."""

from __future__ import annotations

import os
import shutil
from contextlib import asynccontextmanager
from itertools import product
from typing import TYPE_CHECKING

import pytest

from rosic.errors import ConfigurationError, StoreFault
from rosic.stores.data_dir import LOCK
from rosic.stores.database import DatabaseStore
from rosic.stores.record_files import KeptFiles
from rosic.stores.record_mark import DATABASE, LOG, MARK, STOPS
from rosic.stores.stop_latch import FileLatch
from rosic.testing.clock import ManualClock
from rosic.testing.factories import a_claim, a_decision, a_fact

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Callable
    from pathlib import Path

INDEX = f"{DATABASE}-shm"
LOST = "is gone or was replaced, emptied or overwritten"


class Running:
    """A record and a stop file of one gateway, in which something stands."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        kept = KeptFiles()
        self.store = DatabaseStore(folder, clock=ManualClock(), kept=kept)
        self.latch = FileLatch(folder / STOPS, kept=kept)

    async def refuses(self, name: str, file: str) -> None:
        assert self.store.lost_file() == file
        with pytest.raises(StoreFault, match=f"^{file} {LOST}"):
            await self.store.write(a_claim(name, n=9))


@asynccontextmanager
async def running(folder: Path) -> AsyncIterator[Running]:
    gateway = Running(folder)
    await gateway.store.open()
    gateway.latch.read()
    try:
        await gateway.store.write(a_decision("one"))
        await gateway.store.write(a_claim(f"first of {id(gateway)}", n=1))
        await gateway.latch.write("omni", 1, latched=True)
        yield gateway
    finally:
        await gateway.store.close()
        await gateway.latch.close()


def emptied(path: Path) -> None:
    os.truncate(path, 0)


def shortened(path: Path) -> None:
    os.truncate(path, path.stat().st_size - 1)


def lengthened(path: Path) -> None:
    with path.open("ab") as file:
        file.write(b"something else")


def zeroed(path: Path) -> None:
    size = path.stat().st_size
    os.truncate(path, 0)
    os.truncate(path, size)


def written_over(path: Path) -> None:
    with path.open("r+b") as file:
        file.write(b"something else" * 100)


WAYS = (emptied, zeroed, written_over)


@pytest.mark.parametrize(
    ("name", "do"),
    [*product((DATABASE, LOG, STOPS, MARK), WAYS), (STOPS, shortened), (MARK, shortened)],
)
async def test_nothing_is_claimed_in_what_was_changed_in_place(
    tmp_path: Path, name: str, do: Callable[[Path], None]
) -> None:
    async with running(tmp_path) as gateway:
        do(tmp_path / name)
        await gateway.refuses("two", name)
        await gateway.latch.write("omni", 2, latched=True)  # a stop goes on
    again = FileLatch(tmp_path / STOPS)
    assert again.read()["omni"] == (2, True)
    await again.close()


@pytest.mark.parametrize("do", WAYS)
@pytest.mark.parametrize("name", [DATABASE, LOG])
async def test_what_was_changed_in_place_does_not_come_back_by_itself(
    tmp_path: Path, name: str, do: Callable[[Path], None]
) -> None:
    """Neither by a new connection nor by a new start; and it is not folded into what is good."""
    good = {DATABASE: LOG, LOG: DATABASE}[name]
    async with running(tmp_path) as gateway:
        before = (tmp_path / good).read_bytes()
        do(tmp_path / name)
        for number in range(4):
            with pytest.raises(StoreFault):
                await gateway.store.write(a_claim(f"no {number}", n=9))
            assert gateway.store.lost_file()
    assert (tmp_path / good).read_bytes() == before
    with pytest.raises(ConfigurationError):
        await DatabaseStore(tmp_path, clock=ManualClock()).open()


@pytest.mark.parametrize("name", [DATABASE, LOG])
async def test_a_copy_that_is_put_back_in_place_is_noticed(tmp_path: Path, name: str) -> None:
    """As `cp backup/rosic.db rosic.db` does it under a gateway that runs."""
    folder, copy = tmp_path / "data", tmp_path / "copy"
    async with running(folder) as gateway:
        shutil.copy(folder / name, copy)
    async with running(folder) as gateway:
        shutil.copyfile(copy, folder / name)
        await gateway.refuses("two", name)
        with pytest.raises(StoreFault):
            await gateway.store.write(a_claim("three", n=9))
        for _ in range(2):
            with pytest.raises(StoreFault, match="not what it was a moment ago|" + LOST):
                await gateway.store.write(a_decision("revoked"))


async def test_the_log_of_this_run_is_noticed_when_it_is_put_back(tmp_path: Path) -> None:
    folder, copy = tmp_path / "data", tmp_path / "copy"
    async with running(folder) as gateway:
        shutil.copy(folder / LOG, copy)
        await gateway.store.write(a_claim(2, n=2))
        shutil.copyfile(copy, folder / LOG)
        await gateway.refuses("three", LOG)


@pytest.mark.parametrize("do", WAYS)
async def test_the_mark_is_written_again(tmp_path: Path, do: Callable[[Path], None]) -> None:
    async with running(tmp_path) as gateway:
        before = (tmp_path / MARK).read_bytes()
        do(tmp_path / MARK)
        await gateway.refuses("two", MARK)
        await gateway.store.write(a_fact("what is no motion is written down"))
        assert len((tmp_path / MARK).read_bytes()) == len(before)
        assert gateway.store.lost_file() == ""
        await gateway.store.write(a_claim(3, n=3))
    await DatabaseStore(tmp_path, clock=ManualClock()).open()


@pytest.mark.parametrize("do", [*WAYS, shortened, lengthened])
async def test_the_stop_file_is_written_again(tmp_path: Path, do: Callable[[Path], None]) -> None:
    async with running(tmp_path) as gateway:
        await gateway.latch.write("kuka1", 7, latched=False)
        before = (tmp_path / STOPS).read_bytes()
        do(tmp_path / STOPS)
        await gateway.refuses("two", STOPS)
        await gateway.latch.mend()
        assert (tmp_path / STOPS).read_bytes() == before
        assert gateway.store.lost_file() == ""
        await gateway.store.write(a_claim(3, n=3))


async def test_a_stop_that_was_put_back_is_noticed(tmp_path: Path) -> None:
    async with running(tmp_path) as gateway:
        shutil.copy(tmp_path / STOPS, tmp_path / "copy")
        await gateway.latch.write("omni", 2, latched=True)
        shutil.copyfile(tmp_path / "copy", tmp_path / STOPS)
        await gateway.refuses("two", STOPS)


async def test_a_stop_file_that_was_closed_is_looked_at_no_more(tmp_path: Path) -> None:
    async with running(tmp_path) as gateway:
        await gateway.latch.close()
        (tmp_path / STOPS).unlink()
        assert gateway.store.lost_file() == ""


def without(path: Path) -> None:
    path.unlink()


def in_its_way(path: Path) -> None:
    path.unlink()
    path.mkdir()


@pytest.mark.parametrize("do", [without, in_its_way])
@pytest.mark.parametrize("others", [(LOCK,), (STOPS,), (MARK,), (LOCK, STOPS, MARK)])
@pytest.mark.parametrize("name", [DATABASE, LOG, INDEX])
async def test_nothing_at_all_is_written_when_the_record_is_gone_with_others(
    tmp_path: Path, name: str, others: tuple[str, ...], do: Callable[[Path], None]
) -> None:
    async with running(tmp_path) as gateway:
        for other in (*others, name):
            do(tmp_path / other)
        for record in (a_claim(2, n=2), a_decision("revoked")):
            with pytest.raises(StoreFault, match=f"^{name} {LOST}"):
                await gateway.store.write(record)


@pytest.mark.parametrize("error", [PermissionError(), OSError(5, "EIO"), ValueError()])
async def test_what_cannot_be_looked_at_is_lost(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, error: Exception
) -> None:
    async with running(tmp_path) as gateway:
        with monkeypatch.context() as patch:
            patch.setattr(os, "pread", _failing(error))
            await gateway.refuses("two", DATABASE)
        assert gateway.store.lost_file() == ""
        with monkeypatch.context() as patch:
            patch.setattr("pathlib.Path.read_bytes", _failing(error))
            await gateway.refuses("two", MARK)
        await gateway.store.write(a_claim("two", n=9))


def _failing(error: Exception) -> Callable[..., bytes]:
    def fail(*_arguments: object) -> bytes:
        raise error

    return fail
