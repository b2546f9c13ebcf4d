"""Many rows in one statement, prepared once.

One statement is one visit to the database and one release of the interpreter's lock: a busy event
loop then delays a group of writes once, not once for each row.
"""

from __future__ import annotations

from bisect import bisect_right
from importlib import import_module
from typing import TYPE_CHECKING, Any

from sqlalchemy import (
    Column,
    ColumnElement,
    Dialect,
    Table,
    and_,
    bindparam,
    case,
    delete,
    select,
)

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from sqlalchemy.engine.interfaces import DBAPICursor
    from sqlalchemy.sql import ClauseElement
    from sqlalchemy.sql.dml import Insert

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
