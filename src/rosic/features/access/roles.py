"""``/role guest may omni:move``: roles of the place's own, made and taken back in a chat."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Final

from rosic.core.i18n import joined
from rosic.core.language import clean
from rosic.core.language.keywords import OPTIONS, option_typed
from rosic.core.language.sanitise import fold_word
from rosic.core.message import Button
from rosic.core.policy.compiled import FOR_GOOD_NS
from rosic.core.policy.roles import Role, chains
from rosic.core.policy.scope import FLEET
from rosic.core.role_names import role_typed
from rosic.errors import NotPermitted, NotUnderstood
from rosic.features.access import messages, request_messages, roles_messages
from rosic.features.access.admin_policy import asked_again, sure
from rosic.features.access.limit_line import limit_typed
from rosic.gateway.commands import Reply, asks_first, check_length, check_private
from rosic.gateway.replies import LEAVE
from rosic.organiser.grants import MOST_ROLES

if TYPE_CHECKING:
    from collections.abc import Container

    from rosic.core.identity import PrincipalId
    from rosic.core.policy.roles import RoleRules
    from rosic.core.policy.scope import Fleet
    from rosic.features.access.admin_policy import AdminPolicy
    from rosic.features.access.context import AccessContext
    from rosic.gateway.commands import CommandContext
    from rosic.organiser.grants import CustomRoles


# ---- what a role shall be ----

LONGEST_LINE: Final = 300
MAY, WITH, OFF = "may", "with", "off"
_NAME = re.compile(r"[a-z][a-z0-9_-]{0,31}\Z")
_LIMITS = re.compile(r"\s*,\s+|,(?!\d)|(?<!\d),|\s+(?:and|with|und|mit)\s+", re.IGNORECASE)
_FILLERS = frozenset({"and", ",", "&", "und"})
_WITH = re.compile(r"\s(?:with|mit)\s")
# Words that mean something else where roles are named: in /grant, /invite and here.
_TAKEN = frozenset(
    {
        "a",
        "an",
        "and",
        "as",
        "at",
        "back",
        "code",
        "confirm",
        "everywhere",
        FLEET,
        "for",
        "limit",
        MAY,
        OFF,
        "on",
        "the",
        WITH,
        *OPTIONS,
    }
)


def said_line(text: str) -> str:
    """Return a line as it is read.

    Raises:
        OutOfBounds: It is too long.
    """
    said = " ".join(clean(text).split())
    check_length(said, LONGEST_LINE)
    return said


def can_be_a_role(name: str, fleet: Fleet) -> bool:
    """Whether a name would be read as a role's and as nothing else."""
    other = name in _TAKEN or name in fleet.skills or name in fleet.groups
    return bool(_NAME.match(name)) and not other


def check_name(name: str, fleet: Fleet) -> None:
    """See that a role can be called so.

    Raises:
        NotUnderstood: It cannot: it would be read as something else.
    """
    if not can_be_a_role(name, fleet):
        raise NotUnderstood(roles_messages.no_name(name))


def read_role(text: str, fleet: Fleet, known: Container[str] = ()) -> Role:
    """Read what stands after ``may``. Whether it makes sense, the check of the rulebook says.

    Args:
        text: The words.
        fleet: Whose parameters may be limited.
        known: The roles of this place, which other languages may have words for.
    """
    said, *after = _WITH.split(text, maxsplit=1)
    limits = after[0] if after else ""
    named = [fold_word(word).casefold() for word in said.replace(",", " , ").split()]
    given = [word for word in dict.fromkeys(named) if word not in _FILLERS]
    return Role(
        scopes=tuple(word for word in given if ":" in word),
        includes=tuple(role_typed(word, known) for word in given if ":" not in word),
        limits=tuple(
            dict.fromkeys(
                limit_typed(each, fleet) for each in _LIMITS.split(limits) if each.strip()
            )
        ),
    )


# ---- ``/role`` ----


