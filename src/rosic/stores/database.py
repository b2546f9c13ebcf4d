"""The record on disk: what an event loop sees of it."""

from __future__ import annotations

from functools import partial
from pathlib import PurePath
from typing import TYPE_CHECKING, TypeVar

import msgspec
from sqlalchemy import select

from rosic.core.history import with_stops
from rosic.core.i18n import said
from rosic.core.records import APART, Fact, KeyRevoked, Letter, Resumed, Stopped
from rosic.errors import StoreFault
from rosic.stores import decoding, history, sqlite, tables
from rosic.stores.data_dir import DataDir, StoreSettings
from rosic.stores.encoding import CARD, CLAIM, PLACED, WORDS
from rosic.stores.record_files import KeptFiles
from rosic.stores.write_thread import WriteThread
from rosic.stores.writer import OWN, Writer, fault

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from rosic.contracts.clock import Clock
    from rosic.core.history import HistoryEntry, HistoryQuery
    from rosic.core.records import Decided, Memory, Record

R = TypeVar("R")

DEFAULTS = StoreSettings()
AT_ONCE = 500  # administrative acts read in one step
NEWER_THAN_ALL = 2**63 - 1
COMMANDS_SHOWN = 10_000  # the newest of one person
URGENT = frozenset({Stopped, Resumed, KeyRevoked})
LOCK = "lock"  # the kind of fact that keeps somebody out


class DatabaseContainers(decoding.RecordDecoder):
    """Reads while a gateway runs: a part of the facts, or what is sealed in one container."""

    def facts(self, kind: str, after: str, limit: int) -> tuple[Fact, ...]:
        """Return facts of a kind by key, in order, from behind a key on."""
        facts = tables.facts.c
        rows = self._connection.execute(
            select(facts.kind, facts.key, facts.body, facts.container, facts.sealed)
            .where(facts.kind == kind, facts.key > after)
            .order_by(facts.key)
            .limit(limit)
        ).all()
        return tuple(
            Fact(kind=row.kind, key=row.key, body=row.body)
            if row.container is None
            else self._fact(row.kind, row.key, row.body, row.container, row.sealed)
            for row in rows
        )

    def containers(self) -> tuple[str, ...]:
        """Return whose containers have a key; the record's own is none of them."""
        table = tables.containers.c
        query = select(table.container).where(table.wrapped.is_not(None), table.container != OWN)
        return tuple(self._connection.scalars(query.order_by(table.container)).all())

    def container_facts(self, container: str) -> tuple[Fact, ...]:
        """Return everything sealed in a container, and the commands that its owner gave."""
        facts, cards = tables.facts.c, tables.cards.c
        principals = tables.principals.c
        query = select(principals.principal, principals.roles, cards.sealed).where(
            cards.principal == principals.principal, cards.container == container
        )
        found = [
            self._thing("card", row.principal, row.roles.encode(), (container, content))
            for row in self._connection.execute(query).all()
            if (content := self._unsealed(container, CARD, row.principal.encode(), row.sealed))
        ]
        sealed = select(facts.kind, facts.key, facts.body, facts.sealed)
        ours = sealed.where(facts.container == container, facts.kind.not_in(APART))
        rows = self._connection.execute(ours).all()
        found += [self._fact(row.kind, row.key, row.body, container, row.sealed) for row in rows]
        return (*found, *self._commands(container))

    def _commands(self, principal: str) -> list[Fact]:
        commands, endings, places = tables.commands, tables.endings, tables.places
        query = (
            select(
                commands,
                endings.c.ending,
                endings.c.container.label("words_container"),
                endings.c.sealed.label("words_sealed"),
                places.c.container.label("placed_container"),
                places.c.sealed.label("placed_sealed"),
            )
            .where(commands.c.principal == principal)
            .outerjoin_from(commands, endings, endings.c.seq == commands.c.seq)
            .outerjoin(places, places.c.seq == commands.c.seq)
            .order_by(commands.c.seq.desc())
            .limit(COMMANDS_SHOWN)
        )
        found = []
        for row in reversed(self._connection.execute(query).all()):
            body = msgspec.msgpack.encode(
                {
                    "at_ns": row.at_ns,
                    "is": row.kind,
                    "robot": row.robot,
                    "skill": row.skill,
                    "ending": row.ending or row.code,
                }
            )
            key = row.cid.hex()
            letters = (
                ("command", row.container, CLAIM, row.sealed),
                ("outcome", row.words_container, WORDS, row.words_sealed),
                ("message", row.placed_container, PLACED, row.placed_sealed),
            )
            for kind, container, place, sealed in letters:
                letter = self._letter(container, place, row.cid, sealed)
                if kind == "command" or letter is not None:
                    found.append(self._thing(kind, key, body, (principal, letter)))
        return found

    @staticmethod
    def _thing(kind: str, key: str, body: bytes, letter: tuple[str, bytes | None]) -> Fact:
        container, content = letter
        sealed = None if content is None else Letter(container, content)
        return Fact(kind=kind, key=key, body=body, letter=sealed)

    def history(self, query: HistoryQuery, before: int, limit: int) -> list[HistoryEntry]:
        """Return commands of one step, newest first."""
        return history.page(self._connection, self._letter, query, before, limit)

    def one(self, query: HistoryQuery) -> list[HistoryEntry]:
        """Return the one command that is asked about by its id, or nothing."""
        return history.one(self._connection, self._letter, query)

    def newest(self) -> int:
        """Return the number behind the newest command."""
        return history.newest(self._connection)

    def stops(self, query: HistoryQuery, before: int, limit: int) -> list[HistoryEntry]:
        """Return stops of one step, newest first."""
        return history.stops(self._connection, query, before, limit)

    def newest_stop(self) -> int:
        """Return the number behind the newest stop."""
        return history.newest_stop(self._connection)


