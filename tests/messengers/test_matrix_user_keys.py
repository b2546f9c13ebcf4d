from __future__ import annotations

from typing import Any

import pytest

from rosic.errors import MessengerFault
from rosic.messengers.matrix.signed_json import ED25519, public_part, sign
from rosic.messengers.matrix.signing_keys import key_object
from rosic.messengers.matrix.user_keys import (
    DEVICES_AT_MOST,
    KEPT_AT_MOST,
    MASTER,
    SELF_SIGNING,
    KeyDirectory,
    UserKeys,
)
from tests.messengers.matrix_identities import ADA, EVE, Device, Homeserver, Person


def test_an_honest_person_has_a_device_that_their_keys_vouch_for() -> None:
    ada = Person(ADA)
    keys = ada.keys()

    phone = keys.device("PHONE")
    assert keys.master == ada.master_public
    assert phone is not None
    assert phone.cross_signed
    assert phone.ed25519 == ada.phone.ed25519
    assert keys.device_with(ada.phone.curve25519) == phone


# ---- lies about devices ----


def _device(ada: Person, shown: dict[str, Any], name: str = "PHONE") -> UserKeys:
    return ada.keys(device_keys={name: shown})


def test_a_device_that_nobody_vouches_for_is_not_cross_signed() -> None:
    ada = Person(ADA)
    phone = _device(ada, ada.phone.shown()).device("PHONE")
    assert phone is not None
    assert not phone.cross_signed


def test_a_device_that_another_persons_key_vouches_for_is_not_cross_signed() -> None:
    ada, eve = Person(ADA), Person(EVE)
    for user in (ADA, EVE):
        phone = _device(ada, sign(ada.phone.shown(), user, eve.self_signing)).device("PHONE")
        assert phone is not None
        assert not phone.cross_signed


def test_the_master_key_does_not_vouch_for_a_device() -> None:
    ada = Person(ADA)
    phone = _device(ada, sign(ada.phone.shown(), ADA, ada.master)).device("PHONE")
    assert phone is not None
    assert not phone.cross_signed


def test_a_signature_over_another_device_vouches_for_nothing() -> None:
    ada, other = Person(ADA), Device(ADA, "PHONE")
    shown = other.shown()
    shown["signatures"][ADA] |= {
        key_id: signature
        for key_id, signature in ada.vouched(ada.phone)["signatures"][ADA].items()
        if key_id != f"{ED25519}:PHONE"
    }
    phone = _device(ada, shown).device("PHONE")
    assert phone is not None
    assert not phone.cross_signed


def test_a_signature_under_the_right_name_by_another_key_vouches_for_nothing() -> None:
    ada, eve = Person(ADA), Person(EVE)
    lie = sign(ada.phone.shown(), ADA, eve.self_signing)
    by_eve = lie["signatures"][ADA].pop(f"{ED25519}:{public_part(eve.self_signing)}")
    lie["signatures"][ADA][f"{ED25519}:{public_part(ada.self_signing)}"] = by_eve
    phone = _device(ada, lie).device("PHONE")
    assert phone is not None
    assert not phone.cross_signed


@pytest.mark.parametrize(
    "changed",
    [
        {"user_id": EVE},
        {"device_id": "LAPTOP"},
        {"user_id": None},
        {"keys": {}},
        {"keys": None},
        {"keys": {f"{ED25519}:PHONE": "short", "curve25519:PHONE": "short"}},
    ],
)
def test_a_device_that_says_it_is_another_is_none(changed: dict[str, Any]) -> None:
    ada = Person(ADA)
    shown = sign(ada.phone.shown(**changed), ADA, ada.self_signing)
    assert _device(ada, shown).device("PHONE") is None


def test_a_device_whose_keys_were_replaced_is_none() -> None:
    ada, eve = Person(ADA), Device(EVE, "PHONE")
    for name, key in ((ED25519, eve.ed25519), ("curve25519", eve.curve25519)):
        shown = ada.vouched(ada.phone)
        shown["keys"][f"{name}:PHONE"] = key
        assert _device(ada, shown).device("PHONE") is None


def test_a_device_under_another_name_is_none() -> None:
    ada = Person(ADA)
    assert _device(ada, ada.vouched(ada.phone), "LAPTOP").device("LAPTOP") is None


def test_a_device_called_like_a_key_of_the_person_is_none() -> None:
    ada = Person(ADA)
    for key in (ada.master, ada.self_signing):
        device = Device(ADA, public_part(key))
        shown = sign(device.shown(), ADA, ada.self_signing)
        assert _device(ada, shown, device.device).device(device.device) is None


def test_whoever_claims_the_identity_key_of_another_has_not_signed_with_its_fingerprint() -> None:
    ada, eve = Person(ADA), Person(EVE)
    eve.phone.curve25519 = ada.phone.curve25519

    claimed = eve.keys().device_with(ada.phone.curve25519)
    assert claimed is not None
    assert claimed.ed25519 != ada.phone.ed25519
    assert claimed.user == EVE


@pytest.mark.parametrize("shown", [None, [], "x", 7, {}, {"signatures": 1}])
def test_what_is_no_device_is_none(shown: dict[str, Any]) -> None:
    ada = Person(ADA)
    keys = _device(ada, shown)
    assert keys.device("PHONE") is None
    assert keys.device_with("A" * 43) is None
    assert keys.fingerprint("PHONE") == ""


def test_of_devices_without_end_only_so_many_are_there() -> None:
    ada = Person(ADA)
    shown = ada.vouched(ada.phone)
    many = {f"D{number}": shown for number in range(DEVICES_AT_MOST)}
    assert len(ada.keys(device_keys=many).devices()) == DEVICES_AT_MOST
    assert ada.keys(device_keys={**many, "PHONE": shown}).device("PHONE") is None


