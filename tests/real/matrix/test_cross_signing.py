"""Cross-signing at a real homeserver, and what other clients make of it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from rosic.core.secret import Secret
from rosic.errors import ConfigurationError
from rosic.messengers.matrix.cross_signing import BOOK_FILE, KEYS_FILE
from rosic.messengers.matrix.identity_book import IdentityStanding, KeyChangeKind
from rosic.messengers.matrix.trust import SenderAssurance
from tests.real.matrix.database import found_in
from tests.real.matrix.js_client import JsClient
from tests.real.matrix.person import Person
from tests.real.matrix.verifier import Verifier

if TYPE_CHECKING:
    from pathlib import Path

    from tests.real.matrix.synapse import Synapse


async def test_the_homeserver_takes_the_keys_and_the_device_is_signed(
    synapse: Synapse, tmp_path: Path
) -> None:
    async with Verifier(synapse.create_account("Robot"), tmp_path / "robot") as robot:
        keys = await robot.directory.keys_of(robot.user, fresh=True)
        device = keys.device(robot.device)
        assert device is not None
        assert device.cross_signed
        assert keys.user_signing
        assert keys.master_signed_by(robot.user, device.device, device.ed25519)
        for name in (KEYS_FILE, BOOK_FILE):
            assert (tmp_path / "robot" / name).stat().st_mode & 0o777 == 0o600
            assert keys.master.encode() not in (tmp_path / "robot" / name).read_bytes()


async def test_after_a_restart_of_both_the_keys_are_the_same(
    synapse: Synapse, tmp_path: Path
) -> None:
    account = synapse.create_account("Robot")
    async with Verifier(account, tmp_path / "robot") as robot:
        own, device = robot.cross_signing.own_keys(), robot.device
    synapse.restart()
    async with Verifier(account, tmp_path / "robot") as robot:
        assert robot.device == device
        assert robot.cross_signing.own_keys() == own
        assert robot.told == []


async def test_without_its_folder_the_account_is_refused_until_its_keys_are_reset(
    synapse: Synapse, tmp_path: Path
) -> None:
    account = synapse.create_account("Robot")
    async with Verifier(account, tmp_path / "lost") as robot:
        before = robot.cross_signing.own_keys()
    again = Verifier(account, tmp_path / "new")
    with pytest.raises(ConfigurationError, match="does not have"):
        async with again:
            pass
    async with again.client.held():
        # Synapse asks for the password before it lets keys be replaced.
        with pytest.raises(ConfigurationError, match="did not take the password"):
            await again.cross_signing.reset(Secret("wrong"))
        await again.cross_signing.reset(Secret(account.password))
        assert again.cross_signing.own_keys() != before
    async with Verifier(account, tmp_path / "new") as robot:
        assert robot.cross_signing.own_keys() == again.cross_signing.own_keys()


async def test_a_strict_client_talks_to_the_robot_and_reads_it(
    synapse: Synapse, tmp_path: Path
) -> None:
    """Its keys go to devices that their owner has signed, and to no other."""
    async with (
        Verifier(synapse.create_account("Robot"), tmp_path / "robot") as robot,
        JsClient(synapse.create_account("Ada"), tmp_path / "ada.log") as ada,
    ):
        room = await ada.create_room(robot.user, direct=True)
        await robot.join(room)
        assert (await ada.trust(robot.user, robot.device))["signed_by_owner"]
        await ada.say(room, "where are you")
        await robot.until(lambda: bool(robot.heard))
        assert robot.heard == [("where are you", SenderAssurance.ENCRYPTED_UNVERIFIED)]

        await robot.client.send(room, "m.room.message", {"msgtype": "m.text", "body": "here I am"})
        heard = await ada.hears(room, "here I am")
        assert (heard.encrypted, heard.unreadable, heard.shield) == (True, "", "NONE")
    assert found_in(synapse, "where are you") == found_in(synapse, "here I am") == []


async def test_a_device_without_cross_signing_is_not_verified(
    synapse: Synapse, tmp_path: Path
) -> None:
    async with (
        Verifier(synapse.create_account("Robot"), tmp_path / "robot") as robot,
        Person(synapse.create_account("Ada"), tmp_path / "ada") as ada,
    ):
        room = await ada.create_room(robot.user, direct=True)
        await robot.join(room)
        await ada.say(room, "drive 1 2")
        await robot.until(lambda: bool(robot.heard))
        assert robot.heard == [("drive 1 2", SenderAssurance.ENCRYPTED_UNVERIFIED)]

        plain = await ada.create_room(robot.user, encrypted=False)
        await robot.join(plain)
        await ada.say(plain, "in the open")
        await robot.until(lambda: len(robot.heard) > 1)
        assert robot.heard[1] == ("in the open", SenderAssurance.PLAIN)


async def test_a_person_who_resets_their_identity_is_refused_and_told_of(
    synapse: Synapse, tmp_path: Path
) -> None:
    account = synapse.create_account("Ada")
    async with Verifier(synapse.create_account("Robot"), tmp_path / "robot") as robot:
        async with JsClient(account, tmp_path / "ada.log") as ada:
            room = await ada.create_room(robot.user, direct=True)
            await robot.join(room)
            keys, standing = await robot.cross_signing.look_up(ada.user)
            assert standing is IdentityStanding.FIRST_SEEN
            phone = keys.device(ada.device)
            assert phone is not None
            await robot.cross_signing.compared(phone, keys.master)
            await ada.say(room, "first")
            await robot.until(lambda: bool(robot.heard))
        # Another device, which finds no keys of the first and makes the account new ones.
        async with JsClient(account, tmp_path / "again.log") as again:
            assert await again.ask("rooms")

            await robot.until(lambda: KeyChangeKind.NEW_DEVICE in _kinds(robot))
            await again.say(room, "second")
            await robot.until(lambda: len(robot.heard) > 1)
            _, standing = await robot.cross_signing.look_up(again.user, fresh=True)
            reset = standing is IdentityStanding.REPLACED
    assert robot.heard[0] == ("first", SenderAssurance.ENCRYPTED_VERIFIED)
    assert robot.heard[1] == ("second", SenderAssurance.ENCRYPTED_UNVERIFIED)
    assert reset
    assert KeyChangeKind.MASTER_REPLACED in _kinds(robot)


def _kinds(robot: Verifier) -> set[KeyChangeKind]:
    return {change.kind for change in robot.told}
