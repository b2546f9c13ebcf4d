"""The stop file: each robot has its place in it, and only the file that is there counts."""

from __future__ import annotations

import asyncio
import os
import shutil
from typing import TYPE_CHECKING

import pytest

from rosic.errors import ConfigurationError, StoreFault
from rosic.stores import slots
from rosic.stores.stop_latch import FileLatch
from tests.stores.test_stop_latch import ROOM, a_latch

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path


async def test_robots_that_are_stopped_at_once_keep_their_places_though_others_are_between(
    tmp_path: Path,
) -> None:
    path = tmp_path / "latch"
    latch = FileLatch(path, robots_max=ROOM)
    latch.read()
    for robot in "abcdef":
        await latch.write(robot, 1, latched=False)
    await asyncio.gather(*(latch.write(robot, 2, latched=True) for robot in "fcad"))
    await latch.close()
    assert FileLatch(path).read() == {
        robot: (2, True) if robot in "fcad" else (1, False) for robot in "abcdef"
    }


async def test_a_stop_in_a_file_that_was_replaced_is_not_kept(tmp_path: Path) -> None:
    """Nobody reads the file again in which it stands."""
    path = tmp_path / "latch"
    latch = await a_latch(path)
    path.rename(tmp_path / "original")
    shutil.copy(tmp_path / "original", path)
    with pytest.raises(StoreFault, match="could not be kept on disk"):
        await latch.write("omni", 4, latched=True)
    (tmp_path / "original").rename(path)
    await latch.write("kuka1", 6, latched=True)
    await latch.close()
    assert FileLatch(path).read() == {"omni": (4, True), "kuka1": (6, True)}


async def test_a_file_that_is_refused_is_not_kept_open(tmp_path: Path) -> None:
    path = tmp_path / "latch"
    path.write_bytes(b"no stop file")
    path.chmod(0o600)
    before = sorted(os.listdir("/proc/self/fd"))  # noqa: PTH208 - a descriptor is no path
    with pytest.raises(ConfigurationError):
        FileLatch(path).read()
    assert sorted(os.listdir("/proc/self/fd")) == before  # noqa: PTH208


async def test_a_stop_file_may_be_the_first_thing_in_a_new_folder(tmp_path: Path) -> None:
    path = tmp_path / "rosic" / "data" / "latch"
    latch = await a_latch(path)
    await latch.write("omni", 4, latched=True)
    await latch.close()
    assert FileLatch(path).read()["omni"] == (4, True)


async def test_where_there_is_no_room_a_disk_that_fails_says_nothing_else(tmp_path: Path) -> None:
    fails = False

    def wait(_descriptor: int) -> None:
        if fails:
            raise OSError(5, "Input/output error")

    latch = FileLatch(tmp_path / "latch", robots_max=1, wait_for_disk=wait)
    await latch.write("omni", 1, latched=True)
    fails = True
    with pytest.raises(StoreFault, match="no room"):
        await latch.write("kuka1", 1, latched=True)
    await latch.close()


@pytest.mark.parametrize("number", range(3))
@pytest.mark.parametrize("offset", [slots.name_offset, lambda n: slots.state_offset(n, ROOM)])
async def test_whatever_place_was_written_over_it_is_noticed_and_mended(
    tmp_path: Path, offset: Callable[[int], int], number: int
) -> None:
    latch = await a_latch(tmp_path / "latch")
    await latch.write("drone1", 1, latched=True)
    whole = (tmp_path / "latch").read_bytes()
    with (tmp_path / "latch").open("r+b") as file:
        file.seek(offset(number))
        file.write(b"?" * slots.SLOT_BYTES)
    assert not latch._is_whole()
    await latch.mend()
    assert latch._is_whole()
    assert (tmp_path / "latch").read_bytes() == whole
    await latch.close()


async def test_what_is_being_written_is_not_looked_at_meanwhile(tmp_path: Path) -> None:
    """Nor waited for: a stop is written from another thread."""
    latch = await a_latch(tmp_path / "latch")
    os.truncate(tmp_path / "latch", 0)
    with latch._writing:
        assert latch._is_whole()
    assert not latch._is_whole()
    await latch.close()
