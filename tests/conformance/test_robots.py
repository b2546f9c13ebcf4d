"""Every robot adapter keeps the contract, and the suite catches each way of breaking it."""

from __future__ import annotations

from contextlib import asynccontextmanager
from typing import TYPE_CHECKING, ClassVar

import pytest

from rosic.config.profiles import load_profile, shipped_profiles
from rosic.core.order_gate import OrderGate
from rosic.core.robot.profile import Link, Profile
from rosic.core.robot.skill import Skill
from rosic.robots.memory import MemoryRobot
from rosic.system import SystemClock
from rosic.testing.faulty.robots import FAULTS_BY_RULE, FaultyRobot
from rosic.testing.robots import RobotConformance
from rosic_sim.robots.robot import SimulatedRobot

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Callable
    from contextlib import AbstractAsyncContextManager

    from rosic.contracts.robot import Robot, Tell
    from rosic.core.order import Order, Outcome
    from rosic.core.robot.skill import Argument


@pytest.fixture
def clock() -> SystemClock:
    return SystemClock()


def memory_profile() -> Profile:
    skills = {name: Skill(id=name) for name in ("short", "long")}
    return Profile(id="m1", link=Link(kind="memory"), skills=skills)


class SlowMemoryRobot(MemoryRobot):
    """Takes a minute for a long order, so that only a stop ends it."""

    async def execute(self, order: Order, tell: Tell) -> Outcome:
        self.work_s = 60.0 if order.skill.id == "long" else 0.0
        return await super().execute(order, tell)


@asynccontextmanager
async def opened(robot: Robot) -> AsyncIterator[Robot]:
    await robot.open(lambda _text: None)
    try:
        yield robot
    finally:
        await robot.close()


class TestMemory(RobotConformance):
    short = "short"
    long = "long"

    def acted(self, robot: Robot) -> int:
        assert isinstance(robot, MemoryRobot)
        return len(robot.acted)

    @pytest.fixture
    def make_robot(self, clock: SystemClock) -> Callable[[], AbstractAsyncContextManager[Robot]]:
        return lambda: opened(SlowMemoryRobot(memory_profile(), OrderGate.new("m1"), clock))


class TestSimulated(RobotConformance):
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

    def acted(self, robot: Robot) -> int:
        assert isinstance(robot, SimulatedRobot)
        return robot.begun

    @pytest.fixture
    def make_robot(self, clock: SystemClock) -> Callable[[], AbstractAsyncContextManager[Robot]]:
        return lambda: opened(
            SimulatedRobot(load_profile(shipped_profiles()["omni"]), OrderGate.new("omni"), clock)
        )


# Some break a rule by never answering: they are waited for in vain.
FAULTS_BOUND_S = 3.0
RULES = sorted(name for name in vars(RobotConformance) if name.startswith("test_"))


def test_every_rule_has_its_fault() -> None:
    assert set(RULES) == set(FAULTS_BY_RULE)


@pytest.mark.parametrize("rule", RULES)
async def test_the_fault_is_caught(rule: str, clock: SystemClock) -> None:
    faulty: type[FaultyRobot] = FAULTS_BY_RULE[rule]

    @asynccontextmanager
    async def make_faulty() -> AsyncIterator[FaultyRobot]:
        async with opened(SlowMemoryRobot(memory_profile(), OrderGate.new("m1"), clock)) as honest:
            yield faulty(honest)

    class Suite(TestMemory):
        bound_s = FAULTS_BOUND_S

        def acted(self, robot: Robot) -> int:
            assert isinstance(robot, FaultyRobot)
            return super().acted(robot.honest)

    with pytest.raises((AssertionError, pytest.fail.Exception, TimeoutError)):
        await getattr(Suite(), rule)(make_faulty, clock)
