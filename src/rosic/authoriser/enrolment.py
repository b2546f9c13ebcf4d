"""Coming in: an invitation's code, perhaps an admin's tap, then a person and a key."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, NamedTuple

import msgspec

from rosic.authoriser import messages as words
from rosic.authoriser.enrolment_records import (
    Answer,
    Applicant,
    Applicants,
    EnrolmentAlarm,
    EnrolmentDeclined,
    EnrolmentRecords,
    EnrolmentRefused,
    PendingApplicant,
)
from rosic.authoriser.guessing import BruteForceGuard, GuessLimits
from rosic.authoriser.invitations import ADMIN, KIND, PEPPER, Invitations, InvitationState
from rosic.authoriser.keys_messages import LOCKED
from rosic.core.identity import OPERATOR
from rosic.core.records import Decided
from rosic.errors import Expired, NotPermitted

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from rosic.authoriser.counters import Counters
    from rosic.authoriser.directory import Directory
    from rosic.authoriser.enrolment_records import CodeRedeemed
    from rosic.authoriser.invitations import Invitation, InvitedRights, NewInvitation
    from rosic.authoriser.locks import AccountLocks
    from rosic.authoriser.monotonic_clock import MonotonicWallClock
    from rosic.contracts.clock import Entropy
    from rosic.core.identity import Address, PrincipalId
    from rosic.core.records import Fact, Record

_KINDS: Final = {
    InvitationState.USED: "code-used",
    InvitationState.BURNT: "code-burnt",
    InvitationState.WITHDRAWN: "code-withdrawn",
    InvitationState.OPEN: "code-expired",
}


class EnrolmentRules(NamedTuple):
    """What enrolment goes by.

    Attributes:
        may_invite: Whether somebody may let a person in with that, at the moment.
        limits: How often a code may be guessed.
    """

    may_invite: Callable[[PrincipalId, InvitedRights], bool]
    limits: GuessLimits = GuessLimits()


class Enrolment:
    """Redeems codes and asks admins.

    Every method that decides changes no right: the caller, under one lock, writes the records it
    returns and then applies each fact. Only counts of wrong codes change at once.

    Attributes:
        invitations: What codes give.
        applicants: Who waits for a tap.
        may_invite: Whether somebody may let a person in with that, at the moment.
    """

    def __init__(
        self,
        directory: Directory,
        locks: AccountLocks,
        time: MonotonicWallClock,
        entropy: Entropy,
        counters: Counters,
        rules: EnrolmentRules,
    ) -> None:
        self.invitations = Invitations(time, entropy)
        self.applicants = Applicants()
        self._newcomers = EnrolmentRecords(
            directory, self.invitations, self.applicants, time, entropy
        )
        self._directory = directory
        self._locks = locks
        self._time = time
        self._counters = counters
        self._guessing = BruteForceGuard(rules.limits)
        self.may_invite = rules.may_invite

    def restore(self, facts: Iterable[Fact]) -> None:
        """Take over what earlier runs wrote."""
        for fact in facts:
            self.apply(fact)

    def apply(self, fact: Fact) -> None:
        """Let a fact be so; of the kinds ``invitation``, ``code-key`` and ``pending``."""
        if fact.kind == self.applicants.KIND:
            self.applicants.apply(fact)
        elif fact.kind in {KIND, PEPPER}:
            self.invitations.apply(fact)

    def first_admin_code(self) -> NewInvitation | None:
        """Return a code for the first admin, or None when somebody is admin already."""
        return None if self._has_admin() else self.invitations.first_admin()

    def nobody_is_admin(self) -> bool:
        """Whether the first admin is still to come; one who is locked has come."""
        good = self._directory.has_good_key
        return not any(ADMIN in p.roles and good(p.id) for p in self._directory.people())

    def _has_admin(self) -> bool:
        """Whether an admin can act. Else the operator may let one in, also where all are locked."""
        good, locked = self._directory.has_good_key, self._locks.locked
        return any(
            ADMIN in p.roles and good(p.id) and not locked(p.id) for p in self._directory.people()
        )

    # ---- a code comes in ----

    def redeem(self, code: str, address: Address, *, private: bool, name: str = "") -> Answer:
        """Return what comes of a code that somebody handed in.

        Whoever is known already keeps what they have and gets the invitation's right in addition.
        Whoever had access and lost it waits for an admin's tap, whatever the role.

        Args:
            code: As it was typed.
            address: Who sent it.
            private: Whether nobody else can read along.
            name: How the messenger shows them.
        """
        found = self.look(code, address, private=private)
        if isinstance(found, EnrolmentRefused):
            return found
        self._guessing.right(address)
        applicant = self._newcomers.applicant(found, address, name)
        used = self.invitations.ended(found, InvitationState.USED, applicant.pending.principal)
        if found.needs_confirmation or (applicant.pending.returning and not found.first_admin):
            return self._newcomers.waits(applicant, used)
        return self._newcomers.comes_in(applicant, found.issuer, used)

    def look(self, code: str, address: Address, *, private: bool) -> Invitation | EnrolmentRefused:
        """Return what a code would give, without using it up; a wrong one counts as wrong."""
        if not private:
            return self._in_group(code, address)
        refused = self.not_now(address)
        if refused is not None:
            return refused
        found = self.invitations.find(code)
        fault = self._fault(found)
        if found is None or fault:
            own = found is not None and self._used_by(found, address)
            return self._counted("code-again", words.AGAIN) if own else self._wrong(address, fault)
        known = self._directory.at(address)
        if known is not None and known[0].id == found.issuer:
            return self._counted("code-own", words.OWN)
        return found

    def shown_in(self, text: str) -> tuple[str, ...]:
        """Return every good code that a text shows, however it is written there."""
        made = self.invitations
        return tuple(code for code in made.shown_in(text) if not self._fault(made.find(code)))

    def leaked(self, code: str, address: Address) -> EnrolmentRefused | None:
        """Return what burns a code that a group was shown; None where it is not good any more."""
        good = not self._fault(self.invitations.find(code))
        return self._in_group(code, address) if good else None

    def _in_group(self, code: str, address: Address) -> EnrolmentRefused:
        """Burn the code, if it is one. Nobody in the group learns whether it was."""
        found = self.invitations.find(code)
        if found is None or self._fault(found):
            if self.not_now(address) is None:
                wrong = self._wrong(address, "code-unknown")
                return msgspec.structs.replace(wrong, sentence=words.IN_GROUP)
            return EnrolmentRefused("code-paused", words.IN_GROUP)
        self._counters.count("code-in-group")
        made = self.invitations
        records = (
            made.decided("burn", found.issuer, found),
            made.ended(found, InvitationState.BURNT),
        )
        alarm = EnrolmentAlarm("code-in-group", words.shown_in_group(found.given.words))
        return EnrolmentRefused("code-in-group", words.IN_GROUP, alarm, records)

    def not_now(self, address: Address) -> EnrolmentRefused | None:
        """Return why an address may hand in no code at all, whatever the code."""
        now_ns = self._time.monotonic_ns()
        own_s = self._guessing.pause_s(address, now_ns)
        known = self._directory.at(address)
        waiting = self.applicants.at(address)
        if known is not None and self._locks.locked(known[0].id):
            return self._counted("code-locked", LOCKED)
        if own_s > 0:
            return self._counted("code-paused", words.pause_for_you(own_s))
        if waiting is not None and not self._too_late(waiting.pending):
            sentence = words.waiting(waiting.words, self._left_s(waiting.pending))
            return self._counted("code-while-waiting", sentence)
        return None

    def _fault(self, invitation: Invitation | None) -> str:
        """Return why a code is not good; empty if it is.

        An invitation is good only while its issuer is, and may still give what it gives: whoever
        took an admin's phone may have made some, and whoever was admin for an hour.
        """
        if invitation is None:
            return "code-unknown"
        if not self.invitations.is_good(invitation):
            return _KINDS[invitation.state]
        if invitation.first_admin:
            return "code-withdrawn" if self._has_admin() else ""
        issuer = invitation.issuer
        trusted = issuer == OPERATOR or (
            self._directory.has_good_key(issuer) and self.may_invite(issuer, invitation.given)
        )
        return "" if trusted and not self._locks.locked(issuer) else "code-withdrawn"

    def _used_by(self, invitation: Invitation, address: Address) -> bool:
        """Whether this is a second tap on one's own link; nobody else learns that it was a code."""
        known = self._directory.at(address)
        if known is None or invitation.user != known[0].id:
            return False
        return self._newcomers.is_good(known[1])

    def _wrong(self, address: Address, kind: str) -> EnrolmentRefused:
        limits = self._guessing.limits
        opened = self._guessing.wrong(address, self._time.monotonic_ns())
        alarm = None
        if opened:
            self._counters.count("code-breaker")
            alarm = EnrolmentAlarm("code-breaker", words.guessing(limits))
        return msgspec.structs.replace(self._counted(kind, words.NOT_GOOD), alarm=alarm)

    def _counted(self, kind: str, sentence: str) -> EnrolmentRefused:
        self._counters.count(kind)
        return EnrolmentRefused(kind, sentence)

    def reopen(self, by: PrincipalId) -> tuple[Record, ...]:
        """Let everybody hand in codes again, at once. Return the act to be written."""
        self._guessing.reopen()
        return (Decided(act="reopen", by=by, about="joining", at_ns=self._time.wall_ns()),)

    # ---- an admin taps ----

    def confirm(self, pending: str, by: PrincipalId, *, may_admit: bool) -> CodeRedeemed:
        """Return what lets an applicant in.

        Args:
            pending: Id of the question.
            by: Who tapped.
            may_admit: Whether ``by`` has the right to let people in, as the organiser says.

        Raises:
            NotPermitted: No such right; or their own question; or the applicant is locked. The
                question stays open.
            Expired: Settled before, or it waited too long.
        """
        applicant = self._applicant(pending)
        asked = applicant.pending
        self._check_tap(asked, by, may_admit=may_admit)
        if by == asked.principal:
            raise self._counters.refuse("confirm-own", NotPermitted(words.CONFIRM_OWN))
        if self._locks.locked(asked.principal):
            raise NotPermitted(words.locked(applicant.name))
        known = self._directory.at(applicant.address)
        whose = self._directory.person(asked.principal) if known is None else known[0]
        if whose is not None and (known is None or whose.id != asked.principal):
            # Of somebody else meanwhile; or theirs no more, who are here by other accounts.
            raise Expired(words.SETTLED)
        return self._newcomers.comes_in(applicant, by, self.applicants.gone(pending))

    def decline(self, pending: str, by: PrincipalId, *, may_admit: bool) -> EnrolmentDeclined:
        """Return what turns an applicant away; their own wish counts, too.

        Raises:
            NotPermitted: No right to let people in, and not their own question.
            Expired: Settled before, or it waited too long.
        """
        applicant = self._applicant(pending)
        self._check_tap(applicant.pending, by, may_admit=may_admit)
        self._counters.count("declined")
        return self._ends(applicant, by, words.declined())

    def _check_tap(self, asked: PendingApplicant, by: PrincipalId, *, may_admit: bool) -> None:
        if not may_admit and by != asked.principal:
            raise self._counters.refuse("confirm-no-right", NotPermitted(words.NO_RIGHT))

    def _applicant(self, pending: str) -> Applicant:
        applicant = self.applicants.get(pending)
        if applicant is None or self._too_late(applicant.pending):
            raise self._counters.refuse("confirm-late", Expired(words.SETTLED))
        return applicant

    def _ends(self, applicant: Applicant, by: PrincipalId, sentence: str) -> EnrolmentDeclined:
        asked = applicant.pending
        records = (self._decided("decline", by, asked.id), self.applicants.gone(asked.id))
        newcomer = self._directory.person(asked.principal) is None
        return EnrolmentDeclined(asked.principal, applicant.address, newcomer, records, sentence)

    # ---- time passes ----

    def lapsed(self) -> tuple[EnrolmentDeclined, ...]:
        """Return everybody for whom no admin tapped in time; to be asked for now and then."""
        late = [a for a in self.applicants.all() if self._too_late(a.pending)]
        return tuple(self._ends(a, a.pending.principal, words.lapsed()) for a in late)

    def _too_late(self, asked: PendingApplicant) -> bool:
        return self._time.wall_ns() >= asked.expires_ns

    def _left_s(self, asked: PendingApplicant) -> float:
        return (asked.expires_ns - self._time.wall_ns()) / 1e9

    def _decided(self, act: str, by: PrincipalId, about: str) -> Decided:
        return Decided(act=act, by=by, about=about, at_ns=self._time.wall_ns())
