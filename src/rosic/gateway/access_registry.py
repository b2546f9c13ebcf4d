"""Everything that lets people in and keeps them out, put together and brought up to date.

Features ask and change it through the kernel; what is written down becomes so here.
"""

from __future__ import annotations

from collections import Counter
from contextlib import suppress
from functools import partial
from typing import TYPE_CHECKING, NamedTuple

import msgspec

from rosic.authoriser.abuse import COUNTED_AS, RULE, SUSPICIOUS, AbuseDetector, AbuseLimits
from rosic.authoriser.account_links import AccountLinks
from rosic.authoriser.authoriser import Authoriser
from rosic.authoriser.counters import Counters
from rosic.authoriser.directory import Directory
from rosic.authoriser.enrolment import Enrolment, EnrolmentRules
from rosic.authoriser.keys import KeyRing
from rosic.authoriser.locks import AccountLocks
from rosic.authoriser.page_sessions import KIND as PAGE_SESSION
from rosic.authoriser.page_sessions import PageSessions
from rosic.authoriser.passkeys import KIND as PASSKEY
from rosic.authoriser.passkeys import Passkeys
from rosic.authoriser.program_keys import KIND as KEY_SECRET
from rosic.authoriser.program_keys import ProgramKeys
from rosic.authoriser.security_report import SecurityReports
from rosic.authoriser.two_factor import TwoFactor
from rosic.contracts.background_tasks import BackgroundTasks
from rosic.core.identity import Principal
from rosic.core.policy.compiled import FOR_GOOD_NS
from rosic.core.policy.scope import FLEET
from rosic.core.policy.scope import GRANT as GIVES
from rosic.core.records import Enrolled, KeyIssued, KeyRevoked, PersonRecord
from rosic.core.robot.skill import SkillClass
from rosic.core.signal import Deferred, Signal
from rosic.core.slot import SERIES, SLOT
from rosic.errors import NotPermitted, NotUnderstood, Refusal, TooManyRequests
from rosic.gateway.policy_service import key_of
from rosic.gateway.transactions import Transactions
from rosic.organiser.access_requests import ACCESS_REQUEST, AccessRequests
from rosic.organiser.calendar import Calendar, CalendarNames
from rosic.organiser.grants import GRANT, ROLE
from rosic.organiser.organiser import AccessState
from rosic.organiser.planning.wishes import WISH, Wishes
from rosic.organiser.rate_limits import KIND as RATE
from rosic.organiser.wait_queue import WAITING, WaitingList

if TYPE_CHECKING:
    from collections.abc import Awaitable

    from rosic.authoriser.abuse import InvalidateKey
    from rosic.authoriser.invitations import InvitedRights
    from rosic.authoriser.monotonic_clock import MonotonicWallClock
    from rosic.contracts.clock import Clock, Entropy
    from rosic.contracts.store import Store
    from rosic.core.identity import Address, Caller, PrincipalId
    from rosic.core.message import Chat
    from rosic.core.records import Fact, Memory
    from rosic.core.stop_registry import StopRegistry
    from rosic.gateway.delivery.notifier import Notifier
    from rosic.gateway.policy_service import PolicyService
    from rosic.organiser.organiser import Organiser


def _nobody_invites(_principal: PrincipalId, _given: InvitedRights) -> bool:
    """Let nobody in: who may is not known yet."""
    return False


async def nothing_kept(_principal: PrincipalId) -> None:
    """Erase nothing: there are no containers, so nothing was kept."""


def authoriser_of(time: MonotonicWallClock, clock: Clock, entropy: Entropy) -> Authoriser:
    """Return an authoriser who knows nobody yet."""
    keys = KeyRing(time, entropy, Counters())
    return Authoriser(Directory(), keys, clock, entropy)


class PlaceNames(NamedTuple):
    """How a place, and what there is, is called.

    Attributes:
        place: Its own name, as people see it.
        calendar: What is called how in sentences about times.
    """

    place: str
    calendar: CalendarNames


