"""The simulated robots in a process of their own, and gateways' robots that talk to them."""

from __future__ import annotations

import asyncio
import os
from contextlib import asynccontextmanager, contextmanager
from hashlib import blake2b
from typing import TYPE_CHECKING

import msgspec
from msgspec.structs import replace

from rosic.config.profiles import load_profile, shipped_profiles
from rosic.core.order_gate import OrderGate
from rosic.robots.ros2.bindings.parameters import SET_PARAMETERS, request, service_of
from rosic.robots.ros2.profile import Ros2Profile, ros2_profile
from rosic.robots.ros2.robot import Ros2Robot
from rosic.testing.factories import OrderBook
from rosic_sim.ros2.machine_node import LINK_LOST_S
from tests.pace import patience

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Callable, Iterator
    from pathlib import Path

    from rosic.contracts.clock import Clock
    from rosic.contracts.robot import Tell
    from rosic.core.order import Order, Outcome
    from rosic.core.robot.profile import Profile
    from rosic.core.robot.skill import Argument
    from rosic.robots.ros2.client.runtime import RosRuntime
    from rosic.testing.ros2.graph import RosGraph, RosProcess

SIMULATION = "rosic_sim.ros2.simulation"
FOREVER_S = 60.0


def link_lost(lost_s: float = 0.0) -> tuple[str, ...]:
    """Return how long robots wait for a sign of life: as long as is usual, on a free machine."""
    return ("--link-lost", f"{lost_s or LINK_LOST_S * patience():.2f}")


class Simulated:
    """Robots in another process.

    Attributes:
        process: That process.
        link_lost_s: How long they wait for a sign of life.
    """

    def __init__(self, graph: RosGraph, folder: Path, *robots: str) -> None:
        self.graph = graph
        self._file = folder / f"actuations-{'-'.join(robots)}"
        self.link_lost_s = LINK_LOST_S * patience()
        lost = link_lost(self.link_lost_s)
        self.process: RosProcess = graph.start(
            *("-m", SIMULATION, "--actuations", str(self._file), *lost, *robots),
            timeout_s=120.0,
            ends_with_input=False,
        )

    def actuations(self, robot: str) -> list[str]:
        """Return what a robot has begun: ``move <goal> <number>``."""
        lines = self._file.read_text().splitlines() if self._file.exists() else []
        return [line.removeprefix(f"{robot} ") for line in lines if line.startswith(f"{robot} ")]

    def end(self) -> int:
        """End it as a service manager would."""
        return self.process.stop()


@contextmanager
def simulated(graph: RosGraph, folder: Path, *robots: str) -> Iterator[Simulated]:
    """Run robots until the end of the block."""
    simulation = Simulated(graph, folder, *robots)
    try:
        yield simulation
    finally:
        simulation.end()


class TriedRobot(Ros2Robot):
    """A robot whose commands are never those of another test on the same simulation.

    A goal carries the command's id, and the robot's side turns an id away that it has seen.
    """

    def __init__(self, profile: Profile, clock: Clock) -> None:
        super().__init__(profile, OrderGate.new(profile.id), clock)
        self._salt = os.urandom(8)
        self.book = OrderBook(profile, clock)
        self.begun_before = 0

    async def execute(self, order: Order, tell: Tell) -> Outcome:
        cid = blake2b(order.cid + self._salt, digest_size=16).digest()
        return await super().execute(replace(order, cid=cid), tell)

    async def do(self, skill: str, arguments: dict[str, Argument] | None = None) -> Outcome:
        """Have an order carried out, given now."""
        return await self.execute(self.order(skill, arguments), lambda _report: None)

    def order(self, skill: str, arguments: dict[str, Argument] | None = None) -> Order:
        """Return an order that is good at present."""
        return self.book.order(skill, arguments, stop_generation=self.gate.generation)


def shipped(name: str) -> Ros2Profile:
    """Return a profile that ships."""
    return ros2_profile(load_profile(shipped_profiles()[name]))


def profile_of(**described: object) -> Ros2Profile:
    """Return a profile described as in a file."""
    skills = described.get("skills", {})
    assert isinstance(skills, dict)
    for name, skill in skills.items():
        skill["id"] = name
    return msgspec.convert(described, Ros2Profile)


@asynccontextmanager
async def opened(
    profile: Profile, clock: Clock, say: Callable[[str], None] = lambda _text: None
) -> AsyncIterator[TriedRobot]:
    """Open a robot, and wait until it is heard if it reports anything."""
    robot = TriedRobot(profile, clock)
    await robot.open(say)
    try:
        if profile.at_rest is not None:
            await until(lambda: robot.presence().online is not None)
        yield robot
    finally:
        await robot.close()


async def until(condition: Callable[[], bool], *, timeout_s: float = 60.0) -> None:
    """Wait for a condition.

    Raises:
        TimeoutError: It has not come to hold.
    """
    async with asyncio.timeout(timeout_s):
        while not condition():  # noqa: ASYNC110 - what is measured tells nobody
            await asyncio.sleep(0.01)


async def set_fault(onlooker: RosRuntime, robot: str, name: str, value: bool | float) -> None:
    """Break something, or mend it."""
    link = await onlooker.service(service_of(f"/{robot}/machine"), SET_PARAMETERS)
    answer = await link.call(request({name: value}), timeout_s=30, found_within_s=30)
    assert answer.results[0].successful, answer.results[0].reason
    await link.close()
