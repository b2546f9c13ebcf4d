"""Writes to the record, and waits no longer for it than somebody who said something may wait.

A disk that hangs neither writes nor fails. Whoever waits for it holds up what was received behind
them, and a stop may be there (I10).
"""

from __future__ import annotations

import asyncio
from collections import deque
from functools import partial
from types import coroutine
from typing import TYPE_CHECKING, Any, Final

from rosic.core.i18n import said
from rosic.core.time_units import SECOND_NS
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
        # Whoever waits, and until when; one task looks after all of them, as all wait equally long.
        self._waiting: deque[tuple[int, asyncio.Future[None]]] = deque()
        self._waits = 0
        self._patience: asyncio.Task[None] | None = None

    async def write(self, records: Sequence[Record], disown: Callable[[], None]) -> None:
        """Write all or none, in the order of the calls.

        What is written at once costs no task. While something is late, nothing else is tried.

        Args:
            records: What is to be on disk on return.
            disown: Called if it is on disk after all, once this has given it up.

        Raises:
            Repeated, StoreFault: As the store does; or it was not written in time.
            asyncio.CancelledError: It is written; with a cause, it is not.
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
        over = asyncio.get_running_loop().create_future()
        task.add_done_callback(partial(_end, over))
        self._be_patient(over)
        try:
            await over
        except asyncio.CancelledError as cancelled:
            task.cancel()
            await asyncio.wait((task,))
            found = task.result()
            # Cut off and written all the same is what a store says without a cause.
            raise cancelled from (
                found.__cause__ if isinstance(found, asyncio.CancelledError) else found
            )
        finally:
            self._waits -= 1
            if not self._waits and self._patience is not None:
                self._patience.cancel()
                self._patience = None
                self._waiting.clear()
        if not task.done():
            self._late.add(task)
            task.add_done_callback(lambda done: self._written(done, disown))
            raise StoreFault(NOT_IN_TIME)
        if (error := task.result()) is not None:
            raise error

    def _be_patient(self, over: asyncio.Future[None]) -> None:
        until_ns = self._clock.monotonic_ns() + int(WITHIN_S * SECOND_NS)
        self._waits += 1
        self._waiting.append((until_ns, over))
        if self._patience is None or self._patience.done():
            self._patience = asyncio.create_task(self._end_waits())

    async def _end_waits(self) -> None:
        """End each wait in its time, for as long as anybody waits."""
        while self._waiting:
            until_ns, over = self._waiting[0]
            if not over.done() and (left_ns := until_ns - self._clock.monotonic_ns()) > 0:
                await self._clock.sleep(left_ns / SECOND_NS)
                continue
            self._waiting.popleft()
            _end(over)

    def _written(
        self, task: asyncio.Task[BaseException | None], disown: Callable[[], None]
    ) -> None:
        self._late.discard(task)
        if not task.cancelled() and task.result() is None:
            disown()


def _end(over: asyncio.Future[None], _task: object = None) -> None:
    """Let somebody wait no longer."""
    if not over.done():
        over.set_result(None)


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
