"""An order for a robot at work is answered once, and may follow by a tap; landing needs none."""

from __future__ import annotations

from typing import TYPE_CHECKING

from msgspec.structs import replace

from rosic.core.records import Claimed
from rosic.core.robot.skill import Skill
from rosic.stores.memory import MemoryStore
from tests.gateway.place import BO, VI, Place, line_by_line, profile

if TYPE_CHECKING:
    from rosic.core.records import Record

LAND = Skill(id="land", to_safety=True)
OWN = "omni is busy: move, as you asked. This was not done."


class Counting(MemoryStore):
    claims = 0

    async def write(self, *records: Record) -> None:
        self.claims += sum(isinstance(record, Claimed) for record in records)
        await super().write(*records)


async def _at_work(place: Place) -> None:
    place.robot("omni").work_s = 10_000.0
    await place.say("omni move 1 m")


def _labels(place: Place) -> list[str]:
    return [button.label for row in place.last()[1].buttons for button in row]


async def test_it_is_said_once_and_nothing_is_claimed() -> None:
    store = Counting()
    async with Place(store, chat=line_by_line).open() as place:
        await _at_work(place)
        assert await place.say("omni move 2 m") == OWN
        assert store.claims == 1


async def test_after_this_waits_for_its_turn_once() -> None:
    async with Place().open() as place:
        await _at_work(place)
        await place.say("use omni")
        assert await place.say("move 2 m") == OWN
        assert _labels(place) == ["After this", "Stop, then this"]
        after, under = place.button("After this")
        await place.say("use kuka1")
        await place.tap(after, under)
        assert (place.acted(), place.gateway.rooms.linker.waiting("omni")) == (1, 1)
        await place.tap(after, under)
        place.robot("omni").work_s = 0.0
        place.robot("omni").finish()
        await place.quiet()
        assert place.acted() == 2


async def test_after_this_does_not_outlive_its_order() -> None:
    async with Place().open() as place:
        await _at_work(place)
        await place.say("omni move 2 m")
        await place.tap(*place.button("After this"))
        await place.clock.advance(6.0)
        await place.quiet()
        assert "omni was busy for too long. This was not done." in place.last()[1].text
        place.robot("omni").finish()
        await place.quiet()
        assert place.acted() == 1


async def test_stop_then_this_ends_ones_own_and_latches_nothing() -> None:
    async with Place().open() as place:
        await _at_work(place)
        await place.say("omni move 2 m")
        await place.tap(*place.button("After this"))
        await place.say("omni move 3 m")
        place.robot("omni").work_s = 0.0
        await place.tap(*place.button("Stop, then this"))
        await place.quiet()
        assert place.acted() == 2, "what waited is not done, and this is"
        assert not place.robot("omni").gate.latched
        told = "\n".join(told.outbound.text for told in place.chat.told)
        assert "the next command takes its place" in told
        assert "The next command takes its place. This was not done." in told


async def test_stop_then_this_ends_nothing_when_the_rules_have_changed_since() -> None:
    async with Place().open() as place:
        place.robot("omni").work_s = 10_000.0
        await place.say("omni move 1 m", account=BO, chat=BO)
        await place.say("omni move 2 m", account=BO, chat=BO)
        button = place.button("Stop, then this")
        await place.say("/grant Vi operator cf1 for 1h")
        told = await place.tap(*button, account=BO)
        assert "Nothing was done" in told
        assert place.gateway.rooms.linker.current("omni") is not None, "what runs goes on"


async def test_of_somebody_elses_it_says_whose_and_ends_nothing() -> None:
    async with Place().open() as place:
        await _at_work(place)
        told = await place.say("omni look", account=VI, chat="3")
        assert told.startswith("Look needs the right") or "omni is busy: move, for Ada." in told
        told = await place.say("omni look", account=BO, chat="2")
        assert told == "omni is busy: move, for Ada. This was not done."
        assert _labels(place) == ["After this"]


async def test_a_drone_may_always_land() -> None:
    drone = profile("omni")
    drone = replace(drone, skills={**drone.skills, "land": LAND})
    async with Place(fleet=(drone,)).open() as place:
        await _at_work(place)
        await place.say("omni move 2 m")
        await place.tap(*place.button("After this"))
        place.robot("omni").work_s = 0.0
        told = await place.say("omni land")
        await place.quiet()
        assert "is busy" not in told
        assert place.acted() == 2
        told = "\n".join(told.outbound.text for told in place.chat.told)
        assert "a later command took its place" in told
        assert "A later command took its place. This was not done." in told
