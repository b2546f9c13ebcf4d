"""Nobody waits for the record for longer than a moment, however many wait, and whoever waits."""

from __future__ import annotations

import asyncio

import pytest

from rosic.container.bounded_writes import WITHIN_S, BoundedWriter
from rosic.core.i18n import said
from rosic.errors import StoreFault
from rosic.stores.memory import MemoryStore
from rosic.testing.clock import ManualClock, settle


class HeldStore(MemoryStore):
    """Writes each call once it is let go on, or fails then."""

    def __init__(self) -> None:
        super().__init__()
        self.held: list[asyncio.Event] = []
        self.fails: BaseException | None = None
        self.finishes = False

    async def write(self, *_records: object) -> None:
        """Wait to be let go on; cut off, fail or finish all the same."""
        event = asyncio.Event()
        self.held.append(event)
        try:
            await event.wait()
        except asyncio.CancelledError:
            if not self.finishes:
                raise
        if self.fails is not None:
            raise self.fails


def nothing() -> None:
    """Take back nothing."""


async def test_each_wait_ends_in_its_own_time() -> None:
    clock, store = ManualClock(), HeldStore()
    writer = BoundedWriter(store, clock)
    first = asyncio.create_task(writer.write((), nothing))
    await settle()
    await clock.advance(WITHIN_S / 2)
    second = asyncio.create_task(writer.write((), nothing))
    await settle()
    await clock.advance(WITHIN_S / 2)
    assert first.done()
    assert isinstance(first.exception(), StoreFault)
    assert not second.done()
    await clock.advance(WITHIN_S / 2)
    assert isinstance(second.exception(), StoreFault)
    for event in store.held:
        event.set()
    await settle()


async def test_what_is_written_in_time_leaves_the_others_their_time() -> None:
    clock, store = ManualClock(), HeldStore()
    writer = BoundedWriter(store, clock)
    tasks = []
    for _ in range(3):
        tasks.append(asyncio.create_task(writer.write((), nothing)))
        await settle()
        await clock.advance(WITHIN_S / 4)
    store.held[0].set()
    store.held[2].set()
    await settle()
    assert [task.done() for task in tasks] == [True, False, True]
    await clock.advance(WITHIN_S / 4)
    assert not tasks[1].done()
    await clock.advance(WITHIN_S / 4)
    with pytest.raises(StoreFault):
        await tasks[1]
    store.held[1].set()
    await settle()


class HandClock(ManualClock):
    """Everybody sleeps until the test wakes them, all at once."""

    def __init__(self) -> None:
        super().__init__()
        self._woken = asyncio.Event()

    async def sleep(self, seconds: float) -> None:
        """Sleep until `ring`."""
        del seconds
        await self._woken.wait()

    def ring(self, seconds: float) -> None:
        """Let time pass, and wake everybody."""
        self.suspend(seconds)
        self._woken.set()
        self._woken.clear()


async def test_a_wait_that_begins_as_the_last_one_ends_is_ended_as_well() -> None:
    clock, store, go = HandClock(), HeldStore(), asyncio.Event()
    writer = BoundedWriter(store, clock)

    async def later() -> None:
        await go.wait()
        await writer.write((), nothing)

    first = asyncio.create_task(writer.write((), nothing))
    second = asyncio.create_task(later())
    await settle()
    clock.ring(WITHIN_S)
    go.set()  # it begins after the wait of the first was ended, and before the first has noticed
    await settle()
    assert isinstance(first.exception(), StoreFault)
    assert not second.done()
    clock.ring(WITHIN_S)
    await settle()
    assert second.done()
    assert isinstance(second.exception(), StoreFault)
    for event in store.held:
        event.set()
    await settle()


async def test_a_wait_that_begins_as_the_last_one_was_written_is_ended_as_well() -> None:
    clock, store = ManualClock(), HeldStore()
    writer = BoundedWriter(store, clock)

    async def twice() -> None:
        for _ in range(2):
            await writer.write((), nothing)

    both = asyncio.create_task(twice())
    await settle()
    store.held[0].set()
    await settle()
    assert len(store.held) == 2
    await clock.advance(WITHIN_S)
    assert both.done()
    assert isinstance(both.exception(), StoreFault)
    store.held[1].set()
    await settle()


async def test_what_fails_in_time_is_said_to_whoever_waits() -> None:
    store = HeldStore()
    writer = BoundedWriter(store, ManualClock())
    store.fails = StoreFault(said("The disk is full. Nothing was written."))
    writing = asyncio.create_task(writer.write((), nothing))
    await settle()
    store.held[0].set()
    await settle()
    assert writing.exception() is store.fails


@pytest.mark.parametrize("fails", [False, True])
async def test_what_is_late_is_disowned_once_it_is_on_disk_and_only_then(*, fails: bool) -> None:
    clock, store, disowned = ManualClock(), HeldStore(), list[str]()
    writer = BoundedWriter(store, clock)
    late = asyncio.create_task(writer.write((), lambda: disowned.append("late")))
    await settle()
    await clock.advance(WITHIN_S)
    assert isinstance(late.exception(), StoreFault)
    assert not disowned
    with pytest.raises(StoreFault):
        await writer.write((), nothing)
    assert len(store.held) == 1, "while something is late, nothing else is tried"
    store.fails = StoreFault(said("The disk is full. Nothing was written.")) if fails else None
    store.held[0].set()
    await settle()
    assert disowned == ([] if fails else ["late"])
    again = asyncio.create_task(writer.write((), nothing))
    await settle()
    assert len(store.held) == 2, "it is tried again"
    again.cancel()
    await settle()


FULL = StoreFault(said("The disk is full. Nothing was written."))


def cut_off_because(cause: BaseException) -> BaseException:
    """Return how a store says that it was cut off and has not written."""
    error = asyncio.CancelledError()
    error.__cause__ = cause
    return error


@pytest.mark.parametrize(
    ("ends", "cause"),
    [
        (None, None),
        (asyncio.CancelledError(), None),
        (FULL, FULL),
        (cut_off_because(FULL), FULL),
    ],
    ids=["written", "cut off and written", "failed", "cut off and not written"],
)
async def test_whoever_is_cut_off_knows_whether_it_is_written(
    ends: BaseException | None, cause: BaseException | None
) -> None:
    """Without a cause it is: what was claimed and begins no more is taken back for that."""
    store = HeldStore()
    store.fails, store.finishes = ends, True
    writing = asyncio.create_task(BoundedWriter(store, ManualClock()).write((), nothing))
    await settle()
    writing.cancel()
    with pytest.raises(asyncio.CancelledError) as cut_off:
        await writing
    assert cut_off.value.__cause__ is cause


async def test_nothing_is_left_running_where_nobody_waits() -> None:
    clock, store = ManualClock(), HeldStore()
    writer = BoundedWriter(store, clock)
    before = asyncio.all_tasks()
    tasks = [asyncio.create_task(writer.write((), nothing)) for _ in range(5)]
    await settle()
    for event in store.held:
        event.set()
    await asyncio.gather(*tasks)
    await settle()
    assert asyncio.all_tasks() == before
