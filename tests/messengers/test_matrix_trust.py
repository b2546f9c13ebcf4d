from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import msgspec
import pytest

from rosic.core.policy.roles import Assurance
from rosic.messengers.matrix.identity_book import IdentityStanding
from rosic.messengers.matrix.trust import (
    DEVICES_AT_MOST,
    MISSING_AT_MOST,
    RequestWeight,
    SenderAssurance,
    SessionEvidence,
    Trust,
    evidence_of,
    permits,
    withheld_devices,
)
from rosic.messengers.matrix.user_keys import QUERY
from tests.messengers.matrix_identities import (
    ADA,
    EVE,
    Account,
    Device,
    Person,
    robot_account,
)

ROOM = "!room:example.org"


def _evidence(device: Device, **changed: object) -> SessionEvidence:
    """Return what is known of a message that this device has encrypted."""
    honest = SessionEvidence(
        sender=device.user,
        room=ROOM,
        stated_room=ROOM,
        sender_key=device.curve25519,
        ed25519=device.ed25519,
        forwarded=False,
    )
    return msgspec.structs.replace(honest, **changed)


class World:
    """The robot, Ada whose keys it has compared, and Eve whom it merely has seen."""

    def __init__(self, account: Account) -> None:
        self.account = account
        self.ada, self.eve = Person(ADA), Person(EVE)
        self.trust = Trust(account.cross_signing)

    async def assess(self, device: Device, **changed: object) -> SenderAssurance:
        return await self.trust.assess(_evidence(device, **changed))


@pytest.fixture
async def world() -> World:
    account = robot_account()
    await account.cross_signing.start()
    world = World(account)
    for person in (world.ada, world.eve):
        account.homeserver.knows(person)
        await account.cross_signing.look_up(person.user)
    phone = (await account.directory.keys_of(ADA)).device("PHONE")
    assert phone is not None
    await account.cross_signing.compared(phone, world.ada.master_public)
    return world


async def test_a_verified_device_is_known(world: World) -> None:
    assert await world.assess(world.ada.phone) is SenderAssurance.ENCRYPTED_VERIFIED


async def test_what_came_in_the_open_is_worth_nothing(world: World) -> None:
    assert await world.trust.assess(None) is SenderAssurance.PLAIN


async def test_a_person_whose_key_nobody_compared_is_not_verified(world: World) -> None:
    assert await world.assess(world.eve.phone) is SenderAssurance.ENCRYPTED_UNVERIFIED
    first = Trust(world.account.cross_signing, trust_on_first_use=True)
    found = await first.assess(_evidence(world.eve.phone))
    assert found is SenderAssurance.TRUSTED_ON_FIRST_USE
    assert found.channel is Assurance.E2EE_UNVERIFIED, "nobody has compared anything"
    found = await first.assess(_evidence(world.ada.phone))
    assert found is SenderAssurance.ENCRYPTED_VERIFIED


async def test_a_message_of_eve_in_adas_name_is_forged(world: World) -> None:
    assert await world.assess(world.eve.phone, sender=ADA) is SenderAssurance.FORGED


async def test_a_message_of_ada_in_eves_name_is_forged(world: World) -> None:
    """Eve publishes Ada's identity key as her own, which needs no secret of Ada's."""
    assert await world.assess(world.ada.phone, sender=EVE) is SenderAssurance.FORGED

    world.eve.phone.curve25519 = world.ada.phone.curve25519
    world.account.homeserver.knows(world.eve)
    world.account.directory.forget(EVE)
    assert await world.assess(world.ada.phone, sender=EVE) is SenderAssurance.FORGED
    assert await world.assess(world.ada.phone) is SenderAssurance.ENCRYPTED_VERIFIED


async def test_a_session_that_claims_another_fingerprint_is_forged(world: World) -> None:
    for ed25519 in (world.eve.phone.ed25519, "", "A" * 43):
        assert await world.assess(world.ada.phone, ed25519=ed25519) is SenderAssurance.FORGED


