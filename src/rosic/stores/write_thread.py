"""One thread that does what an event loop hands to it, in order and in groups.

An event loop that waits for a disk serves nobody. What is asked for in one turn of the loop goes
over together, and comes back together: one wake-up each way, however many calls there were.

What is urgent has room of its own and goes before everything that has not begun: it is neither
refused nor delayed because much that is not urgent waits. Among themselves urgent jobs keep their
order, and so do the others.
"""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Callable
from contextlib import suppress
from queue import Empty, SimpleQueue
from typing import Any, Generic, TypeVar

import msgspec

from rosic.core.i18n import said
from rosic.errors import StoreFault

T = TypeVar("T")
R = TypeVar("R")

RETRY_S = 0.25


class WriteJob(msgspec.Struct, Generic[T], eq=False):
    """One thing to be done.

    Attributes:
        content: What; for ``call`` a function.
        future: Who waits; None for a note.
        then: Called in the event loop when the job was tried, done or not.
        error: Set by the thread when it was not done.
        result: Of a call.
        told: Whether what became of it has reached the event loop.
    """

    content: T
    future: asyncio.Future[Any] | None
    then: Callable[[], None] | None = None
    error: Exception | None = None
    result: object = None
    told: bool = False

    def fail(self, error: Exception) -> None:
        """It was not done; whoever waits for it is told why."""
        self.error = error

    def retry_with(self, content: T) -> None:
        """It is to be done with another try, and then so."""
        self.content = content

    def tell(self) -> None:
        """Tell whoever waits what became of it. Whoever is cut off in this turn asks `decided`."""
        self.told = True
        future = self.future
        if future is None or future.done():
            return
        if self.error is None:
            future.set_result(self.result)
        else:
            future.set_exception(self.error)

    async def decided(self) -> None:
        """Wait until it is known what became of it; nobody can call it back."""
        if not self.told and self.future is not None and self.future.cancelled():
            self.future = asyncio.get_running_loop().create_future()
            await asyncio.wait((self.future,))
            self.future.exception()  # whoever was cut off says it by `error`


class WriteCall(WriteJob[Any], eq=False):
    """A function to be run between two groups."""

    def run(self) -> None:
        """Run it, and keep what it returns or raises."""
        try:
            self.result = self.content()
        except Exception as error:  # noqa: BLE001  whoever waits for the call gets it
            self.error = error


