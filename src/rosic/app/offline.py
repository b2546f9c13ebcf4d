"""People and their access while no gateway runs: straight from the data, which it takes."""

from __future__ import annotations

from contextlib import asynccontextmanager
from typing import TYPE_CHECKING

from rosic.app.operating import people_lines, revoked, the_one
from rosic.app.people import Seed, remember, seed
from rosic.authoriser.authoriser import Authoriser
from rosic.authoriser.directory import Directory
from rosic.core.identity import OPERATOR
from rosic.core.language import clean
from rosic.core.record import KeyRevoked, Memory
from rosic.stores.database import DatabaseStore
from rosic.stores.folder import DATABASE

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Sequence
    from pathlib import Path

    from rosic.contracts.clock import Clock
    from rosic.contracts.entropy import Entropy


class People:
    """Everybody on a record that is open.

    Attributes:
        store: Open.
        memory: What it held.
    """

    def __init__(self, store: DatabaseStore, memory: Memory, authoriser: Authoriser) -> None:
        self.store = store
        self.memory = memory
        self.authoriser = authoriser


async def list_people(
    data: Path, seeds: Sequence[Seed], clock: Clock, entropy: Entropy
) -> tuple[str, ...]:
    """Return a line for everybody; those of the file who are not on the record yet are marked.

    Raises:
        ConfigurationError: The data cannot be used.
    """
    waiting = [f"{person.name}: not taken over yet; the first start does it" for person in seeds]
    if not (data / DATABASE).exists():
        return tuple(waiting) or ("Nobody is known yet.",)
    async with _opened(data, clock, entropy) as people:
        known = {person.name.casefold() for person in people.authoriser.directory.people()}
        new = [
            line for person, line in zip(seeds, waiting, strict=True)
            if person.name.casefold() not in known
        ]  # fmt: skip
        return (*people_lines(people.authoriser.directory), *new)


async def revoke_person(
    data: Path, name: str, seeds: Sequence[Seed], clock: Clock, entropy: Entropy
) -> str:
    """Take somebody's access back before any gateway starts. Return what was done.

    People of the configuration file are taken over first: once they are on the record, the file
    has no say in it again.

    Raises:
        ConfigurationError: The data cannot be used, for example because a gateway just started.
        NotUnderstood: Nobody, or more than one, is called so.
        StoreFault: Not written; they still have access.
    """
    async with _opened(data, clock, entropy) as people:
        await seed(seeds, people.memory, people.authoriser, people.store, clock, entropy)
        person = the_one(people.authoriser.directory, name)
        key = people.authoriser.directory.key_of(person.id)
        if key is None or key.revoked_ns is not None:
            return f"{clean(person.name)} has no access already. Nothing was changed."
        await people.store.write(KeyRevoked(key=key.id, by=OPERATOR, at_ns=clock.wall_ns()))
        return revoked(person)


@asynccontextmanager
async def _opened(data: Path, clock: Clock, entropy: Entropy) -> AsyncIterator[People]:
    store = DatabaseStore(data, clock=clock)
    memory = await store.open()
    try:
        authoriser = Authoriser(Directory(), clock, entropy)
        remember(authoriser, memory)
        yield People(store, memory, authoriser)
    finally:
        await store.close()
