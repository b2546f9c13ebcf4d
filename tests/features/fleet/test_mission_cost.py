"""I15: however large a mission is, showing what starts it holds nobody up."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from rosic.core.fleet.mission import TASKS_AT_MOST, Mission, MissionPart
from rosic.core.fleet.task import STEPS_AT_MOST
from tests.gateway.loop_steps import herd, none_is_long, run
from tests.gateway.received import ADA

if TYPE_CHECKING:
    from tests.gateway.received import Receiving

SHOWN_TOGETHER = 5
LONGEST_PART = tuple(f"move 1.{n:02} m" for n in range(STEPS_AT_MOST))


@pytest.mark.parametrize(
    "steps", [("move 1 m",), ("move 9 m",), LONGEST_PART], ids=["done", "refused", "longest"]
)
def test_no_mission_that_is_shown_makes_a_step_long(steps: tuple[str, ...]) -> None:
    """Each button is bound to what two hundred parts let two hundred robots do."""

    async def act(place: Receiving) -> None:
        await none_is_long(place, ADA, ["/mission m0", "/missions"])

    part = MissionPart(on="any", steps=steps)
    missions = tuple(
        Mission(name=f"m{n}", do=(part,) * TASKS_AT_MOST) for n in range(SHOWN_TOGETHER)
    )
    run(act, herd(200), missions)
