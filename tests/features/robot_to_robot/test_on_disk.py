"""What robots share and who helps whom, on the database that ships: sealed, kept, erased."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

from rosic.features.personal_data import PersonalDataFeature
from rosic.stores.database import DatabaseStore
from tests.features.robot_to_robot.peers import PeerRobots
from tests.features.robot_to_robot.test_storm import RealClock, until
from tests.gateway.place import ADA

if TYPE_CHECKING:
    from pathlib import Path


def place(folder: Path) -> PeerRobots:
    clock = RealClock()
    return PeerRobots(DatabaseStore(folder, clock=clock), clock=clock)


async def answered(here: PeerRobots, name: str, kind: str, **said: object) -> dict[str, object]:
    """Let a robot say something, and wait for its answer."""
    here.robot(name).heard.clear()
    here.speaks(name, kind, ref="r", **said)
    await until(lambda: bool(here.heard(name, "result")))
    return here.heard(name, "result")[0]


async def test_it_is_sealed_on_disk_outlives_a_restart_and_is_erased(tmp_path: Path) -> None:
    async with place(tmp_path).open() as here:
        await answered(here, "omni", "share", topic="road", data="a very wet road")
        asked = await answered(here, "omni", "help", what="stuck at the back door")
        assert (await answered(here, "cf1", "accept", id=asked["id"]))["ok"] is True
        await answered(here, "cf1", "follow", robot="omni")
    written = await asyncio.to_thread(_everything_in, tmp_path)
    assert b"wet road" not in written
    assert b"back door" not in written
    async with place(tmp_path).open() as here:
        got = await answered(here, "cf1", "get", robot="omni")
        assert got["data"] == "a very wet road"
        again = await answered(here, "cf1", "accept", id=asked["id"])
        assert "accepted already, by cf1" in str(again["why"])
        await answered(here, "omni", "share", topic="road", data="dry now")
        await until(lambda: bool(here.heard("cf1", "shared")))
        erasing = here.gateway.features.get(PersonalDataFeature).erasing
        assert erasing is not None
        await erasing.erase_other("omni", "operator")
        assert (await answered(here, "cf1", "get", robot="omni"))["found"] is False
    async with place(tmp_path).open() as here:
        assert (await answered(here, "cf1", "get", robot="omni"))["found"] is False
        listed = await here.say("/assist", account=ADA, chat=ADA)
        assert "back door" not in listed


def _everything_in(folder: Path) -> bytes:
    return b"".join(file.read_bytes() for file in folder.rglob("*") if file.is_file())