class RoleCommands:
    """Lists roles; makes, replaces and takes back those that are not the file's.

    Args:
        registry: Who knows people.
        admin_policy: Who may give what.
        rolebook: The roles there are.
    """

    def __init__(
        self, registry: AccessContext, admin_policy: AdminPolicy, rolebook: CustomRoles
    ) -> None:
        self._registry = registry
        self._admin_policy = admin_policy
        self._book = rolebook

    async def role(self, asked: CommandContext) -> Reply:
        """List roles, make one or take one back.

        Raises:
            Refusal: Not theirs, not understood, or others read along; nothing changed.
        """
        check_private(asked)
        by = asked.caller.principal
        self._check_gives(by)
        said = said_line(asked.rest)
        if not said:
            return Reply(roles_messages.listing(self._line(n) for n in self._book.rulebook.roles))
        name, _, rest = said.partition(" ")
        name = fold_word(name).casefold()
        verb, _, what = rest.partition(" ")
        verb = option_typed(verb.casefold())
        meant = role_typed(name, self._book.rulebook.roles)
        if not rest:
            self._check_known(meant)
            return Reply(self._line(meant))
        if verb == OFF and not what:
            return await self._take(by, meant)
        if verb != MAY or not what:
            raise NotUnderstood(roles_messages.HOW)
        return await self._make(asked, name, what)

    def _line(self, name: str) -> str:
        own = name in self._book.own
        return roles_messages.line(name, self._book.rulebook.roles[name], own=own)

    # ---- making ----

    async def _make(self, asked: CommandContext, name: str, what: str) -> Reply:
        by, fleet = asked.caller.principal, self._registry.rights().fleet
        role = read_role(what, fleet, self._book.rulebook.roles)
        agreed = sure(self._registry.rights().policy, "role", name, what)
        if asked.act != agreed:
            before, affected = self._book.own.get(name), self._check(by, name, role)
            yes = Button(roles_messages.MAKE_IT, f"/role {name} {MAY} {what}", act=agreed)
            question = roles_messages.question(name, role, before, self._names(affected))
            return asks_first(
                asked_again(asked.act, question), ((yes, Button(messages.LEAVE_IT, LEAVE)),)
            )
        async with self._registry.changes.turn() as turn:
            affected = self._check(by, name, role)
            now_ns = self._registry.clock.wall_ns()
            await turn.write(self._book.make(name, role, by, now_ns))
        others = {*affected, *self._admin_policy.holders("grant")} - {by}
        told = roles_messages.was_made(self._registry.name(by), name, role)
        self._registry.reach.tell(tuple(sorted(others)), told)
        return Reply(roles_messages.made(name, role))

    def _check(self, by: PrincipalId, name: str, role: Role) -> tuple[PrincipalId, ...]:
        """See that somebody may make a role so; return whose rights it changes.

        Raises:
            Refusal: Why not.
        """
        self._check_gives(by)
        self._check_not_of_the_file(name)
        check_name(name, self._registry.rights().fleet)
        own = self._book.own
        if name not in own and len(own) >= MOST_ROLES:
            raise NotUnderstood(roles_messages.TOO_MANY)
        rules = self._book.made(name, role)
        self._check_sense(name, rules)
        self._check_theirs(by, name, rules)
        if name in own:
            self._check_theirs(by, name, self._book.rulebook)
        affected = self._holders(name, rules)
        if by in affected:
            raise NotPermitted(roles_messages.YOUR_OWN)
        return affected

    def _check_sense(self, name: str, rules: RoleRules) -> None:
        """See that nothing is wrong with it, in the words in which the file's check says so.

        Raises:
            NotUnderstood: Something is. What was wrong elsewhere before is not their concern.
        """
        rights = self._registry.rights()
        before = rights.rule_mistakes(self._book.rulebook)
        for mistake in rights.rule_mistakes(rules):
            if mistake.place[:2] == ("role", name) or mistake not in before:
                what = joined(" ", filter(None, (mistake.sentence, mistake.hint)))
                raise NotUnderstood(request_messages.nothing_done(what))

    def _check_theirs(self, by: PrincipalId, name: str, rules: RoleRules) -> None:
        """See that a role gives no more than somebody may give, and for as long.

        Raises:
            NotPermitted: It does, or it would stay when their own right to give has ended.
        """
        given = self._registry.rights().given_by(rules, name)
        if FLEET in given:
            raise NotPermitted(roles_messages.NO_FLEET)
        now_ns = self._registry.clock.wall_ns()
        if not self._admin_policy.may_make(by, given, rules, name, now_ns):
            what = roles_messages.gives(rules.roles[name])
            raise NotPermitted(messages.too_much(what, self._admin_policy.helpers(by)))
        if not self._admin_policy.may_make(by, given, rules, name, FOR_GOOD_NS):
            raise NotPermitted(
                roles_messages.for_good(self._admin_policy.helpers(by, for_good=True))
            )

    def _check_gives(self, by: PrincipalId) -> None:
        self._admin_policy.check_not_locked(by)
        if not self._admin_policy.gives(by):
            raise NotPermitted(roles_messages.not_yours(self._admin_policy.helpers(by)))

    def _check_not_of_the_file(self, name: str) -> None:
        if name in self._book.file.roles:
            raise NotPermitted(roles_messages.of_the_file(name))

    def _check_known(self, name: str) -> None:
        if name not in self._book.rulebook.roles:
            raise NotUnderstood(roles_messages.unknown(name))

    # ---- taking back ----

    async def _take(self, by: PrincipalId, name: str) -> Reply:
        async with self._registry.changes.turn() as turn:
            self._check_gives(by)
            self._check_not_of_the_file(name)
            self._check_known(name)
            self._check_theirs(by, name, self._book.rulebook)
            self._check_free(name)
            await turn.write(self._book.take(name, by, self._registry.clock.wall_ns()))
        return Reply(roles_messages.taken(name))

    def _check_free(self, name: str) -> None:
        """See that nothing rests on a role.

        Raises:
            NotUnderstood: Something does; says what.
        """
        including = [n for n, r in self._book.rulebook.roles.items() if name in r.includes]
        if including:
            raise NotUnderstood(roles_messages.still_included(name, including))
        if held := self._holders(name, self._book.rulebook):
            raise NotUnderstood(roles_messages.still_held(name, self._names(held)))
        enrolment = self._registry.enrolment
        inviting = [
            made.issuer for made in enrolment.invitations.open() if name in made.given.roles
        ]
        inviting += [
            waiting.pending.issuer
            for waiting in enrolment.applicants.all()
            if name in waiting.pending.given.roles
        ]
        if inviting:
            raise NotUnderstood(roles_messages.still_invited(name, self._names(inviting)))

    def _holders(self, name: str, rules: RoleRules) -> tuple[PrincipalId, ...]:
        """Return everybody who holds a role, or one that includes it; walks everybody."""
        through = {
            outer
            for outer in rules.roles
            if any(name in chain.via for chain in chains(rules.roles, outer))
        }
        now_ns = self._registry.clock.wall_ns()
        return tuple(
            who
            for who, grants in self._registry.rights().people().items()
            if any(
                grant.role in through and (grant.expires_ns is None or now_ns < grant.expires_ns)
                for grant in grants
            )
        )

    def _names(self, people: tuple[PrincipalId, ...] | list[PrincipalId]) -> list[str]:
        return [self._registry.name(who) for who in dict.fromkeys(people)]
