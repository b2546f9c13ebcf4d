"""The simulated robot goes to a place at a time, and does a mission that was put together."""

from __future__ import annotations

from math import hypot

from rosic.config.profiles import load_profile, shipped_profiles
from rosic_sim.robots.robot import SimulatedRobot
from tests.gateway.place import Place


class Simulated(Place):
    """Its robots move."""

    kind = SimulatedRobot


def at(here: Place) -> tuple[float, float]:
    pose = here.gateway.robots["omni"].presence().pose
    assert pose is not None
    return pose.x_m, pose.y_m


async def rest(here: Place, seconds: float) -> str:
    before = len(here.chat.told)
    for _ in range(int(seconds / 0.5)):
        await here.clock.advance(0.5)
    return "\n".join(here.chat.shown(told.message).text for told in list(here.chat.told)[before:])


async def test_it_goes_back_to_a_place_at_its_time_and_does_a_mission() -> None:
    omni = load_profile(shipped_profiles()["omni"], link="simulated")
    async with Simulated(fleet=(omni,)).open() as here:
        await rest(here, 2)
        start = at(here)
        told = await here.say("/place omni dock")
        assert told.startswith("omni: dock is here now: goto, dock: ")
        await here.say("omni move 1 m")
        await rest(here, 15)
        away = hypot(at(here)[0] - start[0], at(here)[1] - start[1])
        assert away > 0.9
        await here.say("/in 20 s omni goto dock; turn 90 deg")
        await here.tap(*here.button("Plan it"))
        await rest(here, 15)
        assert hypot(at(here)[0] - start[0], at(here)[1] - start[1]) > 0.9, "not before its time"
        told = await rest(here, 60)
        assert "Planned order 1 (omni goto dock; omni turn 90 deg): done." in told
        assert hypot(at(here)[0] - start[0], at(here)[1] - start[1]) < 0.1
        await here.say("/mission new round")
        await here.say("omni move 0.5 m")
        await here.say("omni goto dock")
        await here.say("/mission save")
        assert hypot(at(here)[0] - start[0], at(here)[1] - start[1]) < 0.1, "nothing moved yet"
        await here.say("/mission start round")
        told = await rest(here, 60)
        assert "done by omni" in told
        assert hypot(at(here)[0] - start[0], at(here)[1] - start[1]) < 0.1
