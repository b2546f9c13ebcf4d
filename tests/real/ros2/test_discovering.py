"""Drafts of robots as others build them, from the live graph: checked, filled in, and driven."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

import pytest

from rosic.app.setup.discovery import LOOK_S, discover
from rosic.config.profiles import check_profile, load_profile
from rosic.core.order import OrderEnding, Outcome
from rosic.errors import RobotOffline
from rosic.robots.ros2.interfaces.cache import KNOWN, ensure_built, make_importable
from rosic.robots.ros2.profile import ros2_profile
from rosic.system import SystemClock
from tests.pace import pace
from tests.real.ros2.simulated import Simulated, TriedRobot, opened, simulated

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    from rosic.core.robot.skill import Argument
    from rosic.testing.ros2.graph import RosGraph

pytestmark = [pytest.mark.limit(240)]


@pytest.fixture
def robots(graph: RosGraph, tmp_path: Path, interfaces: Path) -> Iterator[Simulated]:  # noqa: ARG001 - built before
    for package in KNOWN.values():
        ensure_built(package)
        make_importable(package)
    with simulated(graph, tmp_path, "rover", "picker") as simulation:
        yield simulation


@pytest.fixture
async def drafts(robots: Simulated, tmp_path: Path) -> dict[str, Path]:  # noqa: ARG001 - on the graph
    """What is found while both robots are there."""
    found = await discover(SystemClock(), seconds=LOOK_S)
    for name, text in found.items():
        (tmp_path / f"{name}.yaml").write_text(text)
    return {name: tmp_path / f"{name}.yaml" for name in found}


class Hasty(SystemClock):
    """Whoever looks before anybody can have said that they are there; and then in earnest."""

    def __init__(self) -> None:
        self.slept = 0

    async def sleep(self, seconds: float) -> None:
        self.slept += 1
        await super().sleep(0.0 if self.slept == 1 else 3 * seconds)


async def test_where_nobody_is_seen_at_first_it_looks_again(robots: Simulated) -> None:  # noqa: ARG001 - on the graph
    assert set(await discover(Hasty(), seconds=LOOK_S)) == {"picker", "rover"}


async def test_drafts_pass_the_check_and_drive_after_filling_in(drafts: dict[str, Path]) -> None:
    assert set(drafts) == {"picker", "rover"}
    for path in drafts.values():
        assert [str(error) for error in check_profile(path)] == []

    rover = drafts["rover"].read_text()
    assert "Drive the robot to every place" in rover
    assert set(load_profile(drafts["rover"]).skills) == {"goto", "visit", "drive"}
    filled = rover.replace("          here: []\n", "          here: []\n          door: []\n")
    filled = filled.replace(
        "          here:\n", "          door: {x: -0.5, y: 0.5, yaw: 0}\n          here:\n"
    )
    drafts["rover"].write_text(filled)
    await drives(drafts["rover"], "visit", {"place": "door"})

    picker = ros2_profile(load_profile(drafts["picker"]))
    assert picker.joints is not None
    assert "finger_joint" not in picker.joints.limits, "the controller says which are its own"
    assert picker.stop is not None
    assert picker.stop.cancel_only
    await drives(drafts["picker"], "joint", {"joint": "elbow_joint", "angle": 1.4})


async def drives(path: Path, skill: str, arguments: dict[str, Argument]) -> None:
    assert [str(error) for error in check_profile(path)] == []
    async with opened(load_profile(path), SystemClock()) as robot:
        outcome = await done(robot, skill, arguments)
        assert outcome.ending is OrderEnding.DONE, outcome


async def done(robot: TriedRobot, skill: str, arguments: dict[str, Argument]) -> Outcome:
    """Return what became of it, asked for once the robot has been heard: nothing is sent before."""
    async with asyncio.timeout(60 * pace()):
        while True:
            try:
                return await robot.do(skill, arguments)
            except RobotOffline:
                await asyncio.sleep(0.05)
