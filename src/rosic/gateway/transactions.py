"""Changes of who may do what: one at a time, on disk before their effect, never half applied."""

from __future__ import annotations

import asyncio
import logging
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING, TypeVar

from rosic.core.i18n import said
from rosic.core.records import Fact
from rosic.errors import RecordUnavailable, StoreFault

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Callable, Iterable

    from rosic.contracts.store import Store
    from rosic.core.records import Record

R = TypeVar("R")

log = logging.getLogger("rosic.changes")

UNWRITABLE = said("I cannot write this down now, so nothing was changed. The operator has to look.")


class Transactions:
    """Takes records to the disk and then to whoever keeps them in memory.

    A decision looks at what is so and returns records; between the look and the effect nothing
    else may change, so both lie in one turn.
    """

    def __init__(self, store: Store) -> None:
        self._store = store
        self._facts: dict[str, Callable[[Fact], object]] = {}
        self._records: dict[type, Callable[[Record], object]] = {}
        self._after: list[Callable[[], object]] = []
        self._one = asyncio.Lock()

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
            yield UnitOfWork(self._store, self._apply)

    def _apply(self, records: Iterable[Record]) -> None:
        for record in records:
            if isinstance(record, Fact):
                apply = self._facts.get(record.kind)
                if apply is None:
                    log.error("nobody keeps facts of the kind %s", record.kind)
                else:
                    apply(record)
            elif (told := self._records.get(type(record))) is not None:
                told(record)
        for settle in self._after:
            settle()


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
        try:
            await self._store.write(*records)
        except StoreFault:
            self._store.note(*records)
            return False
        return True
