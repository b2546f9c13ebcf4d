"""The operator's interface while no gateway runs: straight from the data, which it takes."""

from __future__ import annotations

import enum
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING, NamedTuple

import msgspec

from rosic.app.added_robots import KIND as ADDED
from rosic.app.added_robots import with_added
from rosic.app.admin.api import AdminContext, zone_or_universal
from rosic.app.admin.dispatch import AdminApi
from rosic.app.admin.naming import CONFIGURED, people_lines, people_listed
from rosic.app.containers import DataContext, data_context_of, preferences_of
from rosic.app.features import command_table
from rosic.app.people import remember, seed
from rosic.authoriser.monotonic_clock import MonotonicWallClock
from rosic.config.lexicons import known_phrases
from rosic.config.profiles import known_units
from rosic.container.archive import Archive
from rosic.container.files import FileQuota
from rosic.container.history import CommandHistory
from rosic.contracts.store import ContainerStore
from rosic.core.i18n import plain
from rosic.core.language import Vocabulary, VocabularyHolder, clean
from rosic.core.policy.roles import DEFAULT_ROLES, Assurance, RoleRules
from rosic.core.rate_limit import RateLimit
from rosic.core.stop_registry import StopRegistry, not_known_yet
from rosic.errors import ConfigurationError
from rosic.features.personal_data.commands import books_kept
from rosic.gateway.access_registry import AccessRegistry, PlaceNames, authoriser_of
from rosic.gateway.policy_service import PolicyService
from rosic.organiser.calendar import CalendarNames
from rosic.organiser.organiser import Organiser
from rosic.organiser.rate_limits import RateLimits
from rosic.organiser.timezones import UNIVERSAL
from rosic.stores.database import DatabaseStore
from rosic.stores.memory import MemoryStore
from rosic.stores.record_mark import STOPS, was_begun
from rosic.stores.stop_latch import FileLatch

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Iterable, Sequence
    from pathlib import Path

    from rosic.app.admin.api import AdminRequest
    from rosic.app.config import Config
    from rosic.app.people import ConfiguredPerson
    from rosic.contracts.clock import Clock, Entropy
    from rosic.contracts.store import Store
    from rosic.core.identity import PrincipalId
    from rosic.core.language import UnitTable
    from rosic.core.records import Fact, Memory
    from rosic.core.robot.profile import Profile, RobotId
    from rosic.gateway.container_context import ContainerContext

_encode = msgspec.json.Encoder(enc_hook=plain).encode

LOCAL = {"terminal": Assurance.LOCAL}


class OfflineSeeding(enum.Enum):
    """What becomes of people of the file who are not on the record yet."""

    WRITTEN = "written"
    IMAGINED = "imagined"
    LEFT = "left"


class OfflineContext(NamedTuple):
    """What the books of containers are made with."""

    units: UnitTable
    entropy: Entropy


