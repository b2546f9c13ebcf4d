"""Robots among themselves: a search with drones and rovers (Algorithm 5)."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Final

from rosic.core.policy.roles import DEFAULT_ROLES, Role, RoleRules
from rosic.features.fleet import FleetFeature
from rosic_sim.robots.machines.field_robots import Rover
from rosic_sim.scenarios.robots import several, shipped
from rosic_sim.scenarios.scenario import Person, Scenario

if TYPE_CHECKING:
    from rosic_sim.scenarios.scenario import ScenarioRunner

LEADER: Final = "Search leader"
DRONES: Final = ("cf1", "cf2", "cf3")
ROVERS: Final = ("rover1", "rover2")
PEER_ROLE: Final = Role(scopes=("*:share", "*:ask", "*:help", "*:read"))


async def _script(stage: ScenarioRunner) -> None:
    for name in ROVERS:
        stage.robot(name).help_others()
    stage.aside("A search leader has three drones in the air and two rovers on the ground.")
    await stage.says(LEADER, "/shared cf1 seen follow", hears="From now on you read here")
    stage.aside("All three take off at one moment; if one were not ready, none would.")
    await stage.says(LEADER, "/together crazyflies takeoff 1 m")
    for drone in DRONES:
        await stage.until(partial(_high, stage, drone), f"{drone} is not up")
    await stage.says(LEADER, "crazyflies formation triangle spacing=0.8 m", hears="accepted")
    stage.robot("cf1").says("share", topic="seen", data={"x": 3.5, "y": 0.0, "what": "a coat"})
    stage.aside("A drone sees something, and shares it with whoever follows it.")
    await stage.hears(LEADER, "a coat")
    stage.aside("The rovers have a look, each on its own way.")
    await stage.says(LEADER, "/task rovers goto x=3.5 y=0.5", hears="Task 1: ")
    await stage.says(LEADER, "/task rovers goto x=3.5 y=-0.5", hears="Task 2: ")
    tasks = stage.gateway.features.get(FleetFeature).dispatching.fleet.tasks
    stuck = await stage.until(lambda: tasks["1"].robot, "Task 1 did not begin")
    helper = await stage.until(lambda: tasks["2"].robot, "Task 2 did not begin")
    await _gets_help(stage, stuck, helper)
    await stage.says(LEADER, "/fleet rovers", hears="at work")
    stage.aside("That is enough for the leader. One word, and everything comes to rest.")
    await stage.says(LEADER, "stop", hears="at rest (")
    await stage.hears(LEADER, "paused.")
    await stage.says(LEADER, "/tasks", hears="paused")


async def _gets_help(stage: ScenarioRunner, stuck: str, helper: str) -> None:
    stage.aside(f"The ground gives way under {_shown(stage, stuck)}. It asks for help itself.")
    _rover(stage, stuck).enter_mud()
    await stage.hears(LEADER, "has failed at it")
    stage.robot(stuck).says("help", what="stuck in the mud")
    await stage.hears(LEADER, "asks for help: stuck in the mud")
    await stage.hears(LEADER, f"Task 2 leaves {_shown(stage, helper)}")
    stage.aside(f"{_shown(stage, helper)} has accepted: it takes over, and its own task waits.")
    await stage.hears(LEADER, f"{_shown(stage, helper)} goes on with it")
    await stage.says(LEADER, "/assist", hears="is helped by")
    _rover(stage, stuck).leave_mud()
    help_id = next(told["id"] for told in stage.robot(stuck).heard if told["kind"] == "helped")
    stage.robot(stuck).says("over", id=help_id)
    await stage.hears(LEADER, "needs no more help")
    stage.aside(f"{_shown(stage, stuck)} is out again, and takes what was left.")
    await stage.hears(LEADER, f"{_shown(stage, stuck)} goes on with it")
    stage.aside("Who has been stuck once had better be careful. The robot itself says that it is.")
    await stage.says(LEADER, f"/strategy {stuck} careful speed=0.2 now", hears="has taken on")


def _high(stage: ScenarioRunner, drone: str) -> bool:
    presence = stage.gateway.rooms.linker.presence(drone)
    return float(presence.values.get("z", 0.0)) > 0.95 and not presence.doing  # noqa: PLR2004 - m


def _rover(stage: ScenarioRunner, name: str) -> Rover:
    machine = stage.world.machines[name]
    assert isinstance(machine, Rover)  # noqa: S101 - the play put it there
    return machine


def _shown(stage: ScenarioRunner, robot: str) -> str:
    return stage.gateway.rooms.profiles[robot].shown


SWARM: Final = Scenario(
    name="swarm",
    about="a search with drones in the air and rovers on the ground",
    people=(Person(LEADER, "admin"),),
    profiles=lambda: (*shipped(*DRONES), *several("rover", ((), ()))),
    machines=lambda: tuple(Rover(name, (0.0, 0.5 - at, 0.0)) for at, name in enumerate(ROVERS)),
    script=_script,
    hints=(
        "crazyflies takeoff 1 m",
        "crazyflies formation line",
        "rovers goto x=1 y=0",
        "/together crazyflies land",
        "/strategy rover1 careful",
        "/shared cf1",
        "/assist",
        "stop",
    ),
    peers=(*DRONES, *ROVERS),
    rules=RoleRules(roles={**DEFAULT_ROLES, "fellow": PEER_ROLE}),
)
