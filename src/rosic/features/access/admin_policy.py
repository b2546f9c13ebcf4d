"""Who may do what with people, and who is to be asked."""

from __future__ import annotations

from hashlib import blake2b
from typing import TYPE_CHECKING, Final

from rosic.authoriser import keys_messages
from rosic.authoriser.invitations import InvitedRights
from rosic.core.i18n import joined, said
from rosic.core.language import clean_name
from rosic.core.language.suggestions import MOST_SUGGESTIONS, did_you_mean
from rosic.core.policy.compiled import FOR_GOOD_NS
from rosic.core.policy.roles import priority_of
from rosic.core.policy.scope import FLEET, GRANT
from rosic.errors import NotPermitted, NotUnderstood
from rosic.features.access import messages
from rosic.gateway.person_argument import BY_ID, which_person

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping

    from rosic.core.identity import Principal, PrincipalId
    from rosic.core.policy.permissions import Permissions
    from rosic.core.policy.roles import Grant, RoleRules
    from rosic.core.robot.profile import RobotId
    from rosic.features.access.context import AccessContext
    from rosic.gateway.commands import CommandContext, Reply


# ---- who may do what with people ----

INVITE, LOCK, PEOPLE = "invite", "lock", "people"


class AdminPolicy:
    """Asks the rights in force. Whoever is locked has none."""

    def __init__(self, registry: AccessContext) -> None:
        self._registry = registry
        self._locks = registry.locks
        self._directory = registry.authoriser.directory

    def check(self, principal: PrincipalId, verb: str) -> None:
        """See that somebody may do something with people.

        Raises:
            NotPermitted: Locked, or not theirs; says who can help.
        """
        self.check_not_locked(principal)
        if not self.holds(principal, verb):
            raise NotPermitted(messages.not_yours(verb, self.helpers(principal)))

    def check_not_locked(self, principal: PrincipalId) -> None:
        """See that somebody is not locked.

        Raises:
            NotPermitted: They are.
        """
        if self._locks.locked(principal):
            raise NotPermitted(keys_messages.LOCKED)

    def holds(self, principal: PrincipalId, verb: str) -> bool:
        """Whether somebody has a right about the place now."""
        now_ns = self._registry.clock.wall_ns()
        return self._registry.rights().holds(principal, FLEET, verb, now_ns)

    def helpers(self, besides: PrincipalId = "", *, for_good: bool = False) -> tuple[str, ...]:
        """Return the names of a few people who give rights here; perhaps only without an end."""
        now_ns = FOR_GOOD_NS if for_good else self._registry.clock.wall_ns()
        found = self._registry.rights().givers(FLEET, now_ns, besides=besides)
        return tuple(self._registry.name(p) for p in found if self.acts(p))

    def holders(self, verb: str, besides: PrincipalId = "") -> tuple[PrincipalId, ...]:
        """Return everybody who has a right about the place and can use it; walks everybody."""
        return tuple(
            who
            for who in self._registry.rights().people()
            if who != besides and self.acts(who) and self.holds(who, verb)
        )

    def acts(self, principal: PrincipalId) -> bool:
        """Whether somebody has access and is not locked."""
        return self._directory.has_good_key(principal) and not self._locks.locked(principal)

    def is_last_admin(self, principal: PrincipalId, *, for_good: bool) -> bool:
        """Whether nobody else would be left who gives rights here; walks everybody.

        Args:
            principal: Who would be gone.
            for_good: Whoever is admin for some hours only is none who could be left alone.
        """
        if not self.holds(principal, GRANT):
            return False
        rights = self._registry.rights()
        at_ns = FOR_GOOD_NS if for_good else self._registry.clock.wall_ns()
        return rights.is_last_giver(principal, self.acts, at_ns)

    def may_give(
        self, principal: PrincipalId, given: InvitedRights, now_ns: int | None = None
    ) -> bool:
        """Whether somebody may give all of this to somebody else, now or at another time.

        Whoever gives rights on the whole gives everything. Whoever gives them on some robots only
        gives roles there, of at most the priority they have there themselves, and single skills
        that are theirs without limits.
        """
        rights = self._registry.rights()
        now_ns = self._registry.clock.wall_ns() if now_ns is None else now_ns
        if rights.holds(principal, FLEET, GRANT, now_ns):
            return True
        if not all(self._may_give_scope(principal, scope, now_ns) for scope in given.scopes):
            return False
        robots = {robot for pattern in given.robots for robot in rights.fleet.robots(pattern)}
        if not given.roles:
            return bool(given.scopes)
        if not robots or FLEET in robots:
            return False
        return all(
            rights.holds(principal, robot, GRANT, now_ns)
            and _highest(rights, given) <= rights.priority(principal, robot, now_ns)
            for robot in robots
        )

    def _may_give_scope(self, principal: PrincipalId, scope: str, now_ns: int) -> bool:
        """Whether a skill of a robot, or of all of a group, is somebody's own and to give."""
        name, _, skill = scope.partition(":")
        robots = self._registry.rights().fleet.robots(name)
        if name == FLEET or skill == GRANT or not robots:
            return False
        return all(self._gives_skill(principal, robot, skill, now_ns) for robot in robots)

    def _gives_skill(self, principal: PrincipalId, robot: RobotId, skill: str, now_ns: int) -> bool:
        """Whether one skill of one robot is somebody's own, without limits, and theirs to give."""
        rights = self._registry.rights()
        return rights.holds(principal, robot, GRANT, now_ns) and any(
            not way.limits and now_ns < granted.until_ns
            for way, granted in rights.ways(principal, robot, skill)
        )

    def may_make(
        self,
        principal: PrincipalId,
        given: Mapping[RobotId, frozenset[str]],
        rules: RoleRules,
        role: str,
        now_ns: int,
    ) -> bool:
        """Whether somebody may give all that a role would give, skill by skill, at a time.

        Args:
            principal: Who makes it.
            given: What it gives without its limits.
            rules: The rules with the role in them.
            role: Its name.
            now_ns: When, wall clock; `FOR_GOOD_NS`: without an end of their own right to give.
        """
        rights = self._registry.rights()
        if rights.holds(principal, FLEET, GRANT, now_ns):
            return True
        priority = priority_of(rules.roles, role)
        return all(
            priority <= rights.priority(principal, robot, now_ns)
            and all(self._may_give_scope(principal, f"{robot}:{word}", now_ns) for word in skills)
            for robot, skills in given.items()
        )

    def gives_until_ns(self, principal: PrincipalId, given: InvitedRights, until_ns: int) -> int:
        """Return how long somebody who may give all of this now still may, wall clock.

        Args:
            principal: Who gives.
            given: What.
            until_ns: No longer than this is of interest.
        """
        now_ns = self._registry.clock.wall_ns()
        ends = (grant.expires_ns for grant in self._registry.rights().grants(principal))
        for end_ns in sorted(ns for ns in ends if ns is not None and now_ns < ns < until_ns):
            if not self.may_give(principal, given, end_ns):
                return end_ns
        return until_ns

    def gives(self, principal: PrincipalId) -> bool:
        """Whether somebody gives rights, on the whole or on any robot."""
        rights, now_ns = self._registry.rights(), self._registry.clock.wall_ns()
        robots = (FLEET, *rights.fleet.skills)
        return any(rights.holds(principal, robot, GRANT, now_ns) for robot in robots)

    def givers_of(
        self, grants: Iterable[Grant], *, besides: PrincipalId
    ) -> tuple[PrincipalId, ...]:
        """Return everybody else who may give these grants, and may take them back."""
        grants = tuple(grants)
        given = InvitedRights(
            roles=tuple(grant.role for grant in grants if grant.role),
            robots=grants[0].robots,
            scopes=tuple(scope for grant in grants for scope in grant.scopes),
        )
        return self.givers(given, besides)

    def givers(self, given: InvitedRights, besides: PrincipalId) -> tuple[PrincipalId, ...]:
        """Return everybody else who may give this and can use that right; walks everybody."""
        return tuple(
            who
            for who in self._registry.rights().people()
            if who != besides and self.acts(who) and self.may_give(who, given)
        )

    def check_give(
        self, principal: PrincipalId, given: InvitedRights, *, within_s: float = 0.0
    ) -> None:
        """See that somebody may give all of this, and still may when it ends.

        Whoever gives rights for an hour would otherwise give some that outlive the hour.

        Args:
            principal: Who gives.
            given: What, and for how long.
            within_s: It begins so much later at the latest.

        Raises:
            NotPermitted: It is more than they may give, or for longer.
        """
        if not self.may_give(principal, given):
            raise NotPermitted(messages.too_much(given.words, self.helpers(principal)))
        ends_ns = FOR_GOOD_NS
        if given.lasts_s is not None:
            ends_ns = self._registry.clock.wall_ns() + int((within_s + given.lasts_s) * 1e9)
        if not self.may_give(principal, given, ends_ns):
            raise NotPermitted(
                messages.too_long(given.words, self.helpers(principal, for_good=True))
            )

    def admitters(self, given: InvitedRights) -> tuple[PrincipalId, ...]:
        """Return everybody who may let somebody in who is given this; walks everybody."""
        return tuple(who for who in self.holders(INVITE) if self.may_give(who, given))

    def may_admit(self, principal: PrincipalId, given: InvitedRights) -> bool:
        """Whether somebody may let a person in who is given this."""
        return self.holds(principal, INVITE) and self.may_give(principal, given)


