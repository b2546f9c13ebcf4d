"""``/revoke``, ``/lock`` and ``/unlock``: whose access ends, for good or for now.

What takes rights away is in force before the disk has answered, and whatever it answers.
"""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING, TypeGuard

from rosic.authoriser import keys_messages
from rosic.core.i18n import said
from rosic.core.identity import OPERATOR
from rosic.core.message import Button
from rosic.errors import NotPermitted, NotUnderstood
from rosic.features.access import access_messages, messages
from rosic.features.access.admin_policy import LOCK, PEOPLE, PersonNames, asked_again, sure
from rosic.gateway.commands import Reply, asks_first, check_private
from rosic.gateway.person_argument import BY_ID
from rosic.gateway.replies import LEAVE

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from rosic.authoriser.enrolment_records import Applicant
    from rosic.core.identity import AuthorisationKey, Principal, PrincipalId
    from rosic.core.records import Record
    from rosic.features.access.admin_policy import AdminPolicy
    from rosic.features.access.context import AccessContext
    from rosic.gateway.commands import CommandContext


# ---- ``/revoke``, ``/lock`` and ``/unlock`` ----

MYSELF = frozenset({"me", "myself", "mich"})


class RevokeLockCommands:
    """Takes access away and gives a locked person theirs back."""

    def __init__(
        self, registry: AccessContext, admin_policy: AdminPolicy, notices: AccessNotices
    ) -> None:
        self._registry = registry
        self._admin_policy = admin_policy
        self._notices = notices
        self._names = PersonNames(registry)
        self._directory = registry.authoriser.directory
        self._locks = registry.locks
        self._ending: set[asyncio.Future[object]] = set()

    # ---- for good ----

    async def revoke(self, asked: CommandContext) -> Reply:
        """Take somebody's keys and grants, after asking once.

        Raises:
            Refusal: Others read along, not theirs to do, nobody of that name, or the last admin.
        """
        by = asked.caller.principal
        self._admin_policy.check(by, PEOPLE)
        check_private(asked)
        typed = asked.rest.strip()
        if not typed:
            return Reply(access_messages.HOW_TO_REVOKE)
        found = self._names.find(asked, typed, "revoke", self._has_access)
        if isinstance(found, Reply):
            return found
        question = access_messages.revoke_question(found.name, self._given(found.id))
        agreed = sure("revoke", found.id, question)
        if asked.act != agreed:
            self._check_revocable(found)
            yes = Button(access_messages.REVOKE, f"/revoke {found.id}", act=agreed)
            return asks_first(
                asked_again(asked.act, question), ((yes, Button(messages.LEAVE_IT, LEAVE)),)
            )
        written = await self._end_for_good(found, by)
        self._notices.revoked(found, by)
        return Reply(messages.noted(keys_messages.revoked(found.name), written=written))

    def _has_access(self, person: Principal) -> bool:
        return self._directory.has_good_key(person.id)

    def _check_revocable(self, person: Principal) -> None:
        if not self._has_access(person):
            raise NotUnderstood(access_messages.no_access(person.name))
        if self._admin_policy.is_last_admin(person.id, for_good=True):
            raise NotPermitted(access_messages.last_admin(person.name))

    def _revocation(self, person: Principal, by: PrincipalId) -> tuple[Record, ...]:
        """Return what ends everything of somebody: what they invited to, asked for and hold."""
        enrolment, keys = self._registry.enrolment, self._registry.keys
        made = [i for i in enrolment.invitations.open() if i.issuer == person.id]
        asked = [a for a in map(enrolment.applicants.at, person.addresses) if self._is_open(a)]
        good = [key for key in keys.of(person.id) if key.revoked_ns is None]
        return (
            *_all(enrolment.invitations.withdraw(i.id, by) for i in made),
            *_all(enrolment.decline(a.pending.id, by, may_admit=True).records for a in asked),
            *self._registry.ahead(person.id),
            *self._registry.grants_book.take(person.id, by),
            *_all(keys.revoke(key.id, by).records for key in good),
            *_all(keys.revoke(key.id, by).records for key in self._programs_of(person.id)),
        )

    def _programs_of(self, principal: PrincipalId) -> list[AuthorisationKey]:
        """Return the keys of programs that somebody has made: they end with whoever made them."""
        given = self._registry.keys.issued_by(principal)
        return [key for key in given if self._directory.is_program(key.principal)]

    def _is_open(self, applicant: Applicant | None) -> TypeGuard[Applicant]:
        """Whether somebody still waits for an admin; whoever waited too long is turned away."""
        now_ns = self._registry.clock.wall_ns()
        return applicant is not None and now_ns < applicant.pending.expires_ns

    async def _end_for_good(self, person: Principal, by: PrincipalId) -> bool:
        """Take everything at once, whoever holds the turn: somebody else's write may hang.

        Nothing was waited for since it was seen that this is theirs to do.
        """
        self._check_revocable(person)
        records = self._revocation(person, by)
        return await self._end(person.id, records, lambda: self._revocation(person, by))

    def _given(self, principal: PrincipalId) -> str:
        rights, now_ns = self._registry.rights(), self._registry.clock.wall_ns()
        return messages.held(rights.grants(principal), now_ns)

    # ---- for now ----

    async def lock(self, asked: CommandContext) -> Reply:
        """Lock somebody; in any chat, at once. Everybody may lock themselves.

        Raises:
            Refusal: Not theirs to do, nobody of that name, or the last admin.
        """
        by = asked.caller.principal
        typed = asked.rest.strip()
        if typed.casefold() in MYSELF:
            typed = by
        own = [person.id for person in self._names.called(typed)] == [by]
        if not own:
            self._admin_policy.check(by, LOCK)
        if not typed:
            return Reply(access_messages.HOW_TO_LOCK)
        found = self._names.find(asked, typed, "lock", self._is_free)
        if isinstance(found, Reply):
            return found
        if self._admin_policy.is_last_admin(found.id, for_good=False):
            if found.id != by:
                raise NotPermitted(access_messages.last_admin(found.name))
            agreed = sure("lock", by)
            if asked.act != agreed:
                yes = Button(access_messages.LOCK_ME, f"/lock {by}", act=agreed)
                return asks_first(
                    access_messages.LOCK_LAST, ((yes, Button(messages.LEAVE_IT, LEAVE)),)
                )
        written = await self._end_for_now(found.id, by)
        self._notices.locked(found, by)
        return _locked(found, by, written=written)

    def _is_free(self, person: Principal) -> bool:
        return not self._locks.locked(person.id)

    async def unlock(self, asked: CommandContext) -> Reply:
        """Give a locked person their access back.

        Raises:
            Refusal: Not theirs to do, nobody of that name, or not locked.
        """
        by, typed = asked.caller.principal, asked.rest.strip()
        self._admin_policy.check(by, LOCK)
        if not typed:
            return Reply(
                access_messages.how_to_unlock(self._locked_names() if asked.private else ())
            )
        found = self._names.find(
            asked, typed, "unlock", lambda person: self._locks.locked(person.id)
        )
        if isinstance(found, Reply):
            return found
        async with self._registry.changes.turn() as turn:
            self._admin_policy.check(by, LOCK)
            await turn.write(self._locks.unlock(found.id, by, found.name))
        self._notices.unlocked(found, by)
        return Reply(keys_messages.unlocked(found.name))

    def _locked_names(self) -> tuple[str, ...]:
        return tuple(self._registry.name(principal) for principal in self._locks.all())

    async def _end_for_now(self, principal: PrincipalId, by: PrincipalId) -> bool:
        """Lock at once, whoever holds the turn: they may unlock, and had looked before."""

        def again() -> tuple[Record, ...]:
            return () if self._locks.locked(principal) else self._locks.lock(principal, by)

        return await self._end(principal, self._locks.lock(principal, by), again)

    # ---- both ----

    async def _end(
        self,
        principal: PrincipalId,
        records: tuple[Record, ...],
        again: Callable[[], tuple[Record, ...]],
    ) -> bool:
        """Take access away, and end what somebody has in hand, beside the writing.

        The task begins when the event loop is let go, and by then it is in force that they may
        nothing any more. The answer does not wait for it: it may need a turn of the changes.
        """
        ending = asyncio.ensure_future(self._registry.ended(principal))
        self._ending.add(ending)
        ending.add_done_callback(self._ending.discard)
        return await self._registry.changes.take_away(records, again)


