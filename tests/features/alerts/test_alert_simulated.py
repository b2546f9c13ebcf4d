"""A simulated robot whose battery drains: that is told, and its rule folds the arm."""

from __future__ import annotations

from msgspec.structs import replace

from rosic.config.profiles import load_profile, shipped_profiles
from rosic.core.robot.alert_config import AlertConfig
from rosic_sim.robots.machines.omni import Omni
from rosic_sim.robots.robot import SimulatedRobot
from rosic_sim.robots.simulation_loop import simulation_of
from tests.features.alerts.test_alerts import heard
from tests.gateway.place import ADA, BO, Place

LOW = AlertConfig(
    name="battery_low",
    when="battery < 20 %",
    lasting="10 s",
    say="Battery is low",
    run="arm home",
    author="Bo",
)


class Simulated(Place):
    """Its robots move."""

    kind = SimulatedRobot


async def test_a_battery_that_drains_is_told_and_its_rule_folds_the_arm() -> None:
    omni = replace(load_profile(shipped_profiles()["omni"], link="simulated"), alerts=(LOW,))
    here = Simulated(fleet=(omni,))
    machine = simulation_of(here.clock).world.machines["omni"]
    assert isinstance(machine, Omni)
    async with here.open():
        await here.say("omni arm reach", account=BO, chat=BO)
        await heard(here, 30)
        machine._cell.fraction = 0.202  # drains to a fifth in half a minute
        assert await heard(here, 25) == {}
        told = await heard(here, 20)
        assert told[ADA][0].startswith("omni: Battery is low.\nNow: battery 19.9 %.")
        assert any("arm, home · rule battery_low" in text for text in told[BO])
        await heard(here, 30)
        executor = [here.chat.shown(t.message).text for t in here.chat.told]
        assert any("rule battery_low" in text and "done" in text for text in executor)
        machine._cell.fraction = 1.0
        assert (await heard(here, 2))[ADA][0].startswith("omni: over: Battery is low.")