class ReadingWriter(Writer):
    """The one writer, who also reads when asked; in its thread."""

    def look(self, read: Callable[[DatabaseContainers], R]) -> R:
        """Read.

        Raises:
            StoreFault: It cannot be read now.
        """
        try:
            connection, root = self._reconnected()
            with connection.begin():
                return read(DatabaseContainers(connection, root))
        except sqlite.FAILURES as error:
            raise fault(f"{sqlite.reason(error)}. Try again.", error) from error


def is_urgent(records: tuple[Record, ...]) -> bool:
    """Whether records go before others: stops, what undoes them, and what keeps somebody out.

    Nothing else is written under their ids meanwhile, so it does not matter what they overtake:
    the numbers of a robot only grow, and an administrative act is written before the next begins.
    """
    for record in records:
        kind = type(record)
        if kind in URGENT or (kind is Fact and record.kind == LOCK):  # type: ignore[union-attr]
            return True
    return False


class DatabaseStore:
    """One SQLite file, one writer thread, one transaction for many calls.

    Args:
        folder: Of one gateway; made for its owner only when it does not exist.
        clock: Says how old a command is.
        kept: Knows the files of the folder that must not vanish meanwhile.
        begin_anew: A record that was lost is begun anew, one that is older than it should be is
            taken as it is: for the owner to say.
    """

    def __init__(
        self,
        folder: Path,
        *,
        clock: Clock,
        settings: StoreSettings = DEFAULTS,
        kept: KeptFiles | None = None,
        begin_anew: bool = False,
    ) -> None:
        self._kept = KeptFiles() if kept is None else kept
        self._folder = DataDir(folder, self._kept, begin_anew=begin_anew)
        self._clock = clock
        self._settings = settings
        self._writer: ReadingWriter | None = None
        self._lane: WriteThread[tuple[Record, ...]] | None = None

    @property
    def lost(self) -> int:
        """Notes that could not be kept since opening; the record holds the same number."""
        return 0 if self._writer is None else self._writer.lost

    @property
    def commits(self) -> int:
        """How many groups were written since opening."""
        return 0 if self._writer is None else self._writer.commits

    def lost_file(self) -> str:
        """Return the name of a file that is gone or was replaced; empty while all are there."""
        return PurePath(self._kept.lost()).name

    async def open(self) -> Memory:
        """Open, migrate, check, and return what was; see ``contracts.store``."""
        writer = ReadingWriter(self._folder, self._settings, self._clock, self._kept)
        lane: WriteThread[tuple[Record, ...]] = WriteThread(
            "rosic-record",
            writer.settle,
            finish=writer.close,
            group_max=self._settings.group_max,
            queue_max=self._settings.queue_max,
            urgent=is_urgent,
        )
        lane.start()
        try:
            memory = await lane.call(writer.open)
        except BaseException:
            await lane.stop()
            raise
        self._writer, self._lane = writer, lane
        return memory

    async def close(self) -> None:
        """Write what is waiting, then close."""
        if self._lane is not None:
            await self._lane.stop()

    async def write(self, *records: Record) -> None:
        """Write all or none; see ``contracts.store``."""
        await self._opened().put(records)

    def keep(self, record: Record, then: Callable[[], None]) -> None:
        """Write soon, in order, and call ``then``; see ``contracts.store``."""
        if self._lane is None or not self._lane.drop((record,), then):
            if self._writer is not None:
                self._writer.miss(1)
            then()

    def note(self, *records: Record) -> None:
        """Write soon, in order. While the disk does not work, notes wait, within bounds."""
        if self._lane is not None and not self._lane.drop(records) and self._writer is not None:
            self._writer.miss(1)

    async def prune(self) -> int:
        """Forget settled commands that are older than the settings keep. Return how many.

        Goes in small steps, so that writes pass between them. Meant to be called once a day.

        Raises:
            StoreFault: Not all were forgotten; the rest is tried the next time.
        """
        if self._writer is None:
            raise StoreFault(said("The record is closed."))
        total = 0
        while step := await self._opened().call(self._writer.prune):
            total += step
        return total

    async def decisions(self, limit: int) -> tuple[Decided, ...]:
        """Return the newest administrative acts, the newest first; at most so many.

        What was written or noted before the call is among them. Goes in small steps, so that
        writes pass between them.

        Raises:
            StoreFault: They cannot be read now.
        """
        writer = self._writer
        if writer is None:
            raise StoreFault(said("The record is closed."))
        found: list[Decided] = []
        before = NEWER_THAN_ALL
        while (size := min(limit - len(found), AT_ONCE)) > 0:
            page = await self._opened().call(partial(writer.decisions, before, size))
            found += [decided for _, decided in page]
            if len(page) < size:
                break
            before = page[-1][0]
        return tuple(found)

    async def forget_decisions(self, before_ns: int) -> int:
        """Forget administrative acts from before a time; return how many. In small steps.

        The newest one of all is never forgotten, nor what is not that much older than it is: a
        clock that jumps ahead forgets nothing.

        Raises:
            StoreFault: Not all were forgotten; the rest is tried the next time.
        """
        writer = self._writer
        if writer is None:
            raise StoreFault("The record is closed.")
        kept_ns, total = self._clock.wall_ns() - before_ns, 0
        while step := await self._opened().call(
            partial(writer.forget_decisions, before_ns, kept_ns)
        ):
            total += step
        return total

    async def facts(self, kind: str, after: str, limit: int) -> tuple[Fact, ...]:
        """Return at most so many facts of a kind, by key, from behind a key on.

        Raises:
            StoreFault: They cannot be read now.
        """
        return await self._look(lambda shelves: shelves.facts(kind, after, limit))

    async def container_facts(self, container: str) -> tuple[Fact, ...]:
        """Return everything that is sealed in a container, unsealed, and its owner's commands.

        Facts are what they are. The card of a person is of the kind ``card``; a command, the words
        in which its end was told and the id of the message that shows it are ``command``,
        ``outcome`` and ``message``, under the command's id. Of commands only the newest.

        Raises:
            StoreFault: They cannot be read now.
        """
        return await self._look(lambda shelves: shelves.container_facts(container))

    async def history(self, query: HistoryQuery) -> tuple[HistoryEntry, ...]:
        """Return commands and stops, the newest first, at most as many as are asked for.

        Goes in small steps, so that writes pass between them.

        Raises:
            StoreFault: They cannot be read now.
        """
        if query.cid:
            return tuple(await self._look(partial(DatabaseContainers.one, query=query)))
        commands = await self._stepwise(
            DatabaseContainers.newest, DatabaseContainers.history, query
        )
        stops = await self._stepwise(
            DatabaseContainers.newest_stop, DatabaseContainers.stops, query
        )
        return with_stops(commands, stops, query.limit)

    async def _stepwise(
        self,
        newest: Callable[[DatabaseContainers], int],
        step: Callable[..., list[HistoryEntry]],
        query: HistoryQuery,
    ) -> list[HistoryEntry]:
        found: list[HistoryEntry] = []
        before = await self._look(newest)
        while before > 0 and (left := query.limit - len(found)) > 0:
            found += await self._look(partial(step, query=query, before=before, limit=left))
            before -= history.AT_ONCE
        return found

    async def containers(self) -> tuple[str, ...]:
        """Return whose containers have a key.

        Raises:
            StoreFault: They cannot be read now.
        """
        return await self._look(DatabaseContainers.containers)

    async def _look(self, read: Callable[[DatabaseContainers], R]) -> R:
        writer = self._writer
        if writer is None:
            raise StoreFault(said("The record is closed."))
        return await self._opened().call(lambda: writer.look(read))

    async def shred(self, container: str) -> None:
        """Erase the personal content of one container for good, by erasing its key.

        Raises:
            StoreFault: It may still be readable; doing it again is safe.
        """
        writer = self._writer
        if writer is None:
            raise StoreFault(said("The record is closed."))
        await self._opened().call(lambda: writer.shred(container))

    def _opened(self) -> WriteThread[tuple[Record, ...]]:
        if self._lane is None:
            raise StoreFault(said("The record is closed. Nothing was written."))
        return self._lane
