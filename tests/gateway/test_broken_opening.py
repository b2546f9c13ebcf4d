"""Opening may break off anywhere: what had been made by then is closed again, the record last."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from rosic.app.gateway import Gateway
from rosic.errors import ConfigurationError
from rosic.robots.memory import MemoryRobot
from rosic.stores.memory import MemoryStore
from tests.gateway.place import Place

if TYPE_CHECKING:
    from rosic.contracts.robot import Say

STEPS = ("_authority", "_set_up", "_speaking", "_pipeline", "_recover")


class ClosedStore(MemoryStore):
    closed = 0

    async def close(self) -> None:
        self.closed += 1
        await super().close()


@pytest.mark.parametrize("step", STEPS)
@pytest.mark.parametrize("after", [False, True])
async def test_what_was_made_is_closed_wherever_opening_breaks_off(
    step: str, monkeypatch: pytest.MonkeyPatch, *, after: bool
) -> None:
    made = getattr(Gateway, step)

    async def breaks(gateway: Gateway, *given: object) -> None:
        if after:
            await made(gateway, *given)
        raise ConfigurationError("It breaks off here.")

    def breaks_at_once(gateway: Gateway, *given: object) -> None:
        if after:
            made(gateway, *given)
        raise ConfigurationError("It breaks off here.")

    waits = step in {"_authority", "_set_up", "_recover"}
    monkeypatch.setattr(Gateway, step, breaks if waits else breaks_at_once)
    place = Place(store := ClosedStore())
    with pytest.raises(ConfigurationError, match="breaks off here"):
        await place.gateway.open()
    assert store.closed == 1


class BrokenRobot(MemoryRobot):
    """Cannot be opened."""

    async def open(self, say: Say) -> None:
        say("looking for topics")
        raise ConfigurationError(f"{self.profile.id} has no such topic.")


class BrokenPlace(Place):
    kind = BrokenRobot


async def test_a_robot_that_can_never_work_ends_the_opening_and_closes_the_record() -> None:
    place = BrokenPlace(store := ClosedStore())
    with pytest.raises(ConfigurationError, match="no such topic"):
        await place.gateway.open()
    assert store.closed == 1
