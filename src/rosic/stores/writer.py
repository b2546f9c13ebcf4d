"""The one writer: groups of calls in, one transaction each. Everything here runs in its thread."""

from __future__ import annotations

import logging
import threading
from functools import partial
from typing import TYPE_CHECKING

import msgspec
from sqlalchemy import Dialect, bindparam, select

from rosic.core.i18n import said
from rosic.core.records import Claimed, Decided, Memory, Record, Refused, Resumed, Stopped
from rosic.errors import ConfigurationError, Repeated, RosicError, StoreFault
from rosic.stores import decoding, migrate, sqlite, statements, tables
from rosic.stores.encoding import RecordEncoder
from rosic.stores.encryption import DecryptionError, RootKey
from rosic.stores.record_guard import Calls, RecordGuard
from rosic.stores.record_mark import RecordNumber
from rosic.stores.statements import BulkInsert, FindValue, in_words

if TYPE_CHECKING:
    from sqlalchemy import Connection
    from sqlalchemy.engine.interfaces import DBAPICursor

    from rosic.contracts.clock import Clock
    from rosic.stores.data_dir import DataDir, StoreSettings
    from rosic.stores.record_files import KeptFiles
    from rosic.stores.write_thread import WriteJob


# ---- reading audit records ----


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


log = logging.getLogger("rosic.stores")

OWN = ""  # the container whose key shows that the root key belongs to this record