class AccessRegistry:
    """The authoriser's and the organiser's books, and the way in which they change.

    Attributes:
        changes: Through which every change goes.
        note: Writes down what is so already, and waits for no disk.
        enrolment, links, keys, programs, page_sessions, passkeys, locks, two_factor, misuse,
            counters, time, security, waiting, access_requests: The books.
        account_lost: Tells who has lost which of their accounts, once that is so.
        calendar: Whose time it is.
        refusals: How often what was refused to people who are known, by code, in this run.
        forget_newcomer: Erases what was kept of somebody who was not let in; nothing is kept
            before it is bound.
        may_invite: Whether somebody may let a person in with that; nobody, until it is bound.
    """

    def __init__(
        self,
        authoriser: Authoriser,
        authority: PolicyService,
        store: Store,
        entropy: Entropy,
        stops: StopRegistry,
        place: PlaceNames,
    ) -> None:
        self.keys = authoriser.keys
        self.time, self.counters = self.keys.time, self.keys.counters
        self.programs = ProgramKeys(self.keys, authoriser.directory, entropy)
        self.page_sessions = PageSessions(self.time, entropy, self.counters, authoriser.has_access)
        self.passkeys = Passkeys(self.time, entropy)
        self.changes = Transactions(store, self.time)
        self.note = store.note
        self.locks = AccountLocks(self.time)
        self.may_invite: Deferred[[PrincipalId, InvitedRights], bool] = Deferred(_nobody_invites)
        self.enrolment = Enrolment(
            authoriser.directory,
            self.locks,
            self.time,
            entropy,
            self.counters,
            EnrolmentRules(self.may_invite),
        )
        self.links = AccountLinks(authoriser, self.page_sessions, entropy)
        self.account_lost: Signal[[PrincipalId, Address]] = Signal()
        self.two_factor = TwoFactor(self.time, entropy, self.counters, place=place.place)
        self.refusals: Counter[str] = Counter()
        self.misuse = AbuseDetector(
            self.time, AbuseLimits(), only_admin=self.is_only_admin, name=authoriser.directory.name
        )
        self.security = SecurityReports(
            authoriser, self.enrolment, self.keys, self.locks, self.counters, self.time
        )
        self.waiting = WaitingList(self.time, place.calendar.shown_of)
        self.wishes = Wishes(self.time.wall_ns)
        self.access_requests = AccessRequests(self.time.wall_ns, entropy)
        self.forget_newcomer: Deferred[[PrincipalId], Awaitable[None]] = Deferred(nothing_kept)
        self._authoriser = authoriser
        self._authority, self._stops = authority, stops
        self.calendar = Calendar(self.time, place.calendar)
        self.time.when_behind.connect(self._set_back)
        self.time.when_ahead.connect(self.waiting.age)

    def codes_in(self, text: str) -> tuple[str, ...]:
        """Return every code that a text shows and that lets somebody in: none of them is kept."""
        page_codes, link_codes = self.page_sessions.shown_in(text), self.links.shown_in(text)
        return (*self.enrolment.invitations.shown_in(text), *page_codes, *link_codes)

    @property
    def state(self) -> AccessState:
        """Return what deciding rests on besides the rights."""
        authoriser, authority = self._authoriser, self._authority
        return AccessState(
            clock=self.time,
            calendar=self.calendar,
            key_of=partial(key_of, authoriser),
            narrow=authoriser.directory.narrowed,
            locked=self.locks.everybody(),
            own_limits=authority.grants_book.own_limits,
            locked_out=lambda _principal: self.counters.count("locked"),
            released=lambda _robot: authority.moved(),
        )

    def restore(self, memory: Memory, organiser: Organiser) -> None:
        """Take over what earlier runs wrote, and say who keeps what from now on."""
        authority, changes = self._authority, self.changes
        keepers = {
            "high-water": self.time.apply,
            "tally": self.counters.apply,
            "lock": self.locks.apply,
            "code-key": self.enrolment.apply,
            "invitation": self.enrolment.apply,
            "pending": self.enrolment.apply,
            "totp": self.two_factor.apply,
            KEY_SECRET: self.programs.apply,
            PAGE_SESSION: self.page_sessions.apply,
            PASSKEY: self.passkeys.apply,
            WAITING: self.waiting.apply,
            WISH: self.wishes.apply,
            ACCESS_REQUEST: self.access_requests.apply,
        }
        for kind, apply in keepers.items():
            for fact in memory.facts.get(kind, ()):
                apply(fact)
            changes.keep(kind, apply)
        calendar = self.calendar
        calendar.restore((*memory.facts.get(SERIES, ()), *memory.facts.get(SLOT, ())))
        changes.keep(SLOT, partial(self._booked, calendar))
        changes.keep(SERIES, calendar.apply)
        organiser.rates.restore(memory.facts.get(RATE, ()))
        self.keys.restore(self._authoriser.directory.keys(), memory.facts.get("key-end", ()))
        changes.keep("key-end", self._key_ends)
        changes.keep("lock", self._locked)
        changes.keep(GRANT, authority.granted)
        changes.keep(ROLE, authority.ruled)
        changes.watch(Enrolled, self._enrolled)
        changes.watch(KeyIssued, self._issued)
        changes.watch(KeyRevoked, self._revoked)

    def _set_back(self, behind: bool) -> None:
        if not behind:
            self._stops.not_later(self.time.wall_ns())
        self._authority.moved()
        self._authority.when_changed.emit()

    def _booked(self, calendar: Calendar, fact: Fact) -> None:
        calendar.apply(fact)
        self._authority.moved()

    def _locked(self, fact: Fact) -> None:
        self.locks.apply(fact)
        self.two_factor.end(fact.key)
        self.links.void(fact.key)  # given to whoever had the account then; not good again after
        self._authority.renew(fact.key)

    def _key_ends(self, fact: Fact) -> None:
        self.keys.apply(fact)
        key = self._authoriser.directory.key(fact.key)
        if key is not None:
            self._authoriser.forget(key.principal)
        self._authority.when_changed.emit()

    def _enrolled(self, record: Enrolled) -> None:
        directory = self._authoriser.directory
        before, person = directory.person(record.principal), person_of(record)
        directory.enrol(person)
        self._authoriser.forget(record.principal)
        self._authority.enrolled(record)
        for address in () if before is None else before.addresses:
            if address not in person.addresses:
                self._lost(person.id, address)

    def _lost(self, principal: PrincipalId, address: Address) -> None:
        """End what may have been asked, proven or begun from an account that is theirs no more.

        Buttons are bound to people and chats, and in a group nobody knows of which account one
        was: so all of theirs go.
        """
        self.two_factor.end(principal)
        self._authoriser.buttons.void(principal, "")
        self.account_lost.emit(principal, address)

    def _issued(self, record: KeyIssued) -> None:
        self.keys.apply(record)
        self._authoriser.directory.add_key(record.key)
        self._authoriser.forget(record.key.principal)
        self._authority.when_changed.emit()

    def _revoked(self, record: KeyRevoked) -> None:
        self.keys.apply(record)
        principal = self._authoriser.revoke(record.key)
        if principal is not None:
            self.two_factor.end(principal)
            if not self._authoriser.directory.has_good_key(principal):
                self._authority.revoked(principal)

    def ahead(self, principal: PrincipalId) -> tuple[Fact, ...]:
        """Return what takes away what somebody still had to come: times, queues and wishes.

        Whoever has no access any more keeps no robot from the others.
        """
        booked = self.calendar.end_all(principal)
        return (*booked, *self.waiting.leave_all(principal), *self.wishes.end_all(principal))

    async def leave(self) -> None:
        """Write down what was counted since the last time; at the end, and as far as it can be."""
        with suppress(Refusal):
            async with self.changes.turn() as turn:
                await turn.write((*self.time.due(), *self.counters.due()))

    def is_only_admin(self, principal: PrincipalId) -> bool:
        """Whether nobody else would be left who gives rights here, by a role or by a grant.

        Whoever is admin for some hours only is none who could be left alone.
        """
        directory, locked = self._authoriser.directory, self.locks.locked
        rights = self._authority.rights
        return rights.holds(principal, FLEET, GIVES, self.time.wall_ns()) and rights.is_last_giver(
            principal, lambda who: directory.has_good_key(who) and not locked(who), FOR_GOOD_NS
        )


