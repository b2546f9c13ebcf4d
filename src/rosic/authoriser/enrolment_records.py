"""Making somebody known, or giving a known person more: the records of it."""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING, ClassVar, Final, TypeAlias

import msgspec

from rosic.authoriser import messages as words
from rosic.authoriser.invitations import InvitedRights
from rosic.authoriser.invite_codes import shared_words
from rosic.core.identity import RECORD_ID_BYTES, Address, AuthorisationKey, Principal, PrincipalId
from rosic.core.language.sanitise import clean_name, drawn
from rosic.core.policy.roles import Grant
from rosic.core.records import Decided, Enrolled, Fact, KeyIssued, Letter, PersonRecord, Record
from rosic.core.time_units import DAY_S

if TYPE_CHECKING:
    from rosic.authoriser.directory import Directory
    from rosic.authoriser.invitations import Invitation, Invitations
    from rosic.authoriser.monotonic_clock import MonotonicWallClock
    from rosic.contracts.clock import Entropy


# ---- what comes of a code ----


class CodeRedeemed(msgspec.Struct, frozen=True, kw_only=True):
    """Somebody is in as soon as the records are written.

    Attributes:
        person: As they are known from then on.
        key: Under which they act.
        grants: What the organiser keeps from now on, written together with the records; roles
            without end and bounds are the person's own already, and not among them.
        newcomer: Nobody knew them before, or their access had ended.
        records: To be written together; then each fact among them is applied.
        sentence: For the person.
    """

    person: Principal
    key: AuthorisationKey
    grants: tuple[Grant, ...]
    newcomer: bool
    records: tuple[Record, ...]
    sentence: str


class PendingApplicant(msgspec.Struct, frozen=True, kw_only=True):
    """The body of the fact ``pending``: somebody with a good code waits for an admin's tap.

    Attributes:
        invitation: Its code is used up.
        principal: Who they will be.
        returning: Their access was ended before.
        expires_ns: Until when an admin may tap; wall clock.
    """

    id: str
    invitation: str
    principal: PrincipalId
    given: InvitedRights
    issuer: PrincipalId
    returning: bool
    expires_ns: int


class Applicant(msgspec.Struct, frozen=True):
    """A pending redemption with what its letter holds."""

    pending: PendingApplicant
    name: str
    address: Address

    @property
    def words(self) -> str:
        """Return the two words that both sides see."""
        return shared_words(self.pending.id, self.pending.invitation, self.address)

    @property
    def question(self) -> str:
        """Return what the admins read."""
        asked = self.pending
        return words.wants_in(self.name, asked.given.words, self.words, returning=asked.returning)


class ApprovalPending(msgspec.Struct, frozen=True):
    """The code was good and is used up; an admin has to tap.

    Attributes:
        records: To be written together; then each fact among them is applied.
        sentence: For the person.
    """

    applicant: Applicant
    records: tuple[Record, ...]
    sentence: str


class EnrolmentAlarm(msgspec.Struct, frozen=True):
    """Something that all admins are told, now.

    Attributes:
        kind: ``code-in-group``, ``code-breaker``.
    """

    kind: str
    sentence: str


class EnrolmentRefused(msgspec.Struct, frozen=True):
    """Nobody was enrolled, and why.

    Attributes:
        kind: For counting and logs, never shown: ``code-used``, ``code-expired``, ...
        sentence: For the person; the same for every code that is not good.
        alarm: For the admins, if there is any.
        records: To be written, and applied even if they cannot be written.
    """

    kind: str
    sentence: str
    alarm: EnrolmentAlarm | None = None
    records: tuple[Record, ...] = ()


class EnrolmentDeclined(msgspec.Struct, frozen=True):
    """An admin did not let somebody in, or nobody answered.

    Attributes:
        newcomer: Nobody knew them before: what was kept of them can be erased.
        records: To be written together; then each fact among them is applied.
        sentence: For the person.
    """

    principal: PrincipalId
    address: Address
    newcomer: bool
    records: tuple[Record, ...]
    sentence: str


Answer: TypeAlias = CodeRedeemed | ApprovalPending | EnrolmentRefused


# ---- making somebody known ----

PENDING_S: Final = float(DAY_S)
GUEST: Final = "guest"

_encode_record = msgspec.msgpack.Encoder().encode


