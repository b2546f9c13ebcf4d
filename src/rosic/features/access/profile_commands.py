"""``/me``, ``/people`` and ``/security``: who is who, and who may what, until when."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from rosic.authoriser import link_messages
from rosic.contracts.chats import assurance_of
from rosic.core.i18n import joined
from rosic.core.language import clean_name
from rosic.core.messages import named
from rosic.core.policy.scope import FLEET, RESUME
from rosic.features.access import access_messages, messages
from rosic.features.access.admin_policy import PEOPLE
from rosic.features.access.approve import buttons_for
from rosic.gateway.commands import Reply, check_private
from rosic.organiser.calendar_messages import moment
from rosic.organiser.refusals import bound_of
from rosic.organiser.timezones import UNIVERSAL, zone_named

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from rosic.core.identity import Address, Principal, PrincipalId
    from rosic.core.robot.profile import RobotId
    from rosic.features.access.access_request import AccessRequestCommands
    from rosic.features.access.admin_policy import AdminPolicy
    from rosic.features.access.approve import ApprovalCommands
    from rosic.features.access.context import AccessContext
    from rosic.gateway.commands import CommandContext
    from rosic.gateway.pending_work import PendingRequest
    from rosic.organiser.timezones import Zone

MOST_LINES = 30
MOST_BUTTONS = 4
MOST_CHARACTERS = 3_600


def _no_slots(_: PrincipalId) -> Sequence[str] | None:
    return None


class PendingRequests(NamedTuple):
    """Who waits for an answer.

    Attributes:
        newcomers: Knows who waits to be let in.
        rights: Knows who has asked for a right; None: nobody can here.
    """

    newcomers: ApprovalCommands
    rights: AccessRequestCommands | None

    def waiting_for(self, by: PrincipalId) -> tuple[PendingRequest, ...]:
        """Return what somebody may answer; see `PendingAnswers`."""
        rights = () if self.rights is None else self.rights.pending(by=by)
        return (*self.newcomers.pending(by), *rights)

    def asked_by(self, principal: PrincipalId) -> tuple[PendingRequest, ...]:
        """Return what somebody waits for themselves."""
        return () if self.rights is None else self.rights.pending(principal=principal)


class AccountCommands:
    """Answers from memory. Others' rights are shown to admins alone (I11).

    Args:
        registry: Who knows people.
        admin_policy: Who may look.
        asking: Who waits.
        slots: Returns somebody's next slots, a line each; None if there are no slots here.
        zone_of: Returns the zone whose clocks somebody reads.
        shown: Returns how a robot is shown.
    """

    def __init__(
        self,
        registry: AccessContext,
        admin_policy: AdminPolicy,
        asking: PendingRequests,
        *,
        slots: Callable[[PrincipalId], Sequence[str] | None] = _no_slots,
        zone_of: Callable[[PrincipalId], Zone] = lambda _: zone_named(UNIVERSAL),
        shown: Callable[[RobotId], str] = str,
    ) -> None:
        self._registry = registry
        self._admin_policy = admin_policy
        self._admitting, self._requests = asking
        self._slots = slots
        self._zone_of = zone_of
        self._shown = shown

    # ---- myself ----

    async def me(self, asked: CommandContext) -> Reply:
        """Say who somebody is, what they may do, until when.

        Raises:
            NotPermitted: Others read along, or they are locked.
        """
        check_private(asked)
        principal = asked.caller.principal
        self._admin_policy.check_not_locked(principal)
        lines = [messages.you_are(asked.caller.name)]
        lines += messages.rights_lines(self._grants(principal, reader=principal))
        lines += self._robots(principal)
        lines += self._key(principal)
        lines += self._accounts(principal, asked.caller.address)
        lines.append(self._phone(asked))
        lines += filter(None, (messages.CHAT_IS.get(assurance_of(asked.messenger, asked.inbound)),))
        lines += () if self._requests is None else self._requests.own(principal)
        slots = self._slots(principal)
        if slots is not None:
            lines += messages.next_times(slots)
        return Reply(_cut(lines))

    def _grants(self, principal: PrincipalId, *, reader: PrincipalId) -> list[str]:
        """Return what somebody holds now, a line each, on the clocks of whoever reads it."""
        now_ns = self._registry.clock.wall_ns()
        rights, zone = self._registry.rights(), self._zone_of(reader)
        lines = []
        for grant in rights.grants(principal):
            ends_ns = grant.expires_ns
            if ends_ns is not None and ends_ns <= now_ns:
                continue
            role = rights.rulebook.roles.get(grant.role)
            limits = (*(role.limits if role is not None else ()), *grant.limits)
            until = "" if ends_ns is None else moment(ends_ns, now_ns, zone)
            lines.append(messages.grant(grant, limits, until))
        return lines

    def _robots(self, principal: PrincipalId) -> list[str]:
        """Say what somebody may let each robot do; robots that are alike share a line."""
        rights, now_ns = self._registry.rights(), self._registry.clock.wall_ns()
        alike: dict[str, list[str]] = {}
        for robot in sorted(rights.visible(principal, now_ns) - {FLEET}):
            alike.setdefault(self._may_do(principal, robot, now_ns), []).append(self._shown(robot))
        return [messages.robots_line(robots, said) for said, robots in alike.items()]

    def _may_do(self, principal: PrincipalId, robot: RobotId, now_ns: int) -> str:
        """Say what somebody may let one robot do: everything only where nothing is missing."""
        rights = self._registry.rights()
        skills = rights.fleet.skills[robot]
        may = [s for s in (*skills, RESUME) if rights.holds(principal, robot, s, now_ns)]
        if not any(rights.actuates(robot, skill) for skill in may):
            return messages.MAY_LOOK
        limits = {skill: rights.limits(principal, robot, skill, now_ns) for skill in may}
        lacks = [skill for skill in (*skills, RESUME) if skill not in may]
        if not lacks and not any(limits.values()):
            return messages.EVERYTHING
        told = [
            messages.within(
                named(skills[skill]), [list(map(bound_of, limit)) for limit in limits[skill]]
            )
            for skill in may
            if skill != RESUME
        ]
        return messages.may_do(
            told, [named(skills[s]) for s in lacks if s != RESUME], resume=RESUME in may
        )

    def _key(self, principal: PrincipalId) -> list[str]:
        key = self._registry.keys.current(principal)
        ends_ns = None if key is None else self._registry.keys.ends_ns(key)
        if ends_ns is None:
            return []
        now_ns = self._registry.clock.wall_ns()
        return [messages.access_until(moment(ends_ns, now_ns, self._zone_of(principal)))]

    def _accounts(self, principal: PrincipalId, here: Address) -> list[str]:
        person = self._registry.authoriser.directory.person(principal)
        if person is None or len(person.addresses) < 2:  # noqa: PLR2004 - it is the one they use
            return []
        return [link_messages.your_accounts(link_messages.accounts_shown(person.addresses, here))]

    def _phone(self, asked: CommandContext) -> str:
        principal, two_factor = asked.caller.principal, self._registry.two_factor
        if not two_factor.is_set_up(principal):
            return access_messages.NO_PHONE
        fresh = two_factor.fresh(principal, asked.inbound.chat)
        return access_messages.PHONE_PROVEN if fresh else access_messages.PHONE_SET_UP

    # ---- everybody ----

    async def people(self, asked: CommandContext) -> Reply:
        """List people, or those whose name holds what was said; and who waits to come in.

        Raises:
            NotPermitted: Not theirs to see, or others read along.
        """
        by = asked.caller.principal
        self._admin_policy.check(by, PEOPLE)
        check_private(asked)
        wanted = clean_name(asked.rest).casefold()
        found = [p for p in self._registry.authoriser.directory.people() if self._fits(p, wanted)]
        found.sort(key=lambda person: (person.name.casefold(), person.id))
        lines = [self._person(person, by) for person in found[:MOST_LINES]]
        if not found:
            lines = [messages.no_such_people(asked.rest.strip())]
        if len(found) > MOST_LINES:
            lines.append(messages.and_more(len(found) - MOST_LINES))
        waiting = self._admitting.waiting(by)
        lines += [
            messages.waits(a.name, a.pending.given.words, a.words) for a in waiting[:MOST_LINES]
        ]
        rows = [buttons_for(a, a.name) for a in waiting]
        for _, line, row in () if self._requests is None else self._requests.questions(by):
            lines.append(line)
            rows.append(row)
        return Reply(_cut(lines), tuple(rows[:MOST_BUTTONS]))

    def _fits(self, person: Principal, wanted: str) -> bool:
        """Whether to list somebody; those without access only if they are asked for."""
        if wanted:
            return wanted in person.name.casefold()
        return self._registry.authoriser.directory.has_good_key(person.id)

    def _person(self, person: Principal, by: PrincipalId) -> str:
        what = joined("; ", self._grants(person.id, reader=by))
        lock = self._registry.locks.all().get(person.id)
        locked_by = "" if lock is None else self._registry.name(lock.by)
        access = self._registry.authoriser.directory.has_good_key(person.id)
        several = len(person.addresses) > 1
        return messages.person(
            person.name,
            what,
            locked_by=locked_by,
            access=access,
            you=person.id == by,
            accounts=link_messages.accounts_shown(person.addresses) if several else "",
        )

    async def security(self, asked: CommandContext) -> Reply:
        """Show the security report.

        Raises:
            NotPermitted: Not theirs to see, or others read along.
        """
        self._admin_policy.check(asked.caller.principal, PEOPLE)
        check_private(asked)
        return Reply(_cut(self._registry.security.lines()))


def _cut(lines: Sequence[str]) -> str:
    """Join lines into one message that every messenger takes."""
    shown: list[str] = []
    room = MOST_CHARACTERS
    for line in lines:
        room -= len(line) + 1
        if room < 0:
            return joined("\n", [*shown, messages.lines_left(len(lines) - len(shown))])
        shown.append(line)
    return joined("\n", shown)
