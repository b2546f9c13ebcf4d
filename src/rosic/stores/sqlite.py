"""Everything that is true of SQLite only: how it is opened, made durable, and how it fails."""

from __future__ import annotations

import os
import sqlite3
from contextlib import contextmanager, suppress
from typing import TYPE_CHECKING

from sqlalchemy import Connection, Engine, create_engine, event, pool
from sqlalchemy.exc import DBAPIError, SQLAlchemyError

from rosic.core.i18n import said
from rosic.errors import ConfigurationError, StoreFault
from rosic.stores.record_mark import RecordNumber

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    from sqlalchemy.engine.interfaces import DBAPICursor

    from rosic.stores.data_dir import StoreSettings

CHECKPOINT_PAGES = 4_000  # 16 MiB of write-ahead log before it is folded into the database
LOG_BYTES = 64 << 20  # the log file is cut to this size once it was folded in
CACHE_KIB = 2_048  # 16 MiB were no faster with a record of 80 MB, and took an hour to be filled
FULL = 2  # what PRAGMA synchronous answers; EXTRA, 3, is stronger

SENTENCES = {
    "SQLITE_FULL": "The disk is full",
    "SQLITE_BUSY": "Another program holds the record",
    "SQLITE_LOCKED": "Another program holds the record",
    "SQLITE_READONLY": "The record may not be written",
    "SQLITE_CANTOPEN": "The record cannot be opened",
    "SQLITE_CORRUPT": "The record is damaged",
    "SQLITE_NOTADB": "The record is damaged",
}


# How a database fails, before and after SQLAlchemy has wrapped it.
FAILURES = (SQLAlchemyError, sqlite3.Error, OSError)

# The database is well; it is what was to be written that does not fit.
UNFIT = (
    sqlite3.IntegrityError,
    sqlite3.DataError,
    sqlite3.InterfaceError,
    sqlite3.ProgrammingError,
)


def engine_for(path: Path, settings: StoreSettings) -> Engine:
    """Return an engine for one file, which must exist. Each connection is one transaction wide.

    Nothing is opened yet.
    """
    engine = create_engine(
        f"sqlite:///file:{quoted(path)}?mode=rw&uri=true",
        poolclass=pool.NullPool,
        connect_args={"timeout": settings.busy_timeout_ms / 1000, "isolation_level": None},
    )
    event.listen(engine, "begin", begin)
    return engine


def quoted(path: Path) -> str:
    """Return a path as it stands in a file: address."""
    text = str(path.absolute())
    for letter in "%?#":
        text = text.replace(letter, f"%{ord(letter):02x}")
    return text


def begin(connection: Connection) -> None:
    """Take the right to write at once: two halves of a transaction never wait for each other."""
    connection.exec_driver_sql("BEGIN IMMEDIATE")


@contextmanager
def transaction(connection: Connection) -> Iterator[DBAPICursor]:
    """Write everything that is run on a cursor, or nothing; in the driver's own words.

    The same as ``connection.begin()`` without what it costs: it stands around each group.
    """
    driver = connection.connection
    cursor = driver.cursor()
    cursor.execute("BEGIN IMMEDIATE")
    try:
        yield cursor
        driver.commit()
    except BaseException:
        with suppress(*FAILURES):
            driver.rollback()
        raise


def make_file(path: Path) -> None:
    """Make an empty database for its owner alone, if there is none.

    Raises:
        OSError: The folder cannot be written.
    """
    os.close(os.open(path, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o600))


def pragma(connection: Connection, text: str) -> object:
    """Run one pragma outside a transaction and return its answer."""
    cursor = connection.connection.cursor()
    try:
        cursor.execute(f"PRAGMA {text}")
        row = cursor.fetchone()
    finally:
        cursor.close()
    return None if row is None else row[0]


