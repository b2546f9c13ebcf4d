"""A sentence about a robot names it once, whoever puts the name before it."""

from __future__ import annotations

import pytest
from msgspec.structs import replace

from rosic.config.profiles import load_profile, shipped_profiles
from rosic.core.messages import headed
from rosic_sim.robots.machines.omni import Omni
from rosic_sim.robots.robot import SimulatedRobot
from rosic_sim.robots.simulation_loop import simulation_of
from tests.features.fleet.test_tasks import heard
from tests.gateway.place import Place, edited, line_by_line


class Simulated(Place):
    """Its robots move, if their batteries let them."""

    kind = SimulatedRobot


@pytest.mark.parametrize("chat", [edited, line_by_line])
async def test_a_refused_order_of_a_task_names_its_robot_once(chat: object) -> None:
    omni = replace(load_profile(shipped_profiles()["omni"], link="simulated"), title="Carrier 2")
    here = Simulated(fleet=(omni,), chat=chat)  # type: ignore[arg-type]
    machine = simulation_of(here.clock).world.machines["omni"]
    assert isinstance(machine, Omni)
    machine._cell.fraction = 0.0
    async with here.open():
        await here.say("/task omni arm reach once")
        await heard(here, 3)
        texts = [here.chat.shown(told.message).text for told in here.chat.told]
        refused = [line for text in texts for line in text.splitlines() if "too low" in line]
        assert any("battery 0 %: too low. Nothing was done." in line for line in refused)
        named = [line.count("Carrier 2") + line.count("omni: battery") for line in refused]
        assert max(named) <= 1, refused


@pytest.mark.parametrize(
    ("text", "read"),
    [
        ("battery low", "cf1: battery low"),
        ("cf1 is stopped, by Bo.", "cf1 is stopped, by Bo."),
        ("cf1: busy", "cf1: busy"),
        ("cf12 flies there", "cf1: cf12 flies there"),
    ],
)
def test_a_name_is_put_before_what_does_not_begin_with_it(text: str, read: str) -> None:
    assert headed("cf1", text) == read
