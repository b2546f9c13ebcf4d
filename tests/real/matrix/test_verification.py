"""Verification by emoji at a real homeserver: between two of ours, and with matrix-js-sdk."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from rosic.contracts.verification import VerificationEnd
from rosic.messengers.matrix.trust import SenderAssurance
from tests.real.matrix.js_client import JsClient
from tests.real.matrix.verifier import Verifier

if TYPE_CHECKING:
    from pathlib import Path

    from tests.real.matrix.synapse import Synapse


async def _room_of(one: Verifier, two: Verifier) -> str:
    """Have one make an encrypted room and the other join it."""
    state = {"type": "m.room.encryption", "content": {"algorithm": "m.megolm.v1.aes-sha2"}}
    asked = {"invite": [two.user], "is_direct": True, "preset": "trusted_private_chat"}
    made = await one.client.call(
        "POST", "/_matrix/client/v3/createRoom", {**asked, "initial_state": [state]}
    )
    room = str(made["room_id"])
    await one.until(lambda: room in one.client.rooms)
    await two.join(room)
    await one.until(lambda: two.user in one.client.members(room))
    return room


@pytest.mark.parametrize("in_room", [False, True], ids=["to-device", "in-room"])
async def test_two_of_ours_verify_each_other(
    synapse: Synapse, tmp_path: Path, *, in_room: bool
) -> None:
    ada_account, robot_account = synapse.create_account("Ada"), synapse.create_account("Robot")
    async with (
        Verifier(robot_account, tmp_path / "robot") as robot,
        Verifier(ada_account, tmp_path / "ada") as ada,
    ):
        room = await _room_of(ada, robot)
        name = await ada.emoji.begin(robot.user, room=room if in_room else "")
        ours, theirs = await robot.shown(), await ada.shown()
        assert ours.emoji == theirs.emoji
        assert ours.verification == name
        await robot.emoji.confirm(name)
        await ada.emoji.confirm(name)
        for end in (robot, ada):
            result = await end.ended()
            assert (result.end, result.master) == (VerificationEnd.COMPARED, True)

        # The signature of each on the other's master key stands at the homeserver.
        for one, two in ((robot, ada), (ada, robot)):
            own = await one.directory.keys_of(one.user, fresh=True)
            keys = await one.directory.keys_of(two.user, fresh=True)
            assert keys.master_signed_by(one.user, own.user_signing, own.user_signing)
            assert await one.cross_signing.is_verified_device(two.user, two.device)

        await ada.client.send(room, "m.room.message", {"msgtype": "m.text", "body": "drive 1 2"})
        await robot.until(lambda: bool(robot.heard))
        assert robot.heard == [("drive 1 2", SenderAssurance.ENCRYPTED_VERIFIED)]

    async with Verifier(robot_account, tmp_path / "robot") as robot:
        assert await robot.cross_signing.is_verified_device(ada_account.user, ours.device)


async def test_codes_that_differ_verify_nobody(synapse: Synapse, tmp_path: Path) -> None:
    async with (
        Verifier(synapse.create_account("Robot"), tmp_path / "robot") as robot,
        Verifier(synapse.create_account("Ada"), tmp_path / "ada") as ada,
    ):
        name = await robot.emoji.begin(ada.user)
        await robot.shown()
        await ada.shown()
        await ada.emoji.reject(name)
        result = await robot.ended()
        assert (result.end, result.code) == (VerificationEnd.CANCELLED, "m.mismatched_sas")
        assert not await robot.cross_signing.is_verified_device(ada.user, ada.device)


@pytest.mark.parametrize("in_room", [False, True], ids=["to-device", "in-room"])
@pytest.mark.parametrize("begins", ["person", "robot"])
async def test_a_client_of_rust_and_the_robot_verify_each_other(
    synapse: Synapse, tmp_path: Path, begins: str, *, in_room: bool
) -> None:
    async with (
        Verifier(synapse.create_account("Robot"), tmp_path / "robot") as robot,
        JsClient(synapse.create_account("Ada"), tmp_path / "ada.log") as ada,
    ):
        room = await ada.create_room(robot.user, direct=True)
        await robot.join(room)
        if begins == "person":
            device = "" if in_room else robot.device
            name = await ada.request_verification(
                robot.user, room=room if in_room else "", device=device
            )
            await ada.verification(robot.user, "ready")
            await ada.compare_emoji(name)
        else:
            await robot.cross_signing.look_up(ada.user)
            name = await robot.emoji.begin(ada.user, room=room if in_room else "")
            asked = await ada.verification(robot.user, "requested")
            assert asked["transaction"] == name
            await ada.accept_verification(name)  # and the robot begins to compare at once
        ours = await robot.shown()
        theirs = await ada.verification(robot.user, "emoji")
        assert [sign for sign, _ in ours.emoji] == theirs["emoji"]

        await robot.emoji.confirm(name)
        await ada.confirm(name)
        result = await robot.ended()
        assert (result.end, result.master) == (VerificationEnd.COMPARED, True)
        await ada.verification(robot.user, "done")
        await ada.verified(robot.user)

        await ada.say(room, "drive 1 2")
        await robot.until(lambda: bool(robot.heard))
        assert robot.heard == [("drive 1 2", SenderAssurance.ENCRYPTED_VERIFIED)]


async def test_a_person_says_that_the_emoji_differ(synapse: Synapse, tmp_path: Path) -> None:
    async with (
        Verifier(synapse.create_account("Robot"), tmp_path / "robot") as robot,
        JsClient(synapse.create_account("Ada"), tmp_path / "ada.log") as ada,
    ):
        room = await ada.create_room(robot.user, direct=True)
        await robot.join(room)
        name = await ada.request_verification(robot.user, room=room)
        await ada.verification(robot.user, "ready")
        await ada.compare_emoji(name)
        await robot.shown()
        await ada.verification(robot.user, "emoji")
        await ada.reject(name)
        result = await robot.ended()
        assert (result.end, result.code) == (VerificationEnd.CANCELLED, "m.mismatched_sas")
        assert not await robot.cross_signing.is_verified_device(ada.user, ada.device)
