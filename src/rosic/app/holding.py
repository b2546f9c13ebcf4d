"""Puts the containers in their place: settings, shelves, archives, and how they are erased."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

from rosic.container.archive import NOBODY, Archive, Author
from rosic.container.preferences import KIND as PREFERENCE
from rosic.container.preferences import Caps, PreferenceBook
from rosic.container.shelf import Shelf
from rosic.core.identity import Address, Principal
from rosic.core.language import skills_of
from rosic.core.limits import unit_converter
from rosic.core.reach import FLEET
from rosic.organiser.zones import zone_named
from rosic.pipeline.containers.clerks import employ_clerks, take_over
from rosic.pipeline.containers.erasing import Erasing, Sides
from rosic.pipeline.containers.parts import Holdings, Vault
from rosic.pipeline.containers.recording import Recorded
from rosic.pipeline.containers.tidying import tidy

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from rosic.app.access import Access
    from rosic.app.authority import Authority
    from rosic.authoriser.authoriser import Authoriser
    from rosic.contracts.clock import Clock
    from rosic.contracts.entropy import Entropy
    from rosic.contracts.messenger import Messenger
    from rosic.contracts.store import Store
    from rosic.core.identity import PrincipalId
    from rosic.core.language import UnitTable
    from rosic.core.message import Chat
    from rosic.core.record import Fact, Memory, Record
    from rosic.pipeline import Pipeline
    from rosic.pipeline.rooms import Rooms

LANGUAGES = {"en": ("english",)}


class Holding:
    """The container room's books of one gateway.

    Attributes:
        archive: Which chats are kept.
        preferences: What people set for themselves.
        erasing: Erases somebody.
    """

    def __init__(self, rooms: Rooms, access: Access, authority: Authority, clock: Clock) -> None:
        self._rooms = rooms
        self._access = access
        self._authority = authority
        self._clock = clock
        self._holdings: Holdings | None = None

    def record(self, messengers: Sequence[Messenger], store: Store) -> tuple[Messenger, ...]:
        """Return messengers whose chats can be kept."""
        self.archive = Archive(self._clock)
        author_of = partial(_author_of, self._rooms.authoriser)
        return tuple(Recorded(m, self.archive, store, author_of) for m in messengers)

    async def furnish(
        self, pipeline: Pipeline, vault: Vault, memory: Memory, units: UnitTable, entropy: Entropy
    ) -> None:
        """Say who keeps what, take over what was, and finish what an erasure left."""
        rooms = self._rooms
        organiser, directory = rooms.organiser, rooms.authoriser.directory
        skills = {profile.id: skills_of(profile) for profile in rooms.profiles.values()}
        caps = Caps(skills, unit_converter(units))
        self.preferences = PreferenceBook(self._clock, caps, LANGUAGES)
        shelf = Shelf(self._clock, entropy)
        shelf.is_robot = rooms.profiles.__contains__
        shelf.sees = lambda who, robot: robot in organiser.visible(who)
        shelf.works_with = lambda who, robot: organiser.holder(robot) == who
        place = organiser.calendar.zone_of
        holdings = Holdings(
            preferences=self.preferences,
            shelf=shelf,
            archive=self.archive,
            vault=vault,
            changes=self._access.changes,
            clock=self._clock,
            name=directory.name,
            shown=lambda robot: rooms.profiles[robot].shown if robot in rooms.profiles else robot,
            visible=organiser.visible,
            choices=organiser.visible,
            zone_of=lambda who: zone_named(self.preferences.of(who).zone or place(who)),
            may_archive=lambda who: organiser.rights.holds(
                who, FLEET, "archive", organiser.wall_ns()
            ),
            robots=frozenset(rooms.profiles),
        )
        self._holdings = holdings
        self.erasing = Erasing(holdings, self._sides(pipeline))
        employ_clerks(pipeline.reception.office, holdings, self.erasing)
        take_over(memory.facts, holdings, self.erasing)
        self._follow_settings()
        if memory.facts.get(PREFERENCE):
            rooms.container.usual = self._usual
        await self.erasing.finish()

    async def tidy(self) -> None:
        """Forget what was kept as long as was said; meant for once a day.

        Raises:
            RecordUnavailable: Not all was forgotten; the rest is tried the next time.
        """
        if self._holdings is not None:
            await tidy(self._holdings, self.erasing)

    def _usual(self, principal: PrincipalId) -> str:
        return self.preferences.of(principal).robot

    def _follow_settings(self) -> None:
        """Let what people set for themselves count: a cap on their speed, their usual robot."""
        authority, preferences = self._authority, self.preferences
        authority.roster.own_limits = preferences.limits
        for principal in authority.roster.everybody():
            if preferences.limits(principal):
                authority.renew(principal)

        def changed(fact: Fact) -> None:
            preferences.apply(fact)
            self._rooms.container.usual = self._usual
            authority.renew(fact.key)

        self._access.changes.keep(PREFERENCE, changed)

    def _sides(self, pipeline: Pipeline) -> Sides:
        rooms, access, authority = self._rooms, self._access, self._authority
        directory = rooms.authoriser.directory

        def ends(principal: PrincipalId, by: PrincipalId) -> Iterable[Record]:
            good = (key for key in access.keys.of(principal) if key.revoked_ns is None)
            made = [i for i in access.enrolment.invitations.open() if i.issuer == principal]
            phone = access.stepup.reset(principal, by) if access.stepup.is_set_up(principal) else ()
            return (
                *(r for i in made for r in access.enrolment.invitations.withdraw(i.id, by)),
                *phone,
                *authority.roster.take(principal, by),
                *rooms.organiser.calendar.end_all(principal),
                *access.waiting.leave_all(principal),
                *(r for key in good for r in access.keys.revoke(key.id, by).records),
            )

        def forget(principal: PrincipalId) -> None:
            directory.enrol(Principal(id=principal, name="somebody"))
            rooms.authoriser.forget(principal)
            rooms.container.forget(principal)

        async def ended(_principal: PrincipalId) -> None:
            authority.enforce()

        def theirs(principal: PrincipalId, chat: Chat) -> bool:
            person = directory.person(principal)
            return person is not None and Address(chat.platform, chat.id) in person.addresses

        return Sides(
            known=lambda who: directory.person(who) is not None,
            is_last_admin=access.is_only_admin,
            ends=ends,
            ended=ended,
            busy=lambda _who: bool(len(pipeline.lives)),
            forget=forget,
            theirs=theirs,
        )


def _author_of(authoriser: Authoriser, address: Address) -> Author:
    found = authoriser.directory.at(address)
    return NOBODY if found is None else Author(found[0].id, found[0].name)
