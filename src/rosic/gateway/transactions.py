"""Changes of who may do what: one at a time, on disk before their effect, never half applied.

But for what takes rights away: that is so at once, whoever changes something else meanwhile.
"""

from __future__ import annotations

import asyncio
import logging
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING, Final, TypeVar

from rosic.contracts.background_tasks import BackgroundTasks
from rosic.contracts.clock import done_within
from rosic.core.i18n import said
from rosic.core.records import Decided, Fact
from rosic.core.time_units import SECOND_NS
from rosic.errors import RecordUnavailable, StoreFault

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Callable, Iterable

    from rosic.contracts.clock import Clock
    from rosic.contracts.store import Store
    from rosic.core.records import Record

R = TypeVar("R")

log = logging.getLogger("rosic.changes")

WRITTEN_WITHIN_S: Final = 1.0
"""Nobody waits longer to read that something was taken away."""
UNWRITABLE = said("I cannot write this down now, so nothing was changed. The operator has to look.")


class Transactions:
    """Takes records to the disk and then to whoever keeps them in memory.

    A decision looks at what is so and returns records; between the look and the effect nothing
    else may change, so both lie in one turn. What takes rights away does not wait for a turn, as
    the disk of whoever has it may hang: what that one gives afterwards is taken once more.

    Args:
        clock: Counts how long somebody waits for the disk.
    """

    def __init__(self, store: Store, clock: Clock) -> None:
        self._store = store
        self._clock = clock
        self._facts: dict[str, Callable[[Fact], object]] = {}
        self._records: dict[type, Callable[[Record], object]] = {}
        self._after: list[Callable[[], object]] = []
        self._one = asyncio.Lock()
        # What was taken away since the present turn began: it may have looked before that.
        self._taken: list[Callable[[], Iterable[Record]]] = []
        self._writing: BackgroundTasks[bool] = BackgroundTasks()
        self._since_ns: int | None = None

    def keep(self, kind: str, apply: Callable[[Fact], object]) -> None:
        """Say who keeps facts of a kind."""
        self._facts[kind] = apply

    def watch(self, kind: type[R], apply: Callable[[R], object]) -> None:
        """Say who is told of records of another kind than facts."""
        self._records[kind] = apply  # type: ignore[assignment]  # asked by the very type

    def after(self, settle: Callable[[], object]) -> None:
        """Call something after each change, in the same turn of the event loop."""
        self._after.append(settle)

    def note(self, records: Iterable[Record]) -> None:
        """Let it be so at once and write it soon: at the end, when nothing is waited for."""
        records = tuple(records)
        self._apply(records)
        self._store.note(*records)

    @asynccontextmanager
    async def turn(self) -> AsyncIterator[UnitOfWork]:
        """Let nothing else change meanwhile."""
        async with self._one:
            self._since_ns = self._clock.monotonic_ns()
            try:
                yield UnitOfWork(self._store, self._apply)
            finally:
                self._since_ns = None
                self._taken.clear()

    @property
    def late(self) -> bool:
        """Whether the present turn has lasted so long that its write must hang.

        It is not cut off: nobody would know what of it comes to the disk, and a grant might be
        written after all that was said to be none.
        """
        since_ns = self._since_ns
        if since_ns is None:
            return False
        return self._clock.monotonic_ns() - since_ns >= WRITTEN_WITHIN_S * SECOND_NS

    async def take_away(
        self, records: Iterable[Record], again: Callable[[], Iterable[Record]] = tuple
    ) -> bool:
        """Let it be so before anything is waited for, and write it down beside all turns.

        Args:
            records: Take rights away. They were decided in the present step of the event loop.
            again: Returns what takes away the same of what was given meanwhile by somebody whose
                turn it is, and who had looked before.

        Returns:
            Whether it is on disk, within `WRITTEN_WITHIN_S`. If not, it holds while this process
            lives, and is written as soon as that is possible.
        """
        records = tuple(records)
        self._apply(records)
        if self._one.locked():
            self._taken.append(again)
        writing = self._writing.begin(_write_or_note(self._store, records))
        return await done_within(self._clock, WRITTEN_WITHIN_S, (writing,)) and writing.result()

    def _apply(self, records: Iterable[Record]) -> None:
        self._let_be_so(records)
        for again in self._taken:
            more = tuple(again())
            if any(not isinstance(record, Decided) for record in more):
                self._let_be_so(more)
                self._store.note(*more)
        for settle in self._after:
            settle()

    def _let_be_so(self, records: Iterable[Record]) -> None:
        for record in records:
            if isinstance(record, Fact):
                apply = self._facts.get(record.kind)
                if apply is None:
                    log.error("nobody keeps facts of the kind %s", record.kind)
                else:
                    apply(record)
            elif (told := self._records.get(type(record))) is not None:
                told(record)


class UnitOfWork:
    """One turn: look, decide, write."""

    def __init__(self, store: Store, apply: Callable[[Iterable[Record]], None]) -> None:
        self._store = store
        self._apply = apply

    async def write(self, records: Iterable[Record]) -> None:
        """Write all of it down, then let it be so.

        Raises:
            RecordUnavailable: Nothing was written, nothing changed.
        """
        records = tuple(records)
        if not records:
            return
        try:
            await self._store.write(*records)
        except StoreFault as fault:
            raise RecordUnavailable(UNWRITABLE) from fault
        self._apply(records)

    async def act(self, records: Iterable[Record]) -> bool:
        """Let it be so at once and write it down: what takes rights away waits for no disk.

        Returns:
            Whether it is on disk; if not, it is noted, and holds while this process lives.
        """
        records = tuple(records)
        self._apply(records)
        return await _write_or_note(self._store, records)


async def _write_or_note(store: Store, records: tuple[Record, ...]) -> bool:
    """Write down what is so already; return whether it is on disk, and not noted for later."""
    try:
        await store.write(*records)
    except StoreFault:
        store.note(*records)
        return False
    return True


# ---- writing after the effect ----
# What is so already: in order, one batch after another.


class WriteBehind:
    """For what nobody may wait for: a robot that is set already, an alarm that has begun."""

    def __init__(self, changes: Transactions) -> None:
        self._changes = changes
        self._unwritten: list[Record] = []
        self._writing: asyncio.Task[None] | None = None

    def write(self, records: Iterable[Record]) -> None:
        """Take records in; they are written as soon as those before them are."""
        self._unwritten.extend(records)
        if self._unwritten and self._writing is None:
            self._writing = asyncio.create_task(self._write())

    async def _write(self) -> None:
        try:
            while self._unwritten:
                batch, self._unwritten = self._unwritten, []
                async with self._changes.turn() as turn:
                    await turn.act(batch)
        finally:
            self._writing = None

    async def written(self, within_s: float | None = None) -> None:
        """Wait until everything is written, or noted for later.

        Args:
            within_s: After so long it is given up; None: wait for as long as it takes.
        """
        writing = self._writing
        if writing is None:
            return
        await asyncio.wait((writing,), timeout=within_s)
        writing.cancel()  # which changes nothing if it is over
