"""Whoever has a robot at work is told when it is not there any more, and when it is back."""

from __future__ import annotations

from msgspec.structs import replace

from rosic.core.robot import AtRest, Presence
from rosic.core.words import robot_line
from rosic.pipeline.alerts.absences import back
from tests.rooms.pipeline.place import profile
from tests.rooms.pipeline.test_tasks import heard, warehouse, worker


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
