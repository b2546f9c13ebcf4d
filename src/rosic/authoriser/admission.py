"""What comes of a code: in, waiting for an admin's tap, or turned away."""

from __future__ import annotations

from typing import TypeAlias

import msgspec

from rosic.authoriser import messages as words
from rosic.authoriser.invitation import InvitedRights
from rosic.authoriser.invite_codes import shared_words
from rosic.core.identity import Address, AuthorisationKey, Principal, PrincipalId
from rosic.core.policy.roles import Grant
from rosic.core.records import Record


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


class ApplicantWaits(msgspec.Struct, frozen=True):
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


class TurnedAway(msgspec.Struct, frozen=True):
    """Nobody came in.

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


class Declined(msgspec.Struct, frozen=True):
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


Answer: TypeAlias = CodeRedeemed | ApplicantWaits | TurnedAway
