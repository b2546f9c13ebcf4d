"""One invitation: what was asked for, what is kept of it, and its code, shown once."""

from __future__ import annotations

import enum
from typing import TYPE_CHECKING, Final

import msgspec

from rosic.authoriser import messages as words
from rosic.core.identity import PrincipalId
from rosic.core.policy.roles import Grant
from rosic.core.records import Record
from rosic.core.secret import Secret

if TYPE_CHECKING:
    from collections.abc import Iterator

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
