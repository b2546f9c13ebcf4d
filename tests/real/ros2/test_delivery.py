"""Files handed to a robot's side by a service or a topic, against plain rclpy."""

from __future__ import annotations

import asyncio
import hashlib
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import pytest

from rosic.core.order import Stop
from rosic.core.robot.file_transfer import FileForRobot, Receipt
from rosic.errors import ConfigurationError, RobotOffline, RobotUnreachable
from rosic.system import SystemClock
from rosic.testing.ros2.graph import RosGraph, RosProcess
from tests.pace import pace
from tests.real.ros2.simulated import TriedRobot, profile_of

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable, Iterator

T = TypeVar("T")

PEER = Path(__file__).with_name("peer.py")
CONTENT = b"speed: 0.2\n"
STRING = "std_msgs/msg/String"
TAKE = {
    "service": {
        "name": "/omni/take",
        "type": "diagnostic_msgs/srv/AddDiagnostics",
        "request": {"load_namespace": "$path"},
    }
}
TOPIC = {"topic": {"name": "/omni/file", "type": STRING, "message": {"data": "$path"}}}
RECEIPT = {"topic": "/omni/file_read", "within_s": 5.0}

pytestmark = pytest.mark.usefixtures("peer")


@pytest.fixture(scope="module")
def peer(tmp_path_factory: pytest.TempPathFactory) -> Iterator[RosProcess]:
    with RosGraph(tmp_path_factory.mktemp("peer")) as graph:
        yield graph.start(PEER)


def robot_that(deliver: dict[str, Any], inbox: Path) -> TriedRobot:
    files = {"accept": ["yaml"], "inbox": str(inbox), "max_mb": 0.05, "deliver": deliver}
    profile = profile_of(
        id="omni", title="Omni", link={"kind": "ros2", "namespace": "/omni"}, files=files
    )
    return TriedRobot(profile, SystemClock())


async def delivered(
    deliver: dict[str, Any], folder: Path, name: str = "way.yaml", *, stop: bool = False
) -> Receipt:
    path = folder / name
    path.write_bytes(CONTENT)
    robot = robot_that(deliver, folder)
    await robot.open(lambda _text: None)
    try:
        if stop:
            robot.gate.apply_stop(Stop("omni", robot.gate.generation + 1))
        return await robot.deliver(
            FileForRobot(
                name=name,
                path=str(path),
                sort="yaml",
                size=len(CONTENT),
                digest=hashlib.sha256(CONTENT).digest(),
                content=CONTENT,
            )
        )
    finally:
        await robot.close()


async def until_read(peer: RosProcess, words: str, deliver: Callable[[], Awaitable[T]]) -> T:
    """Deliver until it was read: who has not found us yet hears nothing, and nobody is told."""
    async with asyncio.timeout(90 * pace()):
        while True:
            receipt = await deliver()
            try:
                await asyncio.to_thread(peer.expect, words, timeout_s=5.0)
            except AssertionError:
                continue
            return receipt


async def until_answered(deliver: Callable[[], Awaitable[Receipt]]) -> Receipt:
    """Deliver until a receipt has come: a side that has found the other may not be found yet."""
    async with asyncio.timeout(90 * pace()):
        while True:
            try:
                return await deliver()
            except RobotUnreachable:
                continue


async def test_a_service_says_what_it_has_read(tmp_path: Path) -> None:
    receipt = await delivered(TAKE | {"digest": "message"}, tmp_path)
    assert receipt == Receipt(received=True, digest=hashlib.sha256(CONTENT).hexdigest())
    assert receipt.agrees(hashlib.sha256(CONTENT).digest())


async def test_a_service_that_declines_says_why(tmp_path: Path) -> None:
    receipt = await delivered(TAKE, tmp_path, "bad.yaml")
    assert receipt == Receipt(received=False, declined=True, words="no room")


async def test_a_topic_acknowledges_nothing(peer: RosProcess, tmp_path: Path) -> None:
    receipt = await until_read(peer, "read a.yaml", lambda: delivered(TOPIC, tmp_path, "a.yaml"))
    assert receipt == Receipt(received=False)


async def test_a_topic_of_receipts_says_what_was_read(tmp_path: Path) -> None:
    topic = TOPIC | {"receipt": RECEIPT}
    receipt = await until_answered(lambda: delivered(topic, tmp_path))
    assert receipt.received
    assert receipt.agrees(hashlib.sha256(CONTENT).digest())
    other = await until_answered(lambda: delivered(topic, tmp_path, "other.yaml"))
    assert other.received
    assert not other.agrees(hashlib.sha256(CONTENT).digest())


async def test_silence_leaves_doubt(peer: RosProcess, tmp_path: Path) -> None:
    quiet = TOPIC | {"receipt": RECEIPT | {"within_s": 0.3}}

    async def in_vain() -> None:
        with pytest.raises(RobotUnreachable, match=r"Omni has not answered for 0.3 s"):
            await delivered(quiet, tmp_path, "silent.yaml")

    await until_read(peer, "read silent.yaml", in_vain)


async def test_a_small_text_goes_inside_the_message(peer: RosProcess, tmp_path: Path) -> None:
    mission = {"topic": {"name": "/omni/mission", "type": STRING, "message": {"data": "$text"}}}
    receipt = await until_read(
        peer, "mission 'speed: 0.2\\n'", lambda: delivered(mission, tmp_path)
    )
    assert receipt == Receipt(received=False)


async def test_nothing_is_sent_to_a_stopped_robot(peer: RosProcess, tmp_path: Path) -> None:
    with pytest.raises(RobotOffline, match="stopped"):
        await delivered(TAKE, tmp_path, "late.yaml", stop=True)
    await delivered(TAKE, tmp_path, "after.yaml")
    await asyncio.to_thread(peer.expect, "took after.yaml")
    assert "took late.yaml" not in peer.lines


async def test_a_field_that_is_not_there_is_found_at_opening(tmp_path: Path) -> None:
    for wrong in (
        {"service": {**TAKE["service"], "request": {"path": "$path"}}},
        TAKE | {"digest": "checksum"},
        TOPIC | {"receipt": RECEIPT | {"field": "sum"}},
    ):
        robot = robot_that(wrong, tmp_path)
        with pytest.raises(ConfigurationError):
            await robot.open(lambda _text: None)
