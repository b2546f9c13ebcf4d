"""Whoever loses access while a robot is being opened adds none, and gives nobody a key."""

from __future__ import annotations

import asyncio

import pytest

from rosic.app.admin.api import AdminVerb
from rosic.core.identity import ROBOT, Address
from rosic.errors import NotPermitted
from tests.gateway.place import ADA, TWO_ADMINS, ask_as_operator
from tests.gateway.rover import ROVER, Lab, Reluctant
from tests.gateway.test_added_in_chat import say, send
from tests.pace import pace


class TwoAdmins(Lab):
    """Somebody else may end an admin's access."""

    people = TWO_ADMINS


@pytest.mark.parametrize("ended", ["revoked", "locked"])
async def test_a_right_that_ended_while_it_was_opened_adds_no_robot(ended: str) -> None:
    async with TwoAdmins().open() as place:
        await send(place, ROVER.replace("id: rover", "id: slowrover"))
        await say(place, "/robot add rover.yaml as admin", "as admin")
        button, under = place.button("Add it")
        place.chat.tap(button, under=under, account=ADA)
        async with asyncio.timeout(10 * pace()):
            await Reluctant.opening.wait()
        if ended == "locked":
            place.chat.say("/lock Ada", account="4", chat="4")
            async with asyncio.timeout(10 * pace()):
                while not place.gateway.access.locks.all():  # noqa: ASYNC110 - a chat of its own
                    await asyncio.sleep(0.002)
        else:
            await ask_as_operator(place.gateway, AdminVerb.REVOKE, "Ada")
        adding = tuple(place.gateway.robot_adder._adding)
        Reluctant.goes_on.set()
        await asyncio.wait(adding)
        assert [type(task.exception()) for task in adding] == [NotPermitted]
        assert "slowrover" not in place.gateway.robots
        assert Reluctant.closed == ["slowrover"]
        directory = place.gateway.rooms.authoriser.directory
        assert directory.at(Address(ROBOT, "slowrover")) is None
