"""One person, one robot: a ranger and what watches the forest for fire (Algorithm 2)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from rosic_sim.robots.machines.field_robots import Fire, FireWatcher
from rosic_sim.scenarios.robots import prop
from rosic_sim.scenarios.scenario import Person, Scenario

if TYPE_CHECKING:
    from rosic_sim.scenarios.scenario import ScenarioRunner

RANGER: Final = "Ranger"
WATCH: Final = "watch"
COLD_C: Final = -24.0
BRAMBLES_M_S: Final = 0.18
FIRE: Final = Fire(1.6, 0.5, 45.0)


async def _script(stage: ScenarioRunner) -> None:
    watch = stage.world.machines[WATCH]
    assert isinstance(watch, FireWatcher)  # noqa: S101 - the play put it there
    stage.aside("A forest ranger has one robot on watch. It tells how warm the air is.")
    await stage.says(RANGER, "status watch", hears="heat 21")
    await stage.says(RANGER, "watch goto x=0.6 y=0", hears="at 0.60")
    stage.aside(
        "Its heat sensor drifts. A rule in the robot's profile knows the benchmark, and lets the "
        "robot recalibrate itself, in the ranger's name."
    )
    watch.drift_by(COLD_C)
    await stage.hears(RANGER, "off its benchmark")
    await stage.hears(RANGER, "recalibrated; the sensor was -24.0 °C off")
    await stage.says(RANGER, "status watch", hears="heat 21")
    stage.aside("And then something does burn, out of sight behind the ridge.")
    watch.kindle(FIRE)
    await stage.says(RANGER, "watch goto x=1.2 y=0.3")
    await stage.hears(RANGER, "hotter here than a forest should be")
    await stage.hears(RANGER, "done ")
    await stage.taps(RANGER, "Seen", hears="Noted.")
    await stage.says(RANGER, "/picture watch", hears="camera")
    await stage.beat()
    stage.aside(
        "The ranger calls the fire brigade, and takes the robot back, through brambles. How long "
        "a way should take is in its profile, too."
    )
    watch.cap_speed(BRAMBLES_M_S)
    await stage.says(RANGER, "watch goto x=0.2 y=0", hears="at 0.20")
    await stage.hears(RANGER, "This takes longer than its benchmark")
    await stage.says(RANGER, "/benchmark watch", hears="expected 3.0 s")


ONE_TO_ONE: Final = Scenario(
    name="one-to-one",
    about="a forest ranger and one robot that watches for fire",
    people=(Person(RANGER),),
    profiles=lambda: (prop(WATCH),),
    machines=lambda: (FireWatcher(WATCH),),
    script=_script,
    hints=(
        "watch goto x=1 y=0",
        "status watch",
        "/picture watch",
        "/benchmark watch",
        "/alerts",
        "stop",
    ),
)
