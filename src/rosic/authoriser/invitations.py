"""Every invitation: made, found by the digest of its code, ended, forgotten."""

from __future__ import annotations

import enum
import logging
from hashlib import blake2b
from math import isfinite
from typing import TYPE_CHECKING, Final

import msgspec

from rosic.authoriser import messages as words
from rosic.authoriser.invite_codes import (
    PEPPER_BYTES,
    codes_in,
    digest,
    new_code,
    normal,
    reads_as_stop,
)
from rosic.core.i18n import said
from rosic.core.identity import DIGEST_BYTES, OPERATOR, RECORD_ID_BYTES, PrincipalId
from rosic.core.language.sanitise import clean_name
from rosic.core.policy.limits import parse_limit
from rosic.core.policy.roles import Grant
from rosic.core.policy.scope import READ, Scope
from rosic.core.records import Decided, Fact, Letter, Record
from rosic.core.secret import Secret
from rosic.core.time_units import DAY_NS, DAY_S
from rosic.errors import NotUnderstood, OutOfBounds, TooManyRequests

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

    from rosic.authoriser.monotonic_clock import MonotonicWallClock
    from rosic.contracts.clock import Entropy


# ---- one invitation ----

CODE_TTL_S: Final = 600.0


class InvitationState(enum.Enum):
    """What became of an invitation."""

    OPEN = "open"
    USED = "used"
    BURNT = "burnt"
    WITHDRAWN = "withdrawn"


class InvitedRights(msgspec.Struct, frozen=True, kw_only=True, omit_defaults=True):
    """What somebody is given: roles, perhaps bare scopes, where, how far and for how long.

    Attributes:
        robots: The roles only there, patterns or groups; empty: wherever they reach.
        scopes: Given besides, or instead.
        limits: Hold for everything given here.
        lasts_s: From the moment somebody is in; None: until taken back.
    """

    roles: tuple[str, ...] = ()
    robots: tuple[str, ...] = ()
    scopes: tuple[str, ...] = ()
    limits: tuple[str, ...] = ()
    lasts_s: float | None = None

    @property
    def standing(self) -> bool:
        """Whether it is roles without end and bounds: then they are the person's own.

        Anything else is a grant, which the organiser keeps and which ends by itself.
        """
        return self.lasts_s is None and not (self.robots or self.scopes or self.limits)

    @property
    def words(self) -> str:
        """Return it as people read it: ``operator on kuka1 for 2 hours``."""
        skills = [scope.rpartition(":")[::2] for scope in self.scopes]
        return words.given(self.roles, self.robots, skills, self.limits, self.lasts_s)

    def grants(self, ids: Iterator[str], now_ns: int) -> tuple[Grant, ...]:
        """Return it as the organiser keeps it; nothing for what is the person's own.

        Args:
            ids: One for each grant.
            now_ns: Wall clock.
        """
        if self.standing:
            return ()
        until_ns = None if self.lasts_s is None else now_ns + int(self.lasts_s * 1e9)
        found = [
            Grant(
                id=next(ids),
                role=role,
                robots=self.robots,
                limits=self.limits,
                expires_ns=until_ns,
            )
            for role in self.roles
        ]
        if self.scopes:
            bare = Grant(id=next(ids), scopes=self.scopes, limits=self.limits, expires_ns=until_ns)
            found.append(bare)
        return tuple(found)


class InvitationRequest(msgspec.Struct, frozen=True, kw_only=True):
    """What an invitation shall be.

    Attributes:
        code_ttl_s: How long the code is good.
        needs_confirmation: Whether an admin has to tap; None: as the roles demand.
        name: How the newcomer shall be shown; empty: as their messenger says.
    """

    given: InvitedRights
    code_ttl_s: float = CODE_TTL_S
    needs_confirmation: bool | None = None
    name: str = ""


class Invitation(msgspec.Struct, frozen=True, kw_only=True):
    """The body of the fact; its key is the id. Nothing in it tells the code or names anybody.

    Attributes:
        digest: Of the code, keyed.
        expires_ns: Until when the code is good; wall clock.
        first_admin: Good only while nobody is admin.
        user: Who used it.
    """

    id: str
    digest: bytes
    given: InvitedRights
    issuer: PrincipalId
    issued_ns: int
    expires_ns: int
    needs_confirmation: bool
    first_admin: bool = False
    state: InvitationState = InvitationState.OPEN
    user: PrincipalId = ""


class NewInvitation(msgspec.Struct, frozen=True):
    """A new invitation with its code, which is shown once and kept nowhere.

    Attributes:
        records: To be written; then each fact among them is applied.
        sentence: For whoever invites; holds the code, so it is never logged.
    """

    invitation: Invitation
    code: Secret
    records: tuple[Record, ...]

    @property
    def sentence(self) -> str:
        """Return what whoever invites reads."""
        code, made = self.code.reveal(), self.invitation
        if made.first_admin:
            return words.first_admin(code)
        lasts_s = (made.expires_ns - made.issued_ns) / 1e9
        return words.invitation(made.given.words, code, lasts_s)


