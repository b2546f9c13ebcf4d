from __future__ import annotations

import msgspec
import pytest

from rosic.core.local_time import LocalTime
from rosic.core.records import Fact
from rosic.core.slot import SERIES, SLOT, BookedSlot, Pattern, Series, read_fact

START_NS = 1_795_000_000_000_000_000
HOUR_NS = 3_600_000_000_000


def a_slot(start_ns: int = START_NS, end_ns: int = START_NS + HOUR_NS) -> BookedSlot:
    return BookedSlot(
        id="s1", principal="p1", robot="kuka1", start_ns=start_ns, end_ns=end_ns, made_ns=1, by="p1"
    )


def test_a_slot_is_what_was_written_down() -> None:
    fact = a_slot().fact()
    assert (fact.kind, fact.key, fact.letter) == (SLOT, "s1", None)
    assert read_fact(fact, BookedSlot) == a_slot()
    assert a_slot().no_more() == Fact(kind=SLOT, key="s1", body=b"")


def test_a_series_is_what_was_written_down() -> None:
    pattern = Pattern(LocalTime(2026, 11, 24, 14), 3600, "FREQ=WEEKLY;COUNT=3", "Europe/Vienna")
    series = Series(id="r1", principal="p1", robot="kuka1", pattern=pattern, made_ns=1, by="p2")
    assert series.fact().kind == SERIES
    assert read_fact(series.fact(), Series) == series
    assert series.no_more().body == b""


def test_it_covers_its_start_and_not_its_end() -> None:
    slot = a_slot()
    covered = [slot.covers(at) for at in (START_NS - 1, START_NS, START_NS + HOUR_NS - 1)]
    assert covered == [False, True, True]
    assert not slot.covers(START_NS + HOUR_NS)


@pytest.mark.parametrize(
    ("start_ns", "end_ns"),
    [(START_NS, START_NS), (START_NS, START_NS - 1), (-1, START_NS), (START_NS, 2**63 - 1)],
)
def test_no_other_slot_can_be_made_or_read(start_ns: int, end_ns: int) -> None:
    with pytest.raises(ValueError, match="ends after it starts"):
        a_slot(start_ns, end_ns)
    body = msgspec.msgpack.encode(
        msgspec.structs.asdict(a_slot()) | {"start_ns": start_ns, "end_ns": end_ns}
    )
    with pytest.raises(ValueError, match="ends after it starts"):
        read_fact(Fact(kind=SLOT, key="s1", body=body), BookedSlot)


@pytest.mark.parametrize("body", [b"\xc1", b"\x80", b"nonsense"])
def test_what_is_no_slot_is_not_read(body: bytes) -> None:
    with pytest.raises(ValueError, match=r"."):
        read_fact(Fact(kind=SLOT, key="s1", body=body), BookedSlot)
