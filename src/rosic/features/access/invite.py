"""``operator kuka1 with speed <= 0.2 m/s for 2h code 10m as Cy Young``: what somebody is given.

Total and linear: each word is looked at by a fixed number of rules.
"""

from __future__ import annotations

import asyncio
import re
from functools import partial
from typing import TYPE_CHECKING

from rosic.authoriser.invitations import CODE_TTL_S, InvitationRequest, InvitedRights
from rosic.authoriser.invite_codes import (
    TERMINAL,
    drawn,
    join_text,
    only_here,
    qr_code,
    qr_text,
)
from rosic.authoriser.messages import ONLY_HERE
from rosic.core.i18n import joined
from rosic.core.language import clean, clean_name
from rosic.core.language.keywords import decimals_typed, option_typed
from rosic.core.language.sanitise import fold_word
from rosic.core.language.suggestions import did_you_mean
from rosic.core.language.time_tokens import length_said
from rosic.core.message import Attachment
from rosic.core.policy.roles import Grant
from rosic.core.policy.scope import FLEET, READ
from rosic.core.robot.skill import SkillClass
from rosic.core.role_names import role_typed
from rosic.errors import NotUnderstood, OutOfBounds
from rosic.features.access import messages, request_messages, roles_messages
from rosic.features.access.admin_policy import INVITE, PEOPLE
from rosic.features.access.limit_line import limit_typed
from rosic.features.access.roles import MAY, can_be_a_role
from rosic.gateway.commands import Reply, check_length, check_private

if TYPE_CHECKING:
    from collections.abc import Callable, Collection

    from rosic.contracts.messenger import Messenger
    from rosic.core.policy.permissions import Permissions
    from rosic.core.secret import Secret
    from rosic.features.access.admin_policy import AdminPolicy
    from rosic.features.access.context import AccessContext
    from rosic.gateway.commands import CommandContext

LONGEST_LINE = 300
LENGTH_WORDS = 4
SHORTEST_S = 1.0
_WITH = "with"
_FILLERS = frozenset(
    {"a", "an", "and", "as", "at", "everywhere", "on", "the", "with", "limit", ",", "&"}
)
_LASTS, _CODE, _CONFIRM = "for", "code", "confirm"
_SIGNS = frozenset("<>=≤≥")
_NUMBER = re.compile(r".*[<>=≤≥]\s*[+-]?\.?\d")
_SCOPE = re.compile(r"[a-z0-9_*?-]+:[a-z0-9_*?-]+\Z", re.ASCII)
_AS = re.compile(r"\s+(?:as|als)\s+", re.IGNORECASE)


def read_invitation(text: str, rights: Permissions) -> InvitationRequest:
    """Read what an invitation shall give.

    Args:
        text: After ``/invite``.
        rights: Which roles and robots there are.

    Raises:
        NotUnderstood: Which word is none; offers the line that was meant.
        OutOfBounds: The line is too long.
    """
    said = clean(text).replace("\n", " ").strip()
    check_length(said, LONGEST_LINE)
    before, *after = _AS.split(said, maxsplit=1)
    reading = _Reading(before, rights)
    if after:
        reading.name(after[0])
    return reading.wanted()


def read_grant(text: str, rights: Permissions) -> InvitedRights:
    """Read what somebody who is in already shall be given.

    Roles and robots, or single rights such as ``omni:move``; limits, and how long.

    Raises:
        NotUnderstood: Which word is none.
        OutOfBounds: The line is too long, or it is for no time.
    """
    said = clean(text).replace("\n", " ").strip()
    check_length(said, LONGEST_LINE)
    given = _Reading(said, rights, inviting=False).wanted().given
    if given.lasts_s is not None and given.lasts_s < SHORTEST_S:
        raise OutOfBounds(request_messages.no_time())
    return given


