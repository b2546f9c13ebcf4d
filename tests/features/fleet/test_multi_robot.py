"""``/together`` is all or none also when one turns out not to begin once all were asked."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

import pytest

from rosic.config.profiles import load_profile, shipped_profiles
from rosic.core.order import OrderEnding, Outcome
from rosic.core.synchronised_start import misses_start
from rosic.stores.memory import MemoryStore
from rosic_sim.robots.machines.crazyflie import Crazyflie
from rosic_sim.robots.robot import SimulatedRobot
from rosic_sim.robots.simulation_loop import simulation_of
from tests.features.fleet.test_tasks import WAREHOUSE, Worker, heard
from tests.gateway.place import BO, BrokenStore, Place

if TYPE_CHECKING:
    from rosic.contracts.robot import Tell
    from rosic.core.order import Order, RestReport, Stop
    from rosic.core.records import Record

NAMES = ("w1", "w2", "w3")
DRONES = ("cf1", "cf2", "cf3")


class Linked(Worker):
    """Keeps a common start, over a link.

    Attributes:
        opens_s: How long the link takes to open.
        rests_s: How long it takes to come to rest after a stop.
        brakes: How many turns of the event loop it takes when it is cut off.
        declines: What it says when it turns an order down; empty if it does not.
    """

    opens_s = rests_s = 0.0
    brakes = 0
    declines = ""

    async def stop(self, stop: Stop) -> RestReport:
        self.gate.apply_stop(stop)
        await self._clock.sleep(self.rests_s)
        return await super().stop(stop)

    async def execute(self, order: Order, tell: Tell) -> Outcome:
        if self.declines:
            return Outcome(OrderEnding.REFUSED, self.declines)
        await self._clock.sleep(self.opens_s)
        now_ns, wall_ns = self._clock.monotonic_ns(), self._clock.wall_ns()
        if misses_start(order, now_ns, wall_ns):
            self.gate.pass_order(order, now_ns, wall_ns, together=True)
        try:
            return await super().execute(order, tell)
        except asyncio.CancelledError:
            for _ in range(self.brakes):
                await asyncio.sleep(0)
            raise


class Warehouse(Place):
    kind = Linked


class Air(Place):
    kind = SimulatedRobot


def warehouse(store: MemoryStore | None = None) -> Place:
    return Warehouse(store, fleet=WAREHOUSE)


def air() -> Place:
    profiles = shipped_profiles()
    return Air(fleet=tuple(load_profile(profiles[name], link="simulated") for name in DRONES))


def linked(here: Place, name: str) -> Linked:
    found = here.robot(name)
    assert isinstance(found, Linked)
    return found


def drone(here: Place, name: str) -> Crazyflie:
    found = simulation_of(here.clock).world.machines[name]
    assert isinstance(found, Crazyflie)
    return found


def shown(here: Place) -> str:
    """Return what the chat shows in the end."""
    messages = dict.fromkeys(told.message for told in here.chat.told)
    return "\n".join(here.chat.shown(message).text for message in messages)


def at_work(here: Place) -> set[str]:
    return {name for name in NAMES if here.gateway.rooms.linker.current(name) is not None}


async def test_one_that_hears_of_the_start_too_late_ends_it_for_all() -> None:
    async with warehouse().open() as here:
        linked(here, "w2").opens_s = 0.7
        await here.say("/together warehouse wave")
        await heard(here, 0.5)
        assert at_work(here) == set(NAMES), "the others have begun, and nobody knows better"
        await heard(here, 1.0)
        assert at_work(here) == set()
        told = shown(here)
        assert "This reached w2 too late to begin with the others. Nothing was done." in told
        cut = "stopped before it ended 12:00:00: all or none, and w2 did not begin"
        assert told.count(cut) == 2
        assert [here.acted(name) for name in NAMES] == [1, 0, 1]
        assert not any(here.gateway.rooms.stops[name].latched for name in NAMES)


async def test_what_is_asked_of_each_for_itself_goes_on_without_one() -> None:
    async with warehouse().open() as here:
        linked(here, "w2").declines = "The gripper is open."
        await here.say("/broadcast warehouse wave")
        await heard(here, 2.0)
        assert "The gripper is open." in shown(here)
        assert at_work(here) == {"w1", "w3"}


async def test_one_that_has_begun_and_fails_is_its_own_affair() -> None:
    async with warehouse().open() as here:
        await here.say("/together warehouse wave")
        await heard(here, 1.0)
        linked(here, "w2").end(OrderEnding.FAILED, "the gripper is open")
        await heard(here, 1.0)
        assert at_work(here) == {"w1", "w3"}


async def test_one_that_turns_it_down_before_the_start_keeps_all_on_the_ground() -> None:
    async with air().open() as here:
        await here.say("cf3 takeoff 0.5 m")
        await heard(here, 10.0)
        assert drone(here, "cf3").airborne
        await here.say("/together crazyflies takeoff 1 m")
        await heard(here, 5.0)
        assert not drone(here, "cf1").airborne
        assert not drone(here, "cf2").airborne
        assert shown(here).count("all or none, and Crazyflie 3 did not begin") == 2


async def test_a_stop_before_the_start_is_meant_for_all() -> None:
    async with air().open() as here:
        await here.say("/together crazyflies takeoff 1 m")
        await here.clock.advance(0.1)
        await here.say("stop cf2")
        await heard(here, 5.0)
        assert not any(drone(here, name).airborne for name in DRONES)
        assert shown(here).count("all or none, and Crazyflie 2 did not begin") == 2


async def test_who_was_stopped_was_stopped_and_nothing_else() -> None:
    async with warehouse().open() as here:
        linked(here, "w1").rests_s = 0.2
        await here.say("/together warehouse wave")
        await here.say("stop")
        await heard(here, 2.0)
        assert at_work(here) == set()
        told = shown(here)
        assert told.count("stopped before it ended") == 3
        assert "all or none" not in told


async def test_an_end_of_the_gateway_is_no_reason_to_blame_one() -> None:
    here = warehouse()
    async with here.open():
        linked(here, "w1").brakes = linked(here, "w3").brakes = 200
        await here.say("/together warehouse wave")
    told = shown(here)
    assert told.count("ROSIC was shut down") == 3, told
    assert "all or none" not in told


async def test_all_fly_when_nothing_is_in_the_way() -> None:
    async with air().open() as here:
        await here.say("/together crazyflies takeoff 1 m")
        await heard(here, 10.0)
        assert all(drone(here, name).airborne for name in DRONES)
        begun = {drone(here, name).activity.begun_s for name in DRONES}  # type: ignore[union-attr]
        assert len(begun) == 1


class SlowDisk(MemoryStore):
    """Takes its time on the test's clock, once it has a place."""

    place: Place | None = None

    async def write(self, *records: Record) -> None:
        if self.place is not None:
            await self.place.clock.sleep(0.8)
        await super().write(*records)


@pytest.mark.parametrize("command", ["/together warehouse wave", "warehouse wave"])
async def test_the_moment_is_agreed_once_it_is_on_disk(command: str) -> None:
    disk = SlowDisk()
    async with warehouse(disk).open() as here:
        disk.place = here
        here.chat.say(command)
        await here.clock.advance(5.0)
        disk.place = None
        assert at_work(here) == set(NAMES), shown(here)


async def test_what_could_not_be_written_leaves_the_robots_to_others() -> None:
    """All of a common start are asked for before it is written: none is kept by it."""
    store = BrokenStore()
    async with Place(store).open() as place:
        store.broken = True
        told = await place.say("/together swarm wave", account=BO, chat=BO)
        assert "nothing may move" in told
        store.broken = False
        organiser = place.gateway.rooms.organiser
        assert [organiser.holder(robot) for robot in ("cf1", "cf2")] == [None, None]
