"""Robots that are told one after another begin together, and who hears of it too late does not.

`rosic bench start` has figures.
"""

from __future__ import annotations

import asyncio
from contextlib import AsyncExitStack
from typing import TYPE_CHECKING

import pytest
from msgspec.structs import replace

from rosic.bench.start import SIMULATION, began, one_more
from rosic.core.order import OrderEnding
from rosic.core.order_gate import OrderGate
from rosic.errors import OrderVoid
from rosic.system import SystemClock
from tests.pace import pace
from tests.real.ros2.simulated import opened, shipped

if TYPE_CHECKING:
    from pathlib import Path

    from rosic.core.order import Order
    from rosic.core.robot.skill import Argument
    from rosic.testing.ros2.graph import RosGraph

NAMES = ("omni1", "omni2", "omni3", "omni4")
APART_S = 0.5
# Half a second apart they were told; a machine that hardly gets on is still far from that.
TOGETHER_WITHIN_S = 0.4
MOVE: dict[str, Argument] = {"direction": "forward", "distance": 0.05, "speed": 0.5}

pytestmark = [pytest.mark.usefixtures("interfaces"), pytest.mark.limit(240)]


async def test_robots_that_were_told_one_after_another_begin_together(
    graph: RosGraph, tmp_path: Path
) -> None:
    file, clock = tmp_path / "starts", SystemClock()
    for names in (NAMES[:2], NAMES[2:]):
        graph.start(
            "-m",
            SIMULATION,
            "--starts",
            file,
            "--punctual",
            *names,
            timeout_s=60 * pace(),
            ends_with_input=False,
        )
    async with AsyncExitStack() as stack:
        robots = [await stack.enter_async_context(opened(one_more(n), clock)) for n in NAMES]
        start_ns = clock.monotonic_ns() + 3_000_000_000
        agreed_ns = clock.wall_ns() + 3_000_000_000
        tasks = []
        for robot in robots:
            order = replace(robot.order("move", MOVE), start_ns=start_ns)
            tasks.append(asyncio.create_task(robot.execute(order, lambda _report: None)))
            await asyncio.sleep(APART_S)
        outcomes = await asyncio.gather(*tasks)

    assert [outcome.ending for outcome in outcomes] == [OrderEnding.DONE] * len(NAMES), outcomes
    moments = began(file)
    assert set(moments) == set(NAMES)
    assert min(moments.values()) >= agreed_ns - 5_000_000, "nobody begins early"
    assert max(moments.values()) - min(moments.values()) < TOGETHER_WITHIN_S * 1e9


class LetsAllBegin(OrderGate):
    """Lets what comes too late for a common start pass, as if that came to be on the way."""

    __slots__ = ()

    def pass_order(
        self,
        order: Order,
        now_ns: int,
        wall_ns: int,
        *,
        together: bool = False,  # noqa: ARG002
    ) -> None:
        super().pass_order(order, now_ns, wall_ns)


async def test_who_hears_of_a_common_start_too_late_does_not_begin(
    graph: RosGraph, tmp_path: Path
) -> None:
    file, clock = tmp_path / "starts", SystemClock()
    graph.start(
        "-m", SIMULATION, "--starts", file, "omni", timeout_s=60 * pace(), ends_with_input=False
    )
    async with opened(shipped("omni"), clock) as robot:

        def late() -> Order:
            start_ns = clock.monotonic_ns() - 200_000_000
            return replace(robot.order("move", MOVE), start_ns=start_ns)

        with pytest.raises(OrderVoid, match="too late to begin with the others"):
            await robot.execute(late(), lambda _report: None)

        strict, robot.gate = robot.gate, LetsAllBegin.new("omni")
        declined = await robot.execute(late(), lambda _report: None)
        assert declined.ending is OrderEnding.REFUSED
        assert declined.note == "heard of the common start too late. Nothing was done."
        assert not file.exists() or began(file) == {}, "it has not moved"

        robot.gate = strict
        waited = replace(late(), sequel=True)
        assert (await robot.execute(waited, lambda _report: None)).ending is OrderEnding.DONE
    assert set(began(file)) == {"omni"}
