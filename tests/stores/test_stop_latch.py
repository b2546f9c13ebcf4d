"""The stop file: what damage does to it."""

from __future__ import annotations

import asyncio
import os
import threading
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from rosic.errors import ConfigurationError, StoreFault
from rosic.stores import slots
from rosic.stores.stop_latch import FileLatch
from tests.stores.waits import waits

if TYPE_CHECKING:
    from collections.abc import Callable

ROOM = 8
NAME, STATE = slots.name_offset(1), slots.state_offset(1, ROOM)


async def a_latch(path: Path) -> FileLatch:
    """omni resumed after its third stop, kuka1 (in the second place) resumed after its fifth."""
    latch = FileLatch(path, robots_max=ROOM)
    latch.read()
    await latch.write("omni", 3, latched=False)
    await latch.write("kuka1", 5, latched=False)
    return latch


def damage(path: Path, change: Callable[[bytearray], None]) -> None:
    content = bytearray(path.read_bytes())
    change(content)
    path.write_bytes(content)


def test_the_file_is_whole_and_private_from_the_start(tmp_path: Path) -> None:
    path = tmp_path / "data" / "latch"
    assert FileLatch(path).read() == {}
    assert path.stat().st_mode & 0o777 == 0o600
    assert path.parent.stat().st_mode & 0o777 == 0o700
    assert path.stat().st_size == len(slots.empty_file(4096))
    assert path.stat().st_blocks * 512 >= path.stat().st_size, "blocks that are really there"


async def test_it_never_grows(tmp_path: Path) -> None:
    latch = await a_latch(tmp_path / "latch")
    size = (tmp_path / "latch").stat().st_size
    for generation in range(4, 50):
        await latch.write("omni", generation, latched=True)
    assert (tmp_path / "latch").stat().st_size == size
    await latch.close()


@pytest.mark.parametrize("latched", [True, False])
async def test_an_older_stop_or_resume_changes_nothing(tmp_path: Path, latched: bool) -> None:
    latch = await a_latch(tmp_path / "latch")
    await latch.write("omni", 7, latched=not latched)
    await latch.write("omni", 6, latched=latched)
    await latch.close()
    assert FileLatch(tmp_path / "latch").read()["omni"] == (7, not latched)


@pytest.mark.parametrize("offset", range(64))
async def test_any_damaged_byte_of_a_state_reads_as_stopped(tmp_path: Path, offset: int) -> None:
    latch = await a_latch(tmp_path / "latch")
    await latch.close()

    def flip(content: bytearray) -> None:
        content[STATE + offset] ^= 0x40

    damage(tmp_path / "latch", flip)
    states = FileLatch(tmp_path / "latch").read()
    assert states["omni"] == (3, False)
    assert states["kuka1"][1] is True


async def test_a_state_that_was_wiped_reads_as_stopped(tmp_path: Path) -> None:
    latch = await a_latch(tmp_path / "latch")
    await latch.close()

    def wipe(content: bytearray) -> None:
        content[STATE : STATE + 64] = bytes(64)

    damage(tmp_path / "latch", wipe)
    assert FileLatch(tmp_path / "latch").read() == {"omni": (3, False), "kuka1": (0, True)}


@pytest.mark.parametrize(
    ("shown", "read"),
    [
        (slots.PLAUSIBLE - 1, slots.PLAUSIBLE - 1),
        (slots.PLAUSIBLE, 0),
        (slots.PLAUSIBLE + 1, 0),
        (2**64 - 1, 0),
    ],
)
async def test_a_damaged_state_is_believed_no_generation_that_nobody_reaches(
    tmp_path: Path, shown: int, read: int
) -> None:
    """The next stop has to be later than what was read."""
    latch = await a_latch(tmp_path / "latch")
    await latch.close()

    def show(content: bytearray) -> None:
        content[STATE + 32 : STATE + 40] = shown.to_bytes(8, "little")

    damage(tmp_path / "latch", show)
    assert FileLatch(tmp_path / "latch").read()["kuka1"] == (read, True)


