"""What a start says while its robots are prepared, to whom, and that nobody is heard before."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosic.robots.memory import MemoryRobot
from tests.gateway.place import ADA, BO, Place

if TYPE_CHECKING:
    from rosic.contracts.robot import Say

PREPARED = "All robots are prepared. From now on I listen."


class BuiltRobot(MemoryRobot):
    """Says how far it is while it is opened, and goes on speaking afterwards."""

    says: Say

    async def open(self, say: Say) -> None:
        self.says = say
        if self.profile.id == "kuka1":
            say("building the ROS interfaces nav2_msgs, once: 0 %")
            say("building the ROS interfaces nav2_msgs, once: 50 %")
        await super().open(say)


class SlowPlace(Place):
    kind = BuiltRobot


async def test_admins_read_how_far_a_slow_start_is_and_when_it_listens() -> None:
    async with SlowPlace().open() as place:
        told = [(t.outbound.chat.id, t.outbound.text) for t in place.chat.told]
        assert told == [
            (ADA, "I am starting. I hear nobody until my robots are prepared."),
            (ADA, "kuka1: building the ROS interfaces nav2_msgs, once: 0 %"),
            (ADA, "kuka1: building the ROS interfaces nav2_msgs, once: 50 %"),
            (ADA, PREPARED),
        ]


async def test_once_people_are_heard_a_robot_speaks_to_whoever_speaks_to_it() -> None:
    async with SlowPlace().open() as place:
        await place.say("omni wave", account=BO, chat=BO)
        robot = place.robot("omni")
        assert isinstance(robot, BuiltRobot)
        before = len(place.chat.told)
        robot.says("hello")
        await place.quiet()
        after = [(t.outbound.chat.id, t.outbound.text) for t in list(place.chat.told)[before:]]
        assert after == [(BO, "omni: hello")]


async def test_a_start_that_takes_no_time_says_nothing() -> None:
    async with Place().open() as place:
        assert not [t for t in place.chat.told if t.outbound.text == PREPARED]
