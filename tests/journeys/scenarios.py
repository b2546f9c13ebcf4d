"""The paper's five scenarios, for whatever messenger people have, with robots as ROS 2 nodes.

They share one place and go on side by side, as they would in a house with five places of work; the
two that need the carriers go one after the other.
"""

from __future__ import annotations

import asyncio
import re
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING

from tests.journeys.acts import side_by_side
from tests.journeys.scenes import CARRIERS, DRONES, STUDENTS

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

    from tests.journeys.scenes import Scenes


class ScenarioTests:
    """The tests of one messenger; a fixture `acts` begins the scenarios there.

    Each test waits for the end of one.
    """

    async def test_one_to_one_a_ranger_and_a_robot_that_watches_for_fire(
        self, acts: dict[str, asyncio.Task[None]]
    ) -> None:
        await acts["one-to-one"]

    async def test_class_twenty_students_share_one_arm(
        self, acts: dict[str, asyncio.Task[None]]
    ) -> None:
        await acts["class"]

    async def test_fleet_a_carrier_fails_and_its_task_is_moved_exactly_once(
        self, acts: dict[str, asyncio.Task[None]]
    ) -> None:
        await acts["fleet"]

    async def test_shift_groups_overlap_and_what_runs_is_handed_over(
        self, acts: dict[str, asyncio.Task[None]]
    ) -> None:
        await acts["shift"]

    async def test_swarm_a_rover_asks_for_help_another_accepts_and_a_stop_stops_all(
        self, acts: dict[str, asyncio.Task[None]]
    ) -> None:
        await acts["swarm"]


@asynccontextmanager
async def scenarios(here: Scenes) -> AsyncIterator[dict[str, asyncio.Task[None]]]:
    """Begin every scenario."""
    carriers_free = asyncio.Event()

    async def first() -> None:
        try:
            await _fleet(here)
        finally:
            carriers_free.set()

    async def afterwards() -> None:
        await carriers_free.wait()
        await _shift(here)

    stories = {
        "one-to-one": _one_to_one(here),
        "class": _class(here),
        "fleet": first(),
        "shift": afterwards(),
        "swarm": _swarm(here),
    }
    async with side_by_side(stories) as begun:
        yield begun


async def _one_to_one(here: Scenes) -> None:
    await here.asks("Ranger", "watch goto x=0.2 y=0", "done ")
    await here.breaks("watch", "drift", -24.0)
    await here.reads("Ranger", "The heat sensor is off its benchmark")
    await here.reads("Ranger", "recalibrated; the sensor was -24.0 °C off")
    assert here.acted("watch") == ["goto", "recalibrate"]
    await here.comes_to("Ranger", "status watch", "heat 21")

    await here.breaks("watch", "fire", value=True)
    await here.asks("Ranger", "watch goto x=1.0 y=0.3", "done ")
    await here.reads("Ranger", "It is hotter here than a forest should be")
    picture = await here.asks("Ranger", "/picture watch", "camera")
    assert picture.picture
    await here.taps("Ranger", "Seen", "Noted.")
    await here.breaks("watch", "fire", value=False)
    await here.reads("Ranger", "over: It is hotter here than a forest should be")
    assert here.acted("watch") == ["goto", "recalibrate", "goto"]
    told = await here.asks("Ranger", "/benchmark watch", "Go to a place: took ")
    assert "expected 3.0 s" in told.text


