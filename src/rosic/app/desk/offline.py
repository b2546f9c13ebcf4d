"""The operator's desk while no gateway runs: straight from the data, which it takes."""

from __future__ import annotations

import enum
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING, NamedTuple

import msgspec

from rosic.app.desk.books import Books, zone_or_universal
from rosic.app.desk.naming import CONFIGURED, people_lines, people_listed
from rosic.app.desk.operator_desk import OperatorDesk
from rosic.app.documents.profiles import known_units
from rosic.app.placing.access import Access, authoriser_of
from rosic.app.placing.authority import Authority
from rosic.app.placing.enlisted import KIND as ENLISTED
from rosic.app.placing.enlisted import with_enlisted
from rosic.app.placing.holding import Around, holdings_of, preferences_of
from rosic.app.placing.people import remember, seed
from rosic.authoriser.highwater import HighWater
from rosic.container.archive import Archive
from rosic.container.drawer import Room
from rosic.container.habits import Habits
from rosic.core.language import Vocabulary, clean
from rosic.core.rate import RateLimit
from rosic.core.roles import DEFAULT_ROLES, Assurance, Rulebook
from rosic.core.saying import plain
from rosic.core.stopboard import StopBoard, not_known_yet
from rosic.errors import ConfigurationError
from rosic.organiser.organiser import Organiser
from rosic.organiser.rates import Rates
from rosic.organiser.zones import UNIVERSAL
from rosic.pipeline.containers.clerks import books_kept
from rosic.pipeline.containers.parts import Vault
from rosic.stores.database import DatabaseStore
from rosic.stores.latch import FileLatch
from rosic.stores.memory import MemoryStore
from rosic.stores.record_mark import STOPS, was_begun

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Iterable, Sequence
    from pathlib import Path

    from rosic.app.config import Config
    from rosic.app.desk.asked import Ask
    from rosic.app.placing.people import Seed
    from rosic.contracts.clock import Clock
    from rosic.contracts.entropy import Entropy
    from rosic.contracts.store import Store
    from rosic.core.identity import PrincipalId
    from rosic.core.language import UnitTable
    from rosic.core.record import Fact, Memory
    from rosic.core.robot import Profile, RobotId
    from rosic.pipeline.containers.parts import Holdings

_encode = msgspec.json.Encoder(enc_hook=plain).encode

LOCAL = {"terminal": Assurance.LOCAL}


class Seeding(enum.Enum):
    """What becomes of people of the file who are not on the record yet."""

    WRITTEN = "written"
    IMAGINED = "imagined"
    LEFT = "left"


class Parts(NamedTuple):
    """What the books of containers are made with."""

    units: UnitTable
    entropy: Entropy


class Alone:
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

    async def do(self, ask: Ask, seeding: Seeding) -> tuple[str, ...]:
        """Do what is asked and return the answers.

        Raises:
            ConfigurationError: The data cannot be used, for example because a gateway just started,
                or there is none and something is to be changed.
            Refusal: Why not; nothing was changed.
            StoreFault: Not written; nothing was changed.
        """
        async with self._opened(seeding) as books:
            return tuple(await OperatorDesk(books).do(ask))

    async def people(self, *, json: bool) -> tuple[str, ...]:
        """Return a line for everybody; those of the file who are not on the record are marked.

        Args:
            json: Return one list for programs instead.

        Raises:
            ConfigurationError: The data cannot be used.
        """
        async with self._opened(Seeding.LEFT) as books:
            found = books.authoriser.directory.people()
            known = {person.name.casefold() for person in found}
            new = [clean(p.name) for p in self._seeds if p.name.casefold() not in known]
            if json:
                listed = (*people_listed(books), *({"name": n, "state": CONFIGURED} for n in new))
                return (_encode(listed).decode(),)
            later = (f"{name}: not taken over yet; the first start does it" for name in new)
            return (*people_lines(books), *later) or ("Nobody is known yet.",)

    @property
    def _seeds(self) -> Sequence[Seed]:
        return () if self._config is None else self._config.people

    @asynccontextmanager
    async def _opened(self, seeding: Seeding) -> AsyncIterator[Books]:
        """Open the data. Nothing is made where there is none: it may only be elsewhere for now."""
        there = was_begun(self._data)
        if seeding is Seeding.WRITTEN and not there:
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

    async def books(self, store: Store, memory: Memory, seeding: Seeding) -> Books:
        """Put together what an open record holds and the configuration says."""
        config, clock, entropy = self._config, self._clock, self._entropy
        robots = () if config is None else self._robots(config, memory)
        rulebook = Rulebook(roles=DEFAULT_ROLES) if config is None else config.rulebook
        profiles = {profile.id: profile for profile in robots}
        time = HighWater(clock)
        authoriser = authoriser_of(time, clock, entropy)
        roles = remember(authoriser, memory)
        if seeding is not Seeding.LEFT:
            sink = store if seeding is Seeding.WRITTEN else await _nowhere()
            roles |= await seed(self._seeds, memory, authoriser, sink, clock, entropy)
        preferences = preferences_of(robots, known_units(), clock, memory)
        authority = Authority(rulebook, robots, known_units(), time, preferences.limits)
        authority.restore(memory, roles)
        stops = await self._stops(memory, profiles)
        place = "rosic" if config is None else config.name
        access = Access(authoriser, authority, store, entropy, place)
        board = StopBoard(profiles, stops, not_known_yet())
        rights = authority.draw_up()
        rates = Rates(time, RateLimit(), {}, rights.rates, _nothing_is_asked, str)
        organiser = Organiser(rights, profiles, board, access.state, rates=rates, lease_idle_s=1.0)
        organiser.name_of = lambda who: clean(authoriser.directory.name(who))
        access.restore(memory, organiser, board)
        vocabulary = Vocabulary.build(robots, known_units())
        around = Around(
            preferences, access, authoriser, organiser, profiles, vocabulary, clock,
            _nobody_hears, Habits(),
        )  # fmt: skip
        return Books(
            access=access, authority=authority, authoriser=authoriser, organiser=organiser,
            vocabulary=vocabulary, profiles=profiles, clock=time,
            zone=zone_or_universal(UNIVERSAL if config is None else config.zone),
            assurances=LOCAL,
            holdings=self._holdings(around, store, memory),
        )  # fmt: skip

    @staticmethod
    def _robots(config: Config, memory: Memory) -> tuple[Profile, ...]:
        return with_enlisted(config.robots, memory.facts.get(ENLISTED, ()), known_units())

    def _holdings(self, around: Around, store: Store, memory: Memory) -> Holdings | None:
        if not isinstance(store, Vault):
            return None
        parts = Parts(known_units(), self._entropy)
        holdings = holdings_of(around, store, Archive(self._clock), parts, Room())
        for kind, apply in books_kept(holdings).items():
            for fact in memory.facts.get(kind, ()):
                apply(fact)
            around.access.changes.keep(kind, apply)
        return holdings

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
