"""Making somebody known, or giving a known person more: the records of it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import msgspec

from rosic.authoriser import messages as words
from rosic.authoriser.admission import Applicant, ApplicantWaits, CodeRedeemed, PendingApplicant
from rosic.core.identity import AuthorisationKey, Principal
from rosic.core.language.sanitise import clean_name, drawn
from rosic.core.records import Decided, Enrolled, KeyIssued, Letter, PersonRecord

if TYPE_CHECKING:
    from rosic.authoriser.applicants import Applicants
    from rosic.authoriser.directory import Directory
    from rosic.authoriser.invitation import Invitation
    from rosic.authoriser.invitations import Invitations
    from rosic.authoriser.monotonic_clock import MonotonicWallClock
    from rosic.contracts.entropy import Entropy
    from rosic.core.identity import Address, PrincipalId
    from rosic.core.records import Fact, Record

ID_BYTES: Final = 8
PENDING_S: Final = 86_400.0
GUEST: Final = "guest"

_encode_card = msgspec.msgpack.Encoder().encode


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

    def waits(self, applicant: Applicant, used: Fact) -> ApplicantWaits:
        """Return the question to the admins, with words that no other open question shows."""
        while applicant.words in self._applicants.words():
            asked = msgspec.structs.replace(applicant.pending, id=self._new_id("w"))
            applicant = msgspec.structs.replace(applicant, pending=asked)
        asked = applicant.pending
        decided = self._decided("apply", asked.principal, asked.invitation)
        records = (decided, used, self._applicants.fact(applicant))
        return ApplicantWaits(applicant, records, words.waiting(applicant.words, PENDING_S))

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
        card = Letter(person.id, _encode_card(PersonRecord(person.name, addresses)))
        enrolled = Enrolled(principal=person.id, roles=person.roles, at_ns=now_ns, letter=card)
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
            id=self._new_id("k"), principal=person.id, issuer=issuer,
            issued_ns=self._time.wall_ns(),
        )  # fmt: skip

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
        return f"{letter}{self._entropy.token(ID_BYTES).hex()}"

    def _decided(self, act: str, by: PrincipalId, about: str) -> Decided:
        return Decided(act=act, by=by, about=about, at_ns=self._time.wall_ns())
