"""A disk that does not work: who is told what, what is kept, and that it heals without restart."""

from __future__ import annotations

import asyncio
import sqlite3
from contextlib import asynccontextmanager, closing
from typing import TYPE_CHECKING

import pytest

from rosic.core.records import Fact, Letter
from rosic.errors import Repeated, StoreFault
from rosic.stores.data_dir import StoreSettings
from rosic.stores.database import DatabaseStore
from rosic.stores.record_mark import DATABASE
from rosic.testing.clock import ManualClock
from rosic.testing.factories import (
    ADA,
    KUKA,
    OMNI,
    a_choice,
    a_claim,
    a_conclusion,
    a_decision,
    a_resumption,
    a_stop,
    told,
)
from tests.pace import pace

if TYPE_CHECKING:
    from collections.abc import AsyncIterator
    from pathlib import Path

QUICK = StoreSettings(busy_timeout_ms=20)
DAY_S = 86_400


@pytest.fixture
def clock() -> ManualClock:
    return ManualClock()


@asynccontextmanager
async def opened(
    folder: Path, clock: ManualClock, settings: StoreSettings = QUICK
) -> AsyncIterator[DatabaseStore]:
    store = DatabaseStore(folder, clock=clock, settings=settings)
    await store.open()
    try:
        yield store
    finally:
        await store.close()


def a_rival(folder: Path) -> sqlite3.Connection:
    """Another program at the same database, in autocommit."""
    return sqlite3.connect(folder / DATABASE, isolation_level=None)


def rows(folder: Path, query: str) -> list[tuple[object, ...]]:
    with closing(sqlite3.connect(folder / DATABASE)) as database:
        return database.execute(query).fetchall()


async def unfinished(folder: Path, clock: ManualClock) -> int:
    """Return how many open commands the next process finds."""
    store = DatabaseStore(folder, clock=clock)
    memory = await store.open()
    await store.close()
    return len(memory.unfinished)


async def test_a_locked_database_is_said_and_heals(tmp_path: Path, clock: ManualClock) -> None:
    async with opened(tmp_path, clock) as store:
        with closing(a_rival(tmp_path)) as rival:
            rival.execute("BEGIN EXCLUSIVE")
            for name in range(3):
                with pytest.raises(StoreFault, match="Another program holds the record"):
                    await store.write(a_claim(name))
            rival.execute("ROLLBACK")
        await store.write(a_claim(0))
        with pytest.raises(Repeated):
            await store.write(a_claim(0))


async def test_notes_wait_for_the_disk_in_order(tmp_path: Path, clock: ManualClock) -> None:
    async with opened(tmp_path, clock) as store:
        await store.write(a_claim(1))
        with closing(a_rival(tmp_path)) as rival:
            rival.execute("BEGIN EXCLUSIVE")
            store.note(a_conclusion(1), told(1))
            store.note(a_stop(3))
            store.note(a_choice(OMNI))
            with pytest.raises(StoreFault):
                await store.write(a_choice("never"))
            store.note(a_choice(KUKA))
            rival.execute("ROLLBACK")
        await store.write(a_claim(2))
        assert store.lost == 0
    assert rows(tmp_path, "SELECT generation, gap FROM stops") == [(3, 1)]
    assert rows(tmp_path, "SELECT robot FROM selections") == [(KUKA,)]
    assert await unfinished(tmp_path, clock) == 1


async def test_notes_are_written_by_themselves_once_the_disk_works(
    tmp_path: Path, clock: ManualClock
) -> None:
    async with opened(tmp_path, clock) as store:
        with closing(a_rival(tmp_path)) as rival:
            rival.execute("BEGIN EXCLUSIVE")
            store.note(a_stop(3))
            with pytest.raises(StoreFault):
                await store.write(a_claim(1))
            rival.execute("ROLLBACK")
            async with asyncio.timeout(60 * pace()):
                while not rival.execute("SELECT * FROM stops").fetchall():  # noqa: ASYNC110
                    await asyncio.sleep(0.01)


