"""Who really sent a message, as far as keys show it, and what it may ask for.

A homeserver writes ``sender``, the time and the order of events, and what stands outside of the
ciphertext (``m.relates_to``: what an event edits, answers or reacts to). The only thing that ties a
message to a person is the key of the session that it came under (Matrix specification v1.11,
client-server API, "m.megolm.v1.aes-sha2": the sender's claimed keys must be those of a device of
the event's sender).
"""

from __future__ import annotations

import enum
import logging
from typing import TYPE_CHECKING, Any, Final

import msgspec

from rosic.core.policy.roles import Assurance
from rosic.errors import MessengerFault
from rosic.messengers.matrix.identity_book import IdentityStanding

if TYPE_CHECKING:
    from nio.crypto import Olm

    from rosic.messengers.matrix.cross_signing import CrossSigning
    from rosic.messengers.matrix.user_keys import DeviceIdentity, UserKeys

_LOGGER = logging.getLogger(__name__)

MISSING_AT_MOST: Final = 1_000
DEVICES_AT_MOST: Final = 50
"""Of one person. However many a homeserver shows, no more are looked at."""


class SenderAssurance(enum.IntEnum):
    """How sure it is that the person who is named has sent this."""

    FORGED = 0
    """Its keys are not those of a device of whoever is named: somebody lies."""
    PLAIN = 1
    """It came in the open: whoever runs a homeserver can have written it."""
    ENCRYPTED_UNVERIFIED = 2
    """Some device encrypted it; that it is that person's is what the homeserver says."""
    TRUSTED_ON_FIRST_USE = 3
    """As before; by the keys that were the first to be seen of that person, which count here."""
    ENCRYPTED_VERIFIED = 4
    """A device of that person encrypted it, by keys that two people have compared."""

    @property
    def channel(self) -> Assurance:
        """What the conversation is worth to the policy."""
        if self is SenderAssurance.ENCRYPTED_VERIFIED:
            return Assurance.E2EE_VERIFIED
        encrypted = self >= SenderAssurance.ENCRYPTED_UNVERIFIED
        return Assurance.E2EE_UNVERIFIED if encrypted else Assurance.PROVIDER_READABLE


class RequestWeight(enum.IntEnum):
    """What a message asks for."""

    STOP = 0
    OBSERVE = 1
    ACT = 2
    """Whatever moves something, or changes who may."""


class SessionEvidence(msgspec.Struct, frozen=True, kw_only=True):
    """What is known of a message that was decrypted.

    Attributes:
        sender: Who has sent it, as the homeserver says.
        room: Where it came, as the homeserver says.
        stated_room: Where it belongs, as stands inside of it; empty for nowhere.
        sender_key: Identity key of the device whose session it came under.
        ed25519: The fingerprint that this device claimed when it shared the session.
        forwarded: Another device has handed the session on, or it was read from a file: whose it
            was is hearsay.
    """

    sender: str
    room: str
    stated_room: str
    sender_key: str
    ed25519: str
    forwarded: bool


def evidence_of(olm: Olm, room: str, event: Any) -> SessionEvidence | None:  # noqa: ANN401 - nio's
    """Return what nio knows of an event; None: it came in the open.

    Args:
        olm: The machine that decrypted it.
        room: Where it came.
        event: As nio has parsed it.
    """
    if not event.decrypted:
        return None
    sender_key, session_id = event.sender_key or "", event.session_id or ""
    session = olm.inbound_group_store.get(room, sender_key, session_id)
    stated = event.source.get("room_id")
    return SessionEvidence(
        sender=event.sender,
        room=room,
        stated_room=stated if isinstance(stated, str) else "",
        sender_key=sender_key,
        ed25519="" if session is None else session.ed25519,
        forwarded=session is None or bool(session.forwarding_chain),
    )


# ---- the policy ----


def assurance_of(
    evidence: SessionEvidence,
    device: DeviceIdentity | None,
    *,
    worth: SenderAssurance,
    others: bool,
) -> SenderAssurance:
    """Return how sure it is who has sent a message that was decrypted.

    Args:
        evidence: Of the message.
        device: The sender's device that has the session's identity key; None for none.
        worth: What comes from that device is worth so much, if it does.
        others: Somebody else's device has that identity key.
    """
    if evidence.stated_room != evidence.room or (device is None and others):
        return SenderAssurance.FORGED
    if device is None:
        return SenderAssurance.ENCRYPTED_UNVERIFIED
    if (device.user, device.curve25519) != (evidence.sender, evidence.sender_key):
        return SenderAssurance.FORGED
    if device.ed25519 != evidence.ed25519 and not evidence.forwarded:
        return SenderAssurance.FORGED
    return SenderAssurance.ENCRYPTED_UNVERIFIED if evidence.forwarded else worth


