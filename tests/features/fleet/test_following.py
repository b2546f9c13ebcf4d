"""From a chat: one drone behind another, measured by what they report, and its ends."""

from __future__ import annotations

from math import hypot

from rosic.config.profiles import load_profile, shipped_profiles
from rosic_sim.robots.robot import SimulatedRobot
from tests.gateway.place import Place

DRONES = tuple(
    load_profile(shipped_profiles()[name], link="simulated") for name in ("cf1", "cf2", "cf3")
)


class Room(Place):
    """Its drones fly."""

    kind = SimulatedRobot

    def gap_m(self) -> float:
        one, other = (self.gateway.rooms.linker.presence(name).pose for name in ("cf1", "cf2"))
        assert one is not None
        assert other is not None
        return hypot(one.x_m - other.x_m, one.y_m - other.y_m)

    async def fly(self, seconds: float) -> None:
        for _ in range(int(seconds / 0.1)):
            await self.clock.advance(0.1)
            await self.quiet()

    def last_of(self, title: str) -> str:
        texts = [self.chat.shown(told.message).text for told in self.chat.told]
        return next(text for text in reversed(texts) if text.startswith(title))


async def test_a_drone_follows_another_until_that_one_has_done_what_it_does() -> None:
    async with Room(fleet=DRONES).open() as here:
        await here.say("cf1 takeoff 1 m\ncf2 takeoff 1 m")
        await here.fly(5)
        await here.say("cf1 goto x=-1.5 y=1.5 z=1 m")
        await here.fly(6)
        told = await here.say("cf2 follow cf1 1.3 m")
        assert "Crazyflie 2: follow" in told
        await here.fly(4)
        await here.say("cf1 goto x=2.8 y=1.5 z=1 m")
        gaps = []
        for _ in range(90):
            await here.fly(0.1)
            pose = here.gateway.rooms.linker.presence("cf1").pose
            assert pose is not None
            if pose.x_m > 0.5:
                gaps.append(here.gap_m())
        assert len(gaps) > 20
        assert max(abs(gap - 1.3) for gap in gaps) < 0.1, gaps
        assert "followed cf1, 1.30 m behind it at the end" in here.last_of("Crazyflie 2: follow")
        presence = here.gateway.rooms.linker.presence("cf2")
        assert presence.doing == ""


async def test_a_stop_of_the_leader_ends_it_and_so_does_one_of_the_follower() -> None:
    async with Room(fleet=DRONES).open() as here:
        await here.say("cf1 takeoff 1 m\ncf2 takeoff 1 m")
        await here.fly(5)
        await here.say("cf2 keep behind cf1")
        await here.fly(1)
        assert "Crazyflie 1" in await here.say("stop cf1")
        await here.fly(1)
        assert "cf1 does not fly any more, hovering" in here.last_of("Crazyflie 2: follow")
        await here.fly(6)
        await here.say("resume cf1")
        await here.say("cf1 takeoff 1 m")
        await here.fly(5)
        await here.say("cf2 follow cf1 bearing=45 deg")
        await here.fly(1)
        await here.say("stop cf2")
        await here.fly(6)
        assert "stopped before it ended" in here.last_of("Crazyflie 2: follow")
        assert here.gateway.rooms.linker.presence("cf2").at_rest
