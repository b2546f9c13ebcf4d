from __future__ import annotations

import msgspec
import pytest

from rosic.errors import MessengerFault
from rosic.messengers.matrix.cross_signing import (
    BOOK_FILE,
)
from rosic.messengers.matrix.identity_book import (
    DEVICES_AT_MOST,
    STRANGERS_AT_MOST,
    IdentityBook,
    IdentityStanding,
    KeyChange,
    KeyChangeKind,
)
from rosic.messengers.matrix.signed_json import sign
from rosic.messengers.matrix.user_keys import UserKeys
from tests.messengers.matrix_identities import (
    ADA,
    EVE,
    ROBOT,
    Device,
    Person,
    everybody,
    met,
    restarted,
    robot_account,
)

# ---- keys of others ----


async def test_a_key_that_nobody_compared_makes_no_device_verified() -> None:
    account, ada = robot_account(), Person(ADA)
    await account.cross_signing.start()
    await met(account, ada)

    verified = account.cross_signing.is_verified_device
    assert not await verified(ADA, "PHONE")
    assert await verified(ADA, "PHONE", trust_on_first_use=True)
    assert not await verified(ADA, "LAPTOP", trust_on_first_use=True)
    assert not await verified(EVE, "PHONE", trust_on_first_use=True)


async def test_once_the_master_key_was_compared_every_device_it_vouches_for_is_verified() -> None:
    account, ada = robot_account(), Person(ADA)
    await account.cross_signing.start()
    phone = await met(account, ada)
    await account.cross_signing.compared(phone, ada.master_public)

    laptop, foreign = Device(ADA, "LAPTOP"), Device(ADA, "FOREIGN")
    account.homeserver.shown["device_keys"][ADA] |= {
        "LAPTOP": ada.vouched(laptop),
        "FOREIGN": foreign.shown(),
    }
    account.directory.forget(ADA)
    verified = account.cross_signing.is_verified_device
    assert await verified(ADA, "PHONE")
    assert await verified(ADA, "LAPTOP")
    assert not await verified(ADA, "FOREIGN")
    assert [(change.device, change.vouched) for change in account.told] == [
        ("LAPTOP", True),
        ("FOREIGN", False),
    ]


async def test_what_was_compared_is_known_after_a_restart() -> None:
    account, ada = robot_account(), Person(ADA)
    await account.cross_signing.start()
    phone = await met(account, ada)
    await account.cross_signing.compared(phone, ada.master_public)

    again = restarted(account)
    await again.cross_signing.start()
    assert await again.cross_signing.is_verified_device(ADA, "PHONE")


async def test_the_master_key_that_was_compared_is_signed_by_ours() -> None:
    account, ada = robot_account(), Person(ADA)
    await account.cross_signing.start()
    phone = await met(account, ada)
    await account.cross_signing.compared(phone, ada.master_public)

    own = await account.directory.keys_of(ROBOT, fresh=True)
    keys = await account.directory.keys_of(ADA)
    assert keys.master_signed_by(ROBOT, own.user_signing, own.user_signing)


async def test_that_the_homeserver_takes_no_signature_changes_nothing() -> None:
    account, ada = robot_account(), Person(ADA)
    await account.cross_signing.start()
    phone = await met(account, ada)
    account.homeserver.away = True
    await account.cross_signing.compared(phone, ada.master_public)
    account.homeserver.away = False
    assert await account.cross_signing.is_verified_device(ADA, "PHONE")


async def test_what_cannot_be_kept_does_not_count() -> None:
    account, ada = robot_account(), Person(ADA)
    await account.cross_signing.start()
    phone = await met(account, ada)
    account.folder.full = True
    with pytest.raises(MessengerFault):
        await account.cross_signing.compared(phone, ada.master_public)
    assert not await account.cross_signing.is_verified_device(ADA, "PHONE")