class _Reading:
    """Reads the words one after another."""

    def __init__(self, before: str, rights: Permissions, *, inviting: bool = True) -> None:
        self._rights = rights
        self._inviting = inviting
        self._limits: list[str] = []
        self._confirm: bool | None = None
        self._roles = {name.casefold(): name for name in rights.rulebook.roles}
        self._lengths: dict[str, float] = {}
        self._given: list[str] = []
        self._where: list[str] = []
        self._scopes: list[str] = []
        self._name = ""
        self._said = before
        self._walk(_raw(before))

    def _walk(self, raw: list[str]) -> None:
        low = [self._meant(word) for word in _folded(raw)]
        at = 0
        while at < len(low):
            word = low[at]
            if self._is_length(word):
                at += 1 + self._length(word, low[at + 1 : at + 1 + LENGTH_WORDS])
            elif _begins_limit(low, at):
                at += self._limit(raw, low, at)
            elif _limits_a_scope(low, at):
                at += 1 + self._limit(raw, low, at + 1, word)
            else:
                self._word(word)
                at += 1

    def _is_length(self, word: str) -> bool:
        return word == _LASTS or (word == _CODE and self._inviting)

    def _word(self, word: str) -> None:
        role = role_typed(word, self._roles)
        if role in self._roles:
            self._given.append(self._roles[role])
        elif word != FLEET and self._rights.fleet.robots(word):
            self._where.append(word)
        elif not self._inviting and _SCOPE.match(word):
            self._scopes.append(word)
        elif word == _CONFIRM and self._inviting:
            self._confirm = True
        elif word not in _FILLERS:
            raise self._unknown(word)

    def _meant(self, word: str) -> str:
        """Return what a word says in English; a name of this place stays what it is."""
        named = word in self._roles or word in self._rights.fleet.skills
        return word if named or word in self._rights.fleet.groups else option_typed(word)

    def _limit(self, raw: list[str], low: list[str], begin: int, scope: str = "") -> int:
        """Read ``speed <= 0.2 m/s``, perhaps of one right only; return how many words it took."""
        end = begin + 1
        while end < len(low) and not _NUMBER.match(" ".join(low[begin:end])):
            end += 1
        while end < len(low) and not self._means(low[end]) and not _begins_limit(low, end):
            end += 1
        said = " ".join([scope, low[begin], *raw[begin + 1 : end]])
        self._limits.append(limit_typed(said.strip(), self._rights.fleet))
        return end - begin

    def _means(self, word: str) -> bool:
        """Whether a word says something by itself, so that it is no unit."""
        known = {_LASTS, _CODE, _CONFIRM}
        if word in known or word in _FILLERS - {"a"} or _SCOPE.match(word):
            return True
        if role_typed(word, self._roles) in self._roles:
            return True
        return bool(self._rights.fleet.robots(word))

    def _length(self, which: str, low: list[str]) -> int:
        """Read how long; return how many words that took."""
        if which in self._lengths:
            raise NotUnderstood(messages.twice_how_long(which))
        seconds, used = length_said(low)
        if not used:
            count = 2 if low and low[0].isdecimal() else 1
            raise NotUnderstood(messages.no_length(which, " ".join(low[:count])))
        self._lengths[which] = seconds
        return used

    def name(self, text: str) -> None:
        """Read a name; how long, and the code's time, may stand after it."""
        raw = _raw(text)
        low = list(map(option_typed, _folded(raw)))
        ends = len(low)
        for at in range(1, len(low)):
            if low[at] in {_LASTS, _CODE} and length_said(low[at + 1 : at + 1 + LENGTH_WORDS])[1]:
                ends = at
                break
        self._name = clean_name(" ".join(raw[:ends]))
        self._walk(raw[ends:])

    def wanted(self) -> InvitationRequest:
        """Return what was said."""
        if not self._given and not self._scopes:
            raise NotUnderstood(messages.no_role(tuple(self._roles.values())))
        if self._where and not self._given:
            raise NotUnderstood(request_messages.says_where(self._scopes[0]))
        given = InvitedRights(
            roles=tuple(dict.fromkeys(self._given)),
            robots=tuple(dict.fromkeys(self._where)),
            scopes=tuple(dict.fromkeys(self._scopes)),
            limits=tuple(dict.fromkeys(self._limits)),
            lasts_s=self._lengths.get(_LASTS),
        )
        self._check(given)
        return InvitationRequest(
            given=given,
            code_ttl_s=self._lengths.get(_CODE, CODE_TTL_S),
            name=self._name,
            needs_confirmation=self._confirm,
        )

    def _check(self, given: InvitedRights) -> None:
        """See that this can be given, in the words in which the command line says so.

        Raises:
            NotUnderstood: A limit that cannot be read, or limits nothing.
        """
        grants = [Grant(role=r, robots=given.robots, limits=given.limits) for r in given.roles]
        if given.scopes:
            grants.append(Grant(scopes=given.scopes, limits=given.limits))
        for grant in grants:
            for mistake in self._rights.mistakes(grant):
                what = joined(" ", filter(None, (mistake.sentence, mistake.hint)))
                raise NotUnderstood(request_messages.nothing_done(what))

    def _unknown(self, word: str) -> NotUnderstood:
        fleet = self._rights.fleet
        close = did_you_mean(word, (*self._roles, *fleet.skills, *fleet.groups))
        said = self._said if self._inviting else ""
        offers = tuple(f"/invite {_with(said, word, other)}" for other in close) if said else ()
        sentence = messages.no_role_no_robot(word, close, tuple(self._roles.values()))
        person = "" if close or not said else self._person(word)
        if person:
            how = messages.invite_as(person, tuple(self._roles.values()))
            return NotUnderstood(joined("\n", (sentence, how)))
        scope = "" if close else self._example_of(word)
        if not scope:
            return NotUnderstood(sentence, offers=offers)
        choice = (roles_messages.make_a_role(word), f"/role {word} {MAY} {scope}")
        how = roles_messages.to_make(word, scope)
        return NotUnderstood(joined("\n", (sentence, how)), choices=(choice,))

    def _person(self, word: str) -> str:
        """Return a word as it was typed if it looks like somebody's name; empty: it does not."""
        typed = (raw for raw in _raw(self._said) if fold_word(raw).casefold() == word)
        return clean_name(next((raw for raw in typed if raw.istitle()), ""))

    def _example_of(self, word: str) -> str:
        """Return what a role of this name might give; empty: none can be made of it here."""
        fleet = self._rights.fleet
        meant = (robot for said in _folded(_raw(self._said)) for robot in fleet.robots(said))
        robot = next((robot for robot in (*meant, *fleet.skills) if robot in fleet.skills), "")
        if not robot or self._given or not can_be_a_role(word, fleet):
            return ""
        moving = [name for name, s in fleet.skills[robot].items() if s.kind is SkillClass.MOTION]
        return f"{robot}:{next(iter(moving), READ)}"


