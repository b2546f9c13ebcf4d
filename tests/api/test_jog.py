"""Live control over the connection of events: an order like any other, ended by letting go."""

from __future__ import annotations

import asyncio
import json
import time
from typing import TYPE_CHECKING, Any

from rosic.core.policy.roles import SkillPrecondition
from rosic.core.time_units import SECOND_NS
from tests.api.served import served
from tests.gateway.test_rights import rules
from tests.pace import pace

if TYPE_CHECKING:
    import pytest
    from websockets.asyncio.client import ClientConnection

    from tests.api.served import ServedGateway

EVERY_S = 0.05


class Stick:
    """Steers omni over a connection, as a page does."""

    def __init__(self, connection: ClientConnection) -> None:
        self._connection = connection
        self._n = 0

    async def send(self, *, release: bool = False, **values: float) -> None:
        self._n += 1
        said: dict[str, Any] = {"op": "jog", "robot": "omni", "skill": "drive", "values": values}
        said |= {"sent_ms": time.time() * 1000, "n": self._n, "release": release}
        await self._connection.send(json.dumps(said))

    async def hold(self, seconds: float, **values: float) -> None:
        for _ in range(round(seconds / EVERY_S)):
            await self.send(release=False, **values)
            await asyncio.sleep(EVERY_S)

    async def heard(self, *, over: bool = True) -> dict[str, Any]:
        async with asyncio.timeout(60 * pace()):
            while True:
                event: dict[str, Any] = json.loads(await self._connection.recv())
                if event["event"] == "jog" and event["over"] is over:
                    return event


def x_m(place: ServedGateway) -> float:
    pose = place.gateway.rooms.linker.presence("omni").pose
    assert pose is not None
    return pose.x_m


def at_rest(place: ServedGateway) -> bool:
    presence = place.gateway.rooms.linker.presence("omni")
    return presence.at_rest is True and not presence.doing


async def test_a_stick_drives_and_letting_go_brings_it_to_rest() -> None:
    async with served() as place, place.listening(await place.person("Bo")) as connection:
        stick = Stick(connection)
        before = x_m(place)
        steering = asyncio.create_task(stick.hold(60 * pace(), linear=0.4))
        driving = await stick.heard(over=False)
        assert driving["robot"] == "omni"
        assert driving["first"] >= 1  # of a crowded machine the first samples may be too old
        await place.until(lambda: x_m(place) > before + 0.1)
        steering.cancel()
        await stick.send(release=True)
        ended = await stick.heard()
        assert ended["ending"] == "done"
        assert ended["text"].startswith("drove live for ")
        assert at_rest(place)


async def test_silence_ends_it_and_nothing_goes_on_before_it_was_let_go() -> None:
    async with served() as place, place.listening(await place.person("Bo")) as connection:
        stick = Stick(connection)
        await stick.hold(0.8, linear=0.4)
        ended = await stick.heard()
        assert (ended["ending"], ended["code"]) == ("cancelled", "controls-silent")
        await place.until(lambda: at_rest(place))
        there = x_m(place)
        await stick.hold(0.8, linear=0.4)
        assert x_m(place) == there
        await stick.send(release=True)
        await stick.hold(1.0, linear=0.4)
        assert x_m(place) > there


async def test_a_connection_that_is_gone_is_let_go() -> None:
    async with served() as place:
        bo = await place.person("Bo")
        async with place.listening(bo) as connection:
            stick = Stick(connection)
            await stick.hold(1.0, linear=0.4)
            assert not at_rest(place)
        await place.until(lambda: at_rest(place))
        there = x_m(place)
        orders = (await bo.get("/v1/orders")).json()
        assert [order["over"] for order in orders] == [True]
        assert x_m(place) == there


async def test_more_than_is_allowed_is_brought_within_it() -> None:
    async with served() as place, place.listening(await place.person("Bo")) as connection:
        stick = Stick(connection)
        steering = asyncio.create_task(stick.hold(1.0, linear=99.0))
        while (await stick.heard(over=False))["text"] != "That is the most that is allowed to you.":
            pass
        await steering


async def test_whoever_may_not_drive_does_not_drive() -> None:
    async with served() as place, place.listening(await place.person("Vi")) as connection:
        stick = Stick(connection)
        await stick.send(linear=0.4)
        refused = await stick.heard()
        assert refused["ending"] == ""
        assert refused["code"] == "not-permitted"
        assert (await (await place.person("Vi")).get("/v1/orders")).json() == []


async def test_what_does_not_stream_is_not_driven_live() -> None:
    async with served() as place, place.listening(await place.person("Bo")) as connection:
        said = {"op": "jog", "robot": "omni", "skill": "move", "values": {}, "sent_ms": 0, "n": 1}
        await connection.send(json.dumps(said))
        refused = await Stick(connection).heard()
        assert refused["code"] == "out-of-bounds"
        assert refused["ending"] == ""
        assert place.gateway.rooms.linker.presence("omni").doing == ""


async def test_a_stop_ends_it() -> None:
    async with served() as place, place.listening(await place.person("Bo")) as connection:
        stick = Stick(connection)
        steering = asyncio.create_task(stick.hold(2.0, linear=0.4))
        await stick.heard(over=False)
        await connection.send(json.dumps({"op": "stop", "id": "s"}))
        ended = await stick.heard()
        assert ended["ending"] == "cancelled"
        await steering
        assert at_rest(place)
        assert place.gateway.rooms.stops["omni"].latched


async def test_whoever_has_to_confirm_first_is_told_so_and_nothing_is_driven() -> None:
    care = rules(SkillPrecondition(scopes=("omni:*",), confirm=True))
    async with served(rules=care) as place, place.listening(await place.person("Bo")) as connection:
        stick = Stick(connection)
        await stick.send(linear=0.4)
        refused = await stick.heard()
        assert refused["text"] == (
            "Somebody has to agree first, so this cannot be driven live. Give it as an order."
        )
        assert list(place.server.context.feed.newest()) == []


async def test_what_was_held_while_the_gateway_stood_still_drives_nothing(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    async with served() as place, place.listening(await place.person("Bo")) as connection:
        stick = Stick(connection)
        with monkeypatch.context() as still:
            still.setattr(place.server.context.page, "waited_ns", lambda: SECOND_NS)
            await stick.hold(0.5, linear=0.4)
            await connection.send(json.dumps({"op": "nonsense"}))
            async with asyncio.timeout(60 * pace()):
                while (event := json.loads(await connection.recv()))["event"] != "problem":
                    assert event["event"] != "jog"
        steering = asyncio.create_task(stick.hold(60 * pace(), linear=0.4))
        assert (await stick.heard(over=False))["robot"] == "omni"
        steering.cancel()
