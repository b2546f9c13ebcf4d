"""A robot of two processes: no goal outlives what carries it out, nor what drives (I6)."""

from __future__ import annotations

import asyncio
import time
from typing import TYPE_CHECKING

import pytest
from msgspec.structs import replace

from rosic.core.deadman import INTERRUPTED
from rosic.core.order import OrderEnding, OrderStage, Stop
from rosic.errors import RobotOffline, RobotUnreachable, StillMoves
from rosic.robots.ros2.bindings.action import ActionSkill
from rosic.robots.ros2.goal_watch import LOOK_EVERY_S
from rosic.system import SystemClock
from rosic.testing.ros2.graph import RosGraph
from tests.pace import pace, patience
from tests.real.ros2.base_profile import base_profile
from tests.real.ros2.simulated import opened, profile_of, until
from tests.real.ros2.stream_site import FREEZE, GO_ON, HERE

if TYPE_CHECKING:
    from collections.abc import AsyncIterator
    from pathlib import Path

    from rosic.core.order import Outcome
    from rosic.core.robot.profile import Profile
    from rosic.testing.ros2.graph import RosProcess
    from tests.real.ros2.simulated import TriedRobot

GO = {
    "action": {
        "name": "/base/go",
        "type": "rosic_interfaces/action/Move",
        "goal": {"direction": "forward", "distance_m": 3.0},
        "timeout_s": 600.0,
    }
}
ENDED_WITHIN_S = 8.0
STILL_S = 1.0


def profile() -> Profile:
    go = profile_of(id="base", title="Base", link={"kind": "ros2"}, skills={"go": GO}).skills
    base = base_profile()
    return replace(base, skills={**base.skills, **go})


class Halves:
    """Both halves, and the gateway's side."""

    def __init__(self, graph: RosGraph, folder: Path, interfaces: Path, robot: TriedRobot) -> None:
        self.graph = graph
        self.robot = robot
        self._file = folder / "velocities"
        self._interfaces = interfaces
        self.base = graph.start(HERE / "base_node.py", self._file, "base")
        self.navigator = self.navigate("navigator")

    def navigate(self, name: str) -> RosProcess:
        self.navigator = self.graph.start(HERE / "navigator_node.py", self._interfaces, name)
        return self.navigator

    async def go(self) -> asyncio.Task[Outcome]:
        """Send a goal, and return it once it is driven and tells of it."""
        stages: list[OrderStage] = []
        under_way = asyncio.create_task(
            self.robot.execute(self.robot.order("go"), lambda told: stages.append(told.stage))
        )
        await until(lambda: under_way.done() or stages.count(OrderStage.RUNNING) > 10)
        assert not under_way.done(), under_way
        await until(lambda: self.robot.presence().at_rest is False)
        return under_way

    async def rests(self) -> None:
        """Wait until it rests and stays so; see that it is sent no velocity any more.

        One from before may have waited for what was frozen.
        """
        since_ns = time.time_ns()
        rested_s: float | None = None
        async with asyncio.timeout(60 * pace()):
            while rested_s is None or time.monotonic() - rested_s < STILL_S:
                await asyncio.sleep(0.02)
                if self.robot.presence().at_rest is not True:
                    rested_s = None
                elif rested_s is None:
                    rested_s = time.monotonic()
        sent_ns = [int(line.split()[0]) for line in self._file.read_text().splitlines()]
        assert max(sent_ns, default=0) < since_ns  # it may have been sent none at all


def offered(robot: TriedRobot) -> bool:
    """Whether somebody offers the goal: what is frozen is not discovered any more."""
    carrier = robot._carriers["go"]
    assert isinstance(carrier, ActionSkill)
    return carrier._link is not None and carrier._link.ready()


@pytest.fixture
async def halves(tmp_path: Path, interfaces: Path) -> AsyncIterator[Halves]:
    with RosGraph(tmp_path) as graph:
        async with opened(profile(), SystemClock()) as robot:
            here = await asyncio.to_thread(Halves, graph, tmp_path, interfaces, robot)
            await until(lambda: robot.presence().at_rest is True)
            await until(lambda: offered(robot))
            yield here
            for process in (here.base, here.navigator):
                process.process.send_signal(GO_ON)


