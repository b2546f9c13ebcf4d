"""What is run for a group of records, in an order in which no row misses the one it belongs to."""

from __future__ import annotations

from functools import partial
from itertools import chain
from typing import TYPE_CHECKING, Any

from rosic.stores import tables
from rosic.stores.statements import Put, Take, TakePairs

if TYPE_CHECKING:
    from collections.abc import Iterable

    from sqlalchemy import Dialect
    from sqlalchemy.engine.interfaces import DBAPICursor

    from rosic.stores.batch import WriteBatch

HIGHEST = dict.fromkeys(("n", "fence", "generation"), "highest")
LETTER = {"container": "new", "sealed": "new"}
SIFTED = "commands"  # the part of the record that is sifted


class BulkInsert:
    """All statements of a group, prepared once."""

    def __init__(self, dialect: Dialect) -> None:
        put = partial(Put, dialect)
        self.containers = put(tables.containers, {"wrapped": "new"})
        self.commands = put(tables.commands)
        # The first outcome counts; one without a letter takes the words away, for nobody hears it.
        self.endings = put(tables.endings, LETTER, unless="container")
        self.places = put(tables.places, LETTER)
        self.tellings = put(tables.tellings, {})
        self.opened = put(tables.open_lives)
        self.closed = Take(dialect, tables.open_lives.c.seq)
        self.sifted = put(tables.sifted, {"below": "highest"})
        self.robots = put(tables.robots, HIGHEST)
        self.stops = put(tables.stops)
        self.principals = put(tables.principals, {"roles": "new", "at_ns": "new"})
        self.cards = put(tables.cards, LETTER)
        self.issued = put(tables.keys, {})
        self.revocations = put(tables.revocations, {})
        self.seeds = put(tables.seeds, {})
        self.selections = put(tables.selections, {"robot": "new"})
        self.ended = TakePairs(dialect, tables.facts.c.kind, tables.facts.c.key)
        self.facts = put(tables.facts, LETTER | {"body": "new"}, known_by=("kind", "key"))
        self.decisions = put(tables.decisions)
        self.gaps = put(tables.gaps)

    def run(self, cursor: DBAPICursor, batch: WriteBatch) -> None:
        """Write the rows of a group."""
        if batch.keys:
            keys = batch.keys.values()
            self.containers.run(cursor, [part for k in keys for part in (k.container, k.wrapped)])
        self.commands.run(cursor, batch.commands)
        self.endings.run(cursor, flat(batch.endings.values()))
        self.places.run(cursor, flat(batch.places.values()))
        self.tellings.run(cursor, batch.tellings)
        self.robots.run(cursor, flat((robot, *seen) for robot, seen in batch.robots.items()))
        self.closed.run(cursor, batch.struck)
        if batch.below is not None:
            self.opened.run(cursor, batch.kept)
            self.sifted.run(cursor, [SIFTED, batch.below])
        self.stops.run(cursor, batch.stops)
        self._run_people(cursor, batch)
        if batch.decisions or batch.ended or batch.facts:
            self._run_rooms(cursor, batch)

    def _run_people(self, cursor: DBAPICursor, batch: WriteBatch) -> None:
        self.principals.run(cursor, flat((p, *row) for p, row in batch.principals.items()))
        self.cards.run(cursor, flat((p, *row) for p, row in batch.cards.items()))
        self.issued.run(cursor, batch.issued)
        self.revocations.run(cursor, batch.revocations)
        self.seeds.run(cursor, batch.seeds)
        self.selections.run(
            cursor, flat((*place, robot) for place, robot in batch.selections.items())
        )

    def _run_rooms(self, cursor: DBAPICursor, batch: WriteBatch) -> None:
        self.decisions.run(cursor, batch.decisions)
        self.ended.run(cursor, flat(batch.ended))
        self.facts.run(cursor, flat((*place, *row) for place, row in batch.facts.items()))


def flat(rows: Iterable[tuple[Any, ...]]) -> list[object]:
    """Return rows one after another in one list."""
    return list(chain.from_iterable(rows))
