"""The stop lane's disk side: what is kept of a resume that did not come about."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

import pytest

from rosic.core.gate import Gate
from rosic.core.robot import Link, Profile
from rosic.core.skill import Skill
from rosic.core.stopboard import StopBoard
from rosic.errors import RobotUnreachable, StoreFault
from rosic.linker.linker import Linker
from rosic.robots.memory import MemoryRobot
from rosic.stores.latch import FileLatch, MemoryLatch
from rosic.testing.clock import ManualClock, settle

if TYPE_CHECKING:
    from pathlib import Path

    from rosic.contracts.store import Latch

PROFILE = Profile(id="omni", link=Link(kind="memory"), skills={"move": Skill(id="move")})


class Deaf(MemoryRobot):
    """Its side does not answer when it is to be resumed."""

    async def resume(self, generation: int) -> None:  # noqa: ARG002 - nothing hears it
        raise RobotUnreachable("omni does not answer.")


class Broken(MemoryRobot):
    """Its adapter has a fault that nobody thought of."""

    async def resume(self, generation: int) -> None:  # noqa: ARG002
        raise ZeroDivisionError


class Silent(MemoryRobot):
    """Its side never answers when it is to be resumed."""

    async def resume(self, generation: int) -> None:  # noqa: ARG002
        await asyncio.Event().wait()


async def stopped(kind: type[MemoryRobot], latch: Latch) -> tuple[Linker, StopBoard, MemoryRobot]:
    """A robot that was stopped, durably, for the first time."""
    clock = ManualClock()
    robot = kind(PROFILE, Gate("omni"), clock)
    board = StopBoard(["omni"], {})
    linker = Linker({"omni": robot}, board, latch, clock)
    halting = linker.stop(["omni"], "p1")
    assert await halting.latched
    return linker, board, robot


async def test_a_resume_lets_go_on_disk_too() -> None:
    latch = MemoryLatch()
    linker, board, robot = await stopped(MemoryRobot, latch)
    assert await linker.resume("omni", 1)
    assert latch.read() == {"omni": (1, False)}
    assert not board["omni"].latched
    assert not robot.gate.latched


@pytest.mark.parametrize(("kind", "error"), [(Deaf, RobotUnreachable), (Broken, ZeroDivisionError)])
async def test_a_resume_that_failed_leaves_the_robot_stopped_on_disk_too(
    tmp_path: Path, kind: type[MemoryRobot], error: type[Exception]
) -> None:
    latch = FileLatch(tmp_path / "latch")
    linker, board, _ = await stopped(kind, latch)
    with pytest.raises(error):
        await linker.resume("omni", 1)
    assert board["omni"].latched
    assert FileLatch(tmp_path / "latch").read() == {"omni": (1, True)}
    await latch.close()


async def test_a_resume_that_was_cut_off_leaves_the_robot_stopped_on_disk_too() -> None:
    latch = MemoryLatch()
    linker, board, _ = await stopped(Silent, latch)
    resuming = asyncio.create_task(linker.resume("omni", 1))
    await settle()
    resuming.cancel()
    with pytest.raises(asyncio.CancelledError):
        await resuming
    assert board["omni"].latched
    assert latch.read() == {"omni": (1, True)}


class Disk:
    """Confirms what was written, or says that it cannot."""

    def __init__(self) -> None:
        self.full = False

    def wait(self, _descriptor: int) -> None:
        if self.full:
            raise OSError(28, "No space left on device")


async def test_a_resume_that_could_not_be_kept_is_not_written_by_the_next_stop(
    tmp_path: Path,
) -> None:
    """What failed is written again with what comes next: that must not be the resume."""
    disk = Disk()
    latch = FileLatch(tmp_path / "latch", wait_for_disk=disk.wait)
    linker, board, _ = await stopped(MemoryRobot, latch)
    disk.full = True
    with pytest.raises(StoreFault, match="could not be kept on disk"):
        await linker.resume("omni", 1)
    disk.full = False
    await latch.write("kuka1", 1, latched=True)
    assert board["omni"].latched
    assert FileLatch(tmp_path / "latch").read()["omni"] == (1, True)
    await latch.close()


async def test_a_resume_that_a_later_stop_overtook_says_so_and_keeps_the_later_stop() -> None:
    latch = MemoryLatch()
    linker, board, robot = await stopped(MemoryRobot, latch)
    await linker.stop(["omni"], "p2").latched
    assert not await linker.resume("omni", 1)
    assert board["omni"].latched
    assert robot.gate.latched
    assert latch.read() == {"omni": (2, True)}
