"""A stop that holds until it is released: by a resume, or by an order where nobody stopped it."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

import pytest

from rosic.core.order import OrderEnding, Stop
from rosic.errors import OrderVoid, RobotOffline, RobotUnreachable
from rosic.system import SystemClock
from rosic.testing.ros2.graph import RosGraph, RosProcess
from tests.pace import pace
from tests.real.ros2.simulated import opened, until
from tests.real.ros2.test_robot_bindings import MOVES, PEER, omni

if TYPE_CHECKING:
    from collections.abc import Iterator


@pytest.fixture(scope="module")
def peer(tmp_path_factory: pytest.TempPathFactory) -> Iterator[RosProcess]:
    """A node /omni/robot whose stop holds; it writes down what it is told."""
    with RosGraph(tmp_path_factory.mktemp("peer")) as graph:
        yield graph.start(PEER)


LATCH: dict[str, object] = {
    "service": "/omni/latch",
    "type": "std_srvs/srv/SetBool",
    "request": {"data": True},
    "release": {"data": False},
}


def since_held(peer: RosProcess) -> list[str]:
    """Return what it wrote down since it was last told to hold; a stop is told more than once."""
    lines = list(peer.lines)
    return lines[len(lines) - lines[::-1].index("latch True") :] if "latch True" in lines else lines


async def test_a_stop_that_holds_is_released_by_a_resume(peer: RosProcess) -> None:
    robot = omni(MOVES, stop=LATCH)
    await robot.open(lambda _text: None)
    try:
        await until(lambda: all(link.ready() for link in robot._stop_controller.calls))
        await robot.stop(Stop("omni", 1))
        await asyncio.to_thread(peer.expect, "latch True", timeout_s=60 * pace())
        peer.say("jam")
        await asyncio.to_thread(peer.expect, "ok jam", timeout_s=60 * pace())
        with pytest.raises(
            RobotUnreachable, match=r"^The stop of Omni was not released: the button is pressed\.$"
        ):
            await robot.resume(1)
        assert robot.gate.latched
        peer.say("jam off")
        await asyncio.to_thread(peer.expect, "ok jam", timeout_s=60 * pace())
        await robot.resume(1)
        assert not robot.gate.latched
        assert [line for line in peer.lines if line.startswith("latch")][-1] == "latch False"
    finally:
        await robot.close()


async def test_what_holds_since_a_motion_was_ended_is_released_before_the_next(
    peer: RosProcess,
) -> None:
    robot = omni(MOVES, stop=LATCH)
    await robot.open(lambda _text: None)
    try:
        await until(lambda: all(link.ready() for link in robot._stop_controller.calls))
        await robot._to_rest()
        await asyncio.to_thread(peer.expect, "latch True", timeout_s=60 * pace())
        peer.lines.clear()
        assert (await robot.do("do", {})).ending is OrderEnding.DONE
        # What it says and what it answers come on two ways.
        await asyncio.to_thread(peer.expect, "stopped", timeout_s=60 * pace())
        assert since_held(peer) == ["latch False", "stopped"]
    finally:
        await robot.close()


async def test_what_may_hold_since_an_earlier_run_is_released_before_the_first_order(
    peer: RosProcess,
) -> None:
    async with opened(omni(MOVES, stop=LATCH).profile, SystemClock()) as earlier:
        await until(lambda: all(link.ready() for link in earlier._stop_controller.calls))
        await earlier._to_rest()
        await asyncio.to_thread(peer.expect, "latch True", timeout_s=60 * pace())
    async with opened(omni(MOVES, stop=LATCH).profile, SystemClock()) as robot:
        peer.lines.clear()
        for _ in range(2):
            assert (await robot.do("do", {})).ending is OrderEnding.DONE
            await asyncio.to_thread(peer.expect, "stopped", timeout_s=60 * pace())
        assert since_held(peer) == ["latch False", "stopped", "stopped"]


async def test_a_stop_that_declines_to_release_what_it_may_not_hold_keeps_nothing_from_moving(
    peer: RosProcess,
) -> None:
    async with opened(omni(MOVES, stop=LATCH).profile, SystemClock()) as robot:
        peer.say("jam")
        await asyncio.to_thread(peer.expect, "ok jam", timeout_s=60 * pace())
        peer.lines.clear()
        try:
            assert (await robot.do("do", {})).ending is OrderEnding.DONE
            await asyncio.to_thread(peer.expect, "stopped", timeout_s=60 * pace())
            assert list(peer.lines) == ["latch False", "stopped"]
            await robot._to_rest()  # from here on it is known to hold
            with pytest.raises(RobotOffline, match="the button is pressed"):
                await robot.do("do", {})
        finally:
            peer.say("jam off")
            await asyncio.to_thread(peer.expect, "ok jam", timeout_s=60 * pace())


async def test_what_rosic_has_stopped_is_not_released_by_an_order_of_a_new_run(
    peer: RosProcess,
) -> None:
    async with opened(omni(MOVES, stop=LATCH).profile, SystemClock()) as robot:
        await until(lambda: all(link.ready() for link in robot._stop_controller.calls))
        order = robot.order("do", {})
        robot.gate.apply_stop(Stop("omni", 1))  # as it is kept of the run before
        peer.lines.clear()
        with pytest.raises(OrderVoid, match="was stopped before this could begin"):
            await robot.execute(order, lambda _report: None)
        assert "latch False" not in peer.lines


async def test_a_stop_while_whoever_releases_is_looked_for_keeps_it_held(
    peer: RosProcess,
) -> None:
    async with opened(omni(MOVES, stop=LATCH).profile, SystemClock()) as robot:
        controller = robot._stop_controller
        await until(lambda: all(link.ready() for link in controller.calls))
        peer.lines.clear()
        asked = iter([False])  # stopped between the first look and the moment of sending
        await controller.release_for_order(lambda: next(asked, True), 1.0)
        assert "latch False" not in peer.lines