_decode_record = msgspec.msgpack.Decoder(PersonRecord).decode


def person_of(entry: Enrolled) -> Principal:
    """Return who became known."""
    record = _decode_record(entry.letter.content)
    return Principal(
        id=entry.principal, name=record.name, roles=entry.roles, addresses=record.addresses
    )


# ---- misuse ----


def admins_of(organiser: Organiser) -> tuple[PrincipalId, ...]:
    """Return who looks after people."""
    return organiser.rights.givers(FLEET, organiser.wall_ns())


class AbuseResponse:
    """Lets the rules about misuse hear of what people try, and does what they ask for."""

    def __init__(self, access: AccessRegistry, organiser: Organiser, reach: Notifier) -> None:
        self._two_factor, self._counters, self._misuse = (
            access.two_factor,
            access.counters,
            access.misuse,
        )
        self._changes, self._keys = access.changes, access.keys
        self._refusals = access.refusals
        self._organiser, self._reach = organiser, reach
        self._tasks: BackgroundTasks[None] = BackgroundTasks()

    def proof_used(self, principal: PrincipalId, chat: Chat) -> None:
        """Begin the idle hour of a second factor anew; what has let pass has let pass."""
        with suppress(NotPermitted):  # the hour may have ended since it was asked
            self._two_factor.use(principal, chat)

    def refused(self, caller: Caller, refusal: Refusal) -> None:
        """Let the rules about misuse hear of refusals; what is only late is none."""
        self._refusals[refusal.code] += 1
        if refusal.code not in SUSPICIOUS:
            return
        if not refusal.counted:
            self._counters.count(COUNTED_AS.get(refusal.code, refusal.code))
        if isinstance(refusal, TooManyRequests) and not refusal.own:
            return
        said = self._misuse.attempted(caller.principal, SkillClass.MOTION, refusal.code)
        if said is not None:
            self._tasks.begin(self._invalidate(caller, said))

    async def _invalidate(self, caller: Caller, said: InvalidateKey) -> None:
        """End a key by rule: at once, written as soon as it can be, and both sides are told."""
        if not said.spare:
            try:
                revoked = self._keys.revoke(caller.key, RULE)
            except NotUnderstood:  # it has ended meanwhile, and who had to know was told
                return
            await self._changes.take_away(revoked.records)
            self._reach.tell((caller.principal,), said.to_person)
        self._reach.tell(admins_of(self._organiser), said.to_admins, urgent=True)
