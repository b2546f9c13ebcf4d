"""Taking people over from the configuration file, once; the record has the say from then on."""

from __future__ import annotations

import logging
from hashlib import blake2b
from typing import TYPE_CHECKING

import msgspec

from rosic.core.identity import (
    DIGEST_BYTES,
    OPERATOR,
    RECORD_ID_BYTES,
    Address,
    AuthorisationKey,
    Principal,
    PrincipalId,
)
from rosic.core.records import Enrolled, KeyIssued, Letter, Memory, PersonRecord, Record, Seeded
from rosic.gateway.access_registry import person_of

if TYPE_CHECKING:
    from collections.abc import Iterable

    from rosic.authoriser.authoriser import Authoriser
    from rosic.authoriser.directory import Directory
    from rosic.contracts.clock import Clock, Entropy
    from rosic.contracts.store import Store


log = logging.getLogger("rosic.people")
_encode_record = msgspec.msgpack.Encoder().encode


class ConfiguredPerson(msgspec.Struct, frozen=True):
    """A person as the configuration file names one."""

    name: str
    addresses: tuple[Address, ...]
    roles: tuple[str, ...]


def remember(authoriser: Authoriser, memory: Memory) -> dict[PrincipalId, tuple[str, ...]]:
    """Make everybody of the record known. Return who has which roles, and a key still good."""
    for entry in memory.enrolled:
        authoriser.directory.enrol(person_of(entry))
    for key in memory.keys:
        authoriser.directory.add_key(key)
    good = authoriser.directory.has_good_key
    return {entry.principal: entry.roles for entry in memory.enrolled if good(entry.principal)}


async def seed(
    people: Iterable[ConfiguredPerson],
    memory: Memory,
    authoriser: Authoriser,
    store: Store,
    clock: Clock,
    entropy: Entropy,
) -> dict[PrincipalId, tuple[str, ...]]:
    """Take over everybody whom the record has not taken over before. Return their roles.

    A person who was revoked stays revoked: the record remembers that the file had its say. An
    account that is somebody's already, by an invitation or by a code of theirs, stays theirs; who
    has no other one is not taken over.
    """
    known = {entry.name_digest for entry in memory.seeded}
    roles: dict[PrincipalId, tuple[str, ...]] = {}
    for person in people:
        digest = _digest(person)
        if digest in known:
            continue
        found = _with_free_accounts(person, authoriser.directory)
        if found is None:
            continue
        enrolled, key, records = admitted(found, clock, entropy)
        await store.write(*records)
        authoriser.enrol(enrolled, key)
        roles[enrolled.id] = person.roles
    return roles


def _with_free_accounts(person: ConfiguredPerson, directory: Directory) -> ConfiguredPerson | None:
    """Return a person of the file with the accounts that are nobody's; None if there is none."""
    free = tuple(address for address in person.addresses if directory.at(address) is None)
    for address in person.addresses:
        if address not in free:
            log.warning("%s is somebody's here already, so it is not taken over", address)
    return msgspec.structs.replace(person, addresses=free) if free else None


def named_in_file(
    people: Iterable[ConfiguredPerson], memory: Memory, authoriser: Authoriser
) -> dict[str, PrincipalId]:
    """Return whom each name of the configuration file means, by the name without its case.

    Whoever was taken over once is meant for good, however they or others are called since.
    """
    known = {entry.name_digest: entry.principal for entry in memory.seeded}
    found: dict[str, PrincipalId] = {}
    for person in people:
        principal = known.get(_digest(person))
        for address in person.addresses if principal is None else ():
            just_now = authoriser.directory.at(address)  # in this very run
            principal = just_now[0].id if just_now is not None else principal
        if principal is not None:
            found[person.name.casefold()] = principal
    return found


def admitted(
    person: ConfiguredPerson, clock: Clock, entropy: Entropy, by: PrincipalId = OPERATOR
) -> tuple[Principal, AuthorisationKey, list[Record]]:
    """Return who becomes known, under which key given by whom, and all that makes it so."""
    principal, now_ns = f"p{entropy.token(RECORD_ID_BYTES).hex()}", clock.wall_ns()
    key = AuthorisationKey(
        id=f"k{entropy.token(RECORD_ID_BYTES).hex()}",
        principal=principal,
        issuer=by,
        issued_ns=now_ns,
    )
    record = PersonRecord(str(person.name), person.addresses)
    letter = Letter(principal, _encode_record(record))
    enrolled = Principal(
        id=principal, name=person.name, roles=person.roles, addresses=person.addresses
    )
    return (
        enrolled,
        key,
        [
            Enrolled(principal=principal, roles=person.roles, at_ns=now_ns, letter=letter),
            KeyIssued(key=key),
            Seeded(name_digest=_digest(person), principal=principal),
        ],
    )


def _digest(person: ConfiguredPerson) -> bytes:
    """Return what stands for a person of the file: the name; addresses may be corrected later."""
    return blake2b(person.name.casefold().encode(), digest_size=DIGEST_BYTES).digest()
