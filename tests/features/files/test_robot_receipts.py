"""Files that go on to a robot's own side, and what it says of them."""

from __future__ import annotations

import asyncio
import hashlib
from typing import TYPE_CHECKING

import pytest

from rosic.core.robot.file_transfer import Receipt
from rosic.errors import RobotOffline, RobotUnreachable
from rosic.robots.memory import MemoryRobot
from rosic.robots.ros2.profile import Deliver, ServiceBinding
from tests.features.files.test_transfer import asked, held, place, tapped
from tests.features.files.test_upload import MAP, NOTE, send
from tests.gateway.place import ADA

if TYPE_CHECKING:
    from pathlib import Path

    from tests.features.personal_data.data_gateway import Ward

DIGEST = hashlib.sha256(MAP).hexdigest()


def deliver(field: str = "$path") -> Deliver:
    return Deliver(service=ServiceBinding(name="/take", type="a/srv/B", request={"path": field}))


def omni(ward: Ward) -> MemoryRobot:
    robot = ward.gateway.robots["omni"]
    assert isinstance(robot, MemoryRobot)
    return robot


async def handed(ward: Ward, says: Receipt | Exception | None = None) -> str:
    """Send a picture, hand it over, and return what was said of it in the end."""
    omni(ward).receipt = says
    await send(ward)
    await tapped(ward, "Send it to omni")
    await tapped(ward, "Put it there")
    for _ in range(400):
        if "Put" not in ward.last()[1].text:
            break
        await asyncio.sleep(0.01)
        await ward.quiet()
    return ward.last()[1].text


async def test_what_the_robot_has_read_is_compared(tmp_path: Path) -> None:
    async with place(tmp_path, deliver=deliver()) as ward:
        said = await handed(ward)
        assert said == f"omni has received map.png, and its checksum agrees ({DIGEST[:8]}...)."
        (robot_file,) = omni(ward).delivered
        assert robot_file.path == str(tmp_path / "in" / "map.png")
        assert (robot_file.size, robot_file.digest.hex(), robot_file.content) == (
            len(MAP),
            DIGEST,
            b"",
        )
        assert held(tmp_path) == {"map.png", "map.png.sha256"}


@pytest.mark.parametrize(
    ("says", "said"),
    [
        (Receipt(received=True), "It says no checksum"),
        (Receipt(received=True, digest="ab" * 32), 'read something else: it says "abababab"'),
        (Receipt(received=False), "gives no receipt for files"),
        (
            Receipt(received=False, declined=True, words="no room"),
            "omni has not taken map.png.\nomni says: no room",
        ),
        (RobotOffline("omni is not there."), "map.png lies in the inbox of omni all the same"),
        (RobotUnreachable("omni has not answered."), "Whether omni has taken map.png, I cannot"),
    ],
)
async def test_nothing_more_is_said_than_is_known(
    tmp_path: Path, says: Receipt | Exception, said: str
) -> None:
    async with place(tmp_path, deliver=deliver()) as ward:
        told = await handed(ward, says)
        assert said in told
        assert "agrees" not in told
        assert len(omni(ward).delivered) == 1, "handed over again by itself"


async def test_a_robot_without_an_inbox_is_handed_the_content(tmp_path: Path) -> None:
    async with place(tmp_path, inbox="", deliver=deliver("$text")) as ward:
        await send(ward, "way.yaml", NOTE)
        question = await asked(ward, "/files send way.yaml to omni")
        assert "Hand way.yaml (11 bytes) to omni?" in question
        await tapped(ward, "Put it there")
        (robot_file,) = omni(ward).delivered
        assert (robot_file.content, robot_file.path) == (NOTE, "")
        assert held(tmp_path) == set()
        (decided,) = [d for d in await ward.kept.decisions(9) if d.act == "file-to-robot"]
        assert (decided.by, decided.digest) == (ward.id_of(ADA), hashlib.sha256(NOTE).digest())


async def test_a_stop_meanwhile_keeps_it_from_the_robot(tmp_path: Path) -> None:
    async with place(tmp_path, deliver=deliver()) as ward:
        await send(ward)
        await asked(ward, "/files send map.png to omni")
        await ward.say("stop omni")
        await tapped(ward, "Put it there")
        assert omni(ward).delivered == []
