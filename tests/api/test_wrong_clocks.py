"""Clocks that are wrong or are set, and robots that are renamed or gone, under open connections."""

from __future__ import annotations

import asyncio
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING, Any

import pytest
from msgspec.structs import replace

from rosic.authoriser.invitations import InvitedRights
from rosic.core.identity import OPERATOR
from tests.api.served import problem
from tests.api.ways import SPEAKER, WaysWorld, judge_live
from tests.gateway.events import Acted, Steered
from tests.gateway.judging import judge
from tests.pace import pace

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Callable

EVENTS, BRIDGE = "/v1/events", "/rosbridge"
HOUR_S, DAY_S = 3_600.0, 86_400.0
MOVE = {"skill": "move", "arguments": {"distance": 0.5}}


@asynccontextmanager
async def world_of_all_ways() -> AsyncIterator[WaysWorld]:
    world = WaysWorld()
    await world.start()
    SPEAKER.set("")
    try:
        yield world
        await world.heal()
        judge_live(world.log)
    finally:
        await world.close()


async def held(world: WaysWorld, who: str, path: str, seconds: float, **how: Any) -> None:  # noqa: ANN401
    for _ in range(round(seconds * 20)):
        world.hold(who, path, "omni", 0.2, **how)
        await world.turns(200)
        await world.clock.advance(0.05)


def steered(world: WaysWorld) -> list[bool]:
    return [event.moving for event in world.log if isinstance(event, Steered)]


async def until(holds: Callable[[], object]) -> None:
    """Wait for what goes by the loop's own clock."""
    async with asyncio.timeout(60 * pace()):
        while not holds():  # noqa: ASYNC110 - nobody is told
            await asyncio.sleep(0.02)


async def move(world: WaysWorld, who: str, key: str = "") -> tuple[int, str]:
    how = {"json": MOVE, "headers": {"Idempotency-Key": key or "k"}}
    asking = asyncio.ensure_future(world.request(who, "POST", "/v1/robots/omni/orders", **how))
    while not asking.done():  # an answer may wait for the clock
        await world.turns(50)
        await world.clock.advance(0.05)
    answer = await asking
    return answer.status_code, answer.json().get("code") or answer.json().get("id")


# ---- the clock of whoever asks ----


@pytest.mark.parametrize("ahead_s", [-365 * DAY_S, -HOUR_S, HOUR_S, 10 * 365 * DAY_S])
async def test_a_hand_whose_clock_is_far_off_steers_and_its_silence_is_noticed(
    ahead_s: float,
) -> None:
    async with world_of_all_ways() as world:
        await held(world, "Bo", EVENTS, 1.0, ahead_s=ahead_s)
        assert steered(world) == [True]
        await world.clock.advance(0.4)
        assert steered(world) == [True, False]


@pytest.mark.parametrize("set_s", [HOUR_S, 2.0, -2.0, -HOUR_S])
async def test_a_hand_whose_clock_is_set_while_it_steers_steers_no_further(set_s: float) -> None:
    async with world_of_all_ways() as world:
        await held(world, "Bo", EVENTS, 0.5)
        await held(world, "Bo", EVENTS, 1.0, ahead_s=set_s)
        assert steered(world) == [True, False]
        told = [each for each in (await world.socket("Bo", EVENTS)).told if each["event"] == "jog"]
        assert told[-1]["over"]
        assert told[-1]["text"]


@pytest.mark.parametrize("sent_ms", [-1, 0, 1e300, "now", None, [], "1e999"])
async def test_a_time_that_is_none_steers_nothing_twice_and_breaks_nothing(sent_ms: object) -> None:
    async with world_of_all_ways() as world:
        SPEAKER.set("Bo")
        socket = await world.socket("Bo", EVENTS)
        for n in range(20):
            how = {"robot": "omni", "skill": "drive", "values": {"linear": 0.2}}
            socket.say(op="jog", sent_ms=sent_ms, n=n, **how)
            await world.turns(100)
            await world.clock.advance(0.05)
        await world.turns(200)
        await world.clock.advance(0.4)  # it may have begun late, on a busy machine
        assert not socket.closed
        assert steered(world) in ([], [True, False]), "a time that stands still is soon too old"


# ---- the clock of the gateway ----


async def test_a_clock_set_back_moves_nothing_and_stops_and_looks_as_before() -> None:
    async with world_of_all_ways() as world:
        assert (await move(world, "Ada", "before"))[0] == 202
        await world.clock.advance(5.0)
        world.clock.jump_wall(-HOUR_S)
        await world.clock.advance(5.0)
        after = await move(world, "Ada", "after")
        assert after == (503, "time-in-doubt")
        stopped = await world.request("Ada", "POST", "/v1/stop", json={"robots": ["omni"]})
        assert (stopped.status_code, stopped.json()["at_rest"]) == (200, True)
        for who in ("Ada", "Hal"):
            assert (await world.request(who, "GET", "/v1/robots")).status_code == 200
        assert len([event for event in world.log if isinstance(event, Acted)]) == 1


