"""Looks for a text in everything that a homeserver keeps: its database, its files, its log."""

from __future__ import annotations

import base64
import json
import sqlite3
from contextlib import closing
from typing import TYPE_CHECKING, Any, Final

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator
    from pathlib import Path

    from tests.real.matrix.synapse import Synapse

_SHORTEST: Final = 6
"""What is shorter stands in base64 anywhere, by chance."""


def found_in(synapse: Synapse, text: str) -> list[str]:
    """Return where a text stands: columns of tables, and files by their path.

    It is looked for as it is, as JSON escapes it, and in base64 at any offset. The server may run;
    what it has answered for stands in its database by then.
    """
    wanted = spellings(text)
    return [*_in_tables(synapse.database, wanted), *_in_files(synapse.folder, wanted)]


def spellings(text: str) -> tuple[bytes, ...]:
    """Return the bytes that a text may stand as."""
    plain = text.encode()
    escaped = json.dumps(text)[1:-1].encode()
    return tuple({plain, escaped, *_in_base64(plain)})


def _in_base64(content: bytes) -> Iterator[bytes]:
    """Return what is the same in base64 whatever stands around it; nothing of a short text."""
    for offset in range(3):
        whole = content[offset : offset + (len(content) - offset) // 3 * 3]
        if len(whole) >= _SHORTEST:
            yield base64.b64encode(whole)
            yield base64.urlsafe_b64encode(whole)


def _in_tables(database: Path, wanted: Iterable[bytes]) -> Iterator[str]:
    with closing(sqlite3.connect(f"file:{database}?mode=ro", uri=True, timeout=30)) as connection:
        connection.text_factory = bytes
        for (name,) in connection.execute("SELECT name FROM sqlite_master WHERE type = 'table'"):
            yield from _in_table(connection, name.decode(), tuple(wanted))


def _in_table(
    connection: sqlite3.Connection, table: str, wanted: tuple[bytes, ...]
) -> Iterator[str]:
    quoted = table.replace('"', '""')
    rows = connection.execute(f'SELECT * FROM "{quoted}"')  # noqa: S608 - a name it gave itself
    columns = [column[0] for column in rows.description]
    found = {
        column
        for row in rows
        for column, value in zip(columns, row, strict=True)
        if holds(value, wanted)
    }
    yield from (f"{table}.{column}" for column in sorted(found))


def holds(value: Any, wanted: Iterable[bytes]) -> bool:  # noqa: ANN401 - whatever stands in a cell
    """Whether a cell of a table, or a file's content, holds any of these."""
    return isinstance(value, bytes) and any(one in value for one in wanted)


def _in_files(folder: Path, wanted: tuple[bytes, ...]) -> Iterator[str]:
    for path in sorted(folder.rglob("*")):
        # Rows that are no more stand in the pages of a database yet: it is read as a file, too.
        if path.is_file() and holds(path.read_bytes(), wanted):
            yield str(path.relative_to(folder))