def _with(said: str, word: str, other: str) -> str:
    return " ".join(other if fold_word(w).casefold() == word else w for w in said.split())


def _raw(text: str) -> list[str]:
    return decimals_typed(text).replace(",", " , ").split()


def _folded(raw: list[str]) -> list[str]:
    return [fold_word(word).casefold() for word in raw]


def _begins_limit(low: list[str], at: int) -> bool:
    """Whether a sign of comparison stands in this word or at the head of the next."""
    if not low[at][0].isalpha():
        return False
    following = low[at + 1][:1] if at + 1 < len(low) else ""
    return bool(_SIGNS & {*low[at], following})


def _limits_a_scope(low: list[str], at: int) -> bool:
    """Whether a single right stands here only for what limits it: ``with omni:move speed <= 1``."""
    after_with = at > 0 and low[at - 1] == _WITH and bool(_SCOPE.match(low[at]))
    return after_with and at + 1 < len(low) and _begins_limit(low, at + 1)


# ---- ``/invite`` ----

INVITATION = "invitation"
"""What a message holds that goes once nobody can be let in by it."""


def _no_link(_messenger: Messenger, _code: Secret) -> str:
    return ""


async def qr_picture(messenger: Messenger, name: str, text: str) -> Attachment | None:
    """Return a picture to be scanned; nothing where no file can be sent. It shows a secret."""
    await asyncio.sleep(0)  # what came before, the code and the picture are a step each
    code = qr_code(text)
    await asyncio.sleep(0)
    picture = drawn(code)
    if len(picture) > messenger.file_bytes:
        return None
    return Attachment(name, "image/png", picture)


