"""A robot whose link fails when it is asked how the robot is: nobody else is the worse for it."""

from __future__ import annotations

import asyncio
import json
from typing import TYPE_CHECKING

from msgspec.structs import replace

from tests.api.served import served
from tests.api.test_orders import move
from tests.pace import pace

if TYPE_CHECKING:
    import pytest
    from websockets.asyncio.client import ClientConnection

    from rosic.core.robot.profile import Presence


class FailingLink:
    """Fails whenever it is asked, and counts how often."""

    def __init__(self) -> None:
        self.asked = 0

    def __call__(self) -> Presence:
        self.asked += 1
        raise ZeroDivisionError("battery")


async def shown(connection: ClientConnection, robot: str, name: str, value: object) -> None:
    """Wait until a listener is told this of a robot."""
    async with asyncio.timeout(30 * pace()):
        while True:
            told = json.loads(await connection.recv()).get("robot", {})
            known = told if isinstance(told, dict) else {}
            if known.get("id") == robot and (known | known.get("presence", {})).get(name) == value:
                return


async def test_a_link_that_fails_is_not_there_and_every_other_robot_is_seen(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    failing = FailingLink()
    async with served() as place:
        bo = await place.person("Bo")
        async with place.listening(bo) as connection:
            await connection.send('{"op":"subscribe","topics":["robots"]}')
            await shown(connection, "cf3", "online", value=True)
            with monkeypatch.context() as broken:
                broken.setattr(place.gateway.robots["cf3"], "presence", failing)
                await shown(connection, "cf3", "online", value=False)
                assert (await bo.post("/v1/stop", json={})).json()["at_rest"] is True
                await shown(connection, "omni", "stopped", value=True)
                listed = {one["id"]: one for one in (await bo.get("/v1/robots")).json()}
                assert listed["cf3"]["presence"]["online"] is False
                assert listed["omni"]["presence"]["online"] is True
                ada = await place.person("Ada")
                assert (await ada.get("/v1/metrics")).status_code == 200
                assert failing.asked > 2
            await shown(connection, "cf3", "online", value=True)


async def test_a_link_that_fails_keeps_no_other_robot_from_coming_to_rest_at_the_end(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    async with served() as place:
        hal = await place.program("operator")
        order = await hal.post("/v1/robots/omni/orders", json=move(arguments={"distance": 5.0}))
        assert order.status_code == 202
        omni, linker = place.gateway.robots["omni"], place.gateway.rooms.linker
        await place.until(lambda: linker.presence("omni").at_rest is False)
        monkeypatch.setattr(place.gateway.robots["cf3"], "presence", FailingLink())
    assert omni.presence().at_rest is True


async def test_a_link_that_is_silent_is_late_before_its_robot_counts_as_gone(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    async with served() as place:
        bo = await place.person("Bo")
        robot = place.gateway.robots["cf3"]
        heard = robot.presence
        async with place.listening(bo) as connection:
            await connection.send('{"op":"subscribe","topics":["robots"]}')
            await shown(connection, "cf3", "late", value=False)
            with monkeypatch.context() as silent:
                silent.setattr(robot, "presence", lambda: replace(heard(), age_s=1.3))
                await shown(connection, "cf3", "late", value=True)
                listed = (await bo.get("/v1/robots/cf3")).json()["presence"]
                assert (listed["online"], listed["late"]) == (True, True)
                silent.setattr(robot, "presence", lambda: replace(heard(), age_s=1.1))
                await shown(connection, "cf3", "late", value=False)
                silent.setattr(robot, "presence", lambda: replace(heard(), age_s=None))
                assert (await bo.get("/v1/robots/cf3")).json()["presence"]["late"] is False