async def _class(here: Scenes) -> None:
    first, second, third, *_ = STUDENTS
    before = len(here.acted("kuka1"))
    await here.asks(first, "/book kuka1 now 10 min", "is yours")
    sent = {name: await here.says(name, "kuka1 home") for name in STUDENTS[1:]}
    for name, message in sent.items():
        refused = await here.reads(name, first, to=message)
        assert re.search(r"until \d\d:\d\d\. You can have it then\.", refused.text)
    assert len(here.acted("kuka1")) == before, "nobody but the first may, now"
    await here.asks(first, "kuka1 grasp force=30", "force <= 20 N")
    await here.asks(first, "kuka1 grasp force=20", "object held")
    await here.asks(second, "/wait kuka1", "You are number 1 in the queue")
    await here.asks(third, "/wait kuka1", "You are number 2 in the queue")

    await here.taps(first, "Cancel it", "is given back")
    await here.taps(second, "Take it", "is yours now")
    await here.asks(second, "kuka1 move joint 1 to -165 deg", "done ")
    await here.asks("Teacher", "kuka1 home", "You may take it over")
    # As far as it goes, and nothing is asked on the way that can be asked before.
    moving = await here.says(second, "kuka1 move joint 1 to 165 deg")
    await here.reads(second, "received", to=moving)
    await here.asks("Teacher", "/take over kuka1", "is yours now")
    await here.reads(second, "Teacher took it over", to=moving)
    await here.asks("Teacher", "kuka1 home", "done ")
    await here.asks("Teacher", "/end kuka1", "Session ended")
    assert here.acted("kuka1")[before:] == ["grasp", "move_joint", "move_joint", "home"]


async def _fleet(here: Scenes) -> None:
    here.from_now(*CARRIERS)
    one = await here.gives("Manager", "carriers goto x=0.2 y=0 then goto x=2 y=0")
    await here.reads("Manager", f"task {one}, step 1 of 2")
    two = await here.gives("Manager", "carriers goto x=0.3 y=0")
    failing = await here.has("Manager", "Carrier", f"task {one}, step 2 of 2")
    await here.says("Manager", "/fleet")
    await here.reads("Manager", " at work, ")
    await here.breaks(f"carrier{failing}", "battery", 0.0)
    left = await here.reads("Manager", "The task goes to another robot. 1 of 2 steps are done")
    assert f"Carrier {failing} has failed at it" in left.text
    done = await here.reads(
        "Manager", f"Task {one} (goto x=0.2 y=0; goto x=2 y=0): done by Carrier "
    )
    goes_on = done.text[-2]
    assert goes_on != failing
    await here.reads("Manager", f"Task {two} (goto x=0.3 y=0): done by Carrier ")
    await here.asks("Manager", "/tasks", "No task is open.")
    await here.comes_to("Manager", f"status carrier{failing}", "battery 0 %")
    if not await here.shown("Manager", f"Task {two} (goto x=0.3 y=0): done by Carrier {goes_on}"):
        await here.comes_to("Manager", f"status carrier{goes_on}", "x 2.00 m")
    begun = [skill for n in (1, 2, 3) for skill in here.acted(f"carrier{n}")]
    assert begun == ["goto"] * 4, "two steps, one of them once more, and the other task"
    assert await here.shown("Manager", "The task goes to another robot") == 1
    await _restocks(here)
    await here.breaks(f"carrier{failing}", "battery", 1.0)
    await here.comes_to("Manager", f"status carrier{failing}", "battery 100 %")


async def _restocks(here: Scenes) -> None:
    """Start a mission now, and have it begin by itself every week."""
    begun = await here.asks("Manager", "/mission start restock", "Restock is begun as restock-")
    first = int(begun.text.partition("restock-")[2].partition(" ")[0])
    planned = await here.asks("Manager", "/mission start restock every mon 8:00", "by itself")
    assert re.search(r"^1: restock begins by itself, next .*08:00", planned.text)
    last = await here.reads("Manager", f"Task {first + 2} (goto x=0 y=0.2): done by Carrier ")
    for before in (first, first + 1):
        done = await here.reads("Manager", f"Task {before} (goto x=")
        assert done.place < last.place, "it follows when both are done"
    await here.asks("Manager", "/mission off 1", "does not begin by itself any more")


