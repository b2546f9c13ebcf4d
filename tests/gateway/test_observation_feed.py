"""Robots shown live to one reader: what they may see, the newest of it, and nothing that waits."""

from __future__ import annotations

import asyncio
import json
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING, Any

from rosic.core.identity import Address
from rosic.core.robot.observation import recorded_robot
from rosic.core.robot.view import CompressedFrame, Pose, ViewKind
from rosic.features.recording import RecordingFeature
from rosic.gateway.observation import RobotObserver
from rosic.gateway.observation_feed import HEARD_AT_MOST, ObservationFeed
from tests.features.recording.studio import Studio
from tests.gateway.place import ADA, BO, VI
from tests.pace import pace

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

JPEG = b"\xff\xd8\xff\xe0" + b"\0" * 100


class Reader:
    """One connection, and what came over it."""

    def __init__(self, place: Studio, account: str) -> None:
        kernel = place.gateway.kernel
        found = kernel.rooms.authoriser.directory.at(Address("memory", account))
        assert found is not None
        assert kernel.recorder is not None
        self.principal = found[0].id
        rights = place.gateway.features.get(RecordingFeature).service.rights_of(self.principal)
        profiles = [p for robot, p in kernel.rooms.profiles.items() if rights.sees(robot)]
        session = kernel.recorder.session([recorded_robot(p) for p in profiles], "lab")
        self.feed = ObservationFeed(session, kernel.machine_clock)
        self.observer = RobotObserver(
            kernel.rooms, kernel.pipeline.executor, kernel.clock, rights, self.feed.take
        )
        self.robots = [profile.id for profile in profiles]
        self.may_send = asyncio.Event()
        self.may_send.set()
        self.told: list[dict[str, Any]] = []
        self.data: dict[int, list[dict[str, Any]]] = {}

    async def send(self, frame: str | bytes) -> None:
        await self.may_send.wait()
        if isinstance(frame, str):
            self.told.append(json.loads(frame))
        else:
            number = int.from_bytes(frame[1:5], "little")
            self.data.setdefault(number, []).append(json.loads(frame[13:]))

    def subscribe(self, number: int, topic: str) -> None:
        channels = [c for t in self.told if t["op"] == "advertise" for c in t["channels"]]
        [channel] = [c["id"] for c in channels if c["topic"] == topic]
        wanted = [{"id": number, "channelId": channel}]
        self.feed.hear(json.dumps({"op": "subscribe", "subscriptions": wanted}))


@asynccontextmanager
async def reader(place: Studio, account: str) -> AsyncIterator[Reader]:
    found = Reader(place, account)
    running = asyncio.create_task(found.feed.run(found.observer, found.robots, found.send))
    await place.past(0.5)
    try:
        yield found
    finally:
        running.cancel()
        await asyncio.gather(running, return_exceptions=True)


async def test_orders_and_places_are_shown_as_they_happen() -> None:
    async with Studio().open() as place, reader(place, ADA) as ada:
        place.robot("omni").pose = Pose(1, 0, frame="odom")
        await place.past(0.5)
        ada.subscribe(1, "/omni/orders")
        ada.subscribe(2, "/omni/pose")
        await place.say("omni move 1 m forward", account=BO, chat=BO)
        place.robot("omni").pose = Pose(2, 0, frame="odom")
        await place.past(0.5)
        assert ada.data[1][-1]["stage"] == "done"
        assert {one["words"] for one in ada.data[1]} == {"move, 1.00 m forward"}
        assert ada.data[2][-1]["pose"]["position"]["x"] == 2.0


async def test_whose_access_ends_sees_nothing_from_that_moment() -> None:
    async with Studio().open() as place, reader(place, VI) as vi:
        vi.subscribe(1, "/omni/state")
        vi.subscribe(2, "/omni/orders")
        await place.say("omni move 1 m forward", account=BO, chat=BO)
        await place.past(1.5)
        assert all(one["words"] == "" and one["by"] == "" for one in vi.data[2])
        assert vi.data[1]
        await place.revoke("Vi")
        before = {number: len(found) for number, found in vi.data.items()}
        await place.say("omni wave", account=BO, chat=BO)
        await place.past(3)
        assert {number: len(found) for number, found in vi.data.items()} == before
        assert vi.told[-1]["op"] == "unadvertise"
        assert not vi.observer.robots


async def test_a_slow_reader_gets_the_newest_and_keeps_nobody_up() -> None:
    async with Studio().open() as place, reader(place, ADA) as ada, reader(place, BO) as bo:
        for each in (ada, bo):
            each.subscribe(1, "/omni/telemetry/battery")
            each.subscribe(2, "/omni/orders")
        await place.past(0.5)
        ada.may_send.clear()
        for battery in range(90, 40, -1):
            place.robot("omni").values = {"battery": float(battery)}
            await place.past(0.5)
        await place.say("omni wave", account=BO, chat=BO)
        await place.past(0.5)
        assert [one["value"] for one in bo.data[1]][-50:] == list(range(90, 40, -1))
        assert bo.data[2][-1]["stage"] == "done"
        ada.may_send.set()
        await place.past(0.5)
        values = [one["value"] for one in ada.data[1]]
        assert values[-1] == 41.0
        assert len(values) <= 3
        assert ada.data[2][-1]["stage"] == "done"


async def test_a_camera_is_looked_at_while_somebody_wants_to_see_it() -> None:
    async with Studio().open() as place, reader(place, ADA) as ada:
        omni = place.robot("omni")
        omni.shows[ViewKind.PICTURE] = CompressedFrame(JPEG)
        await place.past(1)
        assert omni.looked == 0
        ada.subscribe(5, "/omni/camera")
        await place.past(1)
        assert omni.looked == 1
        assert ada.data[5][-1]["format"] == "jpeg"
        ada.feed.hear(json.dumps({"op": "unsubscribe", "subscriptionIds": [5]}))
        await place.past(1)
        assert omni.looked == 0


async def test_whoever_says_more_than_is_read_is_left() -> None:
    async with Studio().open() as place:
        found = Reader(place, ADA)
        running = asyncio.create_task(found.feed.run(found.observer, found.robots, found.send))
        await place.past(0.5)
        for _ in range(HEARD_AT_MOST + 1):
            found.feed.hear("{}")
        await asyncio.wait_for(running, 60 * pace())
        assert found.feed.overflowed