class InviteCommands:
    """Makes invitations and takes them back.

    Args:
        registry: Who knows people.
        admin_policy: Who may.
        platforms: Of all that people talk by here.
        link: Returns the link that hands a code in on the messenger where it was asked for; empty
            where there is none. It shows a secret.
    """

    def __init__(
        self,
        registry: AccessContext,
        admin_policy: AdminPolicy,
        platforms: Collection[str],
        *,
        link: Callable[[Messenger, Secret], str] = _no_link,
    ) -> None:
        self._registry = registry
        self._admin_policy = admin_policy
        self._platforms = platforms
        self._link = link

    async def invite(self, asked: CommandContext) -> Reply:
        """Make an invitation, take one back, or open joining again.

        Raises:
            Refusal: Others read along, not theirs to give, or not understood.
        """
        by, rest = asked.caller.principal, asked.rest.strip()
        check_private(asked)
        self._admin_policy.check(by, INVITE)
        if not rest:
            rights = self._registry.rights()
            return Reply(messages.how_to_invite(tuple(rights.rulebook.roles), rights.fleet.skills))
        first, _, other = rest.partition(" ")
        if first == messages.BACK:
            return await self._take_back(asked, other.strip())
        if rest == messages.REOPEN:
            return await self._reopen(asked)
        return await self._invite(asked, rest)

    async def _invite(self, asked: CommandContext, rest: str) -> Reply:
        by = asked.caller.principal
        wanted = read_invitation(rest, self._registry.rights())
        if only_here(self._platforms):
            raise NotUnderstood(ONLY_HERE)
        async with self._registry.changes.turn() as turn:
            self._admin_policy.check(by, INVITE)
            self._admin_policy.check_give(by, wanted.given, within_s=wanted.code_ttl_s)
            offer = self._registry.enrolment.invitations.invite(wanted, by)
            await turn.write(offer.records)
        link = self._link(asked.messenger, offer.code)
        text = join_text(offer.code)
        lines = [offer.sentence, messages.how_to_join(link, text)]
        picture = None
        if asked.messenger.platform == TERMINAL:
            lines.append(qr_text(link or text))
        else:
            picture = await qr_picture(asked.messenger, "invitation.png", link or text)
        made = offer.invitation
        keep = partial(
            self._registry.retracting.keep, f"{INVITATION} {made.id}", by, made.expires_ns
        )
        row = (messages.take_back_button(made.id, wanted.code_ttl_s),)
        return Reply(joined("\n", lines), (row,), picture, landed=keep)

    async def _take_back(self, asked: CommandContext, invitation: str) -> Reply:
        by, made = asked.caller.principal, self._registry.enrolment.invitations
        self._admin_policy.check(by, INVITE)
        written = await self._registry.changes.take_away(made.withdraw(invitation, by))
        return Reply(messages.noted(messages.TAKEN_BACK, written=written), anew=True)

    async def _reopen(self, asked: CommandContext) -> Reply:
        """Let everybody have all their tries again after too many wrong codes."""
        by = asked.caller.principal
        async with self._registry.changes.turn() as turn:
            self._admin_policy.check(by, PEOPLE)
            await turn.write(self._registry.enrolment.reopen(by))
        return Reply(messages.REOPENED)