class OfflineAdmin:
    """Answers when no gateway does.

    Args:
        data: The data folder.
        config: None when only the folder is known: then there are no robots, and no own roles.
    """

    def __init__(self, data: Path, config: Config | None, clock: Clock, entropy: Entropy) -> None:
        self._data = data
        self._config = config
        self._clock = clock
        self._entropy = entropy

    async def do(self, ask: AdminRequest, seeding: OfflineSeeding) -> tuple[str, ...]:
        """Do what is asked and return the answers.

        Raises:
            ConfigurationError: The data cannot be used, for example because a gateway just started,
                or there is none and something is to be changed.
            Refusal: Why not; nothing was changed.
            StoreFault: Not written; nothing was changed.
        """
        async with self._opened(seeding) as books:
            return tuple(await AdminApi(books).do(ask))

    async def people(self, *, json: bool) -> tuple[str, ...]:
        """Return a line for everybody; those of the file who are not on the record are marked.

        Args:
            json: Return one list for programs instead.

        Raises:
            ConfigurationError: The data cannot be used.
        """
        async with self._opened(OfflineSeeding.LEFT) as books:
            found = books.authoriser.directory.people()
            known = {person.name.casefold() for person in found}
            new = [clean(p.name) for p in self._seeds if p.name.casefold() not in known]
            if json:
                listed = (*people_listed(books), *({"name": n, "state": CONFIGURED} for n in new))
                return (_encode(listed).decode(),)
            later = (f"{name}: not taken over yet; the first start does it" for name in new)
            return (*people_lines(books), *later) or ("Nobody is known yet.",)

    @property
    def _seeds(self) -> Sequence[ConfiguredPerson]:
        return () if self._config is None else self._config.people

    @asynccontextmanager
    async def _opened(self, seeding: OfflineSeeding) -> AsyncIterator[AdminContext]:
        """Open the data. Nothing is made where there is none: it may only be elsewhere for now."""
        there = was_begun(self._data)
        if seeding is OfflineSeeding.WRITTEN and not there:
            raise ConfigurationError(
                f"Nothing has run on {self._data}: there is no record. Nothing was changed.",
                hint="Look whether the folder was moved or its disk is missing. A new gateway is "
                "started first: rosic run.",
            )
        store: Store = DatabaseStore(self._data, clock=self._clock) if there else MemoryStore()
        memory = await store.open()
        try:
            yield await self.books(store, memory, seeding)
        finally:
            await store.close()

    async def books(self, store: Store, memory: Memory, seeding: OfflineSeeding) -> AdminContext:
        """Put together what an open record holds and the configuration says."""
        config, clock, entropy = self._config, self._clock, self._entropy
        robots = () if config is None else self._robots(config, memory)
        rulebook = RoleRules(roles=DEFAULT_ROLES) if config is None else config.rulebook
        profiles = {profile.id: profile for profile in robots}
        time = MonotonicWallClock(clock)
        authoriser = authoriser_of(time, clock, entropy)
        roles = remember(authoriser, memory)
        if seeding is not OfflineSeeding.LEFT:
            sink = store if seeding is OfflineSeeding.WRITTEN else await _nowhere()
            roles |= await seed(self._seeds, memory, authoriser, sink, clock, entropy)
        preferences = preferences_of(robots, known_units(), clock, memory)
        authority = PolicyService(rulebook, robots, known_units(), time, preferences.limits)
        authority.restore(memory, roles)
        found = await self._stops(memory, profiles)
        place = "rosic" if config is None else config.name
        stops = StopRegistry(profiles, found, not_known_yet())
        zone = UNIVERSAL if config is None else config.zone
        names = CalendarNames(
            name_of=lambda who: clean(authoriser.directory.name(who)),
            shown_of=lambda robot: profiles[robot].shown if robot in profiles else robot,
            zone_of=lambda who: preferences.of(who).zone or zone,
        )
        access = AccessRegistry(
            authoriser, authority, store, entropy, stops, PlaceNames(place, names)
        )
        rights = authority.draw_up()
        rates = RateLimits(time, RateLimit(), {}, rights.rates, _nothing_is_asked, str)
        organiser = Organiser(
            authority.in_force, profiles, stops, access.state, rates=rates, lease_idle_s=1.0
        )
        access.restore(memory, organiser)
        around = DataContext(
            preferences,
            access,
            authoriser,
            organiser,
            profiles,
            VocabularyHolder(
                Vocabulary.build(robots, known_units(), command_table(), known_phrases())
            ),
            clock,
            _nobody_hears,
            CommandHistory(),
        )
        return AdminContext(
            access=access,
            authority=authority,
            authoriser=authoriser,
            organiser=organiser,
            vocabularies=around.vocabularies,
            profiles=profiles,
            clock=time,
            zone=zone_or_universal(zone),
            assurances=LOCAL,
            data_context=self._data_context(around, store, memory),
        )

    @staticmethod
    def _robots(config: Config, memory: Memory) -> tuple[Profile, ...]:
        return with_added(config.robots, memory.facts.get(ADDED, ()), known_units())

    def _data_context(
        self, around: DataContext, store: Store, memory: Memory
    ) -> ContainerContext | None:
        if not isinstance(store, ContainerStore):
            return None
        parts = OfflineContext(known_units(), self._entropy)
        data_context = data_context_of(around, store, Archive(self._clock), parts, FileQuota())
        for kind, apply in books_kept(data_context).items():
            for fact in memory.facts.get(kind, ()):
                apply(fact)
            around.access.changes.keep(kind, apply)
        return data_context

    async def _stops(
        self, memory: Memory, robots: Iterable[RobotId]
    ) -> dict[RobotId, tuple[int, bool]]:
        """Return which robots stay stopped at the next start."""
        path = self._data / STOPS
        found: dict[RobotId, tuple[int, bool]] = {}
        if path.exists():
            latch = FileLatch(path)
            try:
                found = latch.read()
            finally:
                await latch.close()
        for robot in robots:
            generation = memory.generations.get(robot, 0)
            if generation > found.get(robot, (0, False))[0]:
                found[robot] = (generation, True)
        return found


async def _nowhere() -> MemoryStore:
    store = MemoryStore()
    await store.open()
    return store


def _nobody_hears(_people: tuple[PrincipalId, ...], _text: str) -> None:
    """Without a gateway nobody is reached."""


def _nothing_is_asked(_fact: Fact) -> None:
    """Without a gateway nobody asks anything of a robot, so no bucket is used."""
