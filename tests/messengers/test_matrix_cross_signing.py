from __future__ import annotations

import msgspec
import pytest

from rosic.core.secret import Secret
from rosic.errors import ConfigurationError, MessengerFault
from rosic.messengers.matrix.cross_signing import (
    BOOK_FILE,
    KEYS_FILE,
    UPLOAD_KEYS,
    UPLOAD_SIGNATURES,
)
from rosic.messengers.matrix.identity_book import (
    IdentityStanding,
    KeyChange,
    KeyChangeKind,
)
from rosic.messengers.matrix.signed_json import ED25519
from tests.messengers.matrix_identities import (
    ADA,
    ROBOT,
    Account,
    Device,
    Folder,
    Homeserver,
    Person,
    met,
    restarted,
    robot_account,
)

# ---- our own keys ----


async def test_the_first_start_makes_keys_and_has_the_device_signed_by_them() -> None:
    account = robot_account()
    await account.cross_signing.start()

    keys = await account.directory.keys_of(ROBOT, fresh=True)
    device = keys.device("ROBOTDEV")
    assert device is not None
    assert device.cross_signed
    assert keys.user_signing
    assert len({keys.master, keys.self_signing, keys.user_signing}) == 3
    assert keys.master_signed_by(ROBOT, "ROBOTDEV", account.device.ed25519)
    assert account.told == []
    assert account.cross_signing.own_keys() == {
        f"{ED25519}:ROBOTDEV": account.device.ed25519,
        f"{ED25519}:{keys.master}": keys.master,
    }


async def test_a_restart_takes_the_keys_that_are_there_and_changes_nothing() -> None:
    account = robot_account()
    await account.cross_signing.start()
    own, shown = account.cross_signing.own_keys(), msgspec.json.encode(account.homeserver.shown)
    account.homeserver.calls.clear()

    again = restarted(account)
    await again.cross_signing.start()
    assert again.cross_signing.own_keys() == own
    assert msgspec.json.encode(account.homeserver.shown) == shown
    assert UPLOAD_KEYS not in account.homeserver.calls
    assert UPLOAD_SIGNATURES not in account.homeserver.calls
    assert again.told == []


async def test_a_new_device_of_the_account_is_signed_by_the_same_keys() -> None:
    account = robot_account()
    await account.cross_signing.start()
    master = (await account.directory.keys_of(ROBOT)).master

    other = Device(ROBOT, "OTHERDEV")
    account.homeserver.add(other)
    again = Account(account.homeserver, other, account.folder)
    await again.cross_signing.start()

    keys = await again.directory.keys_of(ROBOT)
    device = keys.device("OTHERDEV")
    assert device is not None
    assert device.cross_signed
    assert keys.master == master


async def test_keys_are_kept_before_the_homeserver_hears_of_them() -> None:
    account = robot_account()
    account.folder.full = True
    with pytest.raises(MessengerFault):
        await account.cross_signing.start()
    assert account.homeserver.shown["master_keys"] == {}

    account.folder.full = False
    account.homeserver.asks_for = "never given"
    with pytest.raises(ConfigurationError):
        await account.cross_signing.start()
    kept = account.folder.files[KEYS_FILE]

    account.homeserver.asks_for = ""
    again = restarted(account)
    await again.cross_signing.start()
    assert account.folder.files[KEYS_FILE] == kept


async def test_a_homeserver_that_lost_the_keys_is_given_them_again() -> None:
    account = robot_account()
    await account.cross_signing.start()
    own = account.cross_signing.own_keys()
    for table in ("master_keys", "self_signing_keys", "user_signing_keys"):
        account.homeserver.shown[table].clear()
    account.homeserver.add(account.device)

    again = restarted(account)
    await again.cross_signing.start()
    assert again.cross_signing.own_keys() == own
    assert account.homeserver.shown["master_keys"][ROBOT]


async def test_a_homeserver_that_asks_for_the_password_is_given_it() -> None:
    account = robot_account()
    account.homeserver.asks_for = "sesame"
    await account.cross_signing.start(Secret("sesame"))
    assert account.homeserver.calls.count(UPLOAD_KEYS) == 2


@pytest.mark.parametrize(
    ("password", "stages", "said"),
    [
        (None, ["m.login.password"], "asks for the password"),
        (Secret("wrong"), ["m.login.password"], "did not take the password"),
        (Secret("sesame"), ["m.login.sso"], "on its own page"),
    ],
)
async def test_a_homeserver_that_is_not_content_is_said(
    password: Secret | None, stages: list[str], said: str
) -> None:
    account = robot_account()
    account.homeserver.asks_for, account.homeserver.stages = "sesame", stages
    with pytest.raises(ConfigurationError, match=said):
        await account.cross_signing.start(password)
    assert account.homeserver.shown["master_keys"] == {}


