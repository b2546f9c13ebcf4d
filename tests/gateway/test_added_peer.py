"""A robot that is added while everything runs may speak with the others from that moment on."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from rosic.core.identity import OPERATOR, ROBOT, Address
from rosic.features.robot_to_robot.digest import EVERY_S
from rosic.gateway.robot_registry import owner_may
from rosic.stores.memory import MemoryStore
from tests.features.robot_to_robot.peers import PeerRobots
from tests.gateway.place import BO, PEOPLE
from tests.gateway.rover import add, draft, refused

if TYPE_CHECKING:
    from rosic.gateway.robot_registry import ProfileDraft


class Alone(PeerRobots):
    """No robot is anybody here yet."""

    people = PEOPLE  # fewer


def rover_is_somebody(here: PeerRobots) -> bool:
    directory = here.gateway.rooms.authoriser.directory
    return directory.at(Address(ROBOT, "rover")) is not None


async def test_it_speaks_under_a_key_of_its_own_and_still_does_after_a_restart() -> None:
    store = MemoryStore()
    async with Alone(store).open() as here:
        told = await here.gateway.robot_adder.add(draft(), OPERATOR, owner_may, "fellow")
        assert "Rover 3 may speak with the other robots, as fellow." in told
        await here.say("/shared rover follow", account=BO, chat=BO)
        assert (await here.says("rover", "share", topic="road", data="wet"))["ok"] is True
        await here.clock.advance(EVERY_S + 1.0)  # somebody looks after it, though nobody did before
        assert any("Rover 3 shares road" in t.outbound.text for t in here.chat.told)
        again = await refused(here.gateway.robot_adder.add(draft(), OPERATOR, owner_may, "fellow"))
        assert "is called rover here already" in again
        await here.say("/lock rover")
        await here.clock.advance(31.0)
        assert (await here.says("rover", "share", topic="road", data="dry"))["ok"] is False
        await here.say("/unlock rover")
    async with Alone(store).open() as here:
        assert rover_is_somebody(here)
        assert (await here.says("rover", "share", topic="road", data="dry"))["ok"] is True


async def test_without_a_role_it_is_nobody() -> None:
    async with Alone().open() as here:
        await add(here)
        assert not rover_is_somebody(here)
        answer = await here.says("rover", "share", topic="road", data="wet")
        assert answer["why"].startswith("Rover 3 has no key of its own here.")


@pytest.mark.parametrize(
    ("text", "role", "why"),
    [
        (draft(), "dancer", "There is no role dancer here. There are: "),
        (draft(rover="bo"), "fellow", "Somebody here is called bo already"),
    ],
)
async def test_a_role_that_is_none_or_a_name_that_somebody_has_changes_nothing(
    text: ProfileDraft, role: str, why: str
) -> None:
    async with Alone().open() as here:
        before = len(list(here.gateway.rooms.authoriser.directory.people()))
        adding = here.gateway.robot_adder.add(text, OPERATOR, owner_may, role)
        assert why in await refused(adding)
        assert len(list(here.gateway.rooms.authoriser.directory.people())) == before
        assert len(here.gateway.robots) == 4