class Writer:
    """Owns the connection, from opening to closing.

    Attributes:
        lost: Notes that could not be kept, since this writer was made.
        commits: Groups that were written since then.
    """

    def __init__(
        self, folder: DataDir, settings: StoreSettings, clock: Clock, kept: KeptFiles
    ) -> None:
        self.lost = 0
        self.commits = 0
        self._folder = folder
        self._guard = RecordGuard(folder, kept, clock)
        self._settings = settings
        self._clock = clock
        self._engine = sqlite.engine_for(folder.database, settings)
        self._insertion = BulkInsert(self._engine.dialect)
        self._erasure = statements.Erasure(self._engine.dialect)
        commands, containers = tables.commands.c, tables.containers.c
        self._find_seq = FindValue(self._engine.dialect, commands.seq, commands.cid)
        self._find_key = FindValue(self._engine.dialect, containers.wrapped, containers.container)
        self._decisions = DecisionQuery(self._engine.dialect)
        self._connection: Connection | None = None
        self._root: RootKey | None = None
        self._scribe: RecordEncoder | None = None
        self._failing = False
        self._late: Calls = []
        self._unrecorded = 0
        self._counting = threading.Lock()

    # ---- opening and closing ----

    def open(self) -> Memory:
        """Take the folder, check everything, migrate, and read what was.

        Raises:
            ConfigurationError: As in ``contracts.store``; the folder is free again.
        """
        self._folder.take()
        try:
            return self._open()
        except BaseException as error:
            self.close()
            cause = error.__cause__ if isinstance(error, StoreFault) else error
            if isinstance(cause, sqlite.FAILURES):
                raise unusable(cause, self._folder) from error
            raise

    def _open(self) -> Memory:
        self._folder.mark.look()
        root = self._root = self._folder.root()
        sqlite.make_file(self._folder.database)
        alone = self._guard.opening()
        connection = self._engine.connect()
        self._connection = connection
        if self._folder.database.stat().st_size <= self._settings.checked_bytes:
            sqlite.check_whole(connection)
        with connection.begin():
            migrate.check(connection)
            if migrate.present(connection) is None:
                self._folder.mark.refuse_empty(f"{self._folder.database.name} is empty")
        mark = self._folder.mark.compare(sqlite.mark_of(connection), alone)
        self._guard.opened()
        sqlite.make_durable(connection, self._settings)
        with connection.begin():
            migrate.upgrade(connection)
            self._check_root(connection, root)
            sqlite.write_mark(cursor_of(connection), mark)
        folded = mark.number if sqlite.fold(connection) else mark.folded
        mark = RecordNumber(mark.identity, mark.number + 1, folded)
        with connection.begin():  # the first thing in a log of its own
            sqlite.write_mark(cursor_of(connection), mark)
        self._guard.begin(mark)
        with connection.begin():
            self._scribe = self._new_scribe(connection, root)
            memory = decoding.RecordDecoder(connection, root).memory()
        self.prune()
        return memory

    def _check_root(self, connection: Connection, root: RootKey) -> None:
        wrapped = decoding.wrapped_key(connection, OWN)
        if wrapped is None:
            key = root.new_key(OWN)
            self._insertion.containers.run(cursor_of(connection), [key.container, key.wrapped])
            return
        try:
            root.unwrap(OWN, wrapped)
        except DecryptionError as error:
            raise ConfigurationError(
                "The root key does not belong to this record.",
                hint="Put back the file, the credential or the passphrase that it was made with.",
            ) from error

    def _new_scribe(self, connection: Connection, root: RootKey) -> RecordEncoder:
        return RecordEncoder(
            root,
            decoding.standing(connection),
            partial(self._find_seq.run, cursor_of(connection)),
            partial(self._find_key.run, cursor_of(connection)),
            settings=self._settings,
        )

    def close(self) -> None:
        """Try once more what could not be written, then let everything go. Never raises."""
        if self._late:
            self.settle([])
        self._disconnect()
        self._guard.ended()
        self._folder.give_back()

    def _disconnect(self) -> None:
        if self._connection is not None:
            self._guard.disconnecting()
            sqlite.close(self._connection)
        self._connection = self._scribe = None
        self._guard.disconnected()

    def _reconnected(self) -> tuple[Connection, RootKey]:
        """Return the connection, after a failure a new one, and the root key."""
        if self._root is None:
            raise StoreFault(said("The record is closed. Nothing was written."))
        if self._connection is None:
            self._guard.reconnecting()
            connection = self._engine.connect()
            try:
                sqlite.make_durable(connection, self._settings)
                self._guard.connected(sqlite.mark_of(connection))
            except BaseException:
                sqlite.close(connection)
                self._guard.disconnected()
                raise
            self._connection = connection
        return self._connection, self._root

    def _connected(self) -> tuple[Connection, RecordEncoder]:
        """Return the connection and a scribe; after a failure, one who asks the database anew."""
        connection, root = self._reconnected()
        if self._scribe is None:
            with connection.begin():
                self._scribe = self._new_scribe(connection, root)
        return connection, self._scribe

    # ---- writing ----

    def settle(self, jobs: Calls) -> bool:
        """Write a group. Return whether notes are left that are to be tried again soon."""
        group, self._late = [*self._late, *jobs], []
        if group:
            try:
                self._commit(group)
            except (*sqlite.FAILURES, RosicError) as error:
                self._fail(group, error)
        return bool(self._late)

    def _commit(self, group: Calls) -> None:
        """Write a group in one transaction; if it does not fit, all of it that does."""
        self._reconnected()
        group = self._guard.check(group)
        connection, scribe = self._connected()
        missed, mark = self._unrecorded, self._guard.next_mark(group)
        try:
            with sqlite.transaction(connection) as cursor:
                batch = scribe.rows([job.content for job in group])
                self._insertion.run(cursor, batch)
                self._record_gap(cursor, missed)
                if mark is not None:
                    sqlite.write_mark(cursor, mark)
            scribe.remember(batch)
        except Exception as error:
            if not is_unfit(error):
                raise
            with connection.begin():
                self._divide(connection, scribe, group)
                self._record_gap(cursor_of(connection), missed)
                if mark is not None:
                    sqlite.write_mark(cursor_of(connection), mark)
        # What was written into a file that nobody will read is not written.
        self._guard.check(group)
        self._guard.has_written(mark)
        self._failing = False
        self.commits += 1
        if missed:
            self.miss(0, recorded=missed)

    def _divide(self, connection: Connection, scribe: RecordEncoder, group: Calls) -> None:
        """Write what fits of a group, in order, by halves: a few bad ones cost a few tries.

        What the scribe remembers here dies with the scribe if the commit fails.
        """
        try:
            with connection.begin_nested():
                batch = scribe.rows([job.content for job in group])
                self._insertion.run(cursor_of(connection), batch)
            scribe.remember(batch)
        except Exception as error:
            if not is_unfit(error):
                raise
            if len(group) == 1:
                self._reject(connection, group[0], error)
                return
            middle = len(group) // 2
            self._divide(connection, scribe, group[:middle])
            self._divide(connection, scribe, group[middle:])

    def _reject(
        self, connection: Connection, job: WriteJob[tuple[Record, ...]], error: Exception
    ) -> None:
        if job.future is None:
            self.miss(1)
        elif isinstance(error, StoreFault):
            job.fail(error)
        elif self._is_repeated(cursor_of(connection), job.content):
            job.fail(Repeated("This was already settled."))
        else:
            job.fail(fault("This cannot be written down. Nothing was written.", error))

    def _is_repeated(self, cursor: DBAPICursor, records: tuple[Record, ...]) -> bool:
        """Whether a call would settle something a second time."""
        cids = [record.cid for record in records if isinstance(record, Claimed | Refused | Resumed)]
        return len(set(cids)) < len(cids) or any(
            self._find_seq.run(cursor, cid) is not None for cid in cids
        )

    def _record_gap(self, cursor: DBAPICursor, missed: int) -> None:
        if missed:
            self._insertion.gaps.run(cursor, [self._clock.wall_ns(), missed])

    def _fail(self, group: Calls, error: Exception) -> None:
        """Nothing of a group was written. Notes wait; whoever waits for a write is told."""
        if not sqlite.is_busy(error):
            self._scribe = None
            if self._failing:  # a connection gets one chance to recover by itself
                self._disconnect()
            self._failing = True
        for job in group:
            if job.future is None:
                job.retry_with(tuple(map(late, job.content)))
                self._late.append(job)
            else:
                job.fail(unwritten(error))
        surplus = len(self._late) - self._settings.notes_max
        if surplus > 0:
            del self._late[:surplus]
            self.miss(surplus)

    def miss(self, count: int, *, recorded: int = 0) -> None:
        """Count lost notes, and those whose loss is in the record by now; from any thread."""
        with self._counting:
            self.lost += count
            self._unrecorded += count - recorded

    # ---- reading ----

    def decisions(self, before: int, limit: int) -> list[tuple[int, Decided]]:
        """Return the newest administrative acts before one of them, each with its number.

        Raises:
            StoreFault: They cannot be read.
        """
        try:
            connection, _ = self._reconnected()
            return self._decisions.run(cursor_of(connection), before, limit)
        except sqlite.FAILURES as error:
            raise fault(f"{sqlite.reason(error)}. Try again.", error) from error

    # ---- upkeep ----

    def prune(self) -> int:
        """Forget some commands that are settled and old. Return how many.

        Raises:
            StoreFault: Nothing was forgotten.
        """
        try:
            connection, _ = self._connected()
            with connection.begin():
                before_ns = statements.horizon(connection, self._clock.wall_ns(), self._settings)
                return self._erasure.prune(connection, before_ns)
        except sqlite.FAILURES as error:
            raise fault(f"{sqlite.reason(error)}. Nothing was forgotten.", error) from error

    def forget_decisions(self, before_ns: int, kept_ns: int) -> int:
        """Forget some administrative acts that are old. Return how many.

        Raises:
            StoreFault: Nothing was forgotten.
        """
        try:
            connection, _ = self._connected()
            with connection.begin():
                return self._erasure.forget_decisions(connection, before_ns, kept_ns)
        except sqlite.FAILURES as error:
            raise fault(f"{sqlite.reason(error)}. Nothing was forgotten.", error) from error

    def shred(self, container: str) -> None:
        """Erase a container's key from the database and from the log file.

        Raises:
            StoreFault: Not erased, or still in the log file; doing it again is safe.
        """
        try:
            connection, scribe = self._connected()
            scribe.forget_key(container)
            with connection.begin():
                self._erasure.shred(connection, container)
            sqlite.forget_erased(connection)
        except sqlite.FAILURES as error:
            self._disconnect()
            raise fault(f"{sqlite.reason(error)}. Try again.", error) from error


