"""One person, many robots: a warehouse manager and three carriers (Algorithm 4)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from rosic.core.fleet.mission import Mission, MissionPart
from rosic.features.fleet import FleetFeature
from rosic_sim.robots.machines.omni import Omni
from rosic_sim.scenarios.robots import several
from rosic_sim.scenarios.scenario import Person, Scenario

if TYPE_CHECKING:
    from rosic_sim.scenarios.scenario import ScenarioRunner

MANAGER: Final = "Manager"
CARRIERS: Final = ("carrier1", "carrier2", "carrier3")
TASKS: Final = (
    "goto x=0.8 y=0.4 then goto x=0 y=0.4",
    "goto x=1.2 y=0 then goto x=0.2 y=0",
    "goto x=0.8 y=-0.4 then goto x=0 y=-0.4",
    "goto x=0.5 y=0.8 battery 30",
)


RESTOCK: Final = Mission(
    name="restock",
    title="Restock the shelves",
    do=(
        MissionPart(
            together=(
                MissionPart(on="carriers", steps=("goto x=0.6 y=0.3",), battery=30),
                MissionPart(on="carriers", steps=("goto x=0.6 y=-0.3",), battery=30),
            )
        ),
        MissionPart(on="any", steps=("goto x=0 y=0",), battery=30),
    ),
)


async def _script(stage: ScenarioRunner) -> None:
    stage.aside("A warehouse manager has three carriers, and four errands for any that can.")
    for number, task in enumerate(TASKS, 1):
        await stage.says(MANAGER, f"/task carriers {task}", hears=f"Task {number}: ")
    tasks = stage.gateway.features.get(FleetFeature).dispatching.fleet.tasks
    victim = await stage.until(
        lambda: tasks["2"].robot if tasks["2"].done == 1 else "", "Task 2 did not get on"
    )
    await stage.says(MANAGER, "/fleet", hears="at work")
    stage.aside(
        f"Halfway through task 2, {_shown(stage, victim)}'s battery gives up. It is brought to "
        "rest before its task goes to another; the step that is done is not done again."
    )
    stage.world.set_battery(victim, 0.0)
    await stage.hears(MANAGER, "The task goes to another robot. 1 of 2 steps are done")
    await stage.until(lambda: all(task.over for task in tasks.values()), "Not all is done", 60.0)
    await stage.quiet()
    stage.aside(
        "What is done every week is written down as a mission: two carriers fetch side by side, "
        "and when both are there, one brings it back."
    )
    await stage.says(MANAGER, "/mission start restock", hears="3 tasks")
    await stage.says(MANAGER, "/mission start restock every mon 8:00", hears="begins by itself")
    await stage.until(lambda: all(task.over for task in tasks.values()), "It is not restocked")
    await stage.quiet()
    await stage.says(MANAGER, "/tasks", hears="No task is open.")
    await stage.says(MANAGER, "/fleet carriers", hears="0 %, low")


def _shown(stage: ScenarioRunner, robot: str) -> str:
    return stage.gateway.rooms.profiles[robot].shown


FLEET: Final = Scenario(
    name="fleet",
    about="a warehouse manager and three carriers, one of which fails",
    people=(Person(MANAGER, "admin"),),
    profiles=lambda: several("carrier", ((), (), ())),
    machines=lambda: tuple(
        Omni(name, (0.0, 0.5 * (1 - at), 0.0)) for at, name in enumerate(CARRIERS)
    ),
    script=_script,
    hints=(
        "/task carriers goto x=1 y=0 then goto x=0 y=0",
        "/fleet",
        "/tasks",
        "/mission restock",
        "/mission start restock",
        "/robot disable carrier2",
        "stop",
    ),
    missions=(RESTOCK,),
)
