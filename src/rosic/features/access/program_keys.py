"""``/key``: keys of programs, made, listed, replaced and taken back.

A key lets a program in that nobody watches. So it is shown once, to one person, in private; it
ends; and whoever makes or replaces one may give all that the program holds, for which the secret
speaks.
"""

from __future__ import annotations

import re
from functools import partial
from typing import TYPE_CHECKING, Final

import msgspec

from rosic.authoriser import keys_messages
from rosic.authoriser.invitations import InvitedRights
from rosic.contracts.messenger import retract_of
from rosic.core.i18n import filled, joined
from rosic.core.language import clean, clean_name
from rosic.core.language.keywords import option_typed
from rosic.core.language.time_tokens import length_said
from rosic.core.message import Button
from rosic.core.policy.roles import chains
from rosic.core.policy.scope import FLEET, GRANT
from rosic.core.time_units import DAY_S, MINUTE_NS
from rosic.errors import NotPermitted, NotUnderstood
from rosic.features.access import messages
from rosic.features.access import program_key_messages as words
from rosic.features.access.admin_policy import PEOPLE, asked_again, sure
from rosic.features.access.invite import LONGEST_LINE, read_grant
from rosic.gateway.commands import Reply, asks_first, check_length, check_private
from rosic.gateway.replies import LEAVE
from rosic.gateway.requests import check_command_fresh

if TYPE_CHECKING:
    from collections.abc import Callable

    from rosic.authoriser.program_keys import ProgramKeys
    from rosic.core.identity import Principal, PrincipalId
    from rosic.core.policy.roles import Grant, RoleRules
    from rosic.core.records import Record
    from rosic.features.access.admin_policy import AdminPolicy
    from rosic.features.access.context import AccessContext
    from rosic.gateway.commands import CommandContext

PROGRAM_KEY: Final = "program-key"
"""What a message holds that goes soon after it was shown."""
SHOWN_NS: Final = 15 * MINUTE_NS
LASTS_S: Final = 90.0 * DAY_S
"""A key that is made in a chat ends, whether or not somebody says when."""
GRACE_S: Final = DAY_S
LISTED_AT_MOST: Final = 20
BUTTONS_AT_MOST: Final = 8
NOW: Final = frozenset({"now", "jetzt", "sofort"})
_NAMED: Final = re.compile(r'\s*(?:["„“]([^"„“”]+)["“”]|(\S+))\s*(.*)', re.DOTALL)
_FOR: Final = re.compile(r"\s+(?:for|für)\s+", re.IGNORECASE)


def check_for_robots_alone(rules: RoleRules, given: InvitedRights) -> None:
    """See that what a program is given is about robots, and about nobody's rights.

    Raises:
        NotUnderstood: It is about people, or about the place.
    """
    reached = (chain.last for role in given.roles for chain in chains(rules.roles, role))
    scopes = [*given.scopes, *(scope for role in reached for scope in role.scopes)]
    if any(s.startswith(f"{FLEET}:") or s.endswith(f":{GRANT}") for s in scopes):
        raise NotUnderstood(keys_messages.NEVER_ADMIN)


