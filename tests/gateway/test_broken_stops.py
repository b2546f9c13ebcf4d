"""A robot that was stopped and at rest, and is driven by somebody else, is told of once a stop."""

from __future__ import annotations

from typing import TYPE_CHECKING

from tests.features.fleet.test_tasks import heard, warehouse, worker
from tests.gateway.place import profile

if TYPE_CHECKING:
    import pytest

BROKEN = "w9 is stopped and was at rest; now it moves, and not by me. Please look."


async def test_whoever_stopped_a_robot_is_told_once_that_it_moves_all_the_same(
    caplog: pytest.LogCaptureFixture,
) -> None:
    async with warehouse(fleet=(profile("w9"),)).open() as here:
        await here.say("stop w9")
        assert BROKEN not in await heard(here, 5.0)
        robot = worker(here, "w9")
        robot.moving = True
        assert (await heard(here, 3.0)).count(BROKEN) == 1
        assert "w9 is stopped, was measured at rest, and moves" in caplog.text
        robot.moving = False
        await heard(here, 3.0)
        robot.moving = True
        assert BROKEN not in await heard(here, 3.0), "once for each stop"
        robot.moving = False
        await here.say("stop w9")
        await heard(here, 3.0)
        robot.moving = True
        assert (await heard(here, 3.0)).count(BROKEN) == 1


async def test_a_push_a_resumed_robot_and_one_that_never_rested_are_not_told_of() -> None:
    async with warehouse(fleet=(profile("w9"),)).open() as here:
        robot = worker(here, "w9")
        robot.moving = True
        assert BROKEN not in await heard(here, 3.0), "nobody has stopped it"
        robot.moving = False
        await here.say("stop w9")
        await heard(here, 3.0)
        robot.moving = True
        told = await heard(here, 0.5)
        robot.moving = False
        assert BROKEN not in told + await heard(here, 3.0), "a push"
        await here.say("/resume w9")
        await heard(here, 1.0)
        robot.moving = True
        assert BROKEN not in await heard(here, 3.0)
