"""Who may come in, and whose access ends, as the operator of the machine decides it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import msgspec

from rosic.app.admin.naming import the_one, utc
from rosic.authoriser import keys_messages, messages
from rosic.authoriser.invitations import CODE_TTL_S, InvitationRequest, InvitedRights
from rosic.authoriser.invite_codes import join_text, only_here
from rosic.authoriser.messages import ONLY_HERE
from rosic.contracts.messenger import invite_link_of
from rosic.core.i18n import joined
from rosic.core.identity import OPERATOR
from rosic.core.language import clean
from rosic.core.policy.roles import Grant
from rosic.core.policy.validation import grant_mistakes
from rosic.core.records import Decided
from rosic.errors import NotPermitted, NotUnderstood
from rosic.features.access.messages import how_to_join, noted
from rosic.features.access.program_keys import check_for_robots_alone

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Sequence

    from rosic.app.admin.api import AdminContext
    from rosic.authoriser.invitations import NewInvitation
    from rosic.core.identity import AuthorisationKey, Principal
    from rosic.core.policy.limits import Convert
    from rosic.core.records import Record

ADMIN = ("admin",)


class InviteParameters(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """An invitation as a command asks for it.

    Attributes:
        confirm: An admin has to tap; otherwise as the roles demand.
    """

    roles: tuple[str, ...]
    robots: tuple[str, ...] = ()
    limits: tuple[str, ...] = ()
    lasts_s: float | None = None
    code_ttl_s: float = CODE_TTL_S
    name: str = ""
    confirm: bool = False


class ProgramParameters(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A program as a command asks for it: how it is called, and what it may."""

    name: str
    roles: tuple[str, ...]
    robots: tuple[str, ...] = ()
    limits: tuple[str, ...] = ()
    lasts_s: float | None = None


