"""Files as large as a Bot API server of one's own takes: out of a robot, and into a container.

A real `rosic run`, the fake server in local mode, sparse files; what both hold in memory is read
from the kernel.
"""

from __future__ import annotations

import hashlib
import re
import shutil
import time
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
import yaml

from rosic.config.profiles import shipped_profiles
from tests.journeys.lab import Lab, lab

if TYPE_CHECKING:
    from tests.journeys.running import Gateway, Launcher

MB = 1_000_000
OMNI = ('[[robot]]\nprofile = "giver.yaml"\nlink = "simulated"',)
GROWS_AT_MOST_MB = 64
"""Less than any of the files; what is held of a file is some pieces of it."""
WITHIN_S = 540.0


def prepare(folder: Path) -> Path:
    """Write the profile of an omni that gives and takes files; return its outbox."""
    inbox, outbox = folder / "inbox", folder / "outbox"
    for one in (inbox, outbox, folder / "server"):
        one.mkdir()
    profile = yaml.safe_load(shipped_profiles()["omni"].read_text())
    files = {"accept": ["zip"], "max_mb": 2_000, "inbox": str(inbox), "outbox": str(outbox)}
    (folder / "giver.yaml").write_text(yaml.safe_dump(profile | {"files": files}))
    return outbox


def local(place: Lab) -> None:
    """Say that the Bot API server is one's own, and that people may keep what it takes."""
    written = place.config.read_text()
    api = next(line for line in written.splitlines() if line.startswith("api_base"))
    here = f'local_mode = true\nlocal_folder = "{place.folder / "server"}"'
    room = "[files]\nperson_mb = 2_000\nplace_mb = 4_000\n"
    place.config.write_text(written.replace(api, f"{api}\n{here}") + room)


def sparse(path: Path, size: int) -> str:
    """Make an archive that takes no room on the disk; return its SHA-256."""
    with path.open("wb") as file:
        file.write(b"PK\x03\x04")
        file.seek(size - 9)
        file.write(path.name.encode()[:9].rjust(9, b"."))
    return digest_of(path)


def digest_of(path: Path) -> str:
    """Return the SHA-256 of a file."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def peak_mb(gateway: Gateway) -> float:
    """Return the most memory that a process has ever had of its own."""
    status = Path(f"/proc/{gateway.pid}/status").read_text()
    found = re.search(r"^VmHWM:\s+(\d+) kB", status, re.MULTILINE)
    assert found is not None
    return int(found[1]) * 1024 / MB


async def goes_out(place: Lab, outbox: Path, size: int) -> None:
    """Let a file of the robot go to a phone, and see that all of it is there."""
    given = sparse(outbox / "way.zip", size)
    await place.say(place.bo, "/files from omni way.zip")
    sent = await place.reads(place.bo, f"SHA-256 {given}", within_s=WITHIN_S)
    assert sent["document"]["file_size"] == size
    left = [one for one in (place.folder / "server").rglob("*") if one.is_file()]
    assert [digest_of(one) for one in left] == [given]


async def comes_in(place: Lab, size: int) -> None:
    """Let somebody send a file, and see that it is kept."""
    own = place.folder / "hall.zip"
    kept = sparse(own, size)
    sent = {"chat": place.bo, "user": place.bo, "name": own.name, "path": str(own)}
    number = await place.control.call("send_file", **sent)
    await place.reads(place.bo, f"SHA-256 {kept}", to=number, within_s=WITHIN_S)


async def goes_to_the_robot(place: Lab) -> None:
    """Put what somebody has sent into the robot's inbox."""
    asked = await place.ask(place.bo, "/files send hall.zip to omni", "into the inbox of omni?")
    await place.control.tap(place.bo, place.bo, asked["message_id"], "Put it there")
    await place.reads(place.bo, "hall.zip lies in the inbox of omni", within_s=WITHIN_S)
    put, sent = place.folder / "inbox" / "hall.zip", place.folder / "hall.zip"
    assert digest_of(put) == digest_of(sent)


def sweep(folder: Path) -> None:
    """Leave no gigabytes lying about."""
    for one in (folder / "server", folder / "data", folder / "inbox", folder / "outbox"):
        shutil.rmtree(one, ignore_errors=True)


@pytest.mark.parametrize(
    "size_mb", [200, pytest.param(1_900, marks=[pytest.mark.campaign, pytest.mark.limit(1_200)])]
)
async def test_a_large_file_goes_out_and_one_comes_in_and_neither_is_ever_in_memory(
    size_mb: int, tmp_path: Path, launcher: Launcher
) -> None:
    outbox, size = prepare(tmp_path), size_mb * MB
    options = ("--no-limits", "--no-privacy", "--local", str(tmp_path / "server"))
    figures: list[str] = []
    async with lab(tmp_path, launcher, robots=OMNI, options=options) as place:
        local(place)
        gateway = await place.start()
        await place.ask(place.bo, "status", "omni")
        begun_mb = peak_mb(gateway)
        for name, step in (
            ("out", goes_out(place, outbox, size)),
            ("in", comes_in(place, size)),
            ("to the robot", goes_to_the_robot(place)),
        ):
            begun_s = time.monotonic()
            await step
            figures.append(f"{name} {time.monotonic() - begun_s:.1f} s, {peak_mb(gateway):.0f} MB")
        most_mb = peak_mb(gateway)
        gateway.kill()
        gateway = await place.start()
        await place.ask(place.bo, "/files", "hall.zip: zip, ")
        figures.append(f"after a restart {peak_mb(gateway):.0f} MB")
        print(f"{size_mb} MB from {begun_mb:.0f} MB: {'; '.join(figures)}")  # noqa: T201 - figures
        assert max(most_mb, peak_mb(gateway)) < begun_mb + GROWS_AT_MOST_MB, figures
        assert await place.control.violations() == []
    sweep(tmp_path)
