"""An admin sends a profile into the chat, reads what the robot could do, and adds it."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

import pytest

from rosic.core.identity import ROBOT, Address
from rosic.core.message import ChatKind
from rosic.core.records import Decided
from rosic.features.files import FilesFeature
from tests.features.robot_to_robot.peers import PeerRobots
from tests.gateway.place import ADA, BO, PEOPLE, VI, Place
from tests.gateway.rover import CAN, ROVER
from tests.pace import pace

if TYPE_CHECKING:
    from rosic.core.records import Record

ADDED = f"Rover 3 is here now, as rover.\n{CAN}"


class Noting(Place):
    """Remembers what was decided."""

    decided: list[Decided]

    def note(self) -> None:
        """Listen from now on."""
        self.decided = []

        def heard(record: Record) -> None:
            assert isinstance(record, Decided)
            self.decided.append(record)

        self.gateway.access.changes.watch(Decided, heard)


async def send(
    place: Place, content: str = ROVER, account: str = ADA, name: str = "rover.yaml"
) -> str:
    """Send a file; return what was told because of it."""
    before = len(place.chat.told)
    place.chat.enclose(name, content.encode(), account=account, chat=account)
    await place.quiet()
    receiving = place.gateway.features.get(FilesFeature).receiving
    assert receiving is not None
    async with asyncio.timeout(60 * pace()):
        while receiving._coming:  # noqa: ASYNC110 - a task of its own
            await asyncio.sleep(0.002)
    await place.quiet()
    return "\n".join(told.outbound.text for told in list(place.chat.told)[before:])


async def heard(place: Place, before: int, words: str) -> str:
    """Wait until something with these words was told, and return what was told since."""
    async with asyncio.timeout(60 * pace()):
        while words not in (told := said_since(place, before)):
            await asyncio.sleep(0.002)  # a thread of its own reads profiles
            await place.quiet()
    return told


def said_since(place: Place, before: int) -> str:
    """Return what was told since, newest last."""
    return "\n".join(told.outbound.text for told in list(place.chat.told)[before:])


async def tap(place: Place, label: str, words: str) -> str:
    """Tap the newest button with a label, and wait for words."""
    before = len(place.chat.told)
    await place.tap(*place.button(label))
    return await heard(place, before, words)


async def say(place: Place, text: str, words: str) -> str:
    """Say something, and wait for words."""
    before = len(place.chat.told)
    await place.say(text)
    return await heard(place, before, words)


async def test_two_taps_add_a_robot_that_was_sent_as_a_file() -> None:
    async with Noting().open() as place:
        place.note()
        assert "is kept for you" in await send(place)
        said = await tap(place, "Add this robot", "Add Rover 3")
        assert said.startswith("Add Rover 3, as rover? Whoever may use every robot here")
        assert CAN in said
        assert "rover" not in place.gateway.robots
        button = place.button("Add it")
        await tap(place, "Add it", ADDED)
        assert [(d.act, d.about) for d in place.decided][-1] == ("robot-added", "rover")
        await place.tap(*button)  # once
        assert "done" in await place.say("rover wiggle")
        await say(place, "/robot add rover.yaml", "called rover here already")


class Alone(PeerRobots):
    """No robot is anybody here yet."""

    people = PEOPLE  # fewer


async def test_an_admin_lets_it_speak_with_the_others_under_a_key_that_is_theirs_to_give() -> None:
    async with Alone().open() as place:
        assert "/robot add rover.yaml as ROLE; /role names" in await say_sent(place)
        asked = "It may speak with the other robots then, as fellow."
        assert "Add Rover 3, as rover?" in await say(
            place, "/robot add rover.yaml as fellow", asked
        )
        assert "rover" not in place.gateway.robots
        await tap(place, "Add it", "Rover 3 may speak with the other robots, as fellow.")
        found = place.gateway.rooms.authoriser.directory.at(Address(ROBOT, "rover"))
        assert found is not None
        rover, key = found
        assert rover.roles == ("fellow",)
        assert key.issuer == ada(place)
        assert (await place.says("rover", "share", topic="road", data="wet"))["ok"] is True


async def test_a_role_that_is_none_is_said_before_anything_is_asked() -> None:
    async with Alone().open() as place:
        await send(place)
        said = await say(place, "/robot add rover.yaml as dancer", "There is no role dancer here.")
        assert "Nothing was changed." in said
        await say(place, "/robot add rover.yaml as fellow", "as fellow")
        button = place.button("Add it")
        await send(place, ROVER.replace("Rover 3", "Bo").replace("rover", "bo"), name="bo.yaml")
        await say(place, "/robot add bo.yaml as fellow", "Somebody here is called bo already")
        await place.say("/files delete rover.yaml")
        await send(place, ROVER.replace("Rover 3", "Other"))
        before = len(place.chat.told)
        await place.tap(*button)
        await heard(place, before, "changed since I showed it")
        assert [b.command for row in place.last()[1].buttons for b in row] == [
            "/robot add rover.yaml as fellow"
        ]
        assert "rover" not in place.gateway.robots


async def test_whoever_may_add_no_robot_gives_none_a_role() -> None:
    async with Alone().open() as place:
        await send(place, account=BO)
        said = await place.say("/robot add rover.yaml as fellow", account=BO, chat=BO)
        assert said.startswith("Only somebody who may assign tasks and give rights here")


async def test_whoever_gives_rights_for_a_while_only_gives_no_robot_a_role_for_good() -> None:
    async with Alone().open() as place:
        await place.say("/grant Bo admin for 1h")
        await send(place, account=BO)
        said = await place.say("/robot add rover.yaml as fellow", account=BO, chat=BO)
        assert said == (
            "A robot keeps its role for good, and your own right to give rights ends. Add it "
            "without a role, or let an admin without an end add it. Nothing was changed."
        )
        before = len(place.chat.told)
        await place.say("/robot add rover.yaml", account=BO, chat=BO)
        assert "Add Rover 3, as rover?" in await heard(place, before, "Add Rover 3")


async def say_sent(place: Place) -> str:
    """Send the rover, tap, and return what is asked."""
    await send(place)
    return await tap(place, "Add this robot", "Add Rover 3")


def ada(place: Place) -> str:
    """Return the admin's id."""
    found = place.gateway.rooms.authoriser.directory.at(Address("memory", ADA))
    assert found is not None
    return found[0].id


