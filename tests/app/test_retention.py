"""What is over is forgotten once a day, as was set, and nothing else is."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest
from msgspec.structs import replace

from rosic.app.config import load_config
from rosic.config.gateway_file import Keep
from rosic.core.slot import SLOT, BookedSlot
from rosic.stores.database import DatabaseStore
from rosic.stores.memory import MemoryStore
from rosic.testing.clock import ManualClock
from rosic.testing.factories import a_decision
from tests.gateway.place import Place

if TYPE_CHECKING:
    from pathlib import Path

    from rosic.core.records import Fact

DAY_S = 86_400
DAY_NS = DAY_S * 10**9
NOW_NS = ManualClock().wall_ns()


def a_slot(ended_days: float, name: str) -> Fact:
    end_ns = NOW_NS - int(ended_days * DAY_NS)
    return BookedSlot(
        id=name,
        principal="bo",
        robot="omni",
        start_ns=end_ns - 10**12,
        end_ns=end_ns,
        series="",
        made_ns=0,
        by="bo",
    ).fact()


async def slots(store: MemoryStore) -> list[str]:
    return [fact.key for fact in await store.facts(SLOT, "", 100)]


async def test_old_times_and_acts_go_at_the_start_and_then_once_a_day() -> None:
    store = MemoryStore()
    await store.open()
    await store.write(*(a_slot(days, f"s{days}") for days in (12, 10.5, 9.5, -3)))
    await store.write(a_decision("a", NOW_NS - 41 * DAY_NS), a_decision("b", NOW_NS - DAY_NS))
    await store.close()
    place = Place(store)
    keep = Keep(slots_days=10, decisions_days=40)
    place.gateway._settings = replace(place.gateway._settings, keep=keep)
    async with place.open():
        calendar = place.gateway.rooms.organiser.calendar
        assert await slots(store) == ["s-3", "s9.5"]
        assert len(calendar) == 2
        assert "a" not in {decided.about for decided in await store.decisions(100)}
        assert "b" in {decided.about for decided in await store.decisions(100)}
        await place.clock.advance(0.4 * DAY_S)
        assert await slots(store) == ["s-3", "s9.5"]
        await place.clock.advance(DAY_S)
        assert await slots(store) == ["s-3"], "the next day"
        assert len(calendar) == 1


async def test_many_are_forgotten_in_steps() -> None:
    store = MemoryStore()
    await store.open()
    facts = [a_slot(200 - number / 50, f"s{number}") for number in range(2_500)]
    await store.write(*facts)
    await store.close()
    async with Place(store).open():
        assert await slots(store) == []


async def test_acts_on_disk_are_forgotten_by_age_and_a_clock_that_jumps_ahead_forgets_none(
    tmp_path: Path,
) -> None:
    clock = ManualClock()
    store = DatabaseStore(tmp_path, clock=clock)
    await store.open()
    try:
        await store.write(*(a_decision(f"p{n}", NOW_NS - n * DAY_NS) for n in range(3_000, 0, -1)))
        assert await store.forget_decisions(NOW_NS - 100 * DAY_NS) == 2_899, (
            "older than the newest by more"
        )
        assert len(await store.decisions(10_000)) == 101
        clock.jump_wall(10_000 * DAY_S)
        assert await store.forget_decisions(clock.wall_ns() - 100 * DAY_NS) == 0
    finally:
        await store.close()


def test_how_long_stands_in_the_configuration(tmp_path: Path) -> None:
    text = """
[keep]
slots_days = 30
[[messenger]]
kind = "terminal"
[[robot]]
profile = "omni"
"""
    path = tmp_path / "rosic.toml"
    path.write_text(text)
    assert load_config(path).keep == Keep(slots_days=30, decisions_days=1095)
    path.write_text(text.replace("30", "0.5"))
    with pytest.raises(Exception, match="'slots_days' must be between 1 and 36500"):
        load_config(path)
