"""Writes down what is so already, behind its effect: in order, one batch after another."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterable

    from rosic.core.records import Record
    from rosic.gateway.transactions import Transactions


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