class EnrolmentRecords:
    """Turns a good code into records. Changes nothing."""

    def __init__(
        self,
        directory: Directory,
        invitations: Invitations,
        applicants: Applicants,
        time: MonotonicWallClock,
        entropy: Entropy,
    ) -> None:
        self._directory = directory
        self._invitations = invitations
        self._applicants = applicants
        self._time = time
        self._entropy = entropy

    def applicant(self, invitation: Invitation, address: Address, name: str) -> Applicant:
        """Return who would come in, by which id and under which name."""
        known = self._directory.at(address)
        returning = known is not None and not self.is_good(known[1])
        principal = known[0].id if known is not None else self._new_id("p")
        shown = known[0].name if known is not None else self._free_name(invitation, name)
        asked = PendingApplicant(
            id=self._new_id("w"),
            invitation=invitation.id,
            principal=principal,
            given=invitation.given,
            issuer=invitation.issuer,
            returning=returning,
            expires_ns=self._time.wall_ns() + int(PENDING_S * 1e9),
        )
        return Applicant(asked, shown, address)

    def waits(self, applicant: Applicant, used: Fact) -> ApprovalPending:
        """Return the question to the admins, with words that no other open question shows."""
        while applicant.words in self._applicants.words():
            asked = msgspec.structs.replace(applicant.pending, id=self._new_id("w"))
            applicant = msgspec.structs.replace(applicant, pending=asked)
        asked = applicant.pending
        decided = self._decided("apply", asked.principal, asked.invitation)
        records = (decided, used, self._applicants.fact(applicant))
        return ApprovalPending(applicant, records, words.waiting(applicant.words, PENDING_S))

    def comes_in(self, applicant: Applicant, by: PrincipalId, settled: Fact) -> CodeRedeemed:
        """Return the records that make somebody known, or that give a known person more."""
        asked, now_ns = applicant.pending, self._time.wall_ns()
        before = self._directory.at(applicant.address)
        stays = before is not None and self.is_good(before[1])
        kept = before[0].roles if before is not None and stays else ()
        own = asked.given.roles if asked.given.standing else ()
        gained = tuple(role for role in own if role not in kept)
        addresses = before[0].addresses if before is not None else (applicant.address,)
        person = Principal(
            id=asked.principal, name=applicant.name, roles=kept + gained, addresses=addresses
        )
        key = before[1] if before is not None and stays else self._new_key(person, asked.issuer)
        record = Letter(person.id, _encode_record(PersonRecord(person.name, addresses)))
        enrolled = Enrolled(principal=person.id, roles=person.roles, at_ns=now_ns, letter=record)
        records: list[Record] = [self._decided("enrol", by, person.id), settled, enrolled]
        if not stays:
            records.append(KeyIssued(key=key))
        what = asked.given.words
        return CodeRedeemed(
            person=person,
            key=key,
            grants=asked.given.grants(iter(lambda: self._new_id("g"), ""), now_ns),
            newcomer=not stays,
            records=tuple(records),
            sentence=words.extended(what) if stays else words.welcome(what),
        )

    def _new_key(self, person: Principal, issuer: PrincipalId) -> AuthorisationKey:
        return AuthorisationKey(
            id=self._new_id("k"),
            principal=person.id,
            issuer=issuer,
            issued_ns=self._time.wall_ns(),
        )

    def _free_name(self, invitation: Invitation, name: str) -> str:
        """Return a name that nobody has, nor any that looks like it.

        An admin can then say whom they mean, and sees it.
        """
        wanted = self._invitations.name_for(invitation) or clean_name(name) or GUEST
        free, number = wanted, 1
        # Collected once: hundreds may be called the same, and each number is asked about.
        names = [applicant.name for applicant in self._applicants.all()]
        names += [person.name for person in self._directory.people()]
        taken = {name.casefold() for name in names}.union(map(drawn, names))
        while free.casefold() in taken or drawn(free) in taken:
            number += 1
            free = f"{wanted} {number}"
        return free

    def is_good(self, key: AuthorisationKey) -> bool:
        """Whether a key still lets its principal in."""
        ended = key.expires_ns is not None and self._time.wall_ns() >= key.expires_ns
        return key.revoked_ns is None and not ended

    def _new_id(self, letter: str) -> str:
        return f"{letter}{self._entropy.token(RECORD_ID_BYTES).hex()}"

    def _decided(self, act: str, by: PrincipalId, about: str) -> Decided:
        return Decided(act=act, by=by, about=about, at_ns=self._time.wall_ns())


# ---- who waits for an admin ----

_log = logging.getLogger(__name__)
_encode = msgspec.msgpack.Encoder().encode
_decode = msgspec.msgpack.Decoder(PendingApplicant).decode
_decode_record = msgspec.msgpack.Decoder(PersonRecord).decode


class Applicants:
    """Everybody who waits, by the id of the question and by address. One question an address."""

    KIND: ClassVar[str] = "pending"

    def __init__(self) -> None:
        self._waiting: dict[str, Applicant] = {}
        self._at: dict[tuple[str, str], str] = {}

    def get(self, pending: str) -> Applicant | None:
        """Return who waits under an id."""
        return self._waiting.get(pending)

    def at(self, address: Address) -> Applicant | None:
        """Return who waits at an address."""
        pending = self._at.get((address.platform, address.account))
        return None if pending is None else self._waiting.get(pending)

    def all(self) -> tuple[Applicant, ...]:
        """Return everybody who waits."""
        return tuple(self._waiting.values())

    def words(self) -> frozenset[str]:
        """Return the words shown now, so that no two questions show the same."""
        return frozenset(applicant.words for applicant in self._waiting.values())

    def fact(self, applicant: Applicant) -> Fact:
        """Return what makes somebody wait."""
        asked = applicant.pending
        record = _encode(PersonRecord(applicant.name, (applicant.address,)))
        letter = Letter(asked.principal, record)
        return Fact(kind=self.KIND, key=asked.id, body=_encode(asked), letter=letter)

    def gone(self, pending: str) -> Fact:
        """Return what settles a question."""
        return Fact(kind=self.KIND, key=pending, body=b"")

    def apply(self, fact: Fact) -> None:
        """Let a fact be so. Whoever cannot be read has to come with a new code."""
        before = self._waiting.pop(fact.key, None)
        if before is not None:
            self._at.pop((before.address.platform, before.address.account), None)
        if not fact.body:
            return
        applicant = _read(fact)
        if applicant is None:
            _log.warning("somebody who waits for an admin cannot be read; they need a new code")
            return
        self._waiting[fact.key] = applicant
        self._at[applicant.address.platform, applicant.address.account] = fact.key


def _read(fact: Fact) -> Applicant | None:
    try:
        asked = _decode(fact.body)
        if fact.letter is None or asked.id != fact.key:
            return None
        record = _decode_record(fact.letter.content)
    except msgspec.MsgspecError:
        return None
    return Applicant(asked, record.name, record.addresses[0]) if record.addresses else None