async def test_another_master_key_is_refused_and_told_once() -> None:
    account, ada = robot_account(), Person(ADA)
    await account.cross_signing.start()
    phone = await met(account, ada)
    await account.cross_signing.compared(phone, ada.master_public)

    other = Person(ADA)
    other.phone = ada.phone
    for _ in range(3):
        await met(account, other)
    verified = account.cross_signing.is_verified_device
    assert not await verified(ADA, "PHONE", trust_on_first_use=True)
    kind = KeyChangeKind.MASTER_REPLACED
    assert account.told == [KeyChange(kind=kind, user=ADA, compared=True)]

    again = restarted(account)
    await again.cross_signing.start()
    assert not await again.cross_signing.is_verified_device(ADA, "PHONE", trust_on_first_use=True)
    assert again.told == []

    phone = await met(again, other)
    await again.cross_signing.compared(phone, other.master_public)
    assert await again.cross_signing.is_verified_device(ADA, "PHONE")
    await met(again, ada)
    assert not await again.cross_signing.is_verified_device(ADA, "PHONE")


async def test_a_key_that_was_merely_seen_first_is_not_replaced_in_silence_either() -> None:
    account, ada = robot_account(), Person(ADA)
    await account.cross_signing.start()
    await met(account, ada)
    await met(account, Person(ADA))
    assert not await account.cross_signing.is_verified_device(ADA, "PHONE", trust_on_first_use=True)
    assert KeyChangeKind.MASTER_REPLACED in {change.kind for change in account.told}


async def test_a_master_key_that_is_hidden_is_refused_and_told_once() -> None:
    account, ada = robot_account(), Person(ADA)
    await account.cross_signing.start()
    phone = await met(account, ada)
    await account.cross_signing.compared(phone, ada.master_public)
    del account.homeserver.shown["master_keys"][ADA]
    for _ in range(3):
        account.directory.forget(ADA)
        assert not await account.cross_signing.is_verified_device(
            ADA, "PHONE", trust_on_first_use=True
        )
    assert [change.kind for change in account.told] == [KeyChangeKind.MASTER_REPLACED]


async def test_what_changed_of_people_known_here_is_told_before_anything_came() -> None:
    account, ada, eve = robot_account(), Person(ADA), Person(EVE)
    await account.cross_signing.start()
    await met(account, ada)
    account.homeserver.knows(eve)
    account.homeserver.add(Device(ADA, "LAPTOP"))
    account.homeserver.calls.clear()
    await account.cross_signing.keys_changed([EVE, ADA])
    assert len(account.homeserver.calls) == 1
    assert [change.device for change in account.told] == ["LAPTOP"]

    account.homeserver.away = True
    await account.cross_signing.keys_changed([ADA])
    account.homeserver.away = False
    account.homeserver.add(Device(ADA, "TABLET"))
    await account.cross_signing.look_up(ADA)
    assert [change.device for change in account.told] == ["LAPTOP", "TABLET"]


async def test_a_device_of_somebody_without_cross_signing_can_be_compared_itself() -> None:
    account, plain = robot_account(), Device(EVE, "PHONE")
    await account.cross_signing.start()
    account.homeserver.add(plain)
    keys, standing = await account.cross_signing.look_up(EVE)
    assert standing is IdentityStanding.NONE
    device = keys.device("PHONE")
    assert device is not None
    await account.cross_signing.compared(device, "")
    assert await account.cross_signing.is_verified_device(EVE, "PHONE")

    account.homeserver.add(Device(EVE, "PHONE"))
    account.directory.forget(EVE)
    assert not await account.cross_signing.is_verified_device(EVE, "PHONE")
    assert account.told == [KeyChange(kind=KeyChangeKind.NEW_DEVICE, user=EVE, device="PHONE")]


