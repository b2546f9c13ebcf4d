"""The paper's five scenarios over the fake Bot API server, with robots as ROS 2 nodes.

They share one place, so that each costs only what happens in it.
"""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

import pytest
import pytest_asyncio

from rosic.robots.ros2.interfaces.cache import ensure_built, make_importable
from rosic.testing.ros2.environment import why_missing
from tests.journeys.scenes import DRONES, STUDENTS, Scenes, scenes

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

    from tests.journeys.running import Launcher

pytestmark = [
    pytest.mark.limit(480),
    pytest.mark.asyncio(loop_scope="module"),
    pytest.mark.skipif(why_missing() is not None, reason=why_missing() or ""),
]


@pytest_asyncio.fixture(scope="module", loop_scope="module")
async def here(
    tmp_path_factory: pytest.TempPathFactory, launcher: Launcher
) -> AsyncIterator[Scenes]:
    make_importable()
    ensure_built()
    async with scenes(tmp_path_factory.mktemp("scenes"), launcher) as place:
        yield place


async def test_one_to_one_a_ranger_and_a_robot_that_watches_for_fire(here: Scenes) -> None:
    here.from_now()
    await here.asks("Ranger", "watch goto x=0.4 y=0", "done ")
    await here.breaks("watch", "drift", -24.0)
    await here.reads("Ranger", "The heat sensor is off its benchmark")
    await here.reads("Ranger", "recalibrated; the sensor was -24.0 °C off")
    assert here.acted("watch") == ["goto", "recalibrate"]
    await here.comes_to("Ranger", "status watch", "heat 21")

    await here.breaks("watch", "fire", value=True)
    await here.asks("Ranger", "watch goto x=1.2 y=0.3", "done ")
    await here.reads("Ranger", "It is hotter here than a forest should be")
    picture = await here.asks("Ranger", "/picture watch", "camera")
    assert picture["photo"]
    await here.taps("Ranger", "Seen", "Noted.")
    await here.breaks("watch", "fire", value=False)
    await here.reads("Ranger", "over: It is hotter here than a forest should be")
    assert here.acted("watch") == ["goto", "recalibrate", "goto"]


async def test_class_twenty_students_share_one_arm(here: Scenes) -> None:
    first, second, third, *_ = STUDENTS
    before = len(here.acted("kuka1"))
    await here.asks(first, "/book kuka1 now 10 min", "is yours")
    sent = {name: await here.says(name, "kuka1 home") for name in STUDENTS[1:]}
    for name, message in sent.items():
        refused = await here.reads(name, first, to=message)
        assert re.search(r"until \d\d:\d\d\. You can have it then\.", refused["text"])
    assert len(here.acted("kuka1")) == before, "nobody but the first may, now"
    await here.asks(first, "kuka1 grasp force=30", "force <= 20 N")
    await here.asks(first, "kuka1 grasp force=20", "object held")
    await here.asks(second, "/wait kuka1", "You are number 1 in the queue")
    await here.asks(third, "/wait kuka1", "You are number 2 in the queue")

    await here.taps(first, "Cancel it", "is given back")
    await here.taps(second, "Take it", "is yours now")
    moving = await here.says(second, "kuka1 move joint 1 to 120 deg")
    await here.reads(second, "received", to=moving)
    await here.asks("Teacher", "kuka1 home", "You may take it over")
    await here.asks("Teacher", "/take over kuka1", "is yours now")
    await here.reads(second, "Teacher took it over", to=moving)
    await here.asks("Teacher", "kuka1 home", "done ")
    await here.asks("Teacher", "/end kuka1", "Session ended")
    assert here.acted("kuka1")[before:] == ["grasp", "move_joint", "home"]


async def test_fleet_a_carrier_fails_and_its_task_is_moved_exactly_once(here: Scenes) -> None:
    here.from_now()
    await here.asks("Manager", "/task carriers goto x=1 y=0 then goto x=0 y=0", "Task 1: ")
    await here.reads("Manager", "task 1, step 1 of 2")
    await here.asks("Manager", "/task carriers goto x=0.5 y=0", "Task 2: ")
    victim = await _at_step(here, "Manager", "task 1, step 2 of 2")
    assert "at work" in (await here.asks("Manager", "/fleet", "robot"))["text"]
    await here.breaks(victim, "battery", 0.0)
    left = await here.reads("Manager", "The task goes to another robot. 1 of 2 steps are done")
    assert "has failed at it" in left["text"]
    done = await here.reads("Manager", "Task 1 (goto x=1 y=0; goto x=0 y=0): done by Carrier ")
    assert not done["text"].endswith(f"Carrier {victim[-1]}.")
    await here.reads("Manager", "Task 2 (goto x=0.5 y=0): done by Carrier ")
    await here.asks("Manager", "/tasks", "No task is open.")
    card = await here.asks("Manager", "/fleet", "0 robots at work")
    assert f"Carrier {victim[-1]}: battery 0 %, low" in card["text"]
    begun = [skill for n in (1, 2, 3) for skill in here.acted(f"carrier{n}")]
    assert len(begun) == 4, "two steps, one of them once more, and the other task"
    assert await here.shown("Manager", "The task goes to another robot") == 1
    await here.breaks(victim, "battery", 1.0)