async def test_a_message_of_another_room_is_forged(world: World) -> None:
    for stated in ("!other:example.org", ""):
        found = await world.assess(world.ada.phone, stated_room=stated)
        assert found is SenderAssurance.FORGED


async def test_a_session_that_was_handed_on_is_hearsay(world: World) -> None:
    found = await world.assess(world.ada.phone, forwarded=True)
    assert found is SenderAssurance.ENCRYPTED_UNVERIFIED
    found = await world.assess(world.ada.phone, forwarded=True, ed25519="A" * 43)
    assert found is SenderAssurance.ENCRYPTED_UNVERIFIED


async def test_a_device_that_the_homeserver_inserts_is_not_hers(world: World) -> None:
    inserted = Device(ADA, "INSERTED")
    world.account.homeserver.add(inserted)
    world.account.directory.forget(ADA)
    assert await world.assess(inserted) is SenderAssurance.ENCRYPTED_UNVERIFIED
    assert await world.assess(world.ada.phone) is SenderAssurance.ENCRYPTED_VERIFIED


async def test_a_whole_identity_that_the_homeserver_makes_up_is_not_hers(world: World) -> None:
    forged = Person(ADA)
    world.account.homeserver.knows(forged)
    world.account.directory.forget(ADA)
    assert await world.assess(forged.phone) is SenderAssurance.ENCRYPTED_UNVERIFIED
    assert await world.assess(world.ada.phone) is SenderAssurance.ENCRYPTED_UNVERIFIED

    first = Trust(world.account.cross_signing, trust_on_first_use=True)
    assert await first.assess(_evidence(forged.phone)) is SenderAssurance.ENCRYPTED_UNVERIFIED


async def test_an_identity_of_somebody_never_met_is_not_verified(world: World) -> None:
    nobody = Person("@nobody:example.org")
    world.account.homeserver.knows(nobody)
    assert await world.assess(nobody.phone) is SenderAssurance.ENCRYPTED_UNVERIFIED


async def test_a_device_newer_than_what_is_kept_is_asked_for_once(world: World) -> None:
    laptop = Device(ADA, "LAPTOP")
    world.account.homeserver.shown["device_keys"][ADA]["LAPTOP"] = world.ada.vouched(laptop)
    assert await world.assess(laptop) is SenderAssurance.ENCRYPTED_VERIFIED

    unknown = Device(ADA, "UNKNOWN")
    world.account.homeserver.calls.clear()
    for _ in range(5):
        assert await world.assess(unknown) is SenderAssurance.ENCRYPTED_UNVERIFIED
    assert world.account.homeserver.calls == [QUERY]


async def test_keys_without_end_are_not_remembered_without_end(world: World) -> None:
    for number in range(MISSING_AT_MOST + 10):
        await world.assess(world.ada.phone, sender_key=f"{number:043}")
    assert len(world.trust._missing) == MISSING_AT_MOST


async def test_nobody_is_sure_while_the_homeserver_is_away(world: World) -> None:
    world.account.directory.forget(ADA)
    world.account.homeserver.away = True
    assert await world.assess(world.ada.phone) is SenderAssurance.ENCRYPTED_UNVERIFIED
    world.account.homeserver.away = False
    assert await world.assess(world.ada.phone) is SenderAssurance.ENCRYPTED_VERIFIED


# ---- the policy ----


@pytest.mark.parametrize("require_verified", [True, False])
@pytest.mark.parametrize("room_encrypted", [True, False])
@pytest.mark.parametrize("assurance", SenderAssurance)
def test_a_stop_is_always_obeyed(
    assurance: SenderAssurance, room_encrypted: bool, require_verified: bool
) -> None:
    assert permits(
        assurance,
        RequestWeight.STOP,
        require_verified=require_verified,
        room_encrypted=room_encrypted,
    )