@pytest.mark.parametrize("torn", [1, 8, 32, 39, 40, 41, 48, 63])
async def test_a_torn_write_reads_as_stopped(tmp_path: Path, torn: int) -> None:
    latch = await a_latch(tmp_path / "latch")
    await latch.close()
    new = slots.pack_state(slots.SlotState("kuka1", 6, latched=True))
    old = (tmp_path / "latch").read_bytes()[STATE : STATE + 64]

    def tear(content: bytearray) -> None:
        content[STATE : STATE + torn] = new[:torn]

    damage(tmp_path / "latch", tear)
    generation, latched = FileLatch(tmp_path / "latch").read()["kuka1"]
    untouched = new[:torn] == old[:torn]
    assert latched is not untouched
    assert generation in (5, 6)


@pytest.mark.parametrize("fill", [0, 0xFF])
async def test_a_damaged_name_costs_nothing(tmp_path: Path, fill: int) -> None:
    latch = await a_latch(tmp_path / "latch")
    await latch.close()

    def wipe(content: bytearray) -> None:
        content[NAME : NAME + 64] = bytes([fill]) * 64

    damage(tmp_path / "latch", wipe)
    latch = FileLatch(tmp_path / "latch")
    assert latch.read() == {"omni": (3, False), "kuka1": (5, False)}
    await latch.write("kuka1", 6, latched=True)
    await latch.close()
    assert FileLatch(tmp_path / "latch").read()["kuka1"] == (6, True)


async def test_a_state_in_another_robots_place_is_not_believed(tmp_path: Path) -> None:
    latch = await a_latch(tmp_path / "latch")
    await latch.write("omni", 4, latched=True)
    await latch.close()
    first = slots.state_offset(0, ROOM)

    def move(content: bytearray) -> None:
        content[first : first + 64] = content[STATE : STATE + 64]

    damage(tmp_path / "latch", move)
    states = FileLatch(tmp_path / "latch").read()
    assert states["omni"][1] is True


@pytest.mark.parametrize(
    "change",
    [
        lambda content: content.__setitem__(slice(0, 64), bytes(64)),
        lambda content: content.__setitem__(20, content[20] ^ 1),
        lambda content: content.__delitem__(slice(-64, None)),
        lambda content: content.clear(),
        lambda content: (
            content.__setitem__(slice(NAME, NAME + 64), b"x" * 64),
            content.__setitem__(slice(STATE, STATE + 64), b"x" * 64),
        ),
    ],
    ids=["no header", "a damaged header", "cut short", "empty", "a robot beyond naming"],
)
async def test_a_file_that_cannot_say_who_is_stopped_is_refused(
    tmp_path: Path, change: Callable[[bytearray], None]
) -> None:
    latch = await a_latch(tmp_path / "latch")
    await latch.close()
    damage(tmp_path / "latch", change)
    before = (tmp_path / "latch").read_bytes()
    with pytest.raises(ConfigurationError, match="is damaged"):
        FileLatch(tmp_path / "latch").read()
    latch = FileLatch(tmp_path / "latch")
    with pytest.raises(StoreFault, match="The stop holds"):
        await latch.write("omni", 9, latched=True)
    await latch.close()
    assert (tmp_path / "latch").read_bytes() == before


async def test_a_damaged_place_is_mended_by_the_next_stop(tmp_path: Path) -> None:
    latch = await a_latch(tmp_path / "latch")
    await latch.close()

    def flip(content: bytearray) -> None:
        content[STATE + 41] ^= 1

    damage(tmp_path / "latch", flip)
    latch = FileLatch(tmp_path / "latch")
    assert latch.read()["kuka1"] == (5, True)
    await latch.write("kuka1", 6, latched=False)
    await latch.close()
    assert FileLatch(tmp_path / "latch").read()["kuka1"] == (6, False)