def _locked(person: Principal, by: PrincipalId, *, written: bool) -> Reply:
    """Return that somebody is locked, with the way back for whoever meant somebody else."""
    if person.id == by:
        return Reply(messages.noted(access_messages.LOCKED_YOURSELF, written=written))
    undo = Button(access_messages.UNLOCK, f"/unlock {person.id}", act=BY_ID)
    return Reply(messages.noted(keys_messages.locked(person.name), written=written), ((undo,),))


def _all(found: Iterable[Iterable[Record]]) -> tuple[Record, ...]:
    return tuple(record for records in found for record in records)


class AccessNotices:
    """Tells them, in private, wherever they can be reached."""

    def __init__(self, registry: AccessContext, admin_policy: AdminPolicy) -> None:
        self._registry = registry
        self._admin_policy = admin_policy

    def revoked(self, person: Principal, by: PrincipalId) -> None:
        """Somebody's access has ended for good."""
        self._person(person, keys_messages.ENDED)
        self._admins(by, person, PEOPLE, access_messages.was_revoked(self._name(by), person.name))

    def key_taken(self, person: Principal, by: PrincipalId) -> None:
        """A key of somebody was taken back; perhaps it was their last one."""
        if not self._registry.authoriser.directory.has_good_key(person.id):
            self.revoked(person, by)
            return
        self._person(person, keys_messages.KEY_TAKEN)
        self._admins(by, person, PEOPLE, access_messages.was_key_taken(self._name(by), person.name))

    def locked(self, person: Principal, by: PrincipalId) -> None:
        """Somebody is locked. Nothing is told to who did it in a chat: they read the answer."""
        if by == OPERATOR:
            self._person(person, keys_messages.LOCKED)
        self._admins(by, person, LOCK, access_messages.was_locked(self._name(by), person.name))

    def unlocked(self, person: Principal, by: PrincipalId) -> None:
        """Somebody has their access back."""
        name = self._name(by)
        self._person(person, access_messages.you_are_unlocked(name))
        self._admins(by, person, LOCK, access_messages.was_unlocked(name, person.name))

    def _name(self, by: PrincipalId) -> str:
        """Return who it was, as a sentence begins with it."""
        return said("The operator") if by == OPERATOR else self._registry.name(by)

    def _person(self, person: Principal, text: str) -> None:
        self._registry.reach.tell((person.id,), text)

    def _admins(self, by: PrincipalId, person: Principal, verb: str, text: str) -> None:
        """Tell everybody else who looks after people: whoever it is about has heard of it."""
        others = [who for who in self._admin_policy.holders(verb, besides=by) if who != person.id]
        self._registry.reach.tell(others, text, urgent=True)