async def test_keys_of_the_account_that_we_do_not_have_are_refused_and_left_alone() -> None:
    homeserver = Homeserver()
    homeserver.knows(Person(ROBOT, "ELSEWHERE"))
    before = msgspec.json.encode(homeserver.shown["master_keys"])
    account = robot_account(homeserver)
    with pytest.raises(ConfigurationError, match="does not have"):
        await account.cross_signing.start()
    assert msgspec.json.encode(homeserver.shown["master_keys"]) == before
    assert KEYS_FILE not in account.folder.files


async def test_a_master_key_of_ours_that_was_replaced_is_refused() -> None:
    account = robot_account()
    await account.cross_signing.start()
    account.homeserver.shown["master_keys"][ROBOT] = Person(ROBOT).shown_master()
    with pytest.raises(ConfigurationError, match="does not have"):
        await restarted(account).cross_signing.start()


async def test_keys_that_are_not_the_accounts_vouch_for_nothing() -> None:
    """Where unverified devices are followed, the gateway goes on without cross-signing."""
    account, ada = robot_account(), Person(ADA)
    await account.cross_signing.start()
    account.homeserver.shown["master_keys"][ROBOT] = Person(ROBOT).shown_master()
    again = restarted(account)
    with pytest.raises(ConfigurationError):
        await again.cross_signing.start()
    assert again.cross_signing.own_keys() == {f"{ED25519}:ROBOTDEV": account.device.ed25519}

    phone = await met(again, ada)
    await again.cross_signing.compared(phone, ada.master_public)
    assert await again.cross_signing.is_verified_device(ADA, "PHONE")


async def test_a_master_key_of_ours_that_is_replaced_while_we_run_is_told() -> None:
    account = robot_account()
    await account.cross_signing.start()
    account.homeserver.shown["master_keys"][ROBOT] = Person(ROBOT).shown_master()
    account.directory.forget(ROBOT)
    _, standing = await account.cross_signing.look_up(ROBOT)

    assert standing is IdentityStanding.REPLACED
    kind = KeyChangeKind.MASTER_REPLACED
    assert account.told == [KeyChange(kind=kind, user=ROBOT, compared=True)]


async def test_somebody_who_signs_in_as_the_robot_is_told_of() -> None:
    account = robot_account()
    await account.cross_signing.start()
    account.homeserver.add(Device(ROBOT, "STOLEN"))
    account.directory.forget(ROBOT)
    await account.cross_signing.look_up(ROBOT)
    assert account.told == [KeyChange(kind=KeyChangeKind.NEW_DEVICE, user=ROBOT, device="STOLEN")]


async def test_a_reset_makes_new_keys_and_says_nothing_of_an_alarm() -> None:
    account = robot_account()
    await account.cross_signing.start()
    before = account.cross_signing.own_keys()
    account.homeserver.asks_for = "sesame"
    await account.cross_signing.reset(Secret("sesame"))

    assert account.cross_signing.own_keys() != before
    keys = await account.directory.keys_of(ROBOT)
    device = keys.device("ROBOTDEV")
    assert device is not None
    assert device.cross_signed
    assert account.told == []
    again = restarted(account)
    await again.cross_signing.start()
    assert again.cross_signing.own_keys() == account.cross_signing.own_keys()


async def test_other_keys_shown_for_this_device_are_never_signed() -> None:
    account = robot_account()
    account.homeserver.add(Device(ROBOT, "ROBOTDEV"))
    with pytest.raises(MessengerFault, match="other keys"):
        await account.cross_signing.start()
    assert UPLOAD_SIGNATURES not in account.homeserver.calls


async def test_a_device_that_is_not_shown_yet_is_said() -> None:
    account = robot_account()
    account.homeserver.shown["device_keys"].clear()
    with pytest.raises(MessengerFault, match="does not show the keys of this device"):
        await account.cross_signing.start()

    account.homeserver.add(account.device)
    await restarted(account).cross_signing.start()


async def test_a_signature_that_the_homeserver_drops_is_said() -> None:
    account = robot_account()
    device = account.homeserver.shown["device_keys"][ROBOT]["ROBOTDEV"]
    # Something of its own beneath our words: what we sign is then not what it keeps.
    device["algorithms"].append("m.other")
    with pytest.raises(MessengerFault):
        await account.cross_signing.start()


async def test_kept_keys_of_another_account_or_damaged_ones_are_refused() -> None:
    account = robot_account()
    await account.cross_signing.start()
    other = Device(ADA, "DEV")
    account.homeserver.add(other)
    with pytest.raises(ConfigurationError, match="those of"):
        await Account(account.homeserver, other, account.folder).cross_signing.start()

    for name in (KEYS_FILE, BOOK_FILE):
        folder = Folder()
        folder.files = {**account.folder.files, name: b"{}"}
        with pytest.raises(ConfigurationError, match="damaged"):
            await Account(account.homeserver, account.device, folder).cross_signing.start()


async def test_a_private_key_is_shown_nowhere() -> None:
    account = robot_account()
    await account.cross_signing.start()
    seeds = msgspec.json.decode(account.folder.files[KEYS_FILE])
    for name in ("master", "self_signing", "user_signing"):
        assert seeds[name] not in str(account.homeserver.shown)
        assert seeds[name] not in repr(account.cross_signing.__dict__)
