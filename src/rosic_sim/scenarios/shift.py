"""Many people, many robots: two managers whose groups overlap, and the night shift."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from rosic.core.policy.roles import DEFAULT_ROLES, Role, RoleRules
from rosic.features.fleet import FleetFeature
from rosic_sim.robots.machines.omni import Omni
from rosic_sim.scenarios.robots import several
from rosic_sim.scenarios.scenario import Person, Scenario

if TYPE_CHECKING:
    from rosic_sim.scenarios.scenario import ScenarioRunner

NORTH, SOUTH, NIGHT = "North manager", "South manager", "Night manager"
CARRIERS: Final = ("carrier1", "carrier2", "carrier3")
LONG: Final = "/task carrier1 goto x=1.6 y=0.6 then goto x=0 y=0.6 then goto x=0.8 y=0.6"
ROLES: Final = {
    **DEFAULT_ROLES,
    "north": Role(scopes=("north:*",), priority=10),
    "south": Role(scopes=("south:*",), priority=10),
}


async def _script(stage: ScenarioRunner) -> None:
    stage.aside(
        "Two halls, two managers: carriers 1 and 2 work in the north, carriers 2 and 3 in the "
        "south. Carrier 2 is in both groups, and does one thing at a time for one of them."
    )
    await stage.says(NORTH, "carrier2 goto x=1 y=0.2", hears="accepted")
    await stage.says(SOUTH, "carrier2 goto x=0 y=0", hears=NORTH)
    await stage.says(SOUTH, "carrier1 goto x=0 y=0", hears="carrier1")
    stage.aside("What is not theirs does not exist for them. Tasks find a robot that is free.")
    await stage.says(SOUTH, "/task south goto x=1 y=-0.6 then goto x=0 y=-0.6", hears="Task 1: ")
    await stage.says(NORTH, LONG, hears="Task 2: ")
    tasks = stage.gateway.features.get(FleetFeature).dispatching.fleet.tasks
    await stage.until(lambda: tasks["2"].robot, "Task 2 did not begin")
    stage.aside(
        "The day is over. The south manager could do nothing with the north's task, so it is not "
        "given to them; the night manager takes over what runs, without stopping it."
    )
    await stage.says(NORTH, "/handover South manager", hears="may move no robot for task 2.")
    await stage.says(NORTH, "/handover Night manager", hears="is asked")
    await stage.hears(NIGHT, "hands over to you")
    await stage.taps(NIGHT, "I take over", hears="Yours now, from North manager")
    await stage.hears(NORTH, "has taken over")
    await stage.until(lambda: all(task.over for task in tasks.values()), "Not all is done", 60.0)
    await stage.hears(NIGHT, "done by Carrier 1")
    await stage.says(NORTH, "/tasks", hears="No task is open.")
    await stage.says(NIGHT, "/fleet", hears="0 robots at work")


SHIFT: Final = Scenario(
    name="shift",
    about="two managers with overlapping groups, and a hand-over to the night shift",
    people=(Person(NORTH, "north"), Person(SOUTH, "south"), Person(NIGHT, "operator")),
    profiles=lambda: several("carrier", (("north",), ("north", "south"), ("south",))),
    machines=lambda: tuple(
        Omni(name, (0.0, 0.6 * (1 - at), 0.0)) for at, name in enumerate(CARRIERS)
    ),
    script=_script,
    hints=(
        "north goto x=1 y=0",
        "/task north goto x=1 y=0 then goto x=0 y=0",
        "/fleet",
        "/handover Night manager",
        "stop",
    ),
    rules=RoleRules(roles=ROLES),
    lease_idle_s=4.0,
)
