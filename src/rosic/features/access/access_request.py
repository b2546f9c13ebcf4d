"""``/ask kuka1 grasp for 1h``: a right one lacks, for a while, if somebody else allows it."""

from __future__ import annotations

import re
from itertools import islice
from typing import TYPE_CHECKING, NamedTuple

from rosic.core.i18n import joined
from rosic.core.local_time import LocalTime
from rosic.core.message import Button
from rosic.errors import Expired, NotPermitted, NotUnderstood, OutOfBounds
from rosic.features.access import request_messages as words
from rosic.features.access.access_request_parser import read_tail, want_of
from rosic.gateway.commands import Reply
from rosic.gateway.pending_work import PendingRequest
from rosic.organiser import access_request_messages
from rosic.organiser.access_requests import (
    LONGEST_S,
    REMEMBERED_S,
    SHORTEST_S,
    WAITS_S,
    RequestState,
)
from rosic.organiser.calendar_messages import length, moment

if TYPE_CHECKING:
    from collections.abc import Iterable

    from rosic.authoriser.invitations import InvitedRights
    from rosic.core.identity import PrincipalId
    from rosic.features.access.access_request_parser import RequestPlaces
    from rosic.features.access.admin_policy import AdminPolicy
    from rosic.features.access.context import AccessContext
    from rosic.features.access.grant import GrantCommands
    from rosic.gateway.commands import CommandContext
    from rosic.organiser.access_requests import AccessRequest, AccessRequests
    from rosic.organiser.timezones import Zone

MOST_NAMED = 6
MOST_LOOKED_AT = 1_000
TODAY = "today"
_NUMBER = re.compile(r"\d{1,9}(?:\.\d{1,3})?")


class RequestAnswer(NamedTuple):
    """What somebody says to an access request: which, and until when."""

    access_request: AccessRequest
    how: str