class RotateParameters(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """How long the replaced key stays good."""

    grace_s: float = 0.0


class AccessAdmin:
    """Invitations, keys and locks. Everything is on the record under `OPERATOR`."""

    def __init__(self, books: AdminContext, convert: Convert) -> None:
        self._books = books
        self._convert = convert
        self._access = books.access
        self._notices = books.notices
        self._directory = books.authoriser.directory

    # ---- coming in ----

    async def invite(self, asked: InviteParameters) -> tuple[str, str]:
        """Make an invitation. Return what to read, and what to show as a picture.

        When nobody is admin, an invitation of an admin lets the first one in.

        Raises:
            NotUnderstood: What is wrong with it, in one sentence. Nothing was done.
            OutOfBounds: A time that is none.
            TooManyRequests: Too many are open.
            RecordUnavailable: Not written.
        """
        self._check(asked.roles, asked.robots, asked.limits)
        # The first admin may be whoever sits at the terminal.
        others = not self.nobody_is_admin()
        if others and only_here([messenger.platform for messenger in self._books.messengers]):
            raise NotUnderstood(ONLY_HERE)
        given = InvitedRights(
            roles=asked.roles, robots=asked.robots, limits=asked.limits, lasts_s=asked.lasts_s
        )
        wanted = InvitationRequest(
            given=given,
            code_ttl_s=asked.code_ttl_s,
            name=asked.name,
            needs_confirmation=True if asked.confirm else None,
        )
        enrolment = self._access.enrolment
        async with self._access.changes.turn() as turn:
            first = given.standing and given.roles == ADMIN and not asked.confirm
            offer = enrolment.first_admin_code() if first else None
            if offer is None:
                offer = enrolment.invitations.invite(wanted, OPERATOR)
            await turn.write(offer.records)
        return self._shown(offer)

    def nobody_is_admin(self) -> bool:
        """Whether the first admin is still to come."""
        return self._access.enrolment.nobody_is_admin()

    async def first_admin(self) -> tuple[str, str] | None:
        """Make the code of the first admin, and end those of earlier starts.

        Returns:
            What to read and what to show; None when somebody is admin already.

        Raises:
            RecordUnavailable: Not written; no code is good.
        """
        async with self._access.changes.turn() as turn:
            offer = self._access.enrolment.first_admin_code()
            if offer is None:
                return None
            await turn.write(offer.records)
        return self._shown(offer)

    def _shown(self, offer: NewInvitation) -> tuple[str, str]:
        found = (invite_link_of(messenger, offer.code) for messenger in self._books.messengers)
        links = [link for link in found if link]
        text = join_text(offer.code)
        if offer.invitation.first_admin:
            return joined("\n", (offer.sentence, *links)), links[0] if links else text
        how = how_to_join("\n".join(links), text).replace("send me", "send the bot")
        return f"{offer.sentence}\n{how}", links[0] if links else text

    def _check(
        self, roles: tuple[str, ...], robots: tuple[str, ...], limits: tuple[str, ...]
    ) -> None:
        rights = self._books.authority.rights
        if not roles:
            raise NotUnderstood(messages.NO_ROLE)
        for role in roles:
            grant = Grant(role=role, robots=robots, limits=limits)
            mistakes = grant_mistakes(grant, rights.rulebook, rights.fleet, self._convert)
            if mistakes:
                first = mistakes[0]
                raise NotUnderstood(" ".join(filter(None, (first.sentence, first.hint))))

    async def create_program(self, asked: ProgramParameters) -> str:
        """Let a program in. Return what to read, with its secret.

        Raises:
            NotUnderstood: What is wrong with it, in one sentence. Nothing was done.
            RecordUnavailable: Not written; nothing changed.
        """
        self._check(asked.roles, asked.robots, asked.limits)
        given = InvitedRights(
            roles=asked.roles, robots=asked.robots, limits=asked.limits, lasts_s=asked.lasts_s
        )
        check_for_robots_alone(self._books.authority.rolebook.rulebook, given)
        async with self._access.changes.turn() as turn:
            made = self._access.programs.enrol(asked.name, given, OPERATOR)
            held = self._books.authority.grants_book.give(made.program.id, made.grants, OPERATOR)
            await turn.write((*made.records, *held))
        return keys_messages.program_made(
            clean(made.program.name), given.words, made.secret.reveal()
        )

    # ---- keys ----

    def keys(self, names: Sequence[str]) -> tuple[str, ...]:
        """Return a line for each key: of one person, or of everybody.

        Raises:
            NotUnderstood: Nobody, or more than one, is called so.
        """
        ring = self._access.keys
        lines = [
            keys_messages.key_line(self._books.name(key.principal), key.id, ring.state(key))
            for key in self._keys_of(names)
        ]
        return tuple(lines) or ("There is no key yet.",)

    def keys_listed(self, names: Sequence[str]) -> tuple[dict[str, object], ...]:
        """Return what `keys` says, for programs.

        Raises:
            NotUnderstood: As `keys`.
        """
        ring, now_ns = self._access.keys, self._books.clock.wall_ns()
        found: list[dict[str, object]] = []
        for key in self._keys_of(names):
            ends_ns = ring.ends_ns(key)
            over = ends_ns is not None and ends_ns <= now_ns
            ended = "ended" if over else "good"
            found.append(
                {
                    "id": key.id,
                    "person": key.principal,
                    "name": self._books.name(key.principal),
                    "state": ended if key.revoked_ns is None else "taken back",
                    "until": utc(ends_ns),
                    "replaced": ring.is_replaced(key.id),
                    "taken_back": utc(key.revoked_ns),
                }
            )
        return tuple(found)

    def _keys_of(self, names: Sequence[str]) -> Iterable[AuthorisationKey]:
        if names:
            return self._access.keys.of(the_one(self._directory, " ".join(names)).id)
        return self._access.keys.all()

    async def rotate(self, name: str, asked: RotateParameters) -> str:
        """Replace somebody's key by a new one.

        Raises:
            NotUnderstood: Nobody of that name, or there is no good key.
            OutOfBounds: A grace that is none.
            RecordUnavailable: Not written; nothing changed.
        """
        person = the_one(self._directory, name)
        async with self._access.changes.turn() as turn:
            rotation = self._access.keys.rotate(person.id, OPERATOR, grace_s=asked.grace_s)
            secret, digest = self._access.programs.secret_for(rotation.key.id)
            shown = (digest,) if person.is_program else ()
            await turn.write((*rotation.records, *shown))
        sentence = keys_messages.rotated(clean(person.name), rotation.grace_s)
        if not person.is_program:
            return sentence
        return keys_messages.secret_renewed(sentence, secret.reveal())

    async def take_key(self, name: str) -> str:
        """Take back one key, by its id, or every key of a person; at once.

        Raises:
            NotUnderstood: There is no such key or person, or it was taken back before.
            NotPermitted: The last key of the last admin. Nothing was changed.
        """
        keys = self._access.keys
        if any(key.id == name for key in keys.all()):
            revocation = keys.revoke(name, OPERATOR)
            owner = self._directory.person(revocation.principal)
            if owner is not None and [key.id for key in self._good(owner)] == [name]:
                self._check_another_admin(owner)
            said = f"The key {name} is not good any more, also after a restart."
            written = await self._access.changes.take_away(revocation.records)
            if self._notices is not None and owner is not None:
                self._notices.key_taken(owner, OPERATOR)
            return noted(said, written=written)
        person = the_one(self._directory, name)
        if not self._good(person):
            raise NotUnderstood(keys_messages.NOTHING_TO_ROTATE)
        self._check_another_admin(person)
        said = f"{clean(person.name)} has no good key any more, also after a restart."
        written = await self._take_away(lambda: self._keys_end(person))
        if self._notices is not None:
            self._notices.revoked(person, OPERATOR)
        return noted(said, written=written)

    def _check_another_admin(self, person: Principal) -> None:
        """See that somebody gives rights here when this person is gone.

        Raises:
            NotPermitted: Nobody would. Locking keeps them out meanwhile, and can be undone.
        """
        if self._access.is_only_admin(person.id):
            raise NotPermitted(last_admin(clean(person.name)))

    def _good(self, person: Principal) -> list[AuthorisationKey]:
        return [key for key in self._access.keys.of(person.id) if key.revoked_ns is None]

    def _keys_end(self, person: Principal) -> tuple[Record, ...]:
        ends = [self._access.keys.revoke(key.id, OPERATOR) for key in self._good(person)]
        return tuple(record for end in ends for record in end.records)

    async def _take_away(self, decide: Callable[[], tuple[Record, ...]]) -> bool:
        return await self._access.changes.take_away(decide(), decide)

    # ---- ends ----

    async def revoke(self, name: str) -> str:
        """Take somebody's access back, at once and for ever. Return what was done.

        What they were given, times they booked, and codes they handed out, end with it.

        Raises:
            NotUnderstood: Nobody, or more than one, is called so.
            NotPermitted: The last admin. Nothing was changed.
        """
        person = the_one(self._directory, name)
        if not self._good(person):
            return f"{clean(person.name)} has no access already. Nothing was changed."
        self._check_another_admin(person)
        written = await self._take_away(lambda: self._everything(person))
        if self._notices is not None:
            self._notices.revoked(person, OPERATOR)
        return noted(
            revoked(person) if written else keys_messages.revoked(clean(person.name)),
            written=written,
        )

    def _everything(self, person: Principal) -> tuple[Record, ...]:
        invitations = self._access.enrolment.invitations
        codes = [made for made in invitations.open() if made.issuer == person.id]
        ended = [record for made in codes for record in invitations.withdraw(made.id, OPERATOR)]
        taken = self._books.authority.grants_book.take(person.id, OPERATOR)
        ahead = self._access.ahead(person.id)
        given = self._access.keys.issued_by(person.id)
        programs = (k for k in given if self._directory.is_program(k.principal))
        made_by = [r for k in programs for r in self._access.keys.revoke(k.id, OPERATOR).records]
        return (*ended, *ahead, *taken, *made_by, *self._keys_end(person))

    async def lock(self, name: str) -> str:
        """Lock somebody at once, whoever else is changing something; what they move stops.

        Raises:
            NotUnderstood: Nobody, or more than one, is called so.
        """
        person = the_one(self._directory, name)
        locks = self._access.locks

        def again() -> tuple[Record, ...]:
            return () if locks.locked(person.id) else locks.lock(person.id, OPERATOR)

        records = locks.lock(person.id, OPERATOR)
        written = await self._access.changes.take_away(records, again)
        if self._notices is not None:
            self._notices.locked(person, OPERATOR)
        return noted(keys_messages.locked(clean(person.name)), written=written)

    async def unlock(self, name: str) -> str:
        """Give a locked person their access back.

        Raises:
            NotUnderstood: Nobody of that name, or not locked.
            RecordUnavailable: Not written; they stay locked.
        """
        person = the_one(self._directory, name)
        async with self._access.changes.turn() as turn:
            await turn.write(self._access.locks.unlock(person.id, OPERATOR, clean(person.name)))
        if self._notices is not None:
            self._notices.unlocked(person, OPERATOR)
        return keys_messages.unlocked(clean(person.name))

    # ---- the clock ----

    async def clock(self, *, accept: bool) -> str:
        """Say whether the machine's clock was set back, or let it count again all the same.

        Raises:
            RecordUnavailable: Not written; nothing changed.
        """
        time = self._access.time
        behind_s = time.behind_s()
        if not time.behind:
            return keys_messages.CLOCK_GOOD
        if not accept:
            return keys_messages.clock_behind(behind_s)
        async with self._access.changes.turn() as turn:
            decided = Decided(act="accept-clock", by=OPERATOR, about="", at_ns=time.wall_ns())
            await turn.write((decided, time.accept()))
        return keys_messages.CLOCK_ACCEPTED


def last_admin(name: str) -> str:
    """Return why the access of somebody cannot end yet, and how it can."""
    return (
        f"{name} is the last admin here. Let another one in first: rosic invite --role admin. "
        f"To keep {name} out at once: rosic lock {name}. Nothing was changed."
    )


def revoked(person: Principal) -> str:
    """Return what is said of somebody whose access has just ended."""
    return f"{clean(person.name)} has no access any more, also after a restart."