async def _shift(here: Scenes) -> None:
    here.from_now(*CARRIERS)
    north, south, night = "North manager", "South manager", "Night manager"
    moving = await here.says(north, "carrier2 goto x=-0.8 y=0.3")
    await here.reads(north, "received", to=moving)
    await here.asks(south, "carrier2 goto x=0 y=0", f"taken by {north}")
    await here.asks(south, "carrier1 goto x=0 y=0", 'I do not know "carrier1"')
    task = await here.gives(north, "carrier1 goto x=-1.8 y=0 then goto x=0 y=0")
    await here.reads(north, f"task {task}, step 1 of 2")
    await here.asks(north, f"/handover {south}", f"may move no robot for task {task}.")
    await here.asks(north, f"/handover {night}", "is asked")
    await here.taps(night, "I take over", f"Yours now, from {north}: ")
    await here.reads(north, f"{night} has taken over")
    await here.reads(night, f"Task {task} (goto x=-1.8 y=0; goto x=0 y=0): done by Carrier 1.")
    await here.reads(north, "done ", to=moving)
    assert (here.acted("carrier1"), here.acted("carrier2")) == (["goto", "goto"], ["goto"])
    assert here.acted("carrier3") == []


async def _swarm(here: Scenes) -> None:
    leader = "Search leader"
    up = await here.says(leader, "/together crazyflies takeoff 1 m")
    card = await here.reads(leader, "hovering", to=up)
    assert await here.chats.until(
        leader, lambda: all("takeoff" in here.acted(drone) for drone in DRONES)
    )
    assert card.text.count("Crazyflie") >= len(DRONES)

    one, two = await _two_rovers_go(here, leader)
    helps = await _one_helps_the_other(here, leader, one, two)

    await here.says(leader, "stop")
    said = await here.reads(leader, "STOP: Crazyflie 1 ")
    assert said.text.count("at rest") + said.text.count("on the ground") == len(DRONES) + 2
    assert "has not confirmed" not in said.text
    await here.reads(leader, f"Task {one} (goto x=50 y=0): paused.")
    held = await here.asks(leader, "status", "stopped by you")
    assert held.text.count("stopped by you") == len(DRONES) + 2
    begun = here.acted(f"rover{helps}")
    assert begun == ["goto", "goto"], "its own task, and the other's"


async def _two_rovers_go(here: Scenes, leader: str) -> tuple[str, str]:
    """Give each a task, so far that none is there before it is stopped; return the numbers."""
    one = await here.gives(leader, "rovers goto x=50 y=0")
    two = await here.gives(leader, "rovers goto x=0 y=50")
    return one, two


async def _one_helps_the_other(here: Scenes, leader: str, one: str, two: str) -> str:
    """Let the first get stuck and the second help; return which one helped."""
    stuck = await here.has(leader, "Rover", f"· task {one}")
    helps = await here.has(leader, "Rover", f"· task {two}")
    assert {stuck, helps} == {"1", "2"}
    await here.breaks(f"rover{stuck}", "mud", value=True)
    await here.reads(leader, "stuck: the wheels turn, and nothing moves")
    await here.thinks(f"rover{stuck}", "help", what="stuck in the mud")
    await here.reads(leader, f"Rover {stuck} asks for help: stuck in the mud.")
    asked = await here.heard(f"rover{helps}", "help")
    await here.thinks(f"rover{helps}", "accept", id=asked["id"])
    told = await here.reads(leader, f"Rover {helps} helps Rover {stuck} (stuck in the mud).")
    assert f"Task {one} goes from Rover {stuck} to Rover {helps}." in told.text
    assert f"Task {two} leaves Rover {helps} and waits for a robot." in told.text
    assert (await here.heard(f"rover{stuck}", "helped"))["by"] == f"rover{helps}"
    await here.breaks(f"rover{stuck}", "mud", value=False)
    await here.thinks(f"rover{stuck}", "over", id=asked["id"])
    await here.reads(leader, f"Rover {stuck} needs no more help")
    await here.reads(leader, f"Task {one} (goto x=50 y=0): Rover {helps} goes on with it.")
    await here.reads(leader, f"Task {two} (goto x=0 y=50): Rover {stuck} goes on with it.")
    await here.asks(leader, f"/strategy rover{stuck} careful speed=0.2 now", "I say when")
    await here.reads(leader, f"Rover {stuck} has taken on: Careful (speed 0.2 m/s).")
    return helps
