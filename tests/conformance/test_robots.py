"""Every robot adapter keeps the contract, and the suite catches each way of breaking it."""

from __future__ import annotations

import asyncio
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING, ClassVar

import pytest

from rosic.config.profiles import load_profile, shipped_profiles
from rosic.core.order_gate import OrderGate
from rosic.core.robot.profile import Link, Profile
from rosic.core.robot.skill import Parameter, Skill
from rosic.robots.memory import MemoryRobot
from rosic.system import SystemClock
from rosic.testing.faulty.live_robots import LIVE_FAULTS_BY_RULE
from rosic.testing.faulty.robots import FAULTS_BY_RULE, FaultyRobot
from rosic.testing.live_robots import LiveRobotConformance
from rosic_sim.robots.machines.activity import ActivityState
from rosic_sim.robots.robot import SimulatedRobot

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Callable
    from contextlib import AbstractAsyncContextManager

    from rosic.contracts.robot import Robot, Tell
    from rosic.core.order import Order, Outcome
    from rosic.core.robot.skill import Argument
    from rosic_sim.robots.machines.machine import Machine


@pytest.fixture
def clock() -> SystemClock:
    return SystemClock()


LOOKS_S = 0.05  # a simulated robot looks at its machine more often than that


def memory_profile() -> Profile:
    skills = {name: Skill(id=name) for name in ("short", "long")}
    speed = Parameter(unit="m/s", min=-1, max=1)
    duration = Parameter(unit="s", min=0.1, max=5)
    skills["drive"] = Skill(id="drive", parameters={"linear": speed, "duration": duration})
    return Profile(id="m1", link=Link(kind="memory"), skills=skills)


class SlowMemoryRobot(MemoryRobot):
    """Takes a minute for a long order, so that only a stop ends it; rolls on once it is done."""

    def __init__(self, profile: Profile, gate: OrderGate, clock: SystemClock) -> None:
        super().__init__(profile, gate, clock)
        self._rolls: asyncio.Event | None = None

    @property
    def moves(self) -> bool:
        """Whether it works, or rolls; driven live, whether it was told to move last."""
        if self.steered:
            return bool(self.steered[-1].get("linear"))
        return bool(self.presence().doing) or (self._rolls is not None and not self._rolls.is_set())

    async def execute(self, order: Order, tell: Tell) -> Outcome:
        self.work_s = 60.0 if order.skill.id == "long" else 0.0
        outcome = await super().execute(order, tell)
        if self._rolls is not None:
            await self._rolls.wait()
        return outcome

    def roll(self) -> None:
        """Be done, and go on moving for a moment."""
        self._rolls = asyncio.Event()
        asyncio.get_running_loop().call_later(0.2, self._rolls.set)
        self.finish()


@asynccontextmanager
async def opened(robot: Robot) -> AsyncIterator[Robot]:
    await robot.open(lambda _text: None)
    try:
        yield robot
    finally:
        await robot.close()


class TestMemory(LiveRobotConformance):
    short = "short"
    long = "long"
    live = "drive"
    live_values: ClassVar[dict[str, float]] = {"linear": 0.5}
    says_progress = False

    def itself(self, robot: Robot) -> SlowMemoryRobot:
        assert isinstance(robot, SlowMemoryRobot)
        return robot

    def acted(self, robot: Robot) -> int:
        return len(self.itself(robot).acted)

    async def moves(self, robot: Robot) -> bool:
        return self.itself(robot).moves

    async def fall_silent(self, robot: Robot) -> None:
        self.itself(robot).lose()

    async def ignore_orders(self, robot: Robot) -> None:
        self.itself(robot).online = False

    async def say_done(self, robot: Robot) -> None:
        self.itself(robot).roll()

    @pytest.fixture
    def make_robot(self, clock: SystemClock) -> Callable[[], AbstractAsyncContextManager[Robot]]:
        return lambda: opened(SlowMemoryRobot(memory_profile(), OrderGate.new("m1"), clock))


class TestSimulated(LiveRobotConformance):
    short = "move"
    short_arguments: ClassVar[dict[str, Argument]] = {
        "direction": "forward",
        "distance": 0.02,
        "speed": 0.25,
    }
    long = "move"
    long_arguments: ClassVar[dict[str, Argument]] = {
        "direction": "forward",
        "distance": 2.0,
        "speed": 0.25,
    }
    live = "drive"
    live_values: ClassVar[dict[str, float]] = {"linear": 0.2, "angular": 0.1}

    def acted(self, robot: Robot) -> int:
        assert isinstance(robot, SimulatedRobot)
        return robot.begun

    def machine(self, robot: Robot) -> Machine:
        assert isinstance(robot, SimulatedRobot)
        return robot.machine

    async def moves(self, robot: Robot) -> bool:
        return not self.machine(robot).at_rest()

    async def fall_silent(self, robot: Robot) -> None:
        assert isinstance(robot, SimulatedRobot)
        robot.online = False

    async def ignore_orders(self, robot: Robot) -> None:
        await self.fall_silent(robot)  # in one process nothing is lost on its way

    async def say_progress(self, robot: Robot, fraction: float) -> None:
        activity = self.machine(robot).activity
        assert activity is not None
        activity.fraction = fraction
        await asyncio.sleep(LOOKS_S)

    async def say_done(self, robot: Robot) -> None:
        activity = self.machine(robot).activity
        assert activity is not None
        activity.end(ActivityState.DONE, "")

    @pytest.fixture
    def make_robot(self, clock: SystemClock) -> Callable[[], AbstractAsyncContextManager[Robot]]:
        return lambda: opened(
            SimulatedRobot(load_profile(shipped_profiles()["omni"]), OrderGate.new("omni"), clock)
        )


# Some break a rule by never answering: they are waited for in vain.
FAULTS_BOUND_S = 3.0
RULES = sorted(name for name in dir(LiveRobotConformance) if name.startswith("test_"))
FAULTS = FAULTS_BY_RULE | LIVE_FAULTS_BY_RULE


def test_every_rule_has_its_fault() -> None:
    assert set(RULES) == set(FAULTS)


@pytest.mark.parametrize("rule", RULES)
async def test_the_fault_is_caught(rule: str, clock: SystemClock) -> None:
    faulty: type[FaultyRobot] = FAULTS[rule]

    @asynccontextmanager
    async def make_faulty() -> AsyncIterator[FaultyRobot]:
        async with opened(SlowMemoryRobot(memory_profile(), OrderGate.new("m1"), clock)) as honest:
            yield faulty(honest)

    class Suite(TestMemory):
        bound_s = FAULTS_BOUND_S

        def itself(self, robot: Robot) -> SlowMemoryRobot:
            assert isinstance(robot, FaultyRobot)
            return super().itself(robot.honest)

    with pytest.raises((AssertionError, pytest.fail.Exception, TimeoutError)):
        await getattr(Suite(), rule)(make_faulty, clock)
