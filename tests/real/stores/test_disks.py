"""Real obstacles: another process at the database, a full disk, a folder of somebody else."""

from __future__ import annotations

import resource
import signal
import subprocess
import sys
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from rosic.core.records import Letter
from rosic.errors import ConfigurationError, StoreFault
from rosic.stores.data_dir import RESERVE, RESERVE_BYTES
from rosic.stores.database import DatabaseStore
from rosic.stores.record_mark import DATABASE
from rosic.stores.stop_latch import FileLatch
from rosic.testing.clock import ManualClock
from rosic.testing.factories import ADA, OMNI, a_claim, a_stop
from tests.pace import pace

if TYPE_CHECKING:
    from collections.abc import Iterator

PROCESS = Path(__file__).with_name("process.py")

HOLD = """
import sqlite3, sys
database = sqlite3.connect(sys.argv[1], isolation_level=None)
database.execute("BEGIN EXCLUSIVE")
print("held", flush=True)
sys.stdin.read()
"""


def a_store(folder: Path) -> DatabaseStore:
    return DatabaseStore(folder, clock=ManualClock())


@contextmanager
def held_by_another_process(folder: Path) -> Iterator[None]:
    with subprocess.Popen(  # noqa: S603 - the program stands in the test
        [sys.executable, "-c", HOLD, str(folder / DATABASE)],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    ) as process:
        try:
            assert process.stdout is not None
            assert process.stdout.readline() == "held\n"
            yield
        finally:
            process.kill()


async def test_another_process_at_the_database_stops_no_stop(tmp_path: Path) -> None:
    store, latch = a_store(tmp_path), FileLatch(tmp_path / "latch")
    await store.open()
    latch.read()
    with held_by_another_process(tmp_path):
        store.note(a_stop(4))
        with pytest.raises(StoreFault, match="Another program holds the record"):
            await store.write(a_claim(1))
        await latch.write(OMNI, 4, latched=True)
    await store.write(a_claim(1))
    await store.close()
    await latch.close()
    store = a_store(tmp_path)
    memory = await store.open()
    await store.close()
    assert memory.generations == {OMNI: 4}
    assert len(memory.unfinished) == 1
    assert FileLatch(tmp_path / "latch").read() == {OMNI: (4, True)}


async def test_a_held_database_is_not_opened(tmp_path: Path) -> None:
    store = a_store(tmp_path)
    await store.open()
    await store.close()
    with (
        held_by_another_process(tmp_path),
        pytest.raises(ConfigurationError, match="another program holds the record"),
    ):
        await store.open()
    await store.open()
    await store.close()


@contextmanager
def a_gateway(folder: Path) -> Iterator[int]:
    with subprocess.Popen(  # noqa: S603 - the program stands beside the test
        [sys.executable, str(PROCESS), str(folder), "1"], stdout=subprocess.PIPE, text=True
    ) as process:
        try:
            assert process.stdout is not None
            assert process.stdout.readline() == "open\n"
            yield process.pid
        finally:
            process.kill()


async def test_a_second_process_is_refused_with_the_number_of_the_first(tmp_path: Path) -> None:
    with (
        a_gateway(tmp_path) as number,
        pytest.raises(ConfigurationError, match=rf"\(process {number}\)"),
    ):
        await a_store(tmp_path).open()


