"""A thousand robots, all of them there at once: nobody waits for it, and nobody reads it all."""

from __future__ import annotations

import asyncio
from contextlib import asynccontextmanager
from itertools import pairwise
from typing import TYPE_CHECKING

import pytest

from rosic.core.fleet.task import TaskState
from rosic.core.messages import NAMED_AT_MOST
from rosic.core.order import RestReport, Stop
from rosic.core.robot.alert_config import AlertConfig
from rosic.core.robot.profile import Busy, Link, Profile, Telemetry
from rosic.features.dashboard import DashboardFeature
from rosic.features.dashboard.rendering import ROBOTS_AT_MOST
from rosic.features.fleet import FleetFeature
from rosic.features.fleet.monitor import at_once
from rosic.features.media import MediaFeature
from rosic.gateway.replies import OFFERED_AT_MOST
from rosic.gateway.scheduling import AT_ONCE, go_round
from rosic.messengers.telegram.formatting import MESSAGE_UNITS
from rosic.robots.memory import MemoryRobot
from rosic.testing.clock import ManualClock, settle
from tests.gateway.place import MOVE, WAVE, Place
from tests.pace import pace

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

ROBOTS = 1_000
LOW = AlertConfig(name="battery_low", when="battery < 20 %", lasting="1 s")
FLEET = tuple(
    Profile(
        id=f"r{n}",
        link=Link(kind="memory"),
        busy=Busy.QUEUE,
        groups=(f"aisle{n // 50}",),
        telemetry={"battery": Telemetry(unit="%")},
        alerts=(LOW,),
        skills={skill.id: skill for skill in (MOVE, WAVE)},
    )
    for n in range(ROBOTS)
)


class Deaf(MemoryRobot):
    """Some of them never say that they are at rest."""

    async def stop(self, stop: Stop) -> RestReport:
        rest = await super().stop(stop)
        return RestReport(
            stop.robot, confirmed=stop.robot not in {"r7", "r800"}, seconds=rest.seconds
        )


class Warehouse(Place):
    """A place with many robots, none of which is there yet."""

    kind = Deaf

    def appear(self, battery: float = 80.0) -> None:
        """All of them are there, at once."""
        for n in range(ROBOTS):
            robot = self.robot(f"r{n}")
            robot.online, robot.values = True, {"battery": battery}


@asynccontextmanager
async def warehouse() -> AsyncIterator[Warehouse]:
    async with Warehouse(fleet=FLEET).open() as here:
        for n in range(ROBOTS):
            here.robot(f"r{n}").online = False
        yield here


async def test_a_thousand_robots_appear_at_once_and_orders_pass_in_between() -> None:
    async with warehouse() as here:
        assert "r500 is not there" in await here.say("r500 wave")
        here.appear()
        assert "done" in await here.say("r500 wave")
        before = len(here.chat.told)
        await here.clock.advance(5.0)
        await here.quiet()
        assert len(here.chat.told) == before, "robots that are as they should be tell nobody"
        samples = here.gateway.features.get(MediaFeature).sampler.samples
        seen = [n for n in range(ROBOTS) if samples.names(f"r{n}")]
        assert len(seen) == ROBOTS


async def test_what_is_said_of_a_thousand_robots_can_be_read() -> None:
    async with warehouse() as here:
        here.appear()
        status = await here.say("status")
        assert len(status.splitlines()) == NAMED_AT_MOST + 1
        assert status.endswith("and 950 more: say status and their names")
        assert len((await here.say("status aisle3")).splitlines()) == 50, "asked for, all of them"
        told = await here.say("robots")
        assert told.endswith("Which robot? Say its name: these are 50 of 1000.")
        assert sum(map(len, here.last()[1].buttons)) == NAMED_AT_MOST
        assert "Here's the information" in await here.say("request information")
        assert all(len(told.outbound.text) <= MESSAGE_UNITS for told in here.chat.told)