@pytest.mark.parametrize(
    ("assurance", "observes", "acts", "acts_in_encrypted", "acts_verified"),
    [
        (SenderAssurance.FORGED, False, False, False, False),
        (SenderAssurance.PLAIN, True, True, False, False),
        (SenderAssurance.ENCRYPTED_UNVERIFIED, True, True, True, False),
        (SenderAssurance.TRUSTED_ON_FIRST_USE, True, True, True, True),
        (SenderAssurance.ENCRYPTED_VERIFIED, True, True, True, True),
    ],
)
def test_what_each_is_worth(
    assurance: SenderAssurance,
    observes: bool,
    acts: bool,
    acts_in_encrypted: bool,
    acts_verified: bool,
) -> None:
    def asked(weight: RequestWeight, *, require_verified: bool, room_encrypted: bool) -> bool:
        return permits(
            assurance, weight, require_verified=require_verified, room_encrypted=room_encrypted
        )

    act, observe = RequestWeight.ACT, RequestWeight.OBSERVE
    assert asked(observe, require_verified=True, room_encrypted=True) is observes
    assert asked(act, require_verified=False, room_encrypted=False) is acts
    assert asked(act, require_verified=False, room_encrypted=True) is acts_in_encrypted
    assert asked(act, require_verified=True, room_encrypted=True) is acts_verified
    assert asked(act, require_verified=True, room_encrypted=False) is acts_verified


def test_only_what_is_verified_is_an_encrypted_channel_to_the_policy() -> None:
    assert [one for one in SenderAssurance if one.channel is Assurance.E2EE_VERIFIED] == [
        SenderAssurance.ENCRYPTED_VERIFIED
    ]
    assert SenderAssurance.PLAIN.channel is Assurance.PROVIDER_READABLE


def test_devices_without_end_are_not_all_looked_at() -> None:
    ada = Person(ADA)
    devices = {
        name: ada.vouched(Device(ADA, name))
        for name in (f"DEVICE{number:03}" for number in range(DEVICES_AT_MOST + 10))
    }
    withheld = withheld_devices(ada.keys(device_keys=devices), IdentityStanding.COMPARED)
    assert withheld == {f"DEVICE{number:03}" for number in range(DEVICES_AT_MOST, len(devices))}


def test_somebody_without_cross_signing_is_given_keys_on_all_devices() -> None:
    ada = Person(ADA)
    keys = ada.keys(master_keys={}, device_keys={"PHONE": ada.phone.shown()})
    assert withheld_devices(keys, IdentityStanding.NONE) == frozenset()


# ---- from nio ----


class Sessions:
    """nio's store of sessions: by room, identity key and id."""

    def __init__(self, **session: object) -> None:
        self.session = SimpleNamespace(**session) if session else None

    def get(self, room: str, sender_key: str, session_id: str) -> SimpleNamespace | None:
        return self.session if (room, sender_key, session_id) == (ROOM, "K", "S") else None


def _event(**changed: object) -> SimpleNamespace:
    said = {
        "decrypted": True,
        "sender": ADA,
        "sender_key": "K",
        "session_id": "S",
        "source": {"room_id": ROOM},
    }
    return SimpleNamespace(**{**said, **changed})


def test_evidence_is_what_the_session_says() -> None:
    olm: Any = SimpleNamespace(inbound_group_store=Sessions(ed25519="F", forwarding_chain=[]))
    assert evidence_of(olm, ROOM, _event()) == SessionEvidence(
        sender=ADA, room=ROOM, stated_room=ROOM, sender_key="K", ed25519="F", forwarded=False
    )
    assert evidence_of(olm, ROOM, _event(decrypted=False)) is None
    assert evidence_of(olm, ROOM, SimpleNamespace(decrypted=False)) is None


def test_a_session_that_is_not_there_or_was_handed_on_is_hearsay() -> None:
    gone: Any = SimpleNamespace(inbound_group_store=Sessions())
    handed: Any = SimpleNamespace(inbound_group_store=Sessions(ed25519="F", forwarding_chain=["X"]))
    for olm in (gone, handed):
        found = evidence_of(olm, ROOM, _event())
        assert found is not None
        assert found.forwarded
    odd = evidence_of(handed, ROOM, _event(sender_key=None, session_id=None, source={"room_id": 7}))
    assert odd is not None
    assert (odd.sender_key, odd.stated_room, odd.ed25519) == ("", "", "")