# ---- all invitations ----

KIND: Final = "invitation"
PEPPER: Final = "code-key"
OPEN_AT_MOST: Final = 1_000
CODE_TTL_MAX_S: Final = 7.0 * DAY_S
FIRST_ADMIN_TTL_S: Final = float(DAY_S)
RIGHT_MAX_S: Final = 10.0 * 366 * DAY_S
# A used or expired invitation is told apart from one that never was, for the count of attempts.
KEPT_NS: Final = 7 * DAY_NS
ADMIN: Final = "admin"
CONFIRMED_ROLES: Final = frozenset({"senior", ADMIN})

_log = logging.getLogger(__name__)


_encode = msgspec.msgpack.Encoder().encode
_decode = msgspec.msgpack.Decoder(Invitation).decode


class Invitations:
    """Every invitation that is open, or ended not long ago; found by the digest of its code."""

    def __init__(self, time: MonotonicWallClock, entropy: Entropy) -> None:
        self._time = time
        self._entropy = entropy
        self._pepper: bytes | None = None
        self._known: dict[str, Invitation] = {}
        self._names: dict[str, str] = {}
        self._by_digest: dict[bytes, str] = {}
        self._searched: tuple[str, dict[str, bool]] = ("", {})

    def find(self, code: str) -> Invitation | None:
        """Return the invitation of a code, whatever became of it."""
        symbols = normal(code)
        if symbols is None or self._pepper is None:
            return None
        found = self._by_digest.get(digest(self._pepper, symbols))
        return None if found is None else self._known[found]

    def shown_in(self, text: str) -> tuple[str, ...]:
        """Return the code of every invitation that a text shows, whatever became of it.

        A message is searched for burning, with its links, and for what is kept of it, without them:
        what was looked up in the last text is not looked up again.
        """
        if self._pepper is None or not self._known:
            return ()
        last, looked_up = self._searched
        if last != text:
            pepper, known = self._pepper, self._by_digest
            looked_up = {
                code: looked_up[code] if code in looked_up else digest(pepper, code) in known
                for code in codes_in(text)
            }
            self._searched = (text, looked_up)
        return tuple(code for code, shown in looked_up.items() if shown)

    def is_good(self, invitation: Invitation) -> bool:
        """Whether it is open and its code has not expired."""
        return (
            invitation.state is InvitationState.OPEN
            and self._time.wall_ns() < invitation.expires_ns
        )

    def open(self) -> tuple[Invitation, ...]:
        """Return the invitations whose code is good; looks at all of them."""
        return tuple(made for made in self._known.values() if self.is_good(made))

    def name_for(self, invitation: Invitation) -> str:
        """Return the name that the inviting admin chose; empty for none."""
        return self._names.get(invitation.id, "")

    # ---- decisions: nothing changes until the facts are applied ----

    def invite(
        self, wanted: InvitationRequest, by: PrincipalId, *, first_admin: bool = False
    ) -> NewInvitation:
        """Return an invitation and its code.

        Whether ``by`` may give these roles is decided before.

        Raises:
            NotUnderstood: No role, or a scope that is none. Nothing changed.
            OutOfBounds: A time that is no time. Nothing changed.
            TooManyRequests: Too many are open. Nothing changed.
        """
        self._check(wanted)
        pepper = self._pepper or self._entropy.token(PEPPER_BYTES)
        code = new_code(self._entropy)
        while (
            reads_as_stop(code)
            or (kept := digest(pepper, code.reveal().replace("-", ""))) in self._by_digest
        ):
            code = new_code(self._entropy)
        now_ns = self._time.wall_ns()
        needs = wanted.needs_confirmation
        made = Invitation(
            id=f"i{self._entropy.token(RECORD_ID_BYTES).hex()}",
            digest=kept,
            given=wanted.given,
            issuer=by,
            issued_ns=now_ns,
            expires_ns=now_ns + int(wanted.code_ttl_s * 1e9),
            needs_confirmation=bool(CONFIRMED_ROLES & set(wanted.given.roles))
            if needs is None
            else needs,
            first_admin=first_admin,
        )
        name = clean_name(wanted.name)
        letter = Letter(by, name.encode()) if name else None
        fact = Fact(kind=KIND, key=made.id, body=_encode(made), letter=letter)
        records: list[Record] = [self.decided("invite", by, made)]
        if self._pepper is None:
            secret = Letter(OPERATOR, pepper)
            records.append(Fact(kind=PEPPER, key=PEPPER, body=b"\x01", letter=secret))
        return NewInvitation(made, code, (*records, fact))

    def first_admin(self) -> NewInvitation:
        """Return the invitation of the first admin; those of earlier starts end."""
        given = InvitedRights(roles=(ADMIN,))
        wanted = InvitationRequest(
            given=given, code_ttl_s=FIRST_ADMIN_TTL_S, needs_confirmation=False
        )
        offer = self.invite(wanted, OPERATOR, first_admin=True)
        old = tuple(
            self.ended(made, InvitationState.WITHDRAWN)
            for made in self._known.values()
            if made.first_admin and made.state is InvitationState.OPEN
        )
        return msgspec.structs.replace(offer, records=(*offer.records, *old))

    def withdraw(self, invitation: str, by: PrincipalId) -> tuple[Record, ...]:
        """Return what takes an open invitation back.

        Raises:
            NotUnderstood: There is no such invitation, or it is not open. Nothing changed.
        """
        made = self._known.get(invitation)
        if made is None or not self.is_good(made):
            raise NotUnderstood(words.NO_SUCH)
        return (self.decided("withdraw", by, made), self.ended(made, InvitationState.WITHDRAWN))

    def ended(self, invitation: Invitation, state: InvitationState, user: PrincipalId = "") -> Fact:
        """Return the fact that an invitation is over; the name in it is forgotten."""
        over = msgspec.structs.replace(invitation, state=state, user=user)
        return Fact(kind=KIND, key=over.id, body=_encode(over))

    def decided(self, act: str, by: PrincipalId, invitation: Invitation) -> Decided:
        """Return the administrative act about an invitation."""
        body = blake2b(_encode(invitation), digest_size=DIGEST_BYTES).digest()
        return Decided(act=act, by=by, about=invitation.id, at_ns=self._time.wall_ns(), digest=body)

    def stale(self) -> tuple[Fact, ...]:
        """Return what forgets the invitations that ended long ago."""
        before_ns = self._time.wall_ns() - KEPT_NS
        return tuple(
            Fact(kind=KIND, key=made.id, body=b"")
            for made in self._known.values()
            if made.expires_ns < before_ns
        )

    def _check(self, wanted: InvitationRequest) -> None:
        given = wanted.given
        if not (given.roles or given.scopes) or not all(given.roles):
            raise NotUnderstood(words.NO_ROLE)
        try:
            _check_bounds(given)
        except ValueError as error:
            raise NotUnderstood(said("{error}. Nothing was done.", error=str(error))) from error
        right_s = RIGHT_MAX_S if given.lasts_s is None else given.lasts_s
        for span_s, longest_s in ((right_s, RIGHT_MAX_S), (wanted.code_ttl_s, CODE_TTL_MAX_S)):
            if not (isfinite(span_s) and 1 <= span_s <= longest_s):
                raise OutOfBounds(words.BAD_SPAN)
        if len(self._known) >= OPEN_AT_MOST and len(self.open()) >= OPEN_AT_MOST:
            raise TooManyRequests(words.TOO_MANY_OPEN, retry_after_s=wanted.code_ttl_s)

    # ---- state ----

    def restore(self, facts: Iterable[Fact]) -> None:
        """Take over every invitation that is written down."""
        for fact in facts:
            self.apply(fact)

    def apply(self, fact: Fact) -> None:
        """Let a fact be so. An invitation that cannot be read lets nobody in."""
        self._searched = ("", {})
        if fact.kind == PEPPER:
            self._pepper = fact.letter.content if fact.letter is not None else None
            return
        self._drop(fact.key)
        if not fact.body:
            return
        try:
            made = _checked(_decode(fact.body), fact.key)
        except (msgspec.MsgspecError, ValueError):
            _log.warning("an invitation cannot be read; its code lets nobody in")
            return
        self._known[made.id] = made
        self._by_digest[made.digest] = made.id
        if fact.letter is not None:
            self._names[made.id] = fact.letter.content.decode(errors="replace")

    def _drop(self, invitation: str) -> None:
        before = self._known.pop(invitation, None)
        self._names.pop(invitation, None)
        if before is not None:
            self._by_digest.pop(before.digest, None)


def _checked(invitation: Invitation, key: str) -> Invitation:
    """Return an invitation that is what its key says, with bounds that are some."""
    if invitation.id != key:
        raise ValueError("an invitation stands under another's key")
    _check_bounds(invitation.given)
    return invitation


def _check_bounds(given: InvitedRights) -> None:
    """Let pass what can be kept.

    Raises:
        ValueError: A scope, a robot or a limit that is none.
    """
    for robot in given.robots:
        Scope.parse(f"{robot}:{READ}")
    for scope in given.scopes:
        Scope.parse(scope)
    for limit in given.limits:
        parse_limit(limit)
