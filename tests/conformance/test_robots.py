"""Every robot adapter keeps the contract, and the suite catches each way of breaking it."""

from __future__ import annotations

from contextlib import asynccontextmanager
from typing import TYPE_CHECKING, ClassVar

import pytest

from rosic.app.documents.profiles import load_profile, shipped_profiles
from rosic.core.gate import Gate
from rosic.core.robot import Link, Profile
from rosic.core.skill import Skill
from rosic.robots.memory import MemoryRobot
from rosic.robots.simulated.robot import SimulatedRobot
from rosic.system import SystemClock
from rosic.testing.robots import RobotConformance
from rosic.testing.wicked_robots import SINNERS, Wicked

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Callable
    from contextlib import AbstractAsyncContextManager

    from rosic.contracts.robot import Robot, Tell
    from rosic.core.order import Order, Outcome
    from rosic.core.skill import Argument


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
        return lambda: opened(SlowMemoryRobot(memory_profile(), Gate.new("m1"), clock))


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
            SimulatedRobot(load_profile(shipped_profiles()["omni"]), Gate.new("omni"), clock)
        )


# Some break a rule by never answering: they are waited for in vain.
SINNERS_BOUND_S = 3.0
RULES = sorted(name for name in vars(RobotConformance) if name.startswith("test_"))


def test_every_rule_has_its_sinner() -> None:
    assert set(RULES) == set(SINNERS)


@pytest.mark.parametrize("rule", RULES)
async def test_the_sinner_is_caught(rule: str, clock: SystemClock) -> None:
    sinner: type[Wicked] = SINNERS[rule]

    @asynccontextmanager
    async def make_wicked() -> AsyncIterator[Wicked]:
        async with opened(SlowMemoryRobot(memory_profile(), Gate.new("m1"), clock)) as honest:
            yield sinner(honest)

    class Suite(TestMemory):
        bound_s = SINNERS_BOUND_S

        def acted(self, robot: Robot) -> int:
            assert isinstance(robot, Wicked)
            return super().acted(robot.honest)

    with pytest.raises((AssertionError, pytest.fail.Exception, TimeoutError)):
        await getattr(Suite(), rule)(make_wicked, clock)