def make_durable(connection: Connection, settings: StoreSettings) -> None:
    """Set what keeps a write through a power cut, and read it back.

    Raises:
        ConfigurationError: The database does not do it. Nothing was changed.
    """
    pragma(connection, f"synchronous={settings.synchronous}")
    answer = pragma(connection, "synchronous")
    if not isinstance(answer, int) or answer < FULL:
        raise ConfigurationError(
            "The record would not survive a power cut (synchronous is not FULL).",
            hint="Leave this setting alone: without it a robot may be moved twice.",
        )
    if pragma(connection, "journal_mode=WAL") != "wal":
        raise ConfigurationError(
            "The record cannot keep a write-ahead log here.",
            hint="Put the data folder on a local disk, not on a network share.",
        )
    for text in (
        "foreign_keys=ON",
        "trusted_schema=OFF",
        "secure_delete=ON",  # what is erased is overwritten
        "cell_size_check=ON",
        f"wal_autocheckpoint={CHECKPOINT_PAGES}",
        f"journal_size_limit={LOG_BYTES}",
        f"cache_size=-{CACHE_KIB}",
    ):
        pragma(connection, text)
    if settings.pages_max is not None:
        pragma(connection, f"max_page_count={settings.pages_max}")


def check_whole(connection: Connection) -> None:
    """Read the whole file for damage. Changes nothing.

    Raises:
        ConfigurationError: It is damaged.
    """
    if pragma(connection, "quick_check(1)") != "ok":
        raise damaged()


def damaged() -> ConfigurationError:
    """Return the sentence about a damaged record."""
    return ConfigurationError(
        "The record is damaged.",
        hint="Keep the file, then start with a copy of it or with an empty data folder.",
    )


def mark_of(connection: Connection) -> RecordNumber:
    """Return what a record says of itself; see `record_mark`."""
    mark = pragma(connection, "application_id"), pragma(connection, "user_version")
    identity, number = (value if isinstance(value, int) else 0 for value in mark)
    return RecordNumber(identity, number)


def write_mark(cursor: DBAPICursor, mark: RecordNumber) -> None:
    """Have a record say something else of itself, as a part of the cursor's transaction."""
    cursor.execute(f"PRAGMA application_id={mark.identity:d}")
    cursor.execute(f"PRAGMA user_version={mark.number:d}")


def fold(connection: Connection) -> bool:
    """Bring the log into the database. Return whether all of it is there, for good."""
    cursor = connection.connection.cursor()
    try:
        row = cursor.execute("PRAGMA wal_checkpoint(PASSIVE)").fetchone()
    finally:
        cursor.close()
    return row is not None and row[0] == 0 and row[1] == row[2]


def forget_erased(connection: Connection) -> None:
    """Leave nothing of what was just erased in the log file.

    Raises:
        StoreFault: Another program is reading; the erased content is still in the log file.
    """
    if pragma(connection, "wal_checkpoint(TRUNCATE)") != 0:
        raise StoreFault(
            said("Another program is reading the record. Try again when it has ended.")
        )


def reason(error: BaseException) -> str:
    """Return in a few words why the database failed."""
    cause = error.orig if isinstance(error, DBAPIError) else error
    name = getattr(cause, "sqlite_errorname", "")
    for prefix, sentence in SENTENCES.items():
        if name.startswith(prefix):
            return sentence
    return "The disk does not work" if name.startswith("SQLITE_IOERR") else "The record failed"


def is_busy(error: BaseException) -> bool:
    """Whether it was only somebody else's turn."""
    cause = error.orig if isinstance(error, DBAPIError) else error
    return getattr(cause, "sqlite_errorname", "").startswith(("SQLITE_BUSY", "SQLITE_LOCKED"))


def is_damage(error: BaseException) -> bool:
    """Whether the file is not what it was."""
    cause = error.orig if isinstance(error, DBAPIError) else error
    return getattr(cause, "sqlite_errorname", "").startswith(("SQLITE_CORRUPT", "SQLITE_NOTADB"))


def close(connection: Connection) -> None:
    """Close a connection that may be broken already."""
    with suppress(*FAILURES):
        connection.close()