def permits(
    assurance: SenderAssurance,
    weight: RequestWeight,
    *,
    require_verified: bool,
    room_encrypted: bool,
) -> bool:
    """Whether a message may ask for something. It may still be refused for any other reason.

    Args:
        assurance: How sure it is who has sent it.
        weight: What it asks for. A stop is always obeyed.
        require_verified: Nothing is done unless it was asked for from a verified device.
        room_encrypted: Its room is encrypted: what comes there in the open was stripped of its
            encryption, or was never that person's.
    """
    if weight is RequestWeight.STOP:
        return True
    if assurance is SenderAssurance.FORGED:
        return False
    if weight is RequestWeight.OBSERVE:
        return True
    if require_verified:
        return assurance >= SenderAssurance.TRUSTED_ON_FIRST_USE
    return assurance is not SenderAssurance.PLAIN or not room_encrypted


def withheld_devices(keys: UserKeys, standing: IdentityStanding) -> frozenset[str]:
    """Return which devices of a person are given no keys: they would read what the robot says.

    Whoever vouches for their devices is spoken to on these alone; a homeserver can add others. Once
    another master key is shown, nobody knows any more which are theirs.
    """
    if standing is IdentityStanding.NONE:
        return frozenset()
    if standing is IdentityStanding.REPLACED:
        return frozenset(keys.devices())
    names = keys.devices()
    found = (keys.device(name) for name in names[:DEVICES_AT_MOST])
    vouched = {device.device for device in found if device is not None and device.cross_signed}
    return frozenset(names) - vouched


class Trust:
    """Asks for keys, and applies the policy to them.

    Args:
        cross_signing: Of this account.
        trust_on_first_use: A master key that was merely seen first counts like one that was
            compared. Whoever runs the homeserver when it is first seen can be anybody then.
    """

    def __init__(self, cross_signing: CrossSigning, *, trust_on_first_use: bool = False) -> None:
        self._cross_signing = cross_signing
        self._trust_on_first_use = trust_on_first_use
        self._missing: dict[tuple[str, str], None] = {}

    async def assess(self, evidence: SessionEvidence | None) -> SenderAssurance:
        """Return how sure it is who has sent a message. Never raises: in doubt, it is not sure.

        Args:
            evidence: Of the message; None: it came in the open.
        """
        if evidence is None:
            return SenderAssurance.PLAIN
        try:
            keys, standing = await self._cross_signing.look_up(evidence.sender)
            device = keys.device_with(evidence.sender_key)
            if device is None and self._is_new(evidence):
                keys, standing = await self._cross_signing.look_up(evidence.sender, fresh=True)
                device = keys.device_with(evidence.sender_key)
        except MessengerFault as fault:
            _LOGGER.warning("Nobody knows whose keys these are: %s", fault)
            return SenderAssurance.ENCRYPTED_UNVERIFIED
        worth = SenderAssurance.ENCRYPTED_UNVERIFIED
        if device is not None:
            worth = self._worth(device, standing)
        owners = self._cross_signing.directory.claimants(evidence.sender_key)
        others = bool(owners - {evidence.sender})
        return assurance_of(evidence, device, worth=worth, others=others)

    def _worth(self, device: DeviceIdentity, standing: IdentityStanding) -> SenderAssurance:
        """Return what comes from a device is worth, if it does."""
        is_verified = self._cross_signing.is_verified
        if is_verified(device, standing, trust_on_first_use=False):
            return SenderAssurance.ENCRYPTED_VERIFIED
        if self._trust_on_first_use and is_verified(device, standing, trust_on_first_use=True):
            return SenderAssurance.TRUSTED_ON_FIRST_USE
        return SenderAssurance.ENCRYPTED_UNVERIFIED

    def _is_new(self, evidence: SessionEvidence) -> bool:
        """Whether this key was not looked for yet: a device may be newer than what is kept."""
        looked_for = (evidence.sender, evidence.sender_key)
        if looked_for in self._missing:
            return False
        if len(self._missing) >= MISSING_AT_MOST:
            del self._missing[next(iter(self._missing))]
        self._missing[looked_for] = None
        return True
