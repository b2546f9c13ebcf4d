"""A robot's queue: what is replaced is at rest first, the newest counts, nothing dead waits."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

from msgspec.structs import replace

from rosic.core.records import Claimed
from rosic.core.robot.profile import Busy
from rosic.core.robot.skill import Skill
from rosic.robots.memory import DONE, MemoryRobot
from tests.gateway.place import Place, SlowStore, profile

if TYPE_CHECKING:
    from rosic.contracts.robot import Tell
    from rosic.core.order import Order, Outcome
    from rosic.core.robot.profile import Profile

WORK_S = 60.0
REST_S = 1.0


class Heavy(MemoryRobot):
    """Works for a minute and takes a second to rest; knows when two orders overlap."""

    moving = False
    overlaps = 0
    rested = 0

    async def execute(self, order: Order, tell: Tell) -> Outcome:  # noqa: ARG002
        self.gate.pass_order(order, self._clock.monotonic_ns(), self._clock.wall_ns())
        self.acted.append(order.n)
        self.overlaps += self.moving
        self.moving = True
        try:
            await self._clock.sleep(WORK_S)
        except asyncio.CancelledError:
            await self._clock.sleep(REST_S)
            self.moving = False
            self.rested += 1
            raise
        self.moving = False
        return DONE


def heavy(*fleet: Profile) -> Place:
    place = Place(fleet=fleet)
    parts = place.gateway._parts
    place.gateway._parts = replace(parts, robot_factory=lambda _kind: Heavy)
    return place


def robot_of(place: Place) -> Heavy:
    robot = place.robot("omni")
    assert isinstance(robot, Heavy)
    return robot


async def test_a_second_replacement_does_not_cut_short_the_coming_to_rest() -> None:
    async with heavy(profile("omni", busy=Busy.REPLACE)).open() as place:
        for text in ("omni move 1 m", "omni wave", "omni move 2 m"):
            await place.say(text)
        await place.clock.advance(2 * REST_S)
        assert robot_of(place).overlaps == 0, "an order began while the robot still moved"
        assert robot_of(place).rested >= 1


async def test_the_newest_of_several_replacements_is_carried_out() -> None:
    async with heavy(profile("omni", busy=Busy.REPLACE)).open() as place:
        for text in ("omni move 1 m", "omni wave", "omni move 2 m"):
            await place.say(text)
        await place.clock.advance(3 * REST_S)
        assert place.robot("omni").acted[-1] == 3


async def test_the_newer_of_two_that_begin_together_is_carried_out() -> None:
    """Both are on disk in the same moment, as a group of claims is: neither is under way yet."""
    place = heavy(profile("omni", busy=Busy.REPLACE))
    store = SlowStore(Claimed)
    place.gateway._parts = replace(place.gateway._parts, store=store)
    async with place.open():
        place.chat.say("omni move 1 m")
        place.chat.say("omni wave", chat="7")
        await place.quiet()
        store.ready.set()
        await place.quiet()
        await place.clock.advance(10.0)
        told = [one.outbound.text for one in place.chat.told]
        assert list(place.robot("omni").acted) == [2], told
        assert any("A later command took its place" in text for text in told), told


async def test_who_replaces_an_order_does_not_shut_rosic_down() -> None:
    async with heavy(profile("omni", busy=Busy.REPLACE)).open() as place:
        await place.say("omni move 1 m")
        await place.say("omni wave")
        await place.clock.advance(2 * REST_S)
        told = [one.outbound.text for one in place.chat.told]
        assert any("stopped before it ended" in text for text in told)
        assert not any("shut down" in text for text in told), told


async def test_an_order_that_expires_sooner_than_those_before_it_is_told_in_time() -> None:
    kuka = profile("omni", busy=Busy.QUEUE)
    patient = {**kuka.skills, "slowly": Skill(id="slowly", lifetime_s=600.0)}
    async with heavy(replace(kuka, skills=patient)).open() as place:
        for text in ("omni move 1 m", "omni slowly", "omni wave"):
            await place.say(text)
        await place.clock.advance(6.0)
        told = [one.outbound.text for one in place.chat.told]
        assert any("busy for too long" in text for text in told), told


async def test_what_expired_waits_no_more() -> None:
    queue = replace(profile("omni", busy=Busy.QUEUE), queue_length=2)
    async with heavy(queue).open() as place:
        for text in ("omni move 1 m", "omni wave", "omni wave"):
            await place.say(text)
        await place.clock.advance(6.0)
        assert place.gateway.rooms.linker.waiting("omni") == 0
        told = await place.say("omni wave")
        assert "waiting already" not in told, told
