"""``/role guest may omni:move``: roles of the place's own, made and taken back in a chat."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosic.core.i18n import joined
from rosic.core.language.option_words import option_typed
from rosic.core.language.sanitise import fold_word
from rosic.core.message import Button
from rosic.core.policy.roles import chains
from rosic.core.policy.scope import FLEET
from rosic.core.role_names import role_typed
from rosic.errors import NotPermitted, NotUnderstood
from rosic.features.access import messages, request_messages, roles_messages
from rosic.features.access.admin_policy import FOR_GOOD_NS
from rosic.features.access.names import asked_again, sure
from rosic.features.access.role_line import MAY, OFF, check_name, read_role, said_line
from rosic.gateway.builtin_commands import Reply
from rosic.gateway.office import check_private
from rosic.gateway.replies import LEAVE
from rosic.organiser.roles import MOST_ROLES

if TYPE_CHECKING:
    from rosic.core.identity import PrincipalId
    from rosic.core.policy.roles import Role, RoleRules
    from rosic.features.access.admin_policy import AdminPolicy
    from rosic.features.access.context import AccessContext
    from rosic.gateway.office import CommandContext
    from rosic.organiser.roles import CustomRoles


class RoleCommands:
    """Lists roles; makes, replaces and takes back those that are not the file's.

    Args:
        registry: Who knows people.
        powers: Who may give what.
        rolebook: The roles there are.
    """

    def __init__(self, registry: AccessContext, powers: AdminPolicy, rolebook: CustomRoles) -> None:
        self._registry = registry
        self._powers = powers
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
            return Reply(
                asked_again(asked.act, question), ((yes, Button(messages.LEAVE_IT, LEAVE)),)
            )
        async with self._registry.changes.turn() as turn:
            affected = self._check(by, name, role)
            now_ns = self._registry.clock.wall_ns()
            await turn.write(self._book.make(name, role, by, now_ns))
        others = {*affected, *self._powers.holders("grant")} - {by}
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
        if not self._powers.may_make(by, given, rules, name, now_ns):
            what = roles_messages.gives(rules.roles[name])
            raise NotPermitted(messages.too_much(what, self._powers.helpers(by)))
        if not self._powers.may_make(by, given, rules, name, FOR_GOOD_NS):
            raise NotPermitted(roles_messages.for_good(self._powers.helpers(by, for_good=True)))

    def _check_gives(self, by: PrincipalId) -> None:
        self._powers.check_not_locked(by)
        if not self._powers.gives(by):
            raise NotPermitted(roles_messages.not_yours(self._powers.helpers(by)))

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