@pytest.mark.limit(240)
async def test_a_goal_ends_when_what_drives_is_frozen(halves: Halves) -> None:
    under_way = await halves.go()
    frozen_s = time.monotonic()
    halves.base.process.send_signal(FREEZE)
    with pytest.raises(
        RobotUnreachable, match=r"broken off because its motion was not measured for \d.* s"
    ):
        await asyncio.wait_for(under_way, 60 * pace())
    assert time.monotonic() - frozen_s < ENDED_WITHIN_S * patience()
    await asyncio.to_thread(halves.navigator.expect, "called off")
    halves.base.process.send_signal(GO_ON)
    await halves.rests()


@pytest.mark.limit(240)
async def test_a_goal_ends_when_what_carries_it_out_is_frozen(halves: Halves) -> None:
    under_way = await halves.go()
    frozen_s = time.monotonic()
    halves.navigator.process.send_signal(FREEZE)
    outcome = await asyncio.wait_for(under_way, 60 * pace())
    assert time.monotonic() - frozen_s < ENDED_WITHIN_S * patience()
    assert (outcome.ending, outcome.code) == (OrderEnding.FAILED, INTERRUPTED)
    assert outcome.note.startswith("moved 0.")
    assert "; broken off because its software told nothing of it for 3." in outcome.note
    assert outcome.facts["distance_m"] > 0
    # It has rested; what is frozen may still go on, so nothing else is begun beside it.
    await until(lambda: halves.robot._settling._task is None)
    with pytest.raises(RobotOffline, match="it may go on with it"):
        await halves.robot.do("drive", {"linear": 0.1, "duration": 0.2})
    halves.navigator.process.send_signal(GO_ON)
    await asyncio.to_thread(halves.navigator.expect, "called off")
    await halves.rests()
    outcome = await halves.robot.do("drive", {"linear": 0.1, "duration": 0.3})
    assert outcome.ending is OrderEnding.DONE


@pytest.mark.limit(240)
async def test_a_goal_ends_when_another_has_taken_the_place_of_what_carried_it_out(
    halves: Halves,
) -> None:
    under_way = await halves.go()
    killed_s = time.monotonic()
    await asyncio.to_thread(halves.navigator.kill)
    await asyncio.to_thread(halves.navigate, "navigator_b")
    outcome = await asyncio.wait_for(under_way, 60 * pace())
    assert time.monotonic() - killed_s < ENDED_WITHIN_S * patience()
    assert outcome.ending is OrderEnding.FAILED
    assert outcome.note.endswith("; broken off because its software began anew")
    await halves.rests()
    under_way = await halves.go()
    assert (await halves.robot.stop(Stop("base", 1))).confirmed
    assert (await asyncio.wait_for(under_way, 60 * pace())).ending is OrderEnding.CANCELLED


@pytest.mark.limit(240)
async def test_a_goal_ends_when_what_drives_was_frozen_before_it_was_accepted(
    halves: Halves,
) -> None:
    stages: list[OrderStage] = []
    halves.navigator.process.send_signal(FREEZE)
    under_way = asyncio.create_task(
        halves.robot.execute(halves.robot.order("go"), lambda told: stages.append(told.stage))
    )
    await until(lambda: OrderStage.SENT in stages)
    halves.base.process.send_signal(FREEZE)
    seen_s = halves.robot._measured.within_s + 2 * LOOK_EVERY_S
    await until(lambda: (halves.robot._measured.judged_age_s() or 0.0) > seen_s)
    halves.base.process.send_signal(GO_ON)
    # At once: an acceptance is waited for 5 s, and no longer on a slow machine.
    halves.navigator.process.send_signal(GO_ON)
    outcome = await asyncio.wait_for(under_way, 30 * pace())
    assert (outcome.ending, outcome.code) == (OrderEnding.FAILED, INTERRUPTED)
    assert "broken off because it was not heard for " in outcome.note
    await asyncio.to_thread(halves.navigator.expect, "called off")
    await halves.rests()


@pytest.mark.parametrize(("on_s", "note"), [(0.7, "there"), (20.0, "there; it still moves")])
@pytest.mark.limit(240)
async def test_what_is_said_to_be_done_is_measured_at_rest(
    halves: Halves, on_s: float, note: str
) -> None:
    halves.navigator.say(f"early {on_s}")
    await asyncio.to_thread(halves.navigator.expect, "ok early")
    outcome = await halves.robot.do("go")
    assert (outcome.ending, outcome.note) == (OrderEnding.DONE, note)
    assert outcome.code == ("" if note == "there" else StillMoves.code), "it is followed up"
    assert halves.robot.presence().at_rest is (note == "there")
