"""Whoever has a robot at work is told when it is not there any more, and when it is back."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest
from msgspec.structs import replace

from rosic.core.messages import robot_line
from rosic.core.order import OrderEnding, Outcome
from rosic.core.robot.profile import Presence
from rosic.errors import StillMoves
from rosic.features.alerts.offline_notices import LOOKED_AFTER_NS, back
from rosic.robots.ros2.profile import AtRest
from tests.features.fleet.test_tasks import Worker, heard, warehouse, worker
from tests.gateway.place import profile

if TYPE_CHECKING:
    from tests.gateway.place import Place


async def test_a_robot_that_vanishes_at_work_is_said_to_be_away_and_to_be_back() -> None:
    async with warehouse(fleet=(profile("w9"),)).open() as here:
        await here.say("w9 move 1 m")
        await heard(here, 1.0)
        worker(here, "w9").online = False
        told = await heard(here, 2.0)
        assert "w9 is not there any more, last heard 0 s ago. Please look." in told
        assert "not there any more" not in await heard(here, 10.0), "once is enough"
        worker(here, "w9").finish()
        worker(here, "w9").online = True
        told = await heard(here, 2.0)
        assert "w9 is there again, at rest. Nothing goes on by itself." in told
        assert "is there again" not in await heard(here, 10.0)


async def test_a_robot_that_vanishes_just_after_its_motion_was_broken_off_is_said_to() -> None:
    async with warehouse(fleet=(profile("w9"),)).open() as here:
        await here.say("w9 move 1 m")
        await heard(here, 1.0)
        worker(here, "w9").finish()
        await heard(here, 3.0)
        worker(here, "w9").online = False
        assert "w9 is not there any more" in await heard(here, 2.0)


async def test_nobody_is_told_of_a_robot_that_did_nothing() -> None:
    async with warehouse(fleet=(profile("w9"),)).open() as here:
        worker(here, "w9").online = False
        await here.say("w9 move 1 m")
        assert "not there any more" not in await heard(here, 10.0)


MOVES = Outcome(OrderEnding.UNKNOWN, "w9 still moves. Please look.", code=StillMoves.code)


def ends_moving(here: Place, ends: Outcome = MOVES) -> Worker:
    robot = worker(here, "w9")
    robot.ends = ends
    robot.moving = True
    robot.finish()
    return robot


REST = "w9 is at rest now."


async def test_an_end_that_said_it_moves_is_followed_by_its_rest_once() -> None:
    async with warehouse(fleet=(profile("w9"),)).open() as here:
        await here.say("w9 move 1 m")
        robot = ends_moving(here)
        assert REST not in await heard(here, 5.0)
        robot.moving = False
        told = await heard(here, 5.0)
        assert told.count(REST) == 1
        assert REST not in await heard(here, 20.0)


async def test_a_robot_that_is_back_and_moves_is_followed_until_it_rests() -> None:
    async with warehouse(fleet=(profile("w9"),)).open() as here:
        await here.say("w9 move 1 m")
        await heard(here, 1.0)
        robot = worker(here, "w9")
        robot.online = False
        await heard(here, 2.0)
        robot.finish()
        robot.moving = robot.online = True
        assert "w9 is there again, and moves. Please look." in await heard(here, 2.0)
        robot.moving = False
        assert REST in await heard(here, 2.0)


async def test_what_was_done_and_still_moves_is_followed_by_its_rest_once() -> None:
    async with warehouse(fleet=(profile("w9"),)).open() as here:
        await here.say("w9 move 1 m")
        robot = ends_moving(here, Outcome(OrderEnding.DONE, "it still moves", code=StillMoves.code))
        told = await heard(here, 5.0)
        assert "it still moves" in told
        assert REST not in told
        robot.moving = False
        assert (await heard(here, 5.0)).count(REST) == 1


async def test_whoever_was_told_that_a_robot_moves_is_warned_once_where_it_never_rests() -> None:
    async with warehouse(fleet=(profile("w9"),)).open() as here:
        await here.say("w9 move 1 m")
        ends_moving(here, Outcome(OrderEnding.DONE, "it still moves", code=StillMoves.code))
        await heard(here, 1.0)
        here.clock.suspend(LOOKED_AFTER_NS / 1e9)
        assert (await heard(here, 5.0)).count("w9 still moves. Please look.") == 1
        assert "moves" not in await heard(here, 5.0)


@pytest.mark.parametrize("then", ["stop w9", "w9 move 1 m", ""])
async def test_what_has_an_answer_of_its_own_and_what_never_rests_is_followed_no_more(
    then: str,
) -> None:
    async with warehouse(fleet=(profile("w9"),)).open() as here:
        await here.say("w9 move 1 m")
        robot = ends_moving(here)
        await heard(here, 1.0)
        if then:
            await here.say(then)
        else:
            here.clock.suspend(LOOKED_AFTER_NS / 1e9)
            await heard(here, 1.0)
        robot.finish()
        robot.moving = False
        assert REST not in await heard(here, 5.0)


def test_nothing_is_said_of_rest_that_was_not_measured() -> None:
    said = {back("w9", Presence(online=True, at_rest=at_rest)) for at_rest in (True, False, None)}
    assert said == {
        "w9 is there again, at rest. Nothing goes on by itself.",
        "w9 is there again, and moves. Please look.",
        "w9 is there again; whether it rests is not measured yet.",
    }
    at_rest = AtRest(topic="/w9/odom", type="nav_msgs/msg/Odometry", field="x", below=0.1)
    measuring = replace(profile("w9"), at_rest=at_rest)
    unmeasured = Presence(online=True, at_rest=None)
    assert "whether it rests is not measured" in robot_line(measuring, unmeasured, "", None)
    assert "rests" not in robot_line(profile("w9"), unmeasured, "", None)
