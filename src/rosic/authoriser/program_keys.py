"""Programs: principals that no person speaks for, known by a secret that is shown once.

The authorisation key stays what it is for everybody, a record without a secret. Beside it stands a
digest of the secret that its program shows; whoever shows one speaks from the program's address.
"""

from __future__ import annotations

import re
from base64 import urlsafe_b64encode
from hashlib import blake2b
from hmac import compare_digest
from typing import TYPE_CHECKING, Final

import msgspec

from rosic.authoriser import keys_messages as words
from rosic.core.identity import (
    PROGRAM,
    RECORD_ID_BYTES,
    Address,
    AuthorisationKey,
    KeyId,
    Principal,
    PrincipalId,
)
from rosic.core.language.sanitise import clean_name, drawn
from rosic.core.policy.roles import Grant
from rosic.core.records import Decided, Enrolled, Fact, KeyIssued, Letter, PersonRecord, Record
from rosic.core.secret import Secret
from rosic.core.time_units import SECOND_NS
from rosic.errors import NotUnderstood, Unrecognised

if TYPE_CHECKING:
    from collections.abc import Iterable

    from rosic.authoriser.directory import Directory
    from rosic.authoriser.invitations import InvitedRights
    from rosic.authoriser.keys import KeyRing
    from rosic.contracts.clock import Entropy

KIND: Final = "program-secret"
BEGINS: Final = "rosic"
SECRET_BYTES: Final = 32
"""Nobody guesses that many: a digest without salt and without delay gives nothing away."""

_SHOWN: Final = re.compile(rf"{BEGINS}_k[0-9a-f]{{8,64}}_[A-Za-z0-9_-]{{20,128}}")
_encode_record = msgspec.msgpack.Encoder().encode


class NewProgram(msgspec.Struct, frozen=True):
    """A program that is known as soon as the records are written.

    Attributes:
        secret: What it shows; kept nowhere.
        grants: What the organiser keeps from now on, written together with the records.
    """

    program: Principal
    key: AuthorisationKey
    secret: Secret
    grants: tuple[Grant, ...]
    records: tuple[Record, ...]


class ProgramKeys:
    """Knows which secret stands for which key.

    Args:
        keys: Which keys are good.
        directory: Who holds them.
        entropy: Makes ids and secrets.
    """

    def __init__(self, keys: KeyRing, directory: Directory, entropy: Entropy) -> None:
        self._keys, self._directory, self._entropy = keys, directory, entropy
        self._digests: dict[KeyId, bytes] = {}

    def identify(self, secret: Secret) -> Address:
        """Return the address from which whoever shows a secret speaks.

        Raises:
            Unrecognised: It is no secret of a good key. It is counted; nothing changed.
        """
        text = secret.reveal()
        key_id = text.split("_", 2)[1] if text.count("_") > 1 else ""
        known = self._digests.get(key_id, b"")
        if not compare_digest(known, _digest(secret)):
            raise self._keys.counters.refuse("key-unknown", Unrecognised(words.NO_SUCH_SECRET))
        person = self._directory.person(self._keys.check(key_id).principal)
        for address in () if person is None else person.addresses:
            if address.platform == PROGRAM:
                return address
        raise self._keys.counters.refuse("key-unknown", Unrecognised(words.NO_SUCH_SECRET))

    def enrol(self, name: str, given: InvitedRights, by: PrincipalId) -> NewProgram:
        """Return a program, its key and its secret. Changes nothing.

        Raises:
            NotUnderstood: Its name is none, or somebody is called so.
        """
        shown, now_ns = self._free(name), self._keys.time.wall_ns()
        principal = self._new_id("p")
        roles = given.roles if given.standing else ()
        addresses = (Address(PROGRAM, principal),)
        lasts_s = given.lasts_s
        key = AuthorisationKey(
            id=self._new_id("k"),
            principal=principal,
            issuer=by,
            issued_ns=now_ns,
            expires_ns=None if lasts_s is None else now_ns + int(lasts_s * SECOND_NS),
        )
        letter = Letter(principal, _encode_record(PersonRecord(shown, addresses)))
        secret, digest = self.secret_for(key.id)
        return NewProgram(
            Principal(id=principal, name=shown, roles=roles, addresses=addresses),
            key,
            secret,
            given.grants(iter(lambda: self._new_id("g"), ""), now_ns),
            (
                Decided(act="enrol", by=by, about=principal, at_ns=now_ns),
                Enrolled(principal=principal, roles=roles, at_ns=now_ns, letter=letter),
                KeyIssued(key=key),
                digest,
            ),
        )

    def secret_for(self, key: KeyId) -> tuple[Secret, Fact]:
        """Return a new secret for a key, and what makes it the one that counts."""
        random = urlsafe_b64encode(self._entropy.token(SECRET_BYTES)).decode().rstrip("=")
        secret = Secret(f"{BEGINS}_{key}_{random}")
        return secret, Fact(kind=KIND, key=key, body=_digest(secret))

    def restore(self, facts: Iterable[Fact]) -> None:
        """Take over what earlier runs wrote."""
        for fact in facts:
            self.apply(fact)

    def apply(self, fact: Fact) -> None:
        """Let a fact be so."""
        if fact.body:
            self._digests[fact.key] = fact.body
        else:
            self._digests.pop(fact.key, None)

    def _free(self, name: str) -> str:
        """Return a name as it is shown, if nobody has it, nor any that looks like it."""
        shown = clean_name(name)
        if not shown:
            raise NotUnderstood(words.NO_PROGRAM_NAME)
        names = [person.name for person in self._directory.people()]
        if drawn(shown) in set(map(drawn, names)):
            raise NotUnderstood(words.name_taken(shown))
        return shown

    def _new_id(self, letter: str) -> str:
        return f"{letter}{self._entropy.token(RECORD_ID_BYTES).hex()}"


def without_keys(text: str, instead: str) -> str:
    """Return a text without secrets of programs: whoever reads it later could use them."""
    return _SHOWN.sub(instead, text) if BEGINS in text else text


def _digest(secret: Secret) -> bytes:
    return blake2b(secret.reveal().encode(errors="replace"), person=b"rosic-secret").digest()
