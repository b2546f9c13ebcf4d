"""What was asked for is read back the same from memory and from disk, in bounded steps."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest
from msgspec.structs import replace

from rosic.core.history import HistoryQuery
from rosic.core.records import Concluded, Letter
from rosic.stores import history
from rosic.stores.database import DatabaseStore
from rosic.stores.memory import MemoryStore
from rosic.testing.clock import ManualClock
from rosic.testing.factories import (
    ADA,
    a_claim,
    a_conclusion,
    a_refusal,
    a_resumption,
    a_stop,
    an_enrolment,
    an_id,
)

if TYPE_CHECKING:
    from pathlib import Path

BO = "bo"


@pytest.fixture(params=["memory", "disk"])
def store(request: pytest.FixtureRequest, tmp_path: Path) -> MemoryStore | DatabaseStore:
    if request.param == "memory":
        return MemoryStore()
    return DatabaseStore(tmp_path / "data", clock=ManualClock())


async def test_the_newest_come_first_and_only_what_was_asked_about(
    store: MemoryStore | DatabaseStore,
) -> None:
    await store.open()
    await store.write(an_enrolment())
    asked = Letter(ADA, b"asked")
    await store.write(a_claim("one", letter=asked, accepted_ns=1_000))
    await store.write(a_conclusion("one"))
    await store.write(a_claim("two", principal=BO, robot="kuka1", accepted_ns=2_000, letter=None))
    await store.write(a_refusal("three", Letter(ADA, b"no")))
    await store.write(a_resumption("four"))

    everything = await store.history(HistoryQuery())
    assert [entry.kind for entry in everything] == ["resumed", "refused", "claimed", "claimed"]
    first = everything[-1]
    assert (first.principal, first.robot, first.skill, first.at_ns) == (ADA, "omni", "move", 1_000)
    assert (first.outcome, first.ended_ns, first.letter, first.words) == (
        "done",
        2_000,
        b"asked",
        b"moved",
    )
    assert everything[1].outcome == "robot-taken"
    assert [e.principal for e in await store.history(HistoryQuery(principal=BO))] == [BO]
    assert [e.robot for e in await store.history(HistoryQuery(robot="kuka1"))] == ["kuka1"]
    assert len(await store.history(HistoryQuery(since_ns=2_000))) == 1
    assert [e.kind for e in await store.history(HistoryQuery(limit=2))] == ["resumed", "refused"]

    [second] = await store.history(HistoryQuery(cid=an_id("two")))
    assert (second.principal, second.robot, second.kind) == (BO, "kuka1", "claimed")
    assert await store.history(HistoryQuery(cid=an_id("five"))) == ()

    await store.shred(ADA)
    erased = (await store.history(HistoryQuery(principal=ADA, robot="omni")))[-1]
    assert (erased.outcome, erased.letter, erased.words) == ("done", None, None)
    await store.close()


async def test_a_resume_that_had_no_effect_says_so(store: MemoryStore | DatabaseStore) -> None:
    await store.open()
    await store.write(a_resumption("one"))
    await store.write(a_resumption("two"))
    store.note(Concluded(cid=an_id("one"), ending="refused", at_ns=2_000))
    await store.write(a_resumption("three"))
    entries = await store.history(HistoryQuery())
    assert [(e.kind, e.outcome) for e in entries] == [
        ("resumed", ""),
        ("resumed", ""),
        ("resumed", "refused"),
    ]
    await store.close()


async def test_a_long_record_is_read_in_steps(tmp_path: Path) -> None:
    store = DatabaseStore(tmp_path / "data", clock=ManualClock())
    await store.open()
    count = 2 * history.AT_ONCE + 10
    claims = (a_claim(n, principal=BO if n else ADA, letter=None) for n in range(count))
    await store.write(*claims)
    assert len(await store.history(HistoryQuery(limit=count + 1))) == count
    [oldest] = await store.history(HistoryQuery(principal=ADA))
    assert oldest.principal == ADA
    await store.close()


async def test_stops_stand_among_the_commands(store: MemoryStore | DatabaseStore) -> None:
    await store.open()
    await store.write(a_claim("one", accepted_ns=500, letter=None))
    await store.write(a_stop(1), a_stop(2))
    await store.write(a_claim("two", accepted_ns=2_000, letter=None))
    everything = await store.history(HistoryQuery())
    assert [e.kind for e in everything] == ["claimed", "stopped", "stopped", "claimed"]
    assert [(e.principal, e.robot, e.at_ns) for e in everything[1:3]] == [(ADA, "omni", 1_000)] * 2
    assert [e.kind for e in await store.history(HistoryQuery(limit=2))] == ["claimed", "stopped"]
    assert len(await store.history(HistoryQuery(robot="omni", since_ns=1_000))) == 3
    assert await store.history(HistoryQuery(principal=BO)) == ()
    assert await store.history(HistoryQuery(robot="kuka1")) == ()
    await store.close()


async def test_a_stop_that_was_repeated_is_no_row_and_its_generation_stays(
    store: MemoryStore | DatabaseStore,
) -> None:
    await store.open()
    await store.write(a_stop(1))
    await store.write(*[replace(a_stop(number), repeated=True) for number in range(2, 500)])
    await store.write(a_stop(500))
    assert [e.kind for e in await store.history(HistoryQuery())] == ["stopped", "stopped"]
    await store.write(replace(a_stop(501), repeated=True))
    await store.close()
    assert (await store.open()).generations == {"omni": 501}, "I13"
    await store.close()