class AccessRequestCommands:
    """Takes questions to whoever may give the right, and their answers back.

    Args:
        registry: Who knows people.
        admin_policy: Who may give what.
        access_requests: What is open.
        granting: Gives it.
        places: How robots are named and shown, and where people read times.
    """

    def __init__(
        self,
        registry: AccessContext,
        admin_policy: AdminPolicy,
        access_requests: AccessRequests,
        granting: GrantCommands,
        places: RequestPlaces,
    ) -> None:
        self._registry = registry
        self._admin_policy = admin_policy
        self._access_requests = access_requests
        self._granting = granting
        self._places = places

    # ---- asking ----

    async def ask(self, asked: CommandContext) -> Reply:
        """Ask whoever may give a right for it.

        Raises:
            Refusal: Not understood, theirs already, asked too often, or nobody can give it.
        """
        if not asked.rest.strip():
            return Reply(words.how_to_ask())
        principal = asked.caller.principal
        want = want_of(asked, self._registry.rights(), self._places)
        given = self._places.given(want)
        self._check_lacking(principal, given)
        digest = self._places.digest(self._registry.rights(), given)
        async with self._registry.changes.turn() as turn:
            access_request, records = self._access_requests.ask(principal, want, digest)
            others = self._answerers(access_request)
            if not others:
                raise NotPermitted(self._nobody(principal, given))
            await turn.write(records)
        names = self._names(others)
        told = self._registry.reach.tell(
            others,
            self._question(access_request),
            (self._buttons(access_request),),
            urgent=True,
            lifetime_s=WAITS_S,
            still=True,
        )
        if not told:
            return Reply(words.reach_nobody(names))
        return Reply(words.have_asked(names, self._asked_for(access_request), WAITS_S))

    def _nobody(self, principal: PrincipalId, given: InvitedRights) -> str:
        """Say that nobody can answer, and who has what was asked for themselves."""
        rights, now_ns = self._registry.rights(), self._registry.clock.wall_ns()
        people = (
            who
            for who in islice(rights.people(), MOST_LOOKED_AT)
            if who != principal
            and self._admin_policy.acts(who)
            and not self._places.lacks(rights, who, given, now_ns)
        )
        names = self._names(islice(people, MOST_NAMED))
        return words.nobody_gives(self._places.what(given), names)

    def _check_lacking(self, principal: PrincipalId, given: InvitedRights) -> None:
        """See that somebody does not have all of this already, without limits.

        Raises:
            NotUnderstood: They have.
        """
        now_ns = self._registry.clock.wall_ns()
        if self._places.lacks(self._registry.rights(), principal, given, now_ns):
            return
        raise NotUnderstood(words.may_already(self._places.what(given)))

    # ---- answering ----

    def knows(self, by: PrincipalId, said: str) -> bool:
        """Whether an answer is about an access request: an id, or somebody who asks this person."""
        return self._meant(by, said) is not None

    async def approve(self, asked: CommandContext) -> Reply:
        """Allow it: the button, or ``/approve Cy for 30 min``.

        Raises:
            Refusal: Not theirs to give, settled before, too late, or nobody is there any more.
        """
        by = asked.caller.principal
        answer = self._checked(by, asked.rest)
        access_request = answer.access_request
        wanted_ns = self._until_ns(answer, self._places.zone_of(by))
        given = self._places.given(access_request.want)
        async with self._registry.changes.turn() as turn:
            self._check(by, access_request)
            self._check_same(access_request)
            until_ns = self._admin_policy.gives_until_ns(by, given, wanted_ns)
            grant, records = self._granting.granted(access_request.principal, given, until_ns, by)
            await turn.write((*self._access_requests.allow(access_request, by), *records))
        name, who = self._registry.name(by), self._registry.name(access_request.principal)
        what = self._places.what(given)
        use = Button(
            self._places.shown(access_request.want.robot), f"/use {access_request.want.robot}"
        )
        told = words.you_may(name, self._until(what, until_ns, access_request.principal))
        self._registry.reach.tell((access_request.principal,), told, ((use,),))
        for other in self._answerers(access_request):
            if other != by:
                text = words.was_allowed(name, who, self._until(what, until_ns, other))
                self._registry.reach.tell((other,), text)
        back = self._granting.take_button(grant)
        text = words.allowed(who, self._until(what, until_ns, by))
        if until_ns < wanted_ns:
            text = joined(" ", (text, words.capped()))
        return Reply(text, ((back,),))

    async def decline(self, asked: CommandContext) -> Reply:
        """Do not allow it: the button, or ``/decline Cy``.

        Raises:
            Refusal: Not theirs to give, settled before, or too late.
        """
        by = asked.caller.principal
        access_request = self._checked(by, asked.rest).access_request
        async with self._registry.changes.turn() as turn:
            self._check(by, access_request)
            await turn.write(self._access_requests.deny(access_request, by))
        name, who = self._registry.name(by), self._registry.name(access_request.principal)
        what = self._asked_for(access_request)
        told = words.you_may_not(name, what, REMEMBERED_S)
        self._registry.reach.tell((access_request.principal,), told)
        others = (other for other in self._answerers(access_request) if other != by)
        self._registry.reach.tell(others, words.was_denied(name, who, what))
        return Reply(words.denied(who))

    def _checked(self, by: PrincipalId, said: str) -> RequestAnswer:
        answer = self._meant(by, said)
        if answer is None:
            raise Expired(access_request_messages.settled())
        self._check(by, answer.access_request)
        return answer

    def _check(self, by: PrincipalId, access_request: AccessRequest) -> None:
        """See that somebody may answer, and that there is something to answer.

        Raises:
            NotPermitted: It is their own question, or not theirs to give; or the asker is gone.
            Expired: It is settled.
        """
        self._admin_policy.check_not_locked(by)
        if by == access_request.principal:
            raise NotPermitted(words.own_question())
        if not self._admin_policy.may_give(by, self._places.given(access_request.want)):
            raise NotPermitted(words.not_yours(self._admin_policy.helpers(by)))
        now = self._access_requests.get(access_request.id)
        if now is not None and now.by:
            name, allowed = self._registry.name(now.by), now.state is RequestState.ALLOWED
            raise Expired(words.answered_before(name, allowed=allowed))
        if not self._admin_policy.acts(access_request.principal):
            raise NotPermitted(words.no_access(self._registry.name(access_request.principal)))

    def _is_same(self, access_request: AccessRequest) -> bool:
        """Whether what was asked for still is what it was (I16)."""
        given, rights = self._places.given(access_request.want), self._registry.rights()
        return access_request.digest == self._places.digest(rights, given)

    def _check_same(self, access_request: AccessRequest) -> None:
        """See that what somebody allows is what they were asked about.

        Raises:
            Expired: It would give something else by now.
        """
        if not self._is_same(access_request):
            raise Expired(words.is_something_else(self._registry.name(access_request.principal)))

    def _meant(self, by: PrincipalId, said: str) -> RequestAnswer | None:
        first, _, how = said.strip().partition(" ")
        known = self._access_requests.get(first)
        if known is not None:
            return RequestAnswer(known, how.strip())
        found = self._called(by, said)
        if len(found) != 1:
            return None  # of several, it was asked which
        if self._registry.name(found[0].principal).casefold() == said.strip().casefold():
            return RequestAnswer(found[0], "")
        lasts = read_tail(said)[1]
        return RequestAnswer(found[0], "" if lasts is None else str(lasts))

    def _called(self, by: PrincipalId, said: str) -> list[AccessRequest]:
        """Return every access request of whoever may be meant: all of it is a name, or its head."""
        wanted = {said.strip().casefold(), read_tail(said)[0].casefold()}
        return [
            access_request
            for access_request in self.waiting(by)
            if self._registry.name(access_request.principal).casefold() in wanted
        ]

    def _until_ns(self, answer: RequestAnswer, zone: Zone) -> int:
        now_ns = self._registry.clock.wall_ns()
        if answer.how == TODAY:
            return midnight_ns(now_ns, zone)
        lasts_s = _seconds(answer.how) if answer.how else answer.access_request.want.lasts_s
        return now_ns + int(lasts_s * 1e9)

    # ---- time ----

    async def lapse(self) -> None:
        """Settle what nobody answered in time, and say so; call it every minute or so.

        Raises:
            RecordUnavailable: Nothing was written; it is tried again with the next call.
        """
        async with self._registry.changes.turn() as turn:
            late = self._access_requests.late()
            void = tuple(p for p in self._access_requests.open() if not self._is_same(p))
            settled = map(self._access_requests.lapse, (*late, *void))
            await turn.write((*settled, *self._access_requests.stale()))
        for access_request in late:
            others, what = self._answerers(access_request), self._asked_for(access_request)
            names = self._names(others)
            asker = access_request.principal
            self._registry.reach.tell((asker,), words.nobody_answered(what, names))
            self._registry.reach.tell(others, words.lapsed(self._registry.name(asker), what))
        for access_request in void:
            self._registry.reach.tell(
                (access_request.principal,), words.ask_anew(self._asked_for(access_request))
            )

    # ---- lists ----

    def waiting(self, by: PrincipalId) -> tuple[AccessRequest, ...]:
        """Return every open access request that this person may answer."""
        return tuple(
            access_request
            for access_request in self._access_requests.open()
            if access_request.principal != by
            and self._admin_policy.may_give(by, self._places.given(access_request.want))
        )

    def questions(
        self, by: PrincipalId, said: str = ""
    ) -> tuple[tuple[str, str, tuple[Button, ...]], ...]:
        """Return what waits for somebody's answer: who asks, a line and its buttons, each.

        Args:
            by: Who may answer.
            said: Only of those whom this may mean: a name, perhaps with how long after it.
        """
        waiting = self._called(by, said) if said else self.waiting(by)
        named = [(self._registry.name(p.principal), p) for p in waiting]
        return tuple(
            (
                name,
                words.asks(name, self._asked_for(access_request)),
                self._buttons(access_request, name),
            )
            for name, access_request in named
        )

    def pending(
        self, *, by: PrincipalId = "", principal: PrincipalId = ""
    ) -> tuple[PendingRequest, ...]:
        """Return every open access request that somebody may answer, or that is their own."""
        own = (p for p in self._access_requests.open() if p.principal == principal)
        return tuple(
            PendingRequest(
                p.id, "right", self._registry.name(p.principal), self._asked_for(p), "", p.lapses_ns
            )
            for p in (self.waiting(by) if by else own)
        )

    def own(self, principal: PrincipalId) -> tuple[str, ...]:
        """Return what somebody waits for, a line each."""
        return tuple(
            words.you_wait(self._asked_for(access_request))
            for access_request in self._access_requests.open()
            if access_request.principal == principal
        )

    def _answerers(self, access_request: AccessRequest) -> tuple[PrincipalId, ...]:
        return self._admin_policy.givers(
            self._places.given(access_request.want), access_request.principal
        )

    # ---- words ----

    def _names(self, people: Iterable[PrincipalId]) -> list[str]:
        return sorted(map(self._registry.name, people))[:MOST_NAMED]

    def _question(self, access_request: AccessRequest) -> str:
        given, rights = self._places.given(access_request.want), self._registry.rights()
        now_ns = self._registry.clock.wall_ns()
        limits = self._places.limits(rights, access_request.principal, given, now_ns)
        name = self._registry.name(access_request.principal)
        return words.wants(name, self._asked_for(access_request), limits)

    def _asked_for(self, access_request: AccessRequest) -> str:
        what = self._places.what(self._places.given(access_request.want))
        return words.for_a_time(what, int(access_request.want.lasts_s))

    def _until(self, what: str, until_ns: int, reader: PrincipalId) -> str:
        now_ns, zone = self._registry.clock.wall_ns(), self._places.zone_of(reader)
        return words.until(what, moment(until_ns, now_ns, zone))

    def _buttons(self, access_request: AccessRequest, name: str = "") -> tuple[Button, ...]:
        number, lasts_s = access_request.id, access_request.want.lasts_s
        yes = words.allow_label(length(int(lasts_s)), name)
        return (
            Button(yes, f"/approve {number} {lasts_s:.0f}"),
            Button(words.allow_today_label(name), f"/approve {number} {TODAY}"),
            Button(words.no_label(name), f"/decline {number}"),
        )


def _seconds(said: str) -> float:
    """Read what a button says, or what somebody typed after an id.

    Raises:
        OutOfBounds: No time, or for longer than anything is given on request.
    """
    _, lasts_s = (said, float(said)) if _NUMBER.fullmatch(said) else read_tail(said)
    if lasts_s is None or not SHORTEST_S <= lasts_s <= LONGEST_S:
        raise OutOfBounds(words.no_such_length())
    return lasts_s


def midnight_ns(now_ns: int, zone: Zone) -> int:
    """Return when today ends in a zone, wall clock."""
    return zone.instant(LocalTime.at(zone.local(now_ns).day_number + 1)).start_ns