async def test_all_are_stopped_and_who_does_not_confirm_is_named() -> None:
    async with warehouse() as here:
        here.appear()
        told = await here.say("stop")
        assert all(here.gateway.rooms.stops[f"r{n}"].latched for n in range(ROBOTS))
        assert "STOP sent to 1000 robots." in told
        assert "r7 has not confirmed the stop. Use its own stop button." in told
        assert "r800 has not confirmed" in told
        assert "998 of 1000 robots have confirmed that they are at rest, within 0.00 s." in told
        assert len(told) < MESSAGE_UNITS


async def test_which_robot_is_asked_with_a_page_of_buttons_at_most() -> None:
    async with Place(fleet=FLEET[:150]).open() as here:
        await here.say("stop")
        for asked in ("resume", "book"):
            await here.say(asked)
            assert len(here.last()[1].buttons) == OFFERED_AT_MOST
    async with Place(fleet=FLEET[:6]).open() as here:
        await here.say("book")
        assert len(here.last()[1].buttons) == 6, "one was left out"


async def test_a_card_looks_at_those_that_it_shows_alone() -> None:
    async with warehouse() as here:
        here.appear()
        assert "988 more" in await here.say("/card")
        await here.clock.advance(10.0)
        await here.quiet()
        cards = here.gateway.features.get(DashboardFeature).robots
        assert len(cards._snapshots._seen) == ROBOTS_AT_MOST


@pytest.mark.parametrize(("robots", "tasks"), [(0, 200), (200, 200), (1_000, 40), (10**6, 1)])
def test_many_robots_are_weighed_for_fewer_tasks_at_once(robots: int, tasks: int) -> None:
    assert at_once(robots) == tasks


async def test_more_tasks_than_are_weighed_at_once_are_all_done() -> None:
    async with warehouse() as here:
        for _ in range(at_once(ROBOTS) + 5):
            await here.say("/task any wave")
        fleet = here.gateway.features.get(FleetFeature).dispatching.fleet
        assert len(fleet.waiting) == at_once(ROBOTS) + 5, "nobody is there yet"
        here.appear()
        await here.clock.advance(5.0)
        await here.quiet()
        tasks = fleet.tasks.values()
        assert {task.state for task in tasks} == {TaskState.DONE}


async def test_a_round_is_made_a_few_at_a_time_and_takes_its_time_in_all() -> None:
    clock, looks = ManualClock(), list[tuple[int, tuple[int, ...]]]()
    began_ns = clock.monotonic_ns()

    def look(part: object) -> None:
        assert isinstance(part, tuple)
        looks.append((clock.monotonic_ns() - began_ns, part))

    task = asyncio.create_task(go_round(clock, 0.5, range(ROBOTS), look))
    await settle()
    assert len(looks) == 1, "the next part waits for its turn"
    await clock.advance(0.499)
    assert [n for _, part in looks for n in part] == list(range(ROBOTS)), "each of them, once"
    assert max(len(part) for _, part in looks) == AT_ONCE
    moments = [at_ns for at_ns, _ in looks]
    assert max(b - a for a, b in pairwise(moments)) == 25_000_000, "evenly"
    await clock.advance(0.5)
    assert [n for _, part in looks for n in part] == [*range(ROBOTS), *range(ROBOTS)]
    task.cancel()

    await asyncio.wait_for(go_round(clock, 0.5, (), look), 60 * pace())


async def test_a_round_that_came_late_is_not_made_up_for() -> None:
    clock, looks = ManualClock(), list[int]()

    def look(_part: object) -> None:
        looks.append(clock.monotonic_ns())

    task = asyncio.create_task(go_round(clock, 0.5, range(3), look))
    await settle()
    clock._move_to(clock.monotonic_ns() + 60_000_000_000)  # this process stood still for a minute
    await clock.advance(0.0)
    await clock.advance(2.0)
    assert len(looks) <= 8, "not a hundred and twenty looks at once"
    task.cancel()