async def test_lost_notes_are_counted_in_the_record(tmp_path: Path, clock: ManualClock) -> None:
    settings = StoreSettings(busy_timeout_ms=20, notes_max=10)
    async with opened(tmp_path, clock, settings) as store:
        with closing(a_rival(tmp_path)) as rival:
            rival.execute("BEGIN EXCLUSIVE")
            for generation in range(1, 31):
                store.note(a_stop(generation))
            with pytest.raises(StoreFault):
                await store.write(a_claim(1))
            rival.execute("ROLLBACK")
        await store.write(a_claim(1))
        assert store.lost == 20
    # The newest stops are the ones that matter.
    assert rows(tmp_path, "SELECT min(generation), max(generation) FROM stops") == [(21, 30)]
    assert rows(tmp_path, "SELECT at_ns, lost FROM gaps") == [(clock.wall_ns(), 20)]


async def test_a_full_database_is_said_and_heals(tmp_path: Path, clock: ManualClock) -> None:
    async with opened(tmp_path, clock, StoreSettings(pages_max=120)) as store:
        big = Letter(ADA, bytes(20_000))
        fault, written = None, 0
        while fault is None and written < 100:
            claim = a_claim(written, letter=big, accepted_ns=clock.wall_ns())
            try:
                await store.write(claim, a_conclusion(written), told(written))
                written += 1
            except StoreFault as error:
                fault = error
        assert "The disk is full" in str(fault)
        assert 5 < written < 60
        clock.jump_wall(31 * DAY_S)
        # Small enough to be written still, and a month younger than those claims.
        await store.write(a_claim("later", letter=None, accepted_ns=clock.wall_ns()))
        assert await store.prune() >= written
        await store.write(a_claim("again", letter=big))


async def test_what_does_not_fit_fails_alone(tmp_path: Path, clock: ManualClock) -> None:
    async with opened(tmp_path, clock) as store:
        calls = [a_claim(name, n=name) for name in range(40)]
        calls[5] = a_claim(5, n=1 << 70)
        calls[17] = a_claim(17, skill="\ud800")
        calls[30] = a_claim(30, principal=None)
        answers = await asyncio.gather(*map(store.write, calls), return_exceptions=True)
        bad = {name: answer for name, answer in enumerate(answers) if answer is not None}
        assert {name: type(answer) for name, answer in bad.items()} == {
            5: StoreFault,
            17: StoreFault,
            30: StoreFault,
        }
        await store.write(a_claim(5))
    assert rows(tmp_path, "SELECT count(*) FROM commands") == [(38,)]


async def test_a_note_that_does_not_fit_is_counted_as_lost(
    tmp_path: Path, clock: ManualClock
) -> None:
    """Nobody waits for it, so that nobody would be told."""
    async with opened(tmp_path, clock) as store:
        store.note(a_stop(1 << 70))
        store.note(a_stop(2))
        await store.write(a_claim(1))
        assert store.lost == 1
        await store.write(a_claim(2))
    assert rows(tmp_path, "SELECT generation FROM stops") == [(2,)]
    assert rows(tmp_path, "SELECT lost FROM gaps") == [(1,)]


async def test_a_group_that_fails_leaves_no_trace_in_memory(
    tmp_path: Path, clock: ManualClock
) -> None:
    """One call does not fit, and then the disk is full: what fitted before is forgotten, too."""
    async with opened(tmp_path, clock, StoreSettings(pages_max=120)) as store:
        answers = await asyncio.gather(
            store.write(a_claim("small")),
            store.write(a_claim("unfit", n=1 << 70)),
            store.write(a_claim("big", letter=Letter(ADA, bytes(1_000_000)))),
            return_exceptions=True,
        )
        assert [type(answer) for answer in answers] == [StoreFault] * 3
        await store.write(a_conclusion("small"))
        await store.write(a_claim("small"), a_conclusion("small"))
    assert rows(tmp_path, "SELECT ending FROM endings JOIN commands USING (seq)") == [("done",)]


async def test_too_many_waiting_calls_are_refused(tmp_path: Path, clock: ManualClock) -> None:
    async with opened(tmp_path, clock, StoreSettings(queue_max=50)) as store:
        answers = await asyncio.gather(
            *(store.write(a_claim(name)) for name in range(80)), return_exceptions=True
        )
        assert answers[:50] == [None] * 50
        assert all("cannot keep up" in str(answer) for answer in answers[50:])
        await store.write(a_claim(79))


