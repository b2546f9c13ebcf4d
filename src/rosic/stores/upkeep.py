"""What is forgotten: old commands that are settled, and the key of a container that is erased."""

from __future__ import annotations

from typing import TYPE_CHECKING

from sqlalchemy import Connection, Dialect, delete, select, update

from rosic.stores import decoding, tables
from rosic.stores.statements import Take

if TYPE_CHECKING:
    from rosic.stores.settings import StoreSettings

AT_ONCE = 1_000  # in one transaction, so that writes never wait long
DAY_NS = 86_400 * 10**9


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
        self._takes = [Take(dialect, table.c.seq) for table in parts]
        self._take_stops = Take(dialect, tables.stops.c.id)
        self._take_decisions = Take(dialect, tables.decisions.c.id)

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
