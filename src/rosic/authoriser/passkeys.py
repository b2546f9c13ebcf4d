"""Passkeys of people: which credential stands for whom (WebAuthn, level 2).

What a browser or a phone proves with one is verified where its protocol is spoken; here stands
whose it is, and that it may still be used. A public key lets nobody in, so it lies in the open.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import msgspec

from rosic.core.i18n import said
from rosic.core.identity import RECORD_ID_BYTES, PrincipalId
from rosic.core.records import Fact, Letter
from rosic.errors import TooManyRequests

if TYPE_CHECKING:
    from collections.abc import Iterable

    from rosic.authoriser.monotonic_clock import MonotonicWallClock
    from rosic.contracts.clock import Entropy

KIND: Final = "passkey"
EACH_AT_MOST: Final = 10
TOO_MANY: Final = said("You have {most} passkeys already. Remove one first.", most=EACH_AT_MOST)

_encode = msgspec.msgpack.Encoder().encode


class Passkey(msgspec.Struct, frozen=True):
    """One passkey of one person.

    Attributes:
        credential: Its id, as the authenticator has given it.
        public_key: In COSE.
        uses: As its authenticator counts; it never falls, where the authenticator counts at all.
    """

    principal: PrincipalId
    credential: bytes
    public_key: bytes
    uses: int
    made_ns: int


_decode = msgspec.msgpack.Decoder(Passkey).decode


class Passkeys:
    """Every passkey, by its credential.

    Args:
        time: When one was made.
        entropy: Makes the names under which they are kept.
    """

    def __init__(self, time: MonotonicWallClock, entropy: Entropy) -> None:
        self._time, self._entropy = time, entropy
        self._known: dict[str, Passkey] = {}
        self._names: dict[str, str] = {}
        self._by_credential: dict[bytes, str] = {}

    def by_credential(self, credential: bytes) -> Passkey | None:
        """Return the passkey of a credential; None: there is none."""
        return self._known.get(self._by_credential.get(credential, ""))

    def of(self, principal: PrincipalId) -> dict[str, Passkey]:
        """Return the passkeys of somebody, by the names under which they are kept."""
        return {key: each for key, each in self._known.items() if each.principal == principal}

    def name(self, key: str) -> str:
        """Return how its owner calls a passkey."""
        return self._names.get(key, "")

    def add(
        self, principal: PrincipalId, credential: bytes, public_key: bytes, uses: int, name: str
    ) -> Fact:
        """Return what makes a credential somebody's passkey.

        Raises:
            TooManyRequests: They have as many as one may have. Nothing changed.
        """
        if len(self.of(principal)) >= EACH_AT_MOST:
            raise TooManyRequests(TOO_MANY, retry_after_s=60.0)
        made = Passkey(principal, credential, public_key, uses, self._time.wall_ns())
        key = f"w{self._entropy.token(RECORD_ID_BYTES).hex()}"
        letter = Letter(principal, name.encode("utf-8", "replace"))
        return Fact(kind=KIND, key=key, body=_encode(made), letter=letter)

    def used(self, passkey: Passkey, uses: int) -> Fact:
        """Return what keeps how often a passkey was used."""
        key = self._by_credential[passkey.credential]
        name = self._names.get(key, "").encode()
        letter = Letter(passkey.principal, name)
        now = msgspec.structs.replace(passkey, uses=uses)
        return Fact(kind=KIND, key=key, body=_encode(now), letter=letter)

    def remove(self, principal: PrincipalId, key: str) -> tuple[Fact, ...]:
        """Return what ends a passkey of somebody; nothing where they have none of that name."""
        found = self._known.get(key)
        return (_end(key),) if found is not None and found.principal == principal else ()

    def end_all(self, principal: PrincipalId) -> Iterable[Fact]:
        """Return what ends every passkey of somebody."""
        return tuple(_end(key) for key in self.of(principal))

    def apply(self, fact: Fact) -> None:
        """Let a fact be so."""
        before = self._known.pop(fact.key, None)
        self._names.pop(fact.key, None)
        if before is not None:
            self._by_credential.pop(before.credential, None)
        if fact.body:
            passkey = self._known[fact.key] = _decode(fact.body)
            self._by_credential[passkey.credential] = fact.key
            if fact.letter is not None:
                self._names[fact.key] = fact.letter.content.decode("utf-8", "replace")


def _end(key: str) -> Fact:
    return Fact(kind=KIND, key=key, body=b"")