async def test_leaving_it_adds_nothing() -> None:
    async with Place().open() as place:
        await send(place)
        await tap(place, "Add this robot", "Add Rover 3")
        await place.tap(*place.button("Leave it"))
        assert "rover" not in place.gateway.robots


@pytest.mark.parametrize("account", [BO, VI])
async def test_only_whoever_assigns_tasks_and_gives_rights_may(account: str) -> None:
    async with Place().open() as place:
        await send(place, account=account)
        with pytest.raises(AssertionError, match="no button"):
            place.button("Add this robot")
        said = await place.say("/robot add rover.yaml", account=account, chat=account)
        assert said.startswith("Only somebody who may assign tasks and give rights here")
        assert "rover" not in place.gateway.robots


async def test_a_file_is_ones_own_and_a_group_is_no_place_for_it() -> None:
    async with Place().open() as place:
        await send(place, account=BO)
        assert "no file" in await place.say("/robot add rover.yaml")
        await send(place)
        said = await place.say("/robot add rover.yaml", chat="-5", kind=ChatKind.GROUP)
        assert "private chat" in said


async def test_what_was_shown_is_what_is_added() -> None:
    async with Place().open() as place:
        await send(place)
        await tap(place, "Add this robot", "Add Rover 3")
        button = place.button("Add it")
        await place.say("/files delete rover.yaml")
        await send(place, ROVER.replace("Rover 3", "Other"))
        before = len(place.chat.told)
        await place.tap(*button)
        await heard(place, before, "changed since I showed it")
        assert "rover" not in place.gateway.robots


@pytest.mark.parametrize(
    ("content", "why"),
    [
        (ROVER + "files: { accept: [yaml], inbox: /tmp/inbox }\n", "Only its operator"),
        (ROVER.replace("max: 9", "max: 0"), "rover.yaml:11"),
        (ROVER.replace("id: rover", "id: omni"), "called omni here already"),
        (ROVER + "# " + "x" * 140_000 + "\n", "128 KiB"),
    ],
)
async def test_what_is_wrong_with_it_is_said_and_nothing_is_changed(content: str, why: str) -> None:
    async with Place().open() as place:
        await send(place, content)
        said = await say(place, "/robot add rover.yaml", why)
        assert "Nothing was changed." in said
        assert "rover" not in place.gateway.robots
