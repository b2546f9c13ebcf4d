"""What is run for a group of records, in an order in which no row misses the one it belongs to."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Any

from sqlalchemy import Dialect, literal_column

from rosic.stores import tables
from rosic.stores.statements import Put, Take

if TYPE_CHECKING:
    from collections.abc import Iterable

    from sqlalchemy.engine.interfaces import DBAPICursor

    from rosic.stores.scribe import Batch

LATEST_PLACE = tables.letters.c.kind == literal_column("'placed'")
HIGHEST = dict.fromkeys(("n", "fence", "generation"), "highest")


class Insertion:
    """All statements of a group, prepared once."""

    def __init__(self, dialect: Dialect) -> None:
        put = partial(Put, dialect)
        self.containers = put(tables.containers, {"wrapped": "new"})
        self.commands = put(tables.commands)
        self.opened = put(tables.open_lives)
        self.endings = put(tables.endings, {})
        self.letters = put(
            tables.letters, {"container": "new", "sealed": "new"}, where=LATEST_PLACE
        )
        self.tellings = put(tables.tellings, {})
        self.closed = Take(dialect, tables.open_lives.c.seq)
        self.robots = put(tables.robots, HIGHEST)
        self.stops = put(tables.stops)
        self.principals = put(tables.principals, {"roles": "new", "at_ns": "new"})
        self.cards = put(tables.cards, {"container": "new", "sealed": "new"})
        self.issued = put(tables.keys, {})
        self.revocations = put(tables.revocations, {})
        self.seeds = put(tables.seeds, {})
        self.selections = put(tables.selections, {"robot": "new"})
        self.gaps = put(tables.gaps)

    def run(self, cursor: DBAPICursor, batch: Batch) -> None:
        """Write the rows of a group."""
        containers = [(key.container, key.wrapped) for key in batch.keys.values()]
        letters = [(*place, *sealed) for place, sealed in batch.letters.items()]
        robots = [(robot, *numbers) for robot, numbers in batch.robots.items()]
        opened = [seq for cid, seq in batch.opened.items() if cid not in batch.closed]
        self.containers.run(cursor, flat(containers))
        self.commands.run(cursor, batch.commands)
        self.opened.run(cursor, opened)
        self.endings.run(cursor, batch.endings)
        self.letters.run(cursor, flat(letters))
        self.tellings.run(cursor, batch.tellings)
        self.closed.run(cursor, list(batch.closed.values()))
        self.robots.run(cursor, flat(robots))
        self.stops.run(cursor, batch.stops)
        self._run_people(cursor, batch)

    def _run_people(self, cursor: DBAPICursor, batch: Batch) -> None:
        self.principals.run(cursor, flat((p, *row) for p, row in batch.principals.items()))
        self.cards.run(cursor, flat((p, *row) for p, row in batch.cards.items()))
        self.issued.run(cursor, batch.issued)
        self.revocations.run(cursor, batch.revocations)
        self.seeds.run(cursor, batch.seeds)
        self.selections.run(
            cursor, flat((*place, robot) for place, robot in batch.selections.items())
        )


def flat(rows: Iterable[tuple[Any, ...]]) -> list[object]:
    """Return rows one after another in one list."""
    return [value for row in rows for value in row]
