"""Commands as they are read back, the newest first, in steps that hold up no write."""

from __future__ import annotations

from typing import TYPE_CHECKING

from sqlalchemy import Select, func, select

from rosic.core.history import STOPPED, HistoryEntry, HistoryQuery
from rosic.stores import tables
from rosic.stores.encoding import CLAIM, WORDS

if TYPE_CHECKING:
    from collections.abc import Callable

    from sqlalchemy import Connection, Row

    from rosic.core.identity import CommandId

    Letter = Callable[[str | None, bytes, CommandId, bytes | None], bytes | None]

AT_ONCE = 2_000
"""Commands that one step looks at: some milliseconds."""


def newest(connection: Connection) -> int:
    """Return the number behind the newest command."""
    found = connection.scalar(select(func.max(tables.commands.c.seq)))
    return 0 if found is None else int(found) + 1


def newest_stop(connection: Connection) -> int:
    """Return the number behind the newest stop."""
    found = connection.scalar(select(func.max(tables.stops.c.id)))
    return 0 if found is None else int(found) + 1


def stops(
    connection: Connection, query: HistoryQuery, before: int, limit: int
) -> list[HistoryEntry]:
    """Return what is asked about of the ``AT_ONCE`` stops before one of them, newest first."""
    table = tables.stops.c
    chosen = select(tables.stops).where(
        table.id < before, table.id >= before - AT_ONCE, table.at_ns >= query.since_ns
    )
    if query.principal:
        chosen = chosen.where(table.principal == query.principal)
    if query.robot:
        chosen = chosen.where(table.robot == query.robot)
    rows = connection.execute(chosen.order_by(table.id.desc()).limit(limit)).all()
    return [
        HistoryEntry(principal=row.principal, kind=STOPPED, at_ns=row.at_ns, robot=row.robot)
        for row in rows
    ]


def page(
    connection: Connection, letter: Letter, query: HistoryQuery, before: int, limit: int
) -> list[HistoryEntry]:
    """Return what is asked about of the ``AT_ONCE`` commands before one of them, newest first."""
    rows = connection.execute(_selected(query, before).limit(limit)).all()
    return [_entry(row, letter) for row in rows]


def one(connection: Connection, letter: Letter, query: HistoryQuery) -> list[HistoryEntry]:
    """Return the one command that is asked about by its id, or nothing."""
    rows = connection.execute(_joined(query).where(tables.commands.c.cid == query.cid)).all()
    return [_entry(row, letter) for row in rows]


def _selected(query: HistoryQuery, before: int) -> Select[tuple[object, ...]]:
    commands = tables.commands.c
    chosen = _joined(query).where(commands.seq < before, commands.seq >= before - AT_ONCE)
    return chosen.order_by(commands.seq.desc())


def _joined(query: HistoryQuery) -> Select[tuple[object, ...]]:
    commands, endings = tables.commands.c, tables.endings.c
    chosen = select(
        tables.commands,
        endings.ending,
        endings.at_ns.label("ended_ns"),
        endings.container.label("words_container"),
        endings.sealed.label("words_sealed"),
    ).where(commands.at_ns >= query.since_ns)
    if query.principal:
        chosen = chosen.where(commands.principal == query.principal)
    if query.robot:
        chosen = chosen.where(commands.robot == query.robot)
    return chosen.outerjoin_from(tables.commands, tables.endings, endings.seq == commands.seq)


def _entry(row: Row[tuple[object, ...]], letter: Letter) -> HistoryEntry:
    return HistoryEntry(
        principal=row.principal,
        kind=row.kind,
        at_ns=row.at_ns,
        robot=row.robot or "",
        skill=row.skill or "",
        n=row.n or 0,
        outcome=row.ending or row.code or "",
        ended_ns=row.ended_ns,
        letter=letter(row.container, CLAIM, row.cid, row.sealed),
        words=letter(row.words_container, WORDS, row.cid, row.words_sealed),
    )