async def test_a_compared_device_counts_no_longer_under_another_master_key() -> None:
    account, ada = robot_account(), Person(ADA)
    await account.cross_signing.start()
    account.homeserver.knows(ada)
    account.homeserver.add(Device(ADA, "LAPTOP"))
    laptop = (await account.cross_signing.look_up(ADA))[0].device("LAPTOP")
    assert laptop is not None
    await account.cross_signing.compared(laptop, ada.master_public)
    verified = account.cross_signing.is_verified_device
    assert await verified(ADA, "LAPTOP")

    other = Person(ADA)
    shown = account.homeserver.shown["device_keys"][ADA]["LAPTOP"]
    account.homeserver.knows(other)
    account.homeserver.shown["device_keys"][ADA]["LAPTOP"] = shown
    account.directory.forget(ADA)
    assert not await verified(ADA, "LAPTOP")

    # Nor does it once the other key is compared: it is not one of that person's devices.
    phone = (await account.cross_signing.look_up(ADA))[0].device("PHONE")
    assert phone is not None
    await account.cross_signing.compared(phone, other.master_public)
    assert await verified(ADA, "PHONE")
    assert not await verified(ADA, "LAPTOP")


async def test_what_was_compared_can_be_taken_back() -> None:
    account, ada = robot_account(), Person(ADA)
    await account.cross_signing.start()
    phone = await met(account, ada)
    await account.cross_signing.compared(phone, ada.master_public)
    await account.cross_signing.revoke(ADA)
    await account.cross_signing.revoke(EVE)
    assert not await account.cross_signing.is_verified_device(ADA, "PHONE")

    again = restarted(account)
    await again.cross_signing.start()
    assert not await again.cross_signing.is_verified_device(ADA, "PHONE")


async def test_an_account_does_not_vouch_for_itself() -> None:
    account = robot_account()
    await account.cross_signing.start()
    own = (await account.directory.keys_of(ROBOT)).device("ROBOTDEV")
    assert own is not None
    with pytest.raises(MessengerFault):
        await account.cross_signing.compared(own, "")


async def test_a_note_that_could_not_be_written_is_written_later() -> None:
    account, ada = robot_account(), Person(ADA)
    await account.cross_signing.start()
    account.folder.full = True
    await met(account, ada)
    account.folder.full = False
    await account.cross_signing.look_up(ADA)
    assert ADA.encode() in account.folder.files[BOOK_FILE]


# ---- the book ----


def test_strangers_without_end_drive_out_nobody_who_is_known_or_was_compared() -> None:
    book = IdentityBook(ROBOT, lambda user: user == EVE)
    book.compared(ADA, "A" * 43)
    eve = Person(EVE)
    book.observe(eve.keys())
    for number in range(STRANGERS_AT_MOST + 50):
        book.observe(UserKeys(f"@{number}:example.org", {}))
    assert book.standing(ADA, "A" * 43) is IdentityStanding.COMPARED
    assert book.standing(EVE, eve.master_public) is IdentityStanding.FIRST_SEEN
    assert len(msgspec.json.decode(book.content())["people"]) == STRANGERS_AT_MOST + 2


def test_of_strangers_no_devices_are_written_down() -> None:
    book, eve = IdentityBook(ROBOT, lambda _user: False), Person(EVE)
    assert book.observe(eve.keys()) == ((), True)
    assert b"PHONE" not in book.content()


def test_a_room_stays_confidential_over_a_restart() -> None:
    book = IdentityBook(ROBOT, everybody)
    assert book.make_confidential("!room:example.org")
    assert not book.make_confidential("!room:example.org")
    after = IdentityBook(ROBOT, everybody)
    after.restore(book.content())
    assert after.is_confidential("!room:example.org")
    assert not after.is_confidential("!other:example.org")


def test_devices_without_end_are_not_told_without_end() -> None:
    book, ada = IdentityBook(ROBOT, everybody), Person(ADA)
    book.observe(ada.keys())
    devices = {
        name: sign(Device(ADA, name).shown(), ADA, ada.self_signing)
        for name in (f"DEVICE{number}" for number in range(DEVICES_AT_MOST + 30))
    }
    changes, _ = book.observe(ada.keys(device_keys=devices))
    assert len(changes) == DEVICES_AT_MOST - 1
    assert book.observe(ada.keys(device_keys=devices)) == ((), False)


def test_a_book_of_another_account_is_refused() -> None:
    with pytest.raises(ValueError, match="another"):
        IdentityBook(ROBOT, everybody).restore(IdentityBook(ADA, everybody).content())