def _highest(rights: Permissions, given: InvitedRights) -> int:
    return max((rights.role_priority(role) for role in given.roles), default=0)


# ---- whom somebody means ----

CHANGED: Final = said("Nothing was done yet: something has changed here since you were asked.")
SURE_BYTES: Final = 16


class PersonNames:
    """Finds people in the directory."""

    def __init__(self, registry: AccessContext) -> None:
        self._directory = registry.authoriser.directory

    def find(
        self, asked: CommandContext, typed: str, verb: str, fits: Callable[[Principal], bool]
    ) -> Principal | Reply:
        """Return who is meant, or the question which of several.

        All of what was said is the name: no word of it means anything else.

        Args:
            asked: By whom, where. Names are offered only where nobody else reads along.
            typed: A name, or an id.
            verb: What is to be done, for offers: ``lock``.
            fits: Whether it can be done with somebody; preferred where names are shared.

        Raises:
            NotUnderstood: Nobody; offers who may have been meant.
        """
        by_id = self._directory.person(typed)
        if by_id is not None and asked.act:
            return by_id
        private = asked.private
        named = self.called(typed)
        fitting = tuple(filter(fits, named)) or named
        if len(fitting) == 1:
            return fitting[0]
        if not fitting:
            raise NotUnderstood(
                messages.nobody_called(typed), offers=self._offers(typed, verb) if private else ()
            )
        return which_person(asked, typed, [(p, f"/{verb} {p.id}", "") for p in fitting])

    def called(self, typed: str) -> tuple[Principal, ...]:
        """Return everybody who is called so, or has that id; each once."""
        return self._directory.called(typed)

    def _offers(self, typed: str, verb: str) -> tuple[str, ...]:
        wanted = clean_name(typed).casefold()
        if not wanted:
            return ()
        everybody = sorted({person.name for person in self._directory.people()})
        parts = [n for n in everybody if any(w.startswith(wanted) for w in _words_of(n))]
        close = parts[:MOST_SUGGESTIONS] or did_you_mean(wanted, _first_alike(everybody, wanted))
        return tuple(f"/{verb} {name}" for name in close)


def _words_of(name: str) -> Iterable[str]:
    return name.casefold().split()


def _first_alike(names: Iterable[str], wanted: str) -> list[str]:
    """Put names with the same first letter first: only so many are looked at."""
    return sorted(names, key=lambda name: name[:1].casefold() != wanted[0])


def asked_again(act: bytes, question: str) -> str:
    """Return a question, and why it is asked once more of somebody who has agreed to it."""
    return joined("\n", (CHANGED, question)) if act not in {b"", BY_ID} else question


def sure(*about: object) -> bytes:
    """Return what a button carries that confirms something: a digest of all that was shown.

    Nobody can type it: a word in a command would also be a word in somebody's name. Whatever is
    different by the time of the tap is asked again.
    """
    encoded = repr(about).encode("utf-8", "replace")
    return blake2b(encoded, digest_size=SURE_BYTES).digest()