def cursor_of(connection: Connection) -> DBAPICursor:
    """Return a cursor of the driver, in the same transaction."""
    return connection.connection.cursor()


def is_unfit(error: Exception) -> bool:
    """Whether it is what was to be written that failed, not the database."""
    return isinstance(error, sqlite.UNFIT) or not isinstance(error, sqlite.FAILURES)


def late(record: Record) -> Record:
    """Return a record as it is written when the database did not work in time."""
    if isinstance(record, Stopped):
        return msgspec.structs.replace(record, gap=True)
    return record


def fault(sentence: str, cause: BaseException) -> StoreFault:
    """Return a fault with its cause: each waiting call has one of its own."""
    error = StoreFault(sentence)
    error.__cause__ = cause
    return error


def unwritten(cause: Exception) -> StoreFault:
    """Say why a group was not written: a fault that says so itself is told as it is."""
    if isinstance(cause, StoreFault):
        return fault(cause.args[0], cause)
    return fault(f"{sqlite.reason(cause)}. Nothing was written.", cause)


def unusable(error: BaseException, folder: DataDir) -> ConfigurationError:
    """Say why a record cannot be opened."""
    if sqlite.is_damage(error):
        return sqlite.damaged()
    if folder.is_full():
        return ConfigurationError(
            f"The record in {folder.path} cannot be opened: the disk is full.",
            hint="Free some space. Nothing was started: robots cannot be stopped by ROSIC either.",
        )
    return ConfigurationError(
        f"The record in {folder.path} cannot be opened: {sqlite.reason(error).lower()}.",
        hint="Close the other program." if sqlite.is_busy(error) else "Look at the disk.",
    )
