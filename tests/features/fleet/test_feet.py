"""Whoever reads feet is asked in tasks what a plain line asks: which unit a number has."""

from __future__ import annotations

import pytest

from rosic.features.fleet import FleetFeature
from tests.features.fleet.test_tasks import warehouse
from tests.gateway.place import BO

QUESTION = (
    "Say the unit of 3: you chose to read feet, and the robot reads metres. Nothing was done."
)
COMMANDS = ("/task w1", "/together w1+w2", "/broadcast w1+w2")


@pytest.mark.parametrize("command", COMMANDS)
async def test_a_number_without_a_unit_is_asked_about_with_both_readings(command: str) -> None:
    async with warehouse().open() as here:
        await here.say("/settings units imperial")
        assert QUESTION in await here.say(f"{command} move 3")
        assert here.acted("w1") == 0
        assert not here.gateway.features.get(FleetFeature).dispatching.fleet.tasks
        _, shown = here.last()
        offers = [button.label for row in shown.buttons for button in row]
        assert offers[0] == f"{command} move 3 ft"
        assert offers[1].startswith(f"{command} move ")
        await here.tap(*here.button(f"{command} move 3 ft"))
        assert here.acted("w1") == 1


@pytest.mark.parametrize("command", COMMANDS)
async def test_whoever_reads_metres_is_not_asked(command: str) -> None:
    async with warehouse().open() as here:
        await here.say("/settings units imperial", account=BO)
        assert "Say the unit" not in await here.say(f"{command} move 3")
        assert here.acted("w1") == 1


async def test_every_step_of_a_task_is_looked_at() -> None:
    async with warehouse().open() as here:
        await here.say("/settings units imperial")
        assert QUESTION in await here.say("/task w1 move 1 m then move 3 priority 2")
        _, shown = here.last()
        offers = [button.label for row in shown.buttons for button in row]
        assert offers[0].endswith("then move 3 ft priority 2")
