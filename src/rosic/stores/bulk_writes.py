"""What is run for a group of records, in an order in which no row misses the one it belongs to."""

from __future__ import annotations

from functools import partial
from itertools import chain
from typing import TYPE_CHECKING, Any

from sqlalchemy import Connection, Dialect, delete, select, update

from rosic.core.time_units import DAY_NS
from rosic.stores import decoding, tables
from rosic.stores.statements import DeletePairs, DeleteRows, InsertRows

if TYPE_CHECKING:
    from collections.abc import Iterable

    from sqlalchemy.engine.interfaces import DBAPICursor

    from rosic.stores.data_dir import StoreSettings
    from rosic.stores.encoding import WriteBatch

HIGHEST = dict.fromkeys(("n", "fence", "generation"), "highest")
LETTER = {"container": "new", "sealed": "new"}
SIFTED = "commands"  # the part of the record that is sifted


class BulkInsert:
    """All statements of a group, prepared once."""

    def __init__(self, dialect: Dialect) -> None:
        put = partial(InsertRows, dialect)
        self.containers = put(tables.containers, {"wrapped": "new"})
        self.commands = put(tables.commands)
        # The first outcome counts; one without a letter takes the words away, for nobody hears it.
        self.endings = put(tables.endings, LETTER, unless="container")
        self.places = put(tables.places, LETTER)
        self.tellings = put(tables.tellings, {})
        self.opened = put(tables.open_orders_of)
        self.closed = DeleteRows(dialect, tables.open_orders_of.c.seq)
        self.sifted = put(tables.sifted, {"below": "highest"})
        self.robots = put(tables.robots, HIGHEST)
        self.stops = put(tables.stops)
        self.principals = put(tables.principals, {"roles": "new", "at_ns": "new"})
        self.cards = put(tables.cards, LETTER)
        self.issued = put(tables.keys, {})
        self.revocations = put(tables.revocations, {})
        self.seeds = put(tables.seeds, {})
        self.selections = put(tables.selections, {"robot": "new"})
        self.ended = DeletePairs(dialect, tables.facts.c.kind, tables.facts.c.key)
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


AT_ONCE = 1_000  # in one transaction, so that writes never wait long


def horizon(connection: Connection, now_ns: int, settings: StoreSettings) -> int:
    """Return the time before which settled commands may be forgotten.

    Counted back from the newest command too: a clock that jumps ahead erases nothing.
    """
    commands = tables.commands
    query = select(commands.c.at_ns).order_by(commands.c.seq.desc()).limit(1)
    newest = next((row.at_ns for row in decoding.checked(connection, query)), 0)
    return min(now_ns, newest) - settings.kept_days * DAY_NS


class Erasure:
    """The statements that forget."""

    def __init__(self, dialect: Dialect) -> None:
        parts = (tables.endings, tables.places, tables.tellings, tables.commands)
        self._takes = [DeleteRows(dialect, table.c.seq) for table in parts]
        self._take_stops = DeleteRows(dialect, tables.stops.c.id)
        self._take_decisions = DeleteRows(dialect, tables.decisions.c.id)

    def prune(self, connection: Connection, before_ns: int) -> int:
        """Forget the oldest commands that are settled, and old stops; some, not all at once."""
        commands, stops = tables.commands, tables.stops
        oldest = (
            select(commands.c.seq, commands.c.at_ns)
            .where(~decoding.is_open(commands.c.seq))
            .order_by(commands.c.seq)
            .limit(AT_ONCE)
        )
        old = [row.seq for row in decoding.checked(connection, oldest) if row.at_ns < before_ns]
        cursor = connection.connection.cursor()
        for take in self._takes:
            take.run(cursor, old)
        oldest_stops = select(stops.c.id, stops.c.at_ns).order_by(stops.c.id).limit(AT_ONCE)
        old_stops = [
            row.id for row in decoding.checked(connection, oldest_stops) if row.at_ns < before_ns
        ]
        self._take_stops.run(cursor, old_stops)
        return len(old)

    def forget_decisions(self, connection: Connection, before_ns: int, kept_ns: int) -> int:
        """Forget the oldest administrative acts; some, not all at once. Return how many.

        Args:
            connection: In a transaction.
            before_ns: Wall clock.
            kept_ns: Nothing goes that is not older than the newest act by this much.
        """
        table = tables.decisions.c
        query = select(table.at_ns).order_by(table.id.desc()).limit(1)
        newest = next((row.at_ns for row in decoding.checked(connection, query)), 0)
        before_ns = min(before_ns, newest - kept_ns)
        oldest = select(table.id, table.at_ns).order_by(table.id).limit(AT_ONCE)
        old = [row.id for row in decoding.checked(connection, oldest) if row.at_ns < before_ns]
        self._take_decisions.run(connection.connection.cursor(), old)
        return len(old)

    def shred(self, connection: Connection, container: str) -> None:
        """Erase the key of a container, and with it every letter sealed with it."""
        containers, cards, facts = tables.containers, tables.cards, tables.facts
        connection.execute(delete(cards).where(cards.c.container == container))
        connection.execute(
            update(facts).where(facts.c.container == container).values(container=None, sealed=None)
        )
        connection.execute(
            update(containers).where(containers.c.container == container).values(wrapped=None)
        )
