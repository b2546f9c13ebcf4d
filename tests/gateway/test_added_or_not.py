"""A robot that cannot be added leaves everything as it was; one that was is there for good."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

import pytest

from rosic.core.records import Fact
from rosic.errors import RecordUnavailable
from rosic.stores.memory import MemoryStore
from tests.gateway.place import FLEET, STRANGER, VI, BrokenStore, Place, profile
from tests.gateway.rover import Lab, Reluctant, add, draft, refused, snapshot

if TYPE_CHECKING:
    from rosic.core.records import Record

# ---- not at all ----


@pytest.mark.parametrize(
    ("changes", "why"),
    [
        ({"id: rover": "id: omni"}, "A robot is called omni here already."),
        ({"title: Rover 3": "title: OMNI"}, "omni is called OMNI already."),
        ({"buggy": "kuka1"}, '"kuka1" means both kuka1 and rover.'),
        ({"swarm": "omni"}, '"omni" is both a group and a name for omni.'),
        ({"wiggle": "swarm"}, "is both a skill of rover and a name for swarm."),
        ({"max: 9": "max: 0"}, "rover.yaml:11"),
        ({"class: observe": "class: sing"}, "rover.yaml:12"),
        ({"for: 1 s": "for: 1 s, run: scan, as: Ada"}, "runs as Ada"),
    ],
)
async def test_what_is_wrong_or_there_already_changes_nothing(
    changes: dict[str, str], why: str
) -> None:
    async with Place().open() as place:
        before = snapshot(place.gateway)
        some = draft(**changes)
        said = await refused(add(place, some))
        assert why in said
        assert "Nothing was changed." in said
        assert snapshot(place.gateway) == before


async def test_a_second_namespace_or_id_is_refused_in_one_sentence() -> None:
    async with Place().open() as place:
        await add(place)
        said = await refused(
            add(place, draft(**{"id: rover": "id: other", "Rover 3": "Other", "[buggy]": "[]"}))
        )
        assert said == "Rover 3 is reached under /rover already. Nothing was changed."
        assert (await refused(add(place))).startswith("A robot is called rover here already.")
        await place.say("/robot retire rover")
        assert "takes no part now: /robot add rover" in await refused(add(place))


@pytest.mark.parametrize(
    ("name", "why"),
    [
        ("badone", "There is nobody there."),
        ("oddone", "the log says why"),
        ("lateone", "was not ready within 30 s."),
    ],
)
async def test_one_that_cannot_be_opened_leaves_the_gateway_as_it_was(name: str, why: str) -> None:
    async with Lab().open() as place:
        before = snapshot(place.gateway)
        assert why in await refused(add(place, draft(rover=name)))
        assert Reluctant.closed == [name]
        assert snapshot(place.gateway) == before
        await add(place)  # and the next one may come


async def test_what_cannot_be_written_down_is_closed_again() -> None:
    store = BrokenStore()
    async with Lab(store).open() as place:
        store.broken = True
        before = snapshot(place.gateway)
        with pytest.raises(RecordUnavailable):
            await add(place)
        assert Reluctant.closed == ["rover"]
        assert snapshot(place.gateway) == before
        store.broken = False
        assert "is here now" in await add(place)


async def test_of_two_that_are_added_at_once_one_is_there() -> None:
    async with Lab().open() as place:
        slow = draft(rover="slowrover")
        first, second = (asyncio.create_task(add(place, slow)) for _ in range(2))
        other = asyncio.create_task(add(place, draft(**{"id: rover": "id: other"})))
        await Reluctant.opening.wait()
        Reluctant.goes_on.set()
        assert "is here now" in await first
        assert "called slowrover here already" in await refused(second)
        assert "called Rover 3 already" in await refused(other)
        assert list(place.gateway.robots) == [*(p.id for p in FLEET), "slowrover"]


# ---- afterwards ----


async def test_it_is_there_after_a_restart_and_its_numbers_go_on() -> None:
    store = MemoryStore()
    async with Place(store).open() as place:
        await add(place)
        await place.say("rover wiggle")
        await place.say("stop rover")
        n = place.robot("rover").gate.n
        latch = place.latch
    async with Place(store, latch).open() as place:
        assert place.robot("rover").gate.n == n
        assert place.gateway.rooms.stops["rover"].latched
        await place.say("resume rover")
        assert "done" in await place.say("rover wiggle")
        assert place.robot("rover").gate.n > n
        assert (await refused(add(place))).startswith("A robot is called rover here already.")


async def test_one_that_was_here_before_goes_on_where_it_was() -> None:
    store = MemoryStore()
    async with Place(store, fleet=(*FLEET, profile("rover"))).open() as place:
        await place.say("rover wave")
        await place.say("stop rover")
        latch, gate = place.latch, place.robot("rover").gate
    async with Place(store, latch).open() as place:
        said = await add(place)
        assert "It was stopped when ROSIC last knew it, and stays stopped." in said
        found = place.robot("rover").gate
        assert (found.n, found.fence, found.generation) == (gate.n, gate.fence, gate.generation)
        assert found.latched
        assert place.gateway.rooms.organiser.lease("rover").fence == gate.fence > 0
        await place.say("resume rover")
        assert "done" in await place.say("rover wiggle")
        assert place.robot("rover").gate.n > gate.n


class DiesAfter(MemoryStore):
    """The process dies as soon as a robot is on disk: nothing else happens in it."""

    async def write(self, *records: Record) -> None:
        await super().write(*records)
        if any(isinstance(record, Fact) and record.kind == "robot" for record in records):
            raise asyncio.CancelledError


async def test_a_crash_between_record_and_effect_is_a_robot_at_the_next_start() -> None:
    store = DiesAfter()
    async with Lab(store).open() as place:
        with pytest.raises(asyncio.CancelledError):
            await add(place)
        assert "rover" not in place.gateway.robots
        assert Reluctant.closed == ["rover"]
    async with Place(store).open() as place:
        assert "done" in await place.say("rover wiggle")


async def test_closing_while_one_is_added_closes_it() -> None:
    place = Lab()
    async with place.open():
        adding = asyncio.create_task(add(place, draft(rover="slowrover")))
        await Reluctant.opening.wait()
    assert Reluctant.closed.count("slowrover") == 1
    with pytest.raises(asyncio.CancelledError):
        await adding
    assert "closing" in await refused(add(place))


@pytest.mark.parametrize("body", [b"", b"\xc1", b"\x80"])
async def test_what_cannot_be_read_of_one_keeps_nobody_from_starting(body: bytes) -> None:
    store = MemoryStore()
    async with Place(store).open() as place:
        await add(place)
        await store.write(Fact(kind="robot", key="rover", body=body))
    async with Place(store).open() as place:
        assert "rover" not in place.gateway.robots
        assert "done" in await place.say("omni wave")


async def test_the_configuration_decides_about_what_it_names() -> None:
    store = MemoryStore()
    async with Place(store).open() as place:
        await add(place)
    async with Place(store, fleet=(*FLEET, profile("rover"))).open() as place:
        assert "done" in await place.say("rover wave")
    async with Place(store, fleet=(*FLEET, profile("buggy"))).open() as place:
        assert list(place.gateway.robots) == [*(p.id for p in FLEET), "buggy"]


async def test_strangers_stops_and_readers_see_no_more_than_before() -> None:
    async with Place().open() as place:
        await add(place)
        await place.say("stop", account=STRANGER)
        assert not place.gateway.rooms.stops["rover"].latched
        await place.say("rover wiggle", account=VI)
        assert place.acted("rover") == 0