async def test_a_stop_a_resume_and_a_lock_are_written_however_much_else_waits(
    tmp_path: Path, clock: ManualClock
) -> None:
    async with opened(tmp_path, clock, StoreSettings(queue_max=50)) as store:
        for name in range(100):
            store.note(a_choice(f"robot{name}"))
        store.note(a_choice("lost"))
        with pytest.raises(StoreFault, match="cannot keep up"):
            await store.write(a_claim(1))
        store.note(a_stop(1))
        lock = Fact(kind="lock", key="bo", body=b"x")
        await asyncio.gather(
            store.write(a_resumption("again", 1)), store.write(a_decision("bo"), lock)
        )
        assert store.lost == 1, "the note that is one too many"
    assert rows(tmp_path, "SELECT kind FROM commands") == [("resumed",)]
    assert rows(tmp_path, "SELECT key FROM facts WHERE kind = 'lock'") == [("bo",)]
    assert rows(tmp_path, "SELECT generation FROM stops") == [(1,)]


async def test_too_many_open_commands_are_refused(tmp_path: Path, clock: ManualClock) -> None:
    async with opened(tmp_path, clock, StoreSettings(open_orders_max=10)) as store:
        answers = await asyncio.gather(
            *(store.write(a_claim(name)) for name in range(15)), return_exceptions=True
        )
        assert [answer is None for answer in answers] == [True] * 10 + [False] * 5
        assert "The record is full" in str(answers[12])
        await store.write(a_conclusion(3), told(3))
        await store.write(a_claim(12))


async def test_a_caller_who_gave_up_disturbs_nobody(tmp_path: Path, clock: ManualClock) -> None:
    async with opened(tmp_path, clock) as store:
        impatient = asyncio.ensure_future(store.write(a_claim(1)))
        patient = asyncio.ensure_future(store.write(a_claim(2)))
        await asyncio.sleep(0)
        impatient.cancel()
        await patient
        assert impatient.cancelled()


async def test_what_comes_of_an_unknown_command_is_left_out(
    tmp_path: Path, clock: ManualClock
) -> None:
    async with opened(tmp_path, clock) as store:
        await store.write(a_conclusion("unknown"), told("unknown"))
        await store.write(a_claim(1), a_conclusion(1), told(1))
        await store.write(told(1))
    assert rows(tmp_path, "SELECT count(*) FROM endings") == [(1,)]


async def test_old_settled_commands_are_forgotten_and_no_others(
    tmp_path: Path, clock: ManualClock
) -> None:
    async with opened(tmp_path, clock) as store:
        await store.write(*(a_claim(name, accepted_ns=clock.wall_ns()) for name in range(2500)))
        await store.write(*(a_conclusion(name) for name in range(2500)))
        await store.write(*(told(name) for name in range(10, 2500)), a_stop(1))
        clock.jump_wall(29 * DAY_S)
        await store.write(a_claim("young", accepted_ns=clock.wall_ns()))
        assert await store.prune() == 0
        with pytest.raises(Repeated):
            await store.write(a_claim(77))
        clock.jump_wall(2 * DAY_S)
        assert await store.prune() == 0, "a clock that jumps ahead forgets nothing"
        await store.write(a_claim("newest", accepted_ns=clock.wall_ns()))
        assert await store.prune() == 2490
        await store.write(a_claim(77))
        with pytest.raises(Repeated):
            await store.write(a_claim(3))
    assert rows(tmp_path, "SELECT count(*) FROM endings WHERE sealed IS NOT NULL") == [(10,)]
    assert await unfinished(tmp_path, clock) == 13


async def test_opening_forgets_some_of_what_is_old(tmp_path: Path, clock: ManualClock) -> None:
    async with opened(tmp_path, clock) as store:
        await store.write(*(a_claim(name, accepted_ns=clock.wall_ns()) for name in range(20)))
        await store.write(*(told(name) for name in range(20)))
        clock.jump_wall(31 * DAY_S)
        await store.write(a_claim("newest", accepted_ns=clock.wall_ns()))
    async with opened(tmp_path, clock):
        pass
    assert rows(tmp_path, "SELECT count(*) FROM commands") == [(1,)]
