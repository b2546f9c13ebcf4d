"""The stop file: each robot has its place in it, and only the file that is there counts."""

from __future__ import annotations

import asyncio
import os
import shutil
from typing import TYPE_CHECKING

import pytest

from rosic.errors import ConfigurationError, StoreFault
from rosic.stores.latch import FileLatch
from tests.rooms.stores.test_latch import ROOM, a_latch

if TYPE_CHECKING:
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
