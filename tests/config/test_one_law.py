"""One law for every kind of link: what moves can be stopped and measured, or says it cannot."""

from __future__ import annotations

import pytest
from msgspec.structs import replace

from rosic.config.plugins import check_robot, demand_good, robot_factory, shared_spaces
from rosic.core.robot.profile import Link, Profile
from rosic.core.robot.skill import Skill, SkillClass
from rosic.errors import ConfigurationError
from rosic.robots.memory import MemoryRobot
from rosic.robots.ros2.profile import AtRest, Ros2Link, StopBinding
from rosic.testing.clock import ManualClock
from tests.gateway.place import Place, profile


class Stranger(MemoryRobot):
    """A link of somebody else's, which says nothing of stops."""

    stops_itself = False


class Choosy(MemoryRobot):
    """A link that refuses what it cannot do."""

    def __init__(self, *parts: object) -> None:
        del parts
        raise ConfigurationError("This link has no arm.", hint="Buy one.")


REST = AtRest(topic="/o", type="nav_msgs/msg/Odometry", field="x", below=0.01)
STOP = StopBinding(service="/o/stop")


def sentences(made: Profile, kind: type[MemoryRobot]) -> list[str]:
    return [fault.sentence for fault in check_robot(made, kind, ManualClock())]


def test_a_stranger_that_moves_needs_a_stop_and_a_measurable_rest() -> None:
    made = profile("omni")
    for lacking in (made, replace(made, stop=STOP), replace(made, at_rest=REST)):
        [said] = sentences(lacking, Stranger)
        assert "omni moves, and nothing here would stop it or measure that it rests" in said
        with pytest.raises(ConfigurationError, match="nothing here would stop it"):
            demand_good(lacking, Stranger, ManualClock())
    assert sentences(replace(made, stop=STOP, at_rest=REST), Stranger) == []
    assert sentences(replace(made, unstoppable=True), Stranger) == []
    look = Skill(id="look", kind=SkillClass.OBSERVE)
    assert sentences(replace(made, skills={"look": look}), Stranger) == []


class Gliding(Profile, frozen=True):
    """A profile of a link that always hears how fast its robots are."""

    @property
    def measures_rest(self) -> bool:
        return True


def test_the_profile_of_a_kind_may_know_more_than_its_keys() -> None:
    plain = profile("omni")
    glider = Gliding(id="omni", link=plain.link, skills=plain.skills)
    [said] = sentences(glider, Stranger)
    assert "nothing here would stop it" in said
    assert sentences(replace(glider, stop="anything that this link knows"), Stranger) == []
    assert sentences(replace(plain, stop="anything"), Stranger) == [said]


def test_a_kind_that_stops_itself_says_so() -> None:
    for kind in ("memory", "simulated"):
        assert sentences(replace(profile("omni"), link=Link(kind=kind)), MemoryRobot) == []
        assert getattr(robot_factory(kind), "stops_itself", False)


def test_what_a_start_would_refuse_is_found_before() -> None:
    assert sentences(profile("omni"), Choosy) == ["This link has no arm. Buy one."]
    lost = replace(profile("nowhere"), link=Link(kind="simulated"))
    [fault] = check_robot(lost, robot_factory("simulated"), ManualClock())
    assert "no simulated machine called 'nowhere'" in fault.sentence


def test_robots_of_one_namespace_are_named() -> None:
    one, two, other = (
        replace(profile(name), link=Ros2Link(kind="ros2", namespace=space))
        for name, space in (("a", "/x"), ("b", "/x"), ("c", "/y"))
    )
    assert list(shared_spaces((one, other))) == []
    [said] = shared_spaces((one, two, other))
    assert said.startswith("a and b have one namespace, /x: what one of them is told")


async def test_whoever_commands_a_robot_that_nothing_stops_is_told() -> None:
    fleet = (replace(profile("omni"), unstoppable=True), profile("kuka1"))
    async with Place(fleet=fleet).open() as place:
        said = await place.say("status")
        [line] = [line for line in said.splitlines() if line.startswith("omni: ")]
        assert line.endswith("free · cannot be stopped from here: stay beside it")
        assert said.count("cannot be stopped") == 1
        assert "cannot be stopped from here" in await place.say("use omni")