async def test_what_has_ended_by_the_clock_stays_so_when_it_is_set_back() -> None:
    async with world_of_all_ways() as world:
        access = world.gateway.access
        short = InvitedRights(roles=("operator",), lasts_s=DAY_S)
        new = access.programs.enrol("Eve", short, OPERATOR)
        async with access.changes.turn() as turn:
            await turn.write(new.records)
        shown = {"Authorization": f"Bearer {new.secret.reveal()}"}
        assert (await world.request("Ada", "GET", "/v1/me")).status_code == 200
        assert (await world.request("Hal", "GET", "/v1/me", headers=shown)).json()["name"] == "Eve"
        world.clock.jump_wall(2 * DAY_S)
        await world.clock.advance(5.0)
        for again in range(2):
            ended = await world.request("Hal", "GET", "/v1/me", headers=shown)
            assert problem(ended)[:2] == (401, "unrecognised"), again
            assert (await world.request("Ada", "GET", "/v1/me")).status_code == 401, again
            assert (await world.request("Hal", "GET", "/v1/me")).status_code == 200, again
            world.clock.jump_wall(-2 * DAY_S)
            await world.clock.advance(5.0)


async def test_a_ticket_is_good_once_and_for_a_minute_however_the_clock_is_set() -> None:
    async with world_of_all_ways() as world:
        first, second, third = [
            (await world.request("Hal", "POST", "/v1/tickets")).json()["ticket"] for _ in range(3)
        ]
        world.clock.jump_wall(-HOUR_S)
        await world.clock.advance(1.0)
        SPEAKER.set("Hal")
        assert await world.bridged(first) == 0
        assert await world.bridged(first) == 4401
        world.clock.jump_wall(2 * HOUR_S)
        assert await world.bridged(second) == 0, "a minute is one of the clock that nobody sets"
        await world.clock.advance(61.0)
        world.clock.jump_wall(-HOUR_S)
        assert await world.bridged(third) == 4401


@pytest.mark.parametrize("jump_s", [HOUR_S, 40 * DAY_S, -1.0])
async def test_an_order_that_is_given_again_after_the_clock_was_set_is_the_same(
    jump_s: float,
) -> None:
    async with world_of_all_ways() as world:
        first = await move(world, "Hal", "tuesday")
        await world.clock.advance(5.0)
        world.clock.jump_wall(jump_s)
        await world.clock.advance(5.0)
        assert await move(world, "Hal", "tuesday") == first
        await world.close()
        await world.start()
        await move(world, "Hal", "tuesday")
        await world.clock.advance(5.0)
        assert len([event for event in world.log if isinstance(event, Acted)]) == 1
        judge(world)


# ---- robots that are called otherwise, or are gone ----


async def test_a_robot_that_is_renamed_is_another_and_the_old_name_is_none() -> None:
    async with world_of_all_ways() as world:
        SPEAKER.set("Hal")
        before = await world.socket("Hal", BRIDGE)
        before.say(op="publish", topic="/omni/cmd_vel", msg={"linear": {"x": 0.2}})
        await world.turns(200)
        await world.close()
        omni, *others = world.fleet
        world.fleet = (replace(omni, id="rover", title="rover"), *others)
        await world.start()
        robots = (await world.request("Hal", "GET", "/v1/robots")).json()
        assert {robot["id"] for robot in robots} == {"rover", "kuka1"}
        gone = await world.request("Hal", "POST", "/v1/robots/omni/orders", json=MOVE)
        assert problem(gone)[:2] == (404, "not-found")
        done = await world.request(
            "Hal", "POST", "/v1/robots/rover/orders", json=MOVE, headers={"Idempotency-Key": "r"}
        )
        assert done.status_code == 202
        events = await world.socket("Bo", EVENTS)
        events.say(op="jog", robot="omni", skill="drive", values={"linear": 0.2}, sent_ms=1, n=1)
        stop = await world.request("Hal", "POST", "/v1/stop", json={"robots": ["omni"]})
        assert stop.json()["at_rest"] is True, "a name of none stops all"
        assert all(entry.latched for _, entry in world.gateway.rooms.stops.items())
        await until(lambda: any(each["event"] == "jog" for each in events.told))
        told = next(each for each in events.told if each["event"] == "jog")
        assert (told["over"], told["code"]) == (True, "not-found")


async def test_a_robot_that_one_may_see_no_more_is_taken_from_an_open_page_and_bridge() -> None:
    async with world_of_all_ways() as world:
        SPEAKER.set("Hal")
        events, bridge = await world.socket("Hal", EVENTS), await world.socket("Hal", BRIDGE)
        events.say(op="subscribe", topics=["robots"])
        bridge.say(op="subscribe", topic="/omni/odom", type="nav_msgs/msg/Odometry")
        await until(lambda: any(each["event"] == "robot" for each in events.told))
        await world.revoke("Hal")
        await until(lambda: events.closed and bridge.closed)
        assert (events.closed, bridge.closed) == (4401, 4401)
