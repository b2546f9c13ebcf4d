"""A robot's process is frozen in a common start and in a mission: nothing moves it on after it.

The whole gateway, with real nodes: what is said in the chat is what a person would say and read.
"""

from __future__ import annotations

import asyncio
import time
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING

import pytest
from msgspec.structs import replace

from rosic.app.gateway import Gateway, GatewayParts, GatewaySettings
from rosic.config.profiles import known_units
from rosic.core.fleet.mission import Mission, MissionPart
from rosic.core.policy.roles import DEFAULT_ROLES, RoleRules
from rosic.core.rate_limit import RateLimit
from rosic.messengers.memory import MemoryMessenger
from rosic.robots.ros2.robot import Ros2Robot
from rosic.stores.memory import MemoryStore
from rosic.stores.stop_latch import MemoryLatch
from rosic.system import SystemClock
from rosic.testing.clock import SeededEntropy
from rosic.testing.ros2.graph import RosGraph
from tests.gateway.place import PEOPLE
from tests.pace import pace, patience
from tests.real.ros2.base_profile import base_profile
from tests.real.ros2.stream_site import FREEZE, GO_ON, HERE, Velocity, velocities_in

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Iterator
    from pathlib import Path

    from rosic.core.robot.profile import Presence

NAMES = ("base1", "base2")
FROZEN_S = 2.5
# The deadline of what shows rest, and half as long again.
BROKEN_WITHIN_S = 1.5
WATCHED_S = 3.0
READ_WITHIN_S = 30.0
NOT_HEARD = "broken off because it was not heard for 1."
# What a machine does that gives this process no processor for as long as a robot's watchdog waits.
STOOD_STILL = "broken off because ROSIC itself stood still"
_NS = 1_000_000_000
TOUR = Mission(
    name="tour", do=(MissionPart(on="base1", steps=("drive 0.2 m/s 20 s", "drive -0.2 m/s 20 s")),)
)


class Base:
    """One robot's side, and what it has taken."""

    def __init__(self, graph: RosGraph, file: Path, name: str) -> None:
        self.process = graph.start(HERE / "base_node.py", file, name)
        self._file = file

    def sent_after(self, moment_ns: int) -> list[Velocity]:
        """Return the velocities that it took and that were sent after a moment."""
        return [v for v in velocities_in(self._file) if v.sent_ns > moment_ns]


class Chat:
    """A gateway in this process, and what was said to and by it."""

    def __init__(self) -> None:
        clock = SystemClock()
        self.messenger = MemoryMessenger("memory", clock=clock)
        fleet = tuple(replace(base_profile(name=name), groups=("bases",)) for name in NAMES)
        self.gateway = Gateway(
            GatewaySettings(
                profiles=fleet,
                people=PEOPLE,
                limit=RateLimit(burst=1e6, per_s=1e6),
                lease_idle_s=30.0,
                rulebook=RoleRules(roles=DEFAULT_ROLES),
                missions=(TOUR,),
            ),
            GatewayParts(
                messengers=(self.messenger,),
                robot_factory=lambda _kind: Ros2Robot,
                store=MemoryStore(),
                latch=MemoryLatch(),
                clock=clock,
                entropy=SeededEntropy(),
                units=known_units(),
                face=lambda _ns: "12:00:00",
            ),
        )

    @property
    def shown(self) -> str:
        """What the chat shows now."""
        messages = dict.fromkeys(told.message for told in self.messenger.told)
        return "\n".join(self.messenger.shown(message).text for message in messages)

    def presence(self, name: str) -> Presence:
        """Return what is known of a robot."""
        return self.gateway.robots[name].presence()

    async def reads_that_it_ended(self) -> None:
        """Wait until the chat shows that a stream was broken off."""
        end_s = time.monotonic() + READ_WITHIN_S * pace()
        while NOT_HEARD not in self.shown and STOOD_STILL not in self.shown:
            assert time.monotonic() < end_s, f"nobody read that it ended: {self.shown}"
            await asyncio.sleep(0.05)

    async def drives(self, *names: str) -> None:
        """Wait until robots are measured to move."""
        async with asyncio.timeout(60 * pace()):
            while not all(self.presence(name).moves for name in names):  # noqa: ASYNC110
                await asyncio.sleep(0.02)

    async def rests(self) -> None:
        """Wait until all are measured at rest."""
        async with asyncio.timeout(60 * pace()):
            while not all(self.presence(name).at_rest for name in NAMES):  # noqa: ASYNC110
                await asyncio.sleep(0.02)

    @asynccontextmanager
    async def open(self) -> AsyncIterator[Chat]:
        """Run it."""
        await self.gateway.open()
        running = asyncio.create_task(self.gateway.run())
        try:
            await self.rests()
            yield self
        finally:
            running.cancel()
            await asyncio.gather(running, return_exceptions=True)
            await self.gateway.close()


@pytest.fixture
def bases(tmp_path: Path) -> Iterator[dict[str, Base]]:
    with RosGraph(tmp_path) as graph:
        yield {name: Base(graph, tmp_path / name, name) for name in NAMES}


async def freeze(base: Base) -> int:
    """Freeze a robot for a while. Return the time after which nothing may be sent to it."""
    frozen_ns = time.time_ns()
    base.process.process.send_signal(FREEZE)
    await asyncio.sleep(FROZEN_S * patience())
    base.process.process.send_signal(GO_ON)
    return frozen_ns + int(BROKEN_WITHIN_S * patience() * _NS)


async def test_one_of_a_common_start_that_was_frozen_is_driven_no_further(
    bases: dict[str, Base],
) -> None:
    async with Chat().open() as here:
        here.messenger.say("/together bases drive 0.2 m/s 20 s")
        await here.drives(*NAMES)
        broken_ns = await freeze(bases["base1"])
        await here.reads_that_it_ended()
        await asyncio.sleep(WATCHED_S)
        assert bases["base1"].sent_after(broken_ns) == []
        if STOOD_STILL not in here.shown:
            assert bases["base2"].sent_after(broken_ns), "the other is its own affair"
            assert here.shown.count("broken off because it was not heard") == 1


async def test_a_mission_whose_robot_was_frozen_waits_for_a_person(bases: dict[str, Base]) -> None:
    async with Chat().open() as here:
        here.messenger.say("/mission start tour")
        await here.drives("base1")
        broken_ns = await freeze(bases["base1"])
        await here.reads_that_it_ended()
        await asyncio.sleep(WATCHED_S)
        assert bases["base1"].sent_after(broken_ns) == [], "neither this step nor the next"
        assert bases["base2"].sent_after(0) == []
