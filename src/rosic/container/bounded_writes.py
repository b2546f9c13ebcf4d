"""Writes to the record, and waits no longer for it than somebody who said something may wait.

A disk that hangs neither writes nor fails. Whoever waits for it holds up what was received behind
them, and a stop may be there (I10).
"""

from __future__ import annotations

import asyncio
from functools import partial
from types import coroutine
from typing import TYPE_CHECKING, Any, Final

from rosic.core.i18n import said
from rosic.errors import StoreFault

if TYPE_CHECKING:
    from collections.abc import Callable, Coroutine, Generator, Sequence

    from rosic.contracts.clock import Clock
    from rosic.contracts.store import Store
    from rosic.core.records import Record

WITHIN_S: Final = 1.0
NOT_IN_TIME: Final = said("The record cannot keep up. Nothing was written.")


class BoundedWriter:
    """Between the containers and the record."""

    def __init__(self, store: Store, clock: Clock) -> None:
        self._store = store
        self._clock = clock
        self._late: set[asyncio.Task[BaseException | None]] = set()

    async def write(self, records: Sequence[Record], disown: Callable[[], None]) -> None:
        """Write all or none, in the order of the calls.

        What is written at once costs no task. While something is late, nothing else is tried.

        Args:
            records: What is to be on disk on return.
            disown: Called if it is on disk after all, once this has given it up.

        Raises:
            Repeated, StoreFault: As the store does; or it was not written in time.
            CancelledError: It is written; with a cause, it is not.
        """
        if self._late:
            raise StoreFault(NOT_IN_TIME)
        writing = self._store.write(*records)
        try:
            waits_for = writing.send(None)
        except StopIteration:
            return
        await self._wait(asyncio.create_task(_outcome(writing, waits_for)), disown)

    async def _wait(
        self, task: asyncio.Task[BaseException | None], disown: Callable[[], None]
    ) -> None:
        patience = asyncio.create_task(self._clock.sleep(WITHIN_S))
        try:
            await asyncio.wait((task, patience), return_when=asyncio.FIRST_COMPLETED)
        except asyncio.CancelledError as cancelled:
            task.cancel()
            await asyncio.wait((task,))
            found = task.result()
            # Cut off and written all the same is what a store says without a cause.
            raise cancelled from (
                found.__cause__ if isinstance(found, asyncio.CancelledError) else found
            )
        finally:
            patience.cancel()
        if not task.done():
            self._late.add(task)
            task.add_done_callback(lambda done: self._written(done, disown))
            raise StoreFault(NOT_IN_TIME)
        if (error := task.result()) is not None:
            raise error

    def _written(
        self, task: asyncio.Task[BaseException | None], disown: Callable[[], None]
    ) -> None:
        self._late.discard(task)
        if not task.cancelled() and task.result() is None:
            disown()


async def _outcome(writing: Coroutine[Any, Any, None], waits_for: object) -> BaseException | None:
    """Return how a write ended that was begun already: the error, or None."""
    try:
        await _rest(writing, waits_for)
    except BaseException as error:  # noqa: BLE001 - whoever waits gets it, if anybody does
        return error
    return None


@coroutine
def _rest(writing: Coroutine[Any, Any, None], waits_for: object) -> Generator[Any, Any, None]:
    """Go on with a coroutine from where it waits first."""
    step: Callable[[], object]
    while True:
        try:
            given = yield waits_for
        except BaseException as error:  # noqa: BLE001 - it is the coroutine's own
            step = partial(writing.throw, error)
        else:
            step = partial(writing.send, given)
        try:
            waits_for = step()
        except StopIteration:
            return