class WriteThread(Generic[T]):
    """The queue and its thread.

    Args:
        name: Of the thread.
        settle: Runs in the thread. Does a group, and calls ``fail`` of the jobs it could not do.
            Returns whether it wants to be called again soon without new jobs.
        finish: Runs in the thread, last.
        group_max: Jobs in one group.
        queue_max: Jobs that may wait; notes may be twice as many, for they cannot be refused. As
            many again may wait that are urgent.
        urgent: Says whether something goes before what is not; None: nothing does.
    """

    def __init__(
        self,
        name: str,
        settle: Callable[[list[WriteJob[T]]], bool],
        *,
        finish: Callable[[], None],
        group_max: int,
        queue_max: int,
        urgent: Callable[[T], bool] | None = None,
    ) -> None:
        self._name = name
        self._settle = settle
        self._finish = finish
        self._group_max = group_max
        self._queue_max = queue_max
        # What one turn of the loop asked for; a call; or, last, nothing any more.
        self._queue: SimpleQueue[list[WriteJob[T]] | WriteCall | None] = SimpleQueue()
        self._turn: list[WriteJob[T]] = []
        self._waiting = 0
        self._is_urgent = urgent or _never
        self._ahead: SimpleQueue[list[WriteJob[T]]] = SimpleQueue()
        self._ahead_turn: list[WriteJob[T]] = []
        self._ahead_waiting = 0
        self._running = False
        self._loop: asyncio.AbstractEventLoop | None = None

    def start(self) -> None:
        """Start the thread; belongs to the running event loop from now on."""
        self._loop = asyncio.get_running_loop()
        self._running = True
        self._stopped = self._loop.create_future()
        threading.Thread(target=self._run, name=self._name, daemon=True).start()

    async def put(self, content: T) -> None:
        """Have something done and wait until it is.

        Raises:
            StoreFault: Too much is waiting, or the lane is closed. It was not done.
            Exception: With whatever ``settle`` failed it.
            asyncio.CancelledError: It was done; with a cause, it was not.
        """
        urgent = self._is_urgent(content)
        future = self._admit(urgent=urgent)
        job = WriteJob(content, future)
        if urgent:
            self._overtake(job)
        else:
            self._append(job)
        try:
            await future
        except asyncio.CancelledError as cancelled:
            await job.decided()
            raise cancelled from job.error

    async def call(self, function: Callable[[], R]) -> R:
        """Run a function in the thread, after everything that was asked for before."""
        future = self._admit()
        self._waiting += 1
        self._hand_over()
        self._queue.put(WriteCall(function, future))
        result: R = await future
        return result

    def drop(self, content: T, then: Callable[[], None] | None = None) -> bool:
        """Have something done without waiting, and ``then`` called. Return whether it was taken."""
        urgent = self._is_urgent(content)
        waiting = self._ahead_waiting if urgent else self._waiting
        if not self._running or waiting >= 2 * self._queue_max:
            return False
        job = WriteJob(content, None, then)
        if urgent:
            self._overtake(job)
        else:
            self._append(job)
        return True

    async def stop(self) -> None:
        """Finish what is waiting, then end the thread. Doing it twice is harmless."""
        if self._loop is None:
            return
        if self._running:
            self._running = False
            self._hand_over()
            self._queue.put(None)
        await asyncio.shield(self._stopped)

    def _admit(self, *, urgent: bool = False) -> asyncio.Future[Any]:
        if not self._running or self._loop is None:
            raise StoreFault(said("The record is closed. Nothing was written."))
        if (self._ahead_waiting if urgent else self._waiting) >= self._queue_max:
            raise StoreFault(said("The record cannot keep up. Nothing was written."))
        return self._loop.create_future()

    def _append(self, job: WriteJob[T]) -> None:
        self._waiting += 1
        turn = self._turn
        if not turn and self._loop is not None:
            self._loop.call_soon(self._hand_over)
        turn.append(job)

    def _overtake(self, job: WriteJob[T]) -> None:
        self._ahead_waiting += 1
        if not self._ahead_turn and self._loop is not None:
            self._loop.call_soon(self._hand_over)
        self._ahead_turn.append(job)

    def _hand_over(self) -> None:
        if self._ahead_turn:
            self._ahead.put(self._ahead_turn)
            self._ahead_turn = []
            self._queue.put([])  # wakes the thread
        if self._turn:
            self._queue.put(self._turn)
            self._turn = []

    # ---- in the thread ----

    def _run(self) -> None:
        again = False
        going = True
        while going:
            jobs, call, going = self._next(again)
            again = self._do_ahead() or again
            if jobs or call is None:
                again = self._do(jobs)
            if call is not None:
                call.run()
                self._report(self._resolve, [call])
        self._finish()
        self._report(self._end)

    def _next(self, again: bool) -> tuple[list[WriteJob[T]], WriteCall | None, bool]:
        """Wait for work, and take all there is up to about one group, or up to a call."""
        jobs: list[WriteJob[T]] = []
        try:
            item = self._queue.get(timeout=RETRY_S if again else None)
            while isinstance(item, list):
                jobs += item
                if len(jobs) >= self._group_max:
                    return jobs, None, True
                item = self._queue.get_nowait()
        except Empty:
            return jobs, None, True
        return jobs, item, item is not None

    def _do(self, jobs: list[WriteJob[T]]) -> bool:
        """Do jobs in groups. Return whether to do so again soon without new jobs."""
        if not jobs:
            return self._do_group(jobs)
        again = False
        for start in range(0, len(jobs), self._group_max):
            self._do_ahead()
            group = jobs[start : start + self._group_max]
            again = self._do_group(group)
            self._report(self._resolve, group)
        return again

    def _do_ahead(self) -> bool:
        """Do what is urgent by now. Return whether to do so again soon without new jobs."""
        jobs: list[WriteJob[T]] = []
        with suppress(Empty):
            while True:
                jobs += self._ahead.get_nowait()
        again = False
        for start in range(0, len(jobs), self._group_max):
            group = jobs[start : start + self._group_max]
            again = self._do_group(group)
            self._report(self._resolve_ahead, group)
        return again

    def _do_group(self, jobs: list[WriteJob[T]]) -> bool:
        try:
            return self._settle(jobs)
        except Exception as error:  # noqa: BLE001  the thread outlives whatever happens in it
            for job in jobs:
                job.fail(job.error or error)
            return False

    def _report(self, function: Callable[..., None], *arguments: object) -> None:
        loop = self._loop
        if loop is not None:
            with suppress(RuntimeError):  # the loop has gone, and with it everybody who waited
                loop.call_soon_threadsafe(function, *arguments)

    # ---- in the event loop ----

    def _resolve(self, jobs: list[WriteJob[T]]) -> None:
        self._waiting -= len(jobs)
        self._tell(jobs)

    def _resolve_ahead(self, jobs: list[WriteJob[T]]) -> None:
        self._ahead_waiting -= len(jobs)
        self._tell(jobs)

    def _tell(self, jobs: list[WriteJob[T]]) -> None:
        for job in jobs:
            if job.then is not None:
                self._call(job.then)
            job.tell()

    def _call(self, then: Callable[[], None]) -> None:
        """Call what follows a job. If it goes wrong, the rest of the group is told all the same."""
        try:
            then()
        except Exception as error:  # noqa: BLE001  said below, and nobody else's business
            if self._loop is not None:
                context = {"message": "what follows a note failed", "exception": error}
                self._loop.call_exception_handler(context)

    def _end(self) -> None:
        if not self._stopped.done():
            self._stopped.set_result(None)


def _never(_content: object) -> bool:
    return False