async def _at_step(here: Scenes, who: str, text: str) -> str:
    """Return which carrier is at a step, by what its person reads."""
    card = await here.reads(who, text)
    found = re.search(r"Carrier (\d)", card["text"])
    assert found, card["text"]
    return f"carrier{found[1]}"


async def test_shift_groups_overlap_and_what_runs_is_handed_over(here: Scenes) -> None:
    here.from_now()
    north, south, night = "North manager", "South manager", "Night manager"
    moving = await here.says(north, "carrier2 goto x=-0.8 y=0")
    await here.reads(north, "received", to=moving)
    await here.asks(south, "carrier2 goto x=0 y=0", f"taken by {north}")
    await here.asks(south, "carrier1 goto x=0 y=0", 'I do not know "carrier1"')
    await here.asks(north, "/task carrier1 goto x=-1 y=0 then goto x=0 y=0", "Task 3: ")
    await here.reads(north, "task 3, step 1 of 2")
    await here.asks(north, f"/handover {south}", "may move no robot for these tasks: 3")
    await here.asks(north, f"/handover {night}", "is asked")
    await here.taps(night, "I take over", f"Yours now, from {north}: ")
    await here.reads(north, f"{night} has taken over")
    await here.reads(night, "task 3, step 2 of 2")
    await here.reads(night, "Task 3 (goto x=-1 y=0; goto x=0 y=0): done by Carrier 1.")
    await here.reads(north, "done ", to=moving)
    assert (here.acted("carrier1"), here.acted("carrier2")) == (["goto", "goto"], ["goto"])
    assert here.acted("carrier3") == []


async def test_swarm_a_rover_asks_for_help_another_accepts_and_a_stop_stops_all(
    here: Scenes,
) -> None:
    here.from_now()
    leader = "Search leader"
    up = await here.asks(leader, "crazyflies takeoff 1 m", "done ")
    await here.place.until(lambda: all("takeoff" in here.acted(drone) for drone in DRONES))
    await here.place.reads(here.people[leader], "hovering", to=up["reply_to"])
    await here.asks(leader, "/task rovers goto x=2 y=0", "Task 4: ")
    first = await _rover_at(here, leader, "task 4")
    other = "rover2" if first == "rover1" else "rover1"
    await here.breaks(first, "mud", value=True)
    await here.reads(leader, "stuck: the wheels turn, and nothing moves")
    await here.thinks(first, "help", what="stuck in the mud")
    await here.reads(leader, f"Rover {first[-1]} asks for help: stuck in the mud.")
    asked = await here.heard(other, "help")
    await here.thinks(other, "accept", id=asked["id"])
    await here.reads(leader, f"Rover {other[-1]} helps Rover {first[-1]} (stuck in the mud).")
    assert (await here.heard(first, "helped"))["by"] == other
    await here.reads(leader, f"Rover {other[-1]} goes on with it")
    await here.place.until(lambda: here.acted(other) == ["goto"])
    stopped = await here.says(leader, "stop")
    said = await here.reads(leader, "Crazyflie 3 on the ground", to=stopped)
    assert said["text"].count("on the ground") == 3
    assert said["text"].count("at rest") == 2
    assert "has not confirmed" not in said["text"]
    await here.reads(leader, "Task 4 (goto x=2 y=0): paused.")
    for robot in (*DRONES, other):
        await here.asks(leader, f"status {robot}", f"stopped by {leader}")
    await here.breaks(first, "mud", value=False)
    assert here.acted(other) == ["goto"], "nothing goes on by itself"


async def _rover_at(here: Scenes, who: str, text: str) -> str:
    card = await here.reads(who, text)
    found = re.search(r"Rover (\d)", card["text"])
    assert found, card["text"]
    return f"rover{found[1]}"