# ---- lies about cross-signing keys ----


def test_a_self_signing_key_that_the_master_key_has_not_signed_vouches_for_nothing() -> None:
    ada, eve = Person(ADA), Person(EVE)
    public = public_part(ada.self_signing)
    said = key_object(ADA, SELF_SIGNING, public)
    for lie in (said, sign(said, ADA, eve.master), sign(said, ADA, ada.self_signing)):
        keys = ada.keys(self_signing_keys=lie)
        assert keys.self_signing == ""
        phone = keys.device("PHONE")
        assert phone is not None
        assert not phone.cross_signed


def test_a_self_signing_key_of_another_use_or_person_vouches_for_nothing() -> None:
    ada, public = Person(ADA), public_part(Person(ADA).self_signing)
    for said in (key_object(ADA, "user_signing", public), key_object(EVE, SELF_SIGNING, public)):
        assert ada.keys(self_signing_keys=sign(said, ADA, ada.master)).self_signing == ""


def test_the_master_key_is_not_its_own_self_signing_key() -> None:
    ada = Person(ADA)
    said = sign(key_object(ADA, SELF_SIGNING, ada.master_public), ADA, ada.master)
    assert ada.keys(self_signing_keys=said).self_signing == ""


def test_a_master_key_under_another_name_is_none() -> None:
    ada, eve = Person(ADA), Person(EVE)
    lies: list[dict[str, Any]] = [
        {**ada.shown_master(), "keys": {f"{ED25519}:{ada.master_public}": eve.master_public}},
        {**ada.shown_master(), "keys": {f"{ED25519}:{eve.master_public}": ada.master_public}},
        {**ada.shown_master(), "keys": {f"{ED25519}:PHONE": ada.master_public}},
        {**ada.shown_master(), "keys": {}},
        {
            **ada.shown_master(),
            "keys": {f"{ED25519}:{of}": of for of in (ada.master_public, eve.master_public)},
        },
        {**ada.shown_master(), "user_id": EVE},
        {**ada.shown_master(), "usage": [SELF_SIGNING]},
        {**ada.shown_master(), "usage": MASTER},
        {},
    ]
    for lie in lies:
        keys = ada.keys(master_keys=lie)
        assert keys.master == ""
        phone = keys.device("PHONE")
        assert phone is not None
        assert not phone.cross_signed


@pytest.mark.parametrize("shown", [{}, {"device_keys": 1}, {"device_keys": {ADA: 1}}])
def test_a_person_of_whom_nothing_is_shown_has_nothing(shown: dict[str, Any]) -> None:
    keys = UserKeys(ADA, {**shown, "master_keys": None, "self_signing_keys": {ADA: []}})
    assert (keys.master, keys.self_signing, keys.devices()) == ("", "", ())


def test_keys_of_another_in_the_answer_are_not_this_persons() -> None:
    assert UserKeys(EVE, Person(ADA).shown()).master == ""


# ---- the directory ----


async def test_what_was_shown_is_kept_until_it_is_said_to_have_changed() -> None:
    homeserver, ada = Homeserver(), Person(ADA)
    homeserver.knows(ada)
    directory = KeyDirectory(homeserver.as_user(EVE))

    first = await directory.keys_of(ADA)
    assert await directory.keys_of(ADA) is first
    assert len(homeserver.calls) == 1

    directory.forget(ADA)
    assert await directory.keys_of(ADA) is not first
    directory.forget_all()
    await directory.keys_of(ADA)
    assert len(homeserver.calls) == 3


async def test_what_changed_while_it_was_asked_for_is_not_kept() -> None:
    homeserver, ada = Homeserver(), Person(ADA)
    homeserver.knows(ada)
    client = homeserver.as_user(EVE)

    async def slow(method: str, path: str, body: dict[str, Any]) -> dict[str, Any]:
        answer = await client(method, path, body)
        directory.forget(ADA)
        return answer

    directory = KeyDirectory(slow)
    await directory.keys_of(ADA)
    await directory.keys_of(ADA)
    assert len(homeserver.calls) == 2


async def test_a_homeserver_that_is_away_is_said_and_changes_nothing() -> None:
    homeserver = Homeserver()
    directory = KeyDirectory(homeserver.as_user(EVE))
    homeserver.away = True
    with pytest.raises(MessengerFault):
        await directory.keys_of(ADA)


async def test_whose_an_identity_key_is_said_to_be() -> None:
    homeserver, ada, eve = Homeserver(), Person(ADA), Person(EVE)
    eve.phone.curve25519 = ada.phone.curve25519
    homeserver.knows(ada)
    homeserver.knows(eve)
    directory = KeyDirectory(homeserver.as_user(EVE))
    assert directory.claimants(ada.phone.curve25519) == frozenset()

    await directory.keys_of(ADA)
    await directory.keys_of(EVE)
    assert directory.claimants(ada.phone.curve25519) == {ADA, EVE}

    directory.forget(EVE)
    assert directory.claimants(ada.phone.curve25519) == {ADA, EVE}
    homeserver.knows(Person(EVE))
    await directory.keys_of(EVE)
    assert directory.claimants(ada.phone.curve25519) == {ADA}


async def test_no_more_people_are_kept_than_there_is_room_for() -> None:
    homeserver = Homeserver()
    directory = KeyDirectory(homeserver.as_user(EVE))
    for number in range(KEPT_AT_MOST + 5):
        await directory.keys_of(f"@{number}:example.org")
    homeserver.calls.clear()

    await directory.keys_of("@0:example.org")
    await directory.keys_of(f"@{KEPT_AT_MOST}:example.org")
    assert len(homeserver.calls) == 1