async def test_room_is_bounded_and_said(tmp_path: Path) -> None:
    latch = FileLatch(tmp_path / "latch", robots_max=3)
    for index in range(3):
        await latch.write(f"robot{index}", 1, latched=True)
    with pytest.raises(StoreFault, match="no room"):
        await latch.write("one_more", 1, latched=True)
    with pytest.raises(StoreFault, match="no room"):
        await latch.write("Not a robot's name", 1, latched=True)
    await latch.write("robot2", 2, latched=True)
    await latch.close()
    # An existing file keeps the room it was made with.
    assert len(FileLatch(tmp_path / "latch", robots_max=100).read()) == 3


async def test_more_robots_than_a_file_has_room_for_get_a_larger_one(tmp_path: Path) -> None:
    path = tmp_path / "latch"
    latch = await a_latch(path)
    await latch.write("omni", 4, latched=True)
    await latch.close()
    damage(path, lambda content: content.__setitem__(STATE + 41, content[STATE + 41] ^ 1))
    before = FileLatch(path).read()

    latch = FileLatch(path, robots_min=5_000)
    assert latch.read() == before == {"omni": (4, True), "kuka1": (5, True)}
    assert path.stat().st_size == len(slots.empty_file(5_000))
    assert path.stat().st_mode & 0o777 == 0o600
    for number in range(20):
        await latch.write(f"robot{number}", 1, latched=True)
    await latch.close()

    latch = FileLatch(path, robots_min=10)
    assert latch.read() == before | {f"robot{number}": (1, True) for number in range(20)}
    assert path.stat().st_size == len(slots.empty_file(5_000)), "never smaller"
    await latch.close()


async def test_thousands_of_robots_are_stopped_at_once_and_stay_so(tmp_path: Path) -> None:
    robots = [f"robot{number}" for number in range(5_000)]
    latch = FileLatch(tmp_path / "latch", robots_min=len(robots))
    latch.read()
    writing = [latch.write(robot, 1, latched=True) for robot in robots]
    faults = [fault for fault in await asyncio.gather(*writing, return_exceptions=True) if fault]
    await latch.close()
    assert not faults
    assert FileLatch(tmp_path / "latch").read() == dict.fromkeys(robots, (1, True))


async def test_a_failed_write_is_said_and_made_good_by_the_next(tmp_path: Path) -> None:
    latch = await a_latch(tmp_path / "latch")
    path = tmp_path / "latch"
    held = os.open(path, os.O_RDONLY)
    broken, latch._file = latch._file, held  # a file that cannot be written
    with pytest.raises(StoreFault, match="could not be kept on disk"):
        await latch.write("omni", 4, latched=True)
    assert FileLatch(path).read()["omni"] == (3, False)
    latch._file = broken
    await latch.write("kuka1", 6, latched=True)
    assert FileLatch(path).read() == {"omni": (4, True), "kuka1": (6, True)}
    await latch.close()
    os.close(held)