class ProgramKeyCommands:
    """Makes, lists, replaces and ends keys of programs.

    Args:
        registry: Who knows people.
        admin_policy: Who may give what.
        programs: Makes programs and their secrets.
        rules: Returns the roles there are.
    """

    def __init__(
        self,
        registry: AccessContext,
        admin_policy: AdminPolicy,
        programs: ProgramKeys,
        rules: Callable[[], RoleRules],
    ) -> None:
        self._registry, self._admin_policy = registry, admin_policy
        self._programs, self._rules = programs, rules
        self._directory, self._keys = registry.authoriser.directory, registry.keys

    async def key(self, asked: CommandContext) -> Reply:
        """Do what is said after ``/key``; alone, say how.

        Raises:
            Refusal: Others read along, not theirs to give, or not understood. Nothing changed.
        """
        check_private(asked)
        by = asked.caller.principal
        if asked.caller.is_program:
            raise NotPermitted(words.FOR_A_PERSON)
        self._admin_policy.check_not_locked(by)
        check_length(asked.rest, LONGEST_LINE)
        verb, _, rest = clean(asked.rest).replace("\n", " ").strip().partition(" ")
        verb, rest = _VERBS.get(verb.casefold(), verb.casefold()), rest.strip()
        if verb == words.LIST:
            return self._list(by)
        if verb == words.FORGET:
            return self._forget(asked)
        if verb == words.CREATE:
            return await self._create(asked, rest)
        if verb == words.ROTATE:
            return await self._rotate(asked, rest)
        if verb == words.REVOKE:
            return await self._revoke(asked, rest)
        if verb:
            raise NotUnderstood(words.HOW)
        return Reply(words.HOW)

    # ---- making ----

    async def _create(self, asked: CommandContext, rest: str) -> Reply:
        check_command_fresh(asked.inbound, f"/key {words.CREATE} {rest}")
        by, (name, what) = asked.caller.principal, _named(rest)
        if not (name and what):
            raise NotUnderstood(words.NO_NAME)
        given = read_grant(what, self._registry.rights())
        if given.lasts_s is None:
            given = msgspec.structs.replace(given, lasts_s=LASTS_S)
        check_for_robots_alone(self._rules(), given)
        async with self._registry.changes.turn() as turn:
            self._admin_policy.check_not_locked(by)
            self._admin_policy.check_give(by, given)
            made = self._programs.enrol(name, given, by)
            held = self._registry.grants_book.give(made.program.id, made.grants, by)
            await turn.write((*made.records, *held))
        secret = made.secret.reveal()
        text = words.created(clean(made.program.name), given.words, secret)
        return self._shown(by, made.key.id, text)

    def _shown(self, by: PrincipalId, key: str, text: str) -> Reply:
        """Return an answer that shows a secret, and goes soon."""
        until_ns = self._registry.clock.wall_ns() + SHOWN_NS
        keep = partial(self._registry.retracting.keep, f"{PROGRAM_KEY} {key}", by, until_ns)
        away = Button(words.TAKE_AWAY, f"/key {words.FORGET}", good_for_ns=SHOWN_NS)
        return Reply(text, ((away,),), landed=keep, anew=True)

    def _forget(self, asked: CommandContext) -> Reply:
        """Take the message that was tapped out of the chat; where that cannot be, its words."""
        inbound = asked.inbound
        if not inbound.under:
            raise NotUnderstood(words.HOW)
        removable = retract_of(asked.messenger) is not None
        if removable:
            self._registry.retracting.now(asked.messenger, inbound.chat, inbound.under)
        return Reply(words.TAKEN_AWAY, anew=removable)

    # ---- which there are ----

    def _list(self, by: PrincipalId) -> Reply:
        found = self._mine(by)[:LISTED_AT_MOST]
        if not found:
            return Reply(words.NO_KEYS)
        rows = tuple(
            (
                Button(filled(words.ROTATE_IT, name=one.name), f"/key {words.ROTATE} {one.id}"),
                Button(filled(words.REVOKE_IT, name=one.name), f"/key {words.REVOKE} {one.id}"),
            )
            for one in found[:BUTTONS_AT_MOST]
        )
        return Reply(joined("\n", map(self._line, found)), rows)

    def _line(self, program: Principal) -> str:
        now_ns = self._registry.clock.wall_ns()
        key = self._keys.current(program.id)
        if key is None:
            return words.line(program.name, "-", words.revoked(program.name), "-")
        what = messages.held(self._held(program.id), now_ns) or "-"
        issuer = self._registry.name(key.issuer)
        lines = [words.line(program.name, what, self._keys.state(key), issuer)]
        lines += [
            words.older(program.name, self._keys.state(other))
            for other in self._keys.of(program.id)
            if other.id != key.id and self._keys.good(other.id)
        ]
        return joined("\n", lines)

    def _mine(self, by: PrincipalId) -> list[Principal]:
        """Return the programs that somebody looks after and that are let in, by their names."""
        good = self._directory.has_good_key
        programs = (p for p in self._directory.people() if p.is_program and good(p.id))
        return sorted((p for p in programs if self._sees(by, p.id)), key=lambda p: p.name)

    def _held(self, program: PrincipalId) -> tuple[Grant, ...]:
        return self._registry.rights().grants(program)

    def _sees(self, by: PrincipalId, program: PrincipalId) -> bool:
        made = any(key.issuer == by for key in self._keys.of(program))
        return made or self._gives(by, program) or self._admin_policy.holds(by, PEOPLE)

    def _gives(self, by: PrincipalId, program: PrincipalId) -> bool:
        """Whether somebody may give all that a program holds; nobody gives nothing."""
        held = [
            InvitedRights(
                roles=(grant.role,) if grant.role else (), robots=grant.robots, scopes=grant.scopes
            )
            for grant in self._held(program)
        ]
        return bool(held) and all(self._admin_policy.may_give(by, given) for given in held)

    def _find(self, by: PrincipalId, typed: str) -> Principal:
        """Return the program that is meant.

        Raises:
            NotUnderstood: There is none of that name, as far as they may know.
        """
        wanted = clean_name(typed).casefold()
        mine = self._mine(by)
        found = [p for p in mine if typed == p.id] or [
            p for p in mine if p.name.casefold() == wanted
        ]
        if not found:
            raise NotUnderstood(words.NOBODY)
        return found[0]

    # ---- replacing and ending ----

    async def _rotate(self, asked: CommandContext, rest: str) -> Reply:
        check_command_fresh(asked.inbound, f"/key {words.ROTATE} {rest}")
        by, (typed, grace_s) = asked.caller.principal, _grace(rest)
        program = self._find(by, typed)
        async with self._registry.changes.turn() as turn:
            self._admin_policy.check_not_locked(by)
            if not self._gives(by, program.id):
                helpers = self._admin_policy.helpers(by)
                raise NotPermitted(words.not_yours(program.name, helpers))
            rotation = self._keys.rotate(program.id, by, grace_s=grace_s)
            secret, digest = self._programs.secret_for(rotation.key.id)
            await turn.write((*rotation.records, digest))
        text = words.rotated(clean(program.name), rotation.grace_s, secret.reveal())
        return self._shown(by, rotation.key.id, text)

    async def _revoke(self, asked: CommandContext, typed: str) -> Reply:
        by = asked.caller.principal
        program = self._find(by, typed)
        question = words.revoke_question(program.name)
        agreed = sure("end-program", program.id)
        if asked.act != agreed:
            yes = Button(
                filled(words.REVOKE_IT, name=program.name),
                f"/key {words.REVOKE} {program.id}",
                act=agreed,
            )
            leave = Button(messages.LEAVE_IT, LEAVE)
            return asks_first(asked_again(asked.act, question), ((yes, leave),))

        def ended() -> tuple[Record, ...]:
            good = [key for key in self._keys.of(program.id) if key.revoked_ns is None]
            return tuple(r for key in good for r in self._keys.revoke(key.id, by).records)

        taken = self._registry.grants_book.take(program.id, by)
        written = await self._registry.changes.take_away((*taken, *ended()), ended)
        await self._registry.ended(program.id)
        return Reply(messages.noted(words.revoked(program.name), written=written))


def _named(text: str) -> tuple[str, str]:
    """Return the name at the beginning of a line, perhaps in quotes, and what follows it."""
    found = _NAMED.match(text)
    if found is None:
        return "", ""
    return found[1] or found[2], found[3].strip()


def _grace(text: str) -> tuple[str, float]:
    """Return whose key is replaced, and how long the old one stays good.

    Raises:
        NotUnderstood: It cannot be read how long.
    """
    whose, *after = _FOR.split(text, maxsplit=1)
    first, _, last = whose.rpartition(" ")
    if not after and first and last.casefold() in NOW:
        return first.strip(' "„“”'), 0.0
    if not after:
        return whose.strip(' "„“”'), GRACE_S
    low = [option_typed(word.casefold()) for word in after[0].split()]
    grace_s, used = length_said(low)
    if not used or used != len(low):
        raise NotUnderstood(words.NO_GRACE)
    return whose.strip(' "„“”'), grace_s


_VERBS: Final = {
    "anlegen": words.CREATE,
    "liste": words.LIST,
    "erneuern": words.ROTATE,
    "entziehen": words.REVOKE,
    "new": words.CREATE,
    "neu": words.CREATE,
}
