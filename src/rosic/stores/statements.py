"""Many rows in one statement, prepared once.

One statement is one visit to the database and one release of the interpreter's lock: a busy event
loop then delays a group of writes once, not once for each row.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from sqlalchemy import (
    BindParameter,
    Column,
    ColumnElement,
    Delete,
    Dialect,
    Table,
    bindparam,
    case,
    delete,
)

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from sqlalchemy.engine.interfaces import DBAPICursor
    from sqlalchemy.sql import ClauseElement
    from sqlalchemy.sql.dml import Insert

ROWS_MAX = 128  # in one statement; more rows are several statements


class Many:
    """A statement that comes in sizes: for 1, 2, 4 ... rows."""

    def __init__(self, dialect: Dialect, width: int) -> None:
        self._dialect = dialect
        self._width = width
        self._texts: dict[int, str] = {}

    def run(self, cursor: DBAPICursor, flat: Sequence[object]) -> None:
        """Run it over rows that are written one after another into one flat list.

        On the driver's own cursor, for the statement is in the driver's own words already.
        """
        start, width = 0, self._width
        while start < len(flat):
            rows = min((len(flat) - start) // width, ROWS_MAX)
            rows = 1 << (rows.bit_length() - 1)
            text = self._texts.get(rows) or self._prepare(rows)
            end = start + rows * width
            cursor.execute(text, tuple(flat[start:end]))
            start = end

    def _prepare(self, rows: int) -> str:
        compiled = self.statement(rows).compile(dialect=self._dialect)
        self._texts[rows] = str(compiled)
        return self._texts[rows]

    def statement(self, rows: int) -> ClauseElement:
        """Build it for a number of rows; parameters in the order of the flat list."""
        raise NotImplementedError


class Put(Many):
    """Insert rows.

    Args:
        settle: What happens to a row that is there already: None is an error, an empty mapping
            leaves it, and a mapping says for each column whether it takes the ``new`` value or
            the ``highest``.
        where: A row that is there already and is not like this is left, too.
    """

    def __init__(
        self,
        dialect: Dialect,
        table: Table,
        settle: Mapping[str, str] | None = None,
        *,
        where: ColumnElement[bool] | None = None,
    ) -> None:
        columns = [column for column in table.columns if column.name != "id"]
        super().__init__(dialect, len(columns))
        self._table = table
        # Each dialect has an insert of its own that knows ON CONFLICT; both are used alike.
        self._insert = import_module(f"sqlalchemy.dialects.{dialect.name}").insert
        self._names = [column.name for column in columns]
        self._settle = settle
        self._where = where

    def statement(self, rows: int) -> Insert:
        """Build the insertion of a number of rows."""
        insert: Any = self._insert(self._table).values(
            [{name: bindparam(f"row{row}_{name}") for name in self._names} for row in range(rows)]
        )
        if self._settle is None:
            return insert  # type: ignore[no-any-return]  # one of two dialects' inserts
        if not self._settle:
            return insert.on_conflict_do_nothing()  # type: ignore[no-any-return]
        new = insert.excluded
        changes = {
            name: new[name] if how == "new" else highest(self._table.c[name], new[name])
            for name, how in self._settle.items()
        }
        return insert.on_conflict_do_update(  # type: ignore[no-any-return]
            index_elements=list(self._table.primary_key.columns),
            set_=changes,
            where=self._where,
        )


class Take(Many):
    """Delete the rows in which a column has one of many values."""

    def __init__(self, dialect: Dialect, column: Column[Any]) -> None:
        super().__init__(dialect, 1)
        self._column = column

    def statement(self, rows: int) -> Delete:
        """Build the deletion for a number of values."""
        values: list[BindParameter[Any]] = [bindparam(f"row{row}") for row in range(rows)]
        return delete(self._column.table).where(self._column.in_(values))


def highest(old: ColumnElement[Any], new: ColumnElement[Any]) -> ColumnElement[Any]:
    """Return the higher of two columns: what it is set to never falls."""
    return case((new > old, new), else_=old)
