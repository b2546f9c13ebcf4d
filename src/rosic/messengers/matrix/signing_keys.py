"""The keys that we sign with: this device's, and the three of the account."""

from __future__ import annotations

from typing import Any, Protocol

import msgspec
from nacl.signing import SigningKey
from nacl.utils import random

from rosic.messengers.matrix.signed_json import (
    ED25519,
    KEY_BYTES,
    from_base64,
    public_part,
    to_base64,
)


class DeviceAccount(Protocol):
    """This device's own keys.

    Attributes:
        user: Whose device it is.
        device: Its id.
        ed25519: Its fingerprint.
        curve25519: Its identity key.
    """

    user: str
    device: str
    ed25519: str
    curve25519: str

    def sign(self, message: bytes) -> str:
        """Return its signature over these bytes, as Base64 without padding."""
        ...


class SigningSeeds(msgspec.Struct, frozen=True):
    """The private keys as they are kept; bound to whose they are."""

    owner: str
    master: str
    self_signing: str
    user_signing: str

    def __repr__(self) -> str:
        return f"SigningSeeds({self.owner})"


class CrossSigningKeys:
    """The three private keys; never shown."""

    __slots__ = ("master", "seeds", "self_signing", "user_signing")

    def __init__(self, seeds: SigningSeeds) -> None:
        self.seeds = seeds
        self.master = _key_of(seeds.master)
        self.self_signing = _key_of(seeds.self_signing)
        self.user_signing = _key_of(seeds.user_signing)

    @classmethod
    def fresh(cls, owner: str) -> CrossSigningKeys:
        """Make keys that nobody has."""
        return cls(SigningSeeds(owner, *(to_base64(random(KEY_BYTES)) for _ in range(3))))

    @property
    def public(self) -> tuple[str, str, str]:
        """Return the public halves: master, self-signing, user-signing."""
        return (
            public_part(self.master),
            public_part(self.self_signing),
            public_part(self.user_signing),
        )


def _key_of(seed: str) -> SigningKey:
    found = from_base64(seed, KEY_BYTES)
    if found is None:
        raise ValueError("not a key")
    return SigningKey(found)


def key_object(user: str, usage: str, public: str) -> dict[str, Any]:
    """Return a cross-signing key as it is published ("CrossSigningKey")."""
    return {"user_id": user, "usage": [usage], "keys": {f"{ED25519}:{public}": public}}