@contextmanager
def files_no_larger_than(size: int) -> Iterator[None]:
    """What the kernel does to a file at its limit: the write fails, in the middle of whatever."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    ignored = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
        signal.signal(signal.SIGXFSZ, ignored)


async def fill(store: DatabaseStore, first: int) -> tuple[int, StoreFault]:
    """Write until it fails; return how many were written and what was said."""
    for number in range(first, first + 2000):
        try:
            await store.write(a_claim(number, n=number, letter=Letter(ADA, bytes(8000))))
        except StoreFault as fault:
            return number - first, fault
    pytest.fail("the disk did not fill")


async def test_a_file_that_cannot_grow_is_said_and_heals(tmp_path: Path) -> None:
    store, latch = a_store(tmp_path), FileLatch(tmp_path / "latch")
    await store.open()
    latch.read()
    with files_no_larger_than(1 << 20):
        written, more = 0, 1
        while more:  # a failure folds the log into the database: there is room for a while
            more, fault = await fill(store, written)
            written += more
            assert "Nothing was written." in str(fault)
        await latch.write(OMNI, 1, latched=True)
    await store.write(a_claim("later"))
    await store.close()
    await latch.close()
    memory = await store.open()
    await store.close()
    assert len(memory.unfinished) == written + 1
    assert FileLatch(tmp_path / "latch").read() == {OMNI: (1, True)}


@contextmanager
def a_small_disk(where: Path, kib: int) -> Iterator[Path]:
    where.mkdir()
    mount = ["/bin/mount", "-t", "tmpfs", "-o", f"size={kib}k", "rosic-test", str(where)]
    mounted = subprocess.run(mount, capture_output=True, check=False)  # noqa: S603 - see above
    if mounted.returncode:
        pytest.skip("a small disk can only be mounted by root: run this test as root")
    try:
        yield where
    finally:
        subprocess.run(["/bin/umount", "--lazy", str(where)], check=True)  # noqa: S603


async def test_a_full_disk_is_said_and_heals_and_stops_are_kept(tmp_path: Path) -> None:
    with a_small_disk(tmp_path / "disk", kib=4096) as disk:
        store, latch = a_store(disk / "data"), FileLatch(disk / "data" / "latch")
        await store.open()
        latch.read()
        ballast = disk / "ballast"
        ballast.write_bytes(bytes(1 << 20))
        written, fault = await fill(store, 0)
        assert "The disk is full" in str(fault)
        with pytest.raises(OSError, match="No space left"):
            (disk / "one more").write_bytes(bytes(1 << 20))
        store.note(a_stop(7))
        await latch.write(OMNI, 7, latched=True)
        with pytest.raises(StoreFault):
            await store.write(a_claim("later", letter=Letter(ADA, bytes(400_000))))
        (disk / "one more").unlink()
        ballast.unlink()
        await store.write(a_claim("later"))
        await store.close()
        await latch.close()
        memory = await store.open()
        await store.close()
        assert len(memory.unfinished) == written + 1
        assert memory.generations == {OMNI: 7}
        latch = FileLatch(disk / "data" / "latch")
        assert latch.read() == {OMNI: (7, True)}
        await latch.close()


async def test_on_a_full_disk_a_gateway_starts_once_more_and_stops_are_kept(tmp_path: Path) -> None:
    with a_small_disk(tmp_path / "disk", kib=8192) as disk:
        store = a_store(disk / "data")
        await store.open()
        FileLatch(disk / "data" / "latch").read()
        await store.write(a_claim("before"))
        await store.close()
        fill_up(disk / "ballast")

        await store.open()
        latch = FileLatch(disk / "data" / "latch")
        latch.read()
        await latch.write(OMNI, 7, latched=True)
        _, fault = await fill(store, 0)
        assert "The disk is full" in str(fault)
        await latch.write(OMNI, 8, latched=True)
        await store.close()
        await latch.close()

        fill_up(disk / "more ballast")
        with pytest.raises(ConfigurationError, match=r"cannot be opened: the disk is full\."):
            await a_store(disk / "data").open()
        (disk / "ballast").unlink()
        store = a_store(disk / "data")
        assert (await store.open()).generations == {}
        await store.close()
        assert (disk / "data" / RESERVE).stat().st_blocks * 512 >= RESERVE_BYTES
        again = FileLatch(disk / "data" / "latch")
        assert again.read() == {OMNI: (8, True)}
        await again.close()


def fill_up(path: Path) -> None:
    """Leave nothing free on a disk."""
    with path.open("wb", buffering=0) as file, suppress(OSError):
        while file.write(bytes(4096)):
            pass


WITHOUT_OVERRIDE = """
import ctypes, os, sys
CAP_DAC_OVERRIDE, PR_CAPBSET_DROP = 1, 24
if os.geteuid() == 0:
    ctypes.CDLL(None).prctl(PR_CAPBSET_DROP, CAP_DAC_OVERRIDE, 0, 0, 0)
os.execv(sys.executable, [sys.executable, "-c", *sys.argv[1:]])
"""
"""A program that runs another: root gives up what lets it write where nobody may, and nothing else.

Another user would not do: whether that user can read the interpreter and ROSIC itself depends on
where they are, and they may be below a home folder that is closed to others.
"""

OPEN_IT = """
import asyncio, sys
from pathlib import Path
from rosic.errors import ConfigurationError
from rosic.stores.database import DatabaseStore
from rosic.testing.clock import ManualClock
try:
    asyncio.run(DatabaseStore(Path(sys.argv[1]), clock=ManualClock()).open())
except ConfigurationError as error:
    print(error)
"""


def opened_as_modes_say(folder: Path) -> str:
    return subprocess.run(  # noqa: S603 - the programs stand in the test
        [sys.executable, "-c", WITHOUT_OVERRIDE, OPEN_IT, str(folder)],
        capture_output=True,
        text=True,
        check=True,
        timeout=150 * pace(),
    ).stdout


async def test_a_folder_that_may_only_be_read_is_refused(tmp_path: Path) -> None:
    store = a_store(tmp_path / "data")
    await store.open()
    await store.write(a_claim(1))
    await store.close()
    folder = tmp_path / "data"
    for path in (*folder.iterdir(), folder):
        path.chmod(0o555 if path.is_dir() else 0o444)
    before = {path.name: path.read_bytes() for path in folder.iterdir()}
    said = opened_as_modes_say(folder)
    assert "cannot be written" in said
    assert said.count("\n") == 1
    assert {path.name: path.read_bytes() for path in folder.iterdir()} == before
    folder.chmod(0o700)
