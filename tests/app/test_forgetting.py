from __future__ import annotations

import asyncio
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING

from rosic.app.service import SOON_S, forget_daily
from rosic.contracts.store import ForgettingStore
from rosic.core.time_units import DAY_S
from rosic.errors import StoreFault
from rosic.stores.database import DatabaseStore
from rosic.stores.memory import MemoryStore
from rosic.testing.clock import ManualClock

if TYPE_CHECKING:
    from collections.abc import AsyncIterator
    from pathlib import Path

    import pytest


class Records:
    """Forgets as it is told; None stands for a disk that fails."""

    def __init__(self, *counts: int | None) -> None:
        self.counts = list(counts)
        self.asked = 0

    async def prune(self) -> int:
        self.asked += 1
        count = self.counts.pop(0) if self.counts else 0
        if count is None:
            raise StoreFault("The disk is full.")
        return count


@asynccontextmanager
async def forgetting(store: ForgettingStore, clock: ManualClock) -> AsyncIterator[None]:
    task = asyncio.create_task(forget_daily(store, clock))
    yield
    assert not task.done()
    task.cancel()
    await asyncio.wait([task])


async def test_it_forgets_soon_and_then_once_a_day() -> None:
    clock, records = ManualClock(), Records()
    async with forgetting(records, clock):
        await clock.advance(SOON_S - 1)
        assert records.asked == 0
        await clock.advance(1)
        assert records.asked == 1
        await clock.advance(DAY_S - 1)
        assert records.asked == 1
        await clock.advance(1 + 2 * DAY_S)
        assert records.asked == 4


async def test_what_fails_is_logged_and_tried_again(caplog: pytest.LogCaptureFixture) -> None:
    caplog.set_level("INFO")
    clock, records = ManualClock(), Records(None, 0, 7)
    async with forgetting(records, clock):
        await clock.advance(SOON_S + 2 * DAY_S)

    assert [(r.levelname, r.getMessage()) for r in caplog.records] == [
        ("ERROR", "old commands could not be forgotten; I try again in a day"),
        ("INFO", "7 old commands were forgotten"),
    ]


async def test_the_record_on_disk_can_forget_the_one_in_memory_need_not(tmp_path: Path) -> None:
    clock = ManualClock()
    store = DatabaseStore(tmp_path / "data", clock=clock)
    assert isinstance(store, ForgettingStore)
    assert not isinstance(MemoryStore(), ForgettingStore)
    await store.open()
    assert await store.prune() == 0
    await store.close()
