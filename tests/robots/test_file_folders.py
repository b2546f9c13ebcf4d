"""A robot's folders: whole files, never replaced, and no way out of them."""
# ruff: noqa: ASYNC240, ASYNC221, S607 - nothing else runs beside these tests

from __future__ import annotations

import hashlib
import os
import subprocess
from typing import TYPE_CHECKING

import pytest

from rosic.core.robot.profile import Files
from rosic.errors import NotUnderstood, RobotUnreachable
from rosic.robots.file_folders import RobotFolders

if TYPE_CHECKING:
    from collections.abc import AsyncGenerator
    from pathlib import Path

CONTENT = os.urandom(100_000)
DIGEST = hashlib.sha256(CONTENT).digest()


@pytest.fixture
def inbox(tmp_path: Path) -> Path:
    (tmp_path / "in").mkdir()
    return tmp_path / "in"


@pytest.fixture
def outbox(tmp_path: Path) -> Path:
    (tmp_path / "out").mkdir()
    return tmp_path / "out"


@pytest.fixture
def folders(inbox: Path, outbox: Path) -> RobotFolders:
    return RobotFolders({"omni": Files(inbox=str(inbox), outbox=str(outbox))})


async def pieces(content: bytes) -> AsyncGenerator[bytes]:
    for start in range(0, len(content), 30_000):
        yield content[start : start + 30_000]


async def read(folders: RobotFolders, name: str) -> bytes:
    return b"".join([piece async for piece in folders.read("omni", name)])


def held(folder: Path) -> set[str]:
    return {path.name for path in folder.iterdir()}


async def test_a_file_appears_with_its_checksum(folders: RobotFolders, inbox: Path) -> None:
    assert await folders.put("omni", "map 2.png", pieces(CONTENT), DIGEST)
    assert held(inbox) == {"map 2.png", "map 2.png.sha256"}
    assert (inbox / "map 2.png").read_bytes() == CONTENT
    assert (inbox / "map 2.png").stat().st_mode & 0o777 == 0o600
    done = subprocess.run(["sha256sum", "-c", "map 2.png.sha256"], cwd=inbox, check=False)
    assert done.returncode == 0


async def test_nothing_is_ever_replaced(folders: RobotFolders, inbox: Path) -> None:
    (inbox / "map.png").write_bytes(b"before")
    assert not await folders.put("omni", "map.png", pieces(CONTENT), DIGEST)
    (inbox / "b.png.sha256").write_bytes(b"before")
    assert not await folders.put("omni", "b.png", pieces(CONTENT), DIGEST)
    assert (inbox / "map.png").read_bytes() == b"before"
    assert held(inbox) == {"map.png", "b.png.sha256"}


async def test_what_is_not_what_was_meant_never_appears(folders: RobotFolders, inbox: Path) -> None:
    async def broken() -> AsyncGenerator[bytes]:
        yield CONTENT[:50_000]
        raise NotUnderstood("no")

    with pytest.raises(RobotUnreachable, match="inbox"):
        await folders.put("omni", "map.png", pieces(CONTENT + b"more"), DIGEST)
    with pytest.raises(NotUnderstood):
        await folders.put("omni", "map.png", broken(), DIGEST)
    assert held(inbox) == set()


@pytest.mark.parametrize("name", ["x.png", "x.png.sha256", ".x.png.part", ".x.png.sha256.part"])
async def test_no_link_in_an_inbox_is_followed(
    folders: RobotFolders, inbox: Path, tmp_path: Path, name: str
) -> None:
    target = tmp_path / "precious"
    target.write_bytes(b"before")
    for to in (target, tmp_path / "nowhere"):
        (inbox / name).symlink_to(to)
        await folders.put("omni", "x.png", pieces(CONTENT), DIGEST)
        assert target.read_bytes() == b"before"
        assert not (tmp_path / "nowhere").exists()
        for path in inbox.iterdir():
            path.unlink()


async def test_a_folder_that_is_a_link_is_none(tmp_path: Path) -> None:
    (tmp_path / "real").mkdir()
    (tmp_path / "in").symlink_to(tmp_path / "real")
    files = Files(inbox=str(tmp_path / "in"), outbox=str(tmp_path / "in"))
    folders = RobotFolders({"omni": files})
    with pytest.raises(RobotUnreachable, match="inbox"):
        await folders.put("omni", "x.png", pieces(CONTENT), DIGEST)
    with pytest.raises(RobotUnreachable, match="outbox"):
        await folders.names("omni", 9)
    assert held(tmp_path / "real") == set()


@pytest.mark.parametrize(
    "name", ["../x", "a/b", "/etc/x", "", ".", "..", ".hidden", "a\0b", "a\nb"]
)
async def test_a_path_is_no_name(folders: RobotFolders, inbox: Path, name: str) -> None:
    with pytest.raises(RobotUnreachable):
        await folders.put("omni", name, pieces(CONTENT), DIGEST)
    with pytest.raises(RobotUnreachable):
        await read(folders, name)
    assert held(inbox) == set()


async def test_an_inbox_that_is_not_there_is_a_fault(folders: RobotFolders, inbox: Path) -> None:
    inbox.rmdir()
    with pytest.raises(RobotUnreachable, match="operator"):
        await folders.put("omni", "x.png", pieces(CONTENT), DIGEST)


async def test_what_a_robot_gives(folders: RobotFolders, outbox: Path) -> None:
    for number, name in enumerate(("old.log", "new.log")):
        (outbox / name).write_bytes(b"line\n")
        os.utime(outbox / name, ns=(number, number))
    (outbox / ".hidden").write_bytes(b"x")
    (outbox / "folder").mkdir()
    assert await folders.names("omni", 9) == (("new.log", 5, 1), ("old.log", 5, 0))
    assert await folders.names("omni", 1) == (("new.log", 5, 1),)
    assert await read(folders, "new.log") == b"line\n"


@pytest.mark.parametrize("trap", ["link", "hard link", "pipe", "folder", "gone"])
async def test_nothing_else_is_read(
    folders: RobotFolders, outbox: Path, tmp_path: Path, trap: str
) -> None:
    secret = tmp_path / "secret"
    secret.write_bytes(b"secret")
    there = outbox / "run.log"
    if trap == "link":
        there.symlink_to(secret)
    elif trap == "hard link":
        there.hardlink_to(secret)
    elif trap == "pipe":
        os.mkfifo(there)
    elif trap == "folder":
        there.mkdir()
    assert await folders.names("omni", 9) == ()
    with pytest.raises(RobotUnreachable):
        await read(folders, "run.log")