class Disk:
    """Keeps for good, at each wait, what the file held by then: what a power cut leaves of it."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.kept = path.with_name("kept")

    def wait(self, descriptor: int) -> None:
        assert os.fstat(descriptor).st_ino == self.path.stat().st_ino
        self.kept.write_bytes(self.path.read_bytes())

    def after_a_power_cut(self) -> dict[str, tuple[int, bool]]:
        return FileLatch(self.kept).read()


async def test_a_stop_is_kept_only_when_the_disk_has_confirmed_it(tmp_path: Path) -> None:
    disk = Disk(tmp_path / "latch")
    latch = FileLatch(disk.path, robots_max=ROOM, wait_for_disk=disk.wait)
    await latch.write("omni", 1, latched=True)
    assert disk.after_a_power_cut() == {"omni": (1, True)}
    await asyncio.gather(
        latch.write("omni", 1, latched=False), latch.write("kuka1", 2, latched=True)
    )
    assert disk.after_a_power_cut() == {"omni": (1, False), "kuka1": (2, True)}
    await latch.close()


async def test_a_gateway_waits_for_the_disk_itself(tmp_path: Path) -> None:
    with waits() as made:
        latch = FileLatch(tmp_path / "latch", robots_max=ROOM)
        latch.read()
        made.clear()
        await latch.write("omni", 1, latched=True)
        assert made == ["fdatasync"]
        await latch.mend()
        assert made == ["fdatasync"] * 2
        await latch.close()


async def test_a_stop_file_that_was_mended_outlives_a_power_cut(tmp_path: Path) -> None:
    disk = Disk(tmp_path / "latch")
    latch = FileLatch(disk.path, robots_max=ROOM, wait_for_disk=disk.wait)
    await latch.write("omni", 1, latched=True)
    os.truncate(disk.path, 0)
    disk.kept.write_bytes(b"")
    await latch.mend()
    assert disk.after_a_power_cut() == {"omni": (1, True)}
    await latch.close()


async def test_a_disk_that_does_not_confirm_a_stop_is_said(tmp_path: Path) -> None:
    def fail(_descriptor: int) -> None:
        raise OSError(5, "Input/output error")

    latch = FileLatch(tmp_path / "latch", robots_max=ROOM, wait_for_disk=fail)
    with pytest.raises(StoreFault, match="could not be kept on disk"):
        await latch.write("omni", 1, latched=True)
    await latch.close()


def opened(path: Path) -> int:
    """Return how often this process has a file open."""
    return sum(
        link.exists() and link.resolve() == path.resolve()
        for link in Path("/proc/self/fd").iterdir()
    )


def latch_threads() -> set[threading.Thread]:
    return {thread for thread in threading.enumerate() if thread.name == "rosic-latch"}


async def test_closing_keeps_what_was_asked_for_before_and_leaves_nothing_open(
    tmp_path: Path,
) -> None:
    path = tmp_path / "latch"
    before = latch_threads()  # another test may have left one to the end of the process
    latch = FileLatch(path, robots_max=ROOM)
    latch.read()
    writing = [
        asyncio.create_task(latch.write(f"robot{number}", 1, latched=True)) for number in range(4)
    ]
    await asyncio.sleep(0)
    await latch.close()
    assert opened(path) == 0
    assert latch_threads() <= before
    await asyncio.gather(*writing)
    assert FileLatch(path, robots_max=ROOM).read() == {f"robot{n}": (1, True) for n in range(4)}


async def test_a_latch_that_was_only_read_is_closed_too(tmp_path: Path) -> None:
    latch = FileLatch(tmp_path / "latch")
    latch.read()
    assert opened(tmp_path / "latch") == 1
    await latch.close()
    await latch.close()
    assert opened(tmp_path / "latch") == 0


async def test_a_stop_that_comes_after_closing_is_kept_all_the_same(tmp_path: Path) -> None:
    latch = await a_latch(tmp_path / "latch")
    await latch.close()
    await latch.write("omni", 4, latched=True)
    await latch.close()
    assert FileLatch(tmp_path / "latch").read()["omni"] == (4, True)


async def test_a_stop_overwrites_the_place_of_its_own_robot_only(tmp_path: Path) -> None:
    """What another place says on disk is not said anew by somebody who has nothing to say."""
    path = tmp_path / "latch"
    latch = await a_latch(path)
    before = path.read_bytes()
    other = slots.SlotState("kuka1", 9, latched=True)
    damage(
        path, lambda content: content.__setitem__(slice(STATE, STATE + 64), slots.pack_state(other))
    )
    await latch.write("omni", 4, latched=True)
    await latch.close()
    assert path.read_bytes() != before
    assert FileLatch(path).read() == {"omni": (4, True), "kuka1": (9, True)}


def test_a_folder_that_cannot_be_written_is_said(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("in the way")
    with pytest.raises(ConfigurationError, match="cannot be used"):
        FileLatch(tmp_path / "file" / "latch").read()
