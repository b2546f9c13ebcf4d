"""Administrative acts as they are read back."""

from __future__ import annotations

from typing import TYPE_CHECKING

from sqlalchemy import Dialect, bindparam, select

from rosic.core.records import Decided
from rosic.stores import tables
from rosic.stores.statements import in_words

if TYPE_CHECKING:
    from sqlalchemy.engine.interfaces import DBAPICursor


class DecisionQuery:
    """Reads administrative acts, the newest first, on the driver's own cursor.

    That is outside any transaction: it waits for nobody and takes no right to write.
    """

    def __init__(self, dialect: Dialect) -> None:
        table = tables.decisions
        older = select(table).where(table.c.id < bindparam("before")).order_by(table.c.id.desc())
        self._text = in_words(dialect, older)

    def run(self, cursor: DBAPICursor, before: int, limit: int) -> list[tuple[int, Decided]]:
        """Return the newest ones before one of them, each with its number; close the cursor."""
        try:
            cursor.execute(self._text, (before,))
            rows = cursor.fetchmany(limit)
        finally:
            cursor.close()  # left half read, it would keep the log file from being cut
        return [
            (number, Decided(act=act, by=by, about=about, at_ns=at_ns, digest=digest))
            for number, act, by, about, at_ns, digest in rows
        ]
