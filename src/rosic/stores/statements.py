"""Many rows in one statement, prepared once.

One statement is one visit to the database and one release of the interpreter's lock: a busy event
loop then delays a group of writes once, not once for each row.
"""

from __future__ import annotations

from bisect import bisect_right
from functools import partial
from importlib import import_module
from itertools import chain
from typing import TYPE_CHECKING, Any

from sqlalchemy import (
    Column,
    ColumnElement,
    Connection,
    Dialect,
    Table,
    and_,
    bindparam,
    case,
    delete,
    select,
    update,
)

from rosic.core.time_units import DAY_NS
from rosic.stores import decoding, tables

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    from sqlalchemy.engine.interfaces import DBAPICursor
    from sqlalchemy.sql import ClauseElement
    from sqlalchemy.sql.dml import Insert

    from rosic.stores.data_dir import StoreSettings
    from rosic.stores.encoding import WriteBatch

# Rows in one statement; more rows are several statements. Few sizes, for the driver keeps each
# prepared; close together, so that a group needs two or three statements a table.
SIZES = (1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64, 96, 128)


class BulkStatement:
    """A statement that comes in sizes.

    It is compiled for one row; the text for more rows repeats what stands there for one.

    Args:
        statement: For one row, its values as parameters in the order of the flat list.
        unit: How one row looks in its text.
        width: Values of one row.
        between: What stands between two of them.
    """

    def __init__(
        self,
        dialect: Dialect,
        statement: ClauseElement,
        unit: str,
        width: int,
        *,
        between: str = ", ",
    ) -> None:
        self._between = between
        self._head, self._unit, self._tail = in_words(dialect, statement).partition(unit)
        if not self._unit:
            raise ValueError(f"{self._head} has no {unit}")
        self._width = width
        self._texts: dict[int, str] = {}

    def run(self, cursor: DBAPICursor, flat: Sequence[object]) -> None:
        """Run it over rows that are written one after another into one flat list.

        On the driver's own cursor, for the statement is in the driver's own words already.
        """
        start, width = 0, self._width
        while start < len(flat):
            rows = (len(flat) - start) // width
            rows = SIZES[bisect_right(SIZES, rows) - 1]
            text = self._texts.get(rows) or self._repeated(rows)
            end = start + rows * width
            cursor.execute(text, tuple(flat[start:end]))
            start = end

    def _repeated(self, rows: int) -> str:
        text = self._texts[rows] = self._head + self._between.join([self._unit] * rows) + self._tail
        return text


class InsertRows(BulkStatement):
    """Insert rows.

    Args:
        settle: What happens to a row that is there already: None is an error, an empty mapping
            leaves it, and a mapping says for each column whether it takes the ``new`` value or
            the ``highest``.
        unless: A row that is there already stays as it is unless this column is NULL in the new.
        known_by: Columns by which a row is known; none for those of its primary key.
    """

    def __init__(
        self,
        dialect: Dialect,
        table: Table,
        settle: Mapping[str, str] | None = None,
        *,
        unless: str | None = None,
        known_by: tuple[str, ...] = (),
    ) -> None:
        # Each dialect has an insert of its own that knows ON CONFLICT; both are used alike.
        insert = import_module(f"sqlalchemy.dialects.{dialect.name}").insert
        names = [column.name for column in table.columns if column.name != "id"]
        one_row = insert(table).values([{name: bindparam(name) for name in names}])
        place = [table.c[name] for name in known_by] or list(table.primary_key.columns)
        statement = settled(one_row, place, settle, unless)
        super().__init__(dialect, statement, f"({', '.join('?' * len(names))})", len(names))


class DeleteRows(BulkStatement):
    """Delete the rows in which a column has one of many values."""

    def __init__(self, dialect: Dialect, column: Column[Any]) -> None:
        statement = delete(column.table).where(column.in_([bindparam("value")]))
        super().__init__(dialect, statement, "?", 1)


class DeletePairs(BulkStatement):
    """Delete the rows in which two columns together have one of many pairs of values.

    Each pair is found by the index of the two; a list of pairs would be looked for row by row.
    """

    def __init__(self, dialect: Dialect, first: Column[Any], second: Column[Any]) -> None:
        pair = and_(first == bindparam("first"), second == bindparam("second"))
        unit = in_words(dialect, pair)
        super().__init__(dialect, delete(first.table).where(pair), unit, 2, between=" OR ")


class FindValue:
    """Look up one value of one row."""

    def __init__(self, dialect: Dialect, wanted: Column[Any], known: Column[Any]) -> None:
        self._text = in_words(dialect, select(wanted).where(known == bindparam("value")))

    def run(self, cursor: DBAPICursor, value: object) -> Any:  # noqa: ANN401  a column's type
        """Return the value; None if there is no such row."""
        cursor.execute(self._text, (value,))
        rows = cursor.fetchall()
        return rows[0][0] if rows else None


def in_words(dialect: Dialect, statement: ClauseElement) -> str:
    """Return a statement in the driver's words."""
    return str(statement.compile(dialect=dialect))


def settled(
    insert: Any,  # noqa: ANN401  one of two dialects' inserts
    place: Sequence[Column[Any]],
    settle: Mapping[str, str] | None,
    unless: str | None,
) -> Insert:
    """Say in an insertion what happens to a row that is there already, in its place."""
    if settle is None:
        return insert  # type: ignore[no-any-return]
    if not settle:
        return insert.on_conflict_do_nothing()  # type: ignore[no-any-return]
    new = insert.excluded
    old = place[0].table.c
    changes = {
        name: new[name] if how == "new" else highest(old[name], new[name])
        for name, how in settle.items()
    }
    return insert.on_conflict_do_update(  # type: ignore[no-any-return]
        index_elements=place,
        set_=changes,
        where=None if unless is None else new[unless].is_(None),
    )


def highest(old: ColumnElement[Any], new: ColumnElement[Any]) -> ColumnElement[Any]:
    """Return the higher of two columns: what it is set to never falls."""
    return case((new > old, new), else_=old)


# ---- bulk writes ----

# What is run for a group of records, in an order in which no row misses the one it belongs to.

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
