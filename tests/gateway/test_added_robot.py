"""A robot that is added while the gateway runs: every room knows it at once."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

from rosic.testing.clock import settle
from tests.gateway.place import BO, Place
from tests.gateway.rover import CAN, HoldingStore, Lab, Reluctant, add, draft
from tests.pace import pace

if TYPE_CHECKING:
    from rosic.gateway.robot_registry import AddedRobot

# ---- it is there ----


async def test_every_room_knows_a_robot_from_the_moment_it_was_added() -> None:
    async with Place().open() as place:
        assert "no robot" in await place.say("/robot rover")
        assert await add(place) == f"Rover 3 is here now, as rover.\n{CAN}"
        assert "done" in await place.say("rover wiggle 2")
        assert place.acted("rover") == 1
        await place.clock.advance(31.0)
        assert "done" in await place.say("buggy wiggle", account=BO)  # by wildcard
        assert "wiggle" in await place.say("help rover")
        assert "Rover 3" in await place.say("status")
        assert await place.say("/robot rover") == CAN
        await place.say("use rover")
        await place.clock.advance(31.0)
        assert "done" in await place.say("wiggle")


async def test_who_subscribes_is_told_when_every_room_knows() -> None:
    async with Place().open() as place:
        rooms, told = place.gateway.rooms, list[str]()

        def hear(newcomer: AddedRobot) -> None:
            robot = newcomer.profile.id
            assert rooms.linker.presence(robot) == newcomer.robot.presence()
            assert robot in rooms.profiles
            assert robot in rooms.organiser.leases
            assert rooms.vocabulary.robot(robot) is newcomer.profile
            assert not rooms.stops[robot].latched
            told.append(robot)

        place.gateway.registry.added.connect(hear)
        await add(place)
        assert told == ["rover"]


async def test_a_line_that_made_no_sense_before_makes_sense_now() -> None:
    async with Place().open() as place:
        for _ in range(2):  # and what was read of it is remembered
            assert "done" not in await place.say("rover wiggle")
        await add(place)
        assert "done" in await place.say("rover wiggle")


async def test_groups_tasks_cards_and_times_have_it() -> None:
    async with Place().open() as place:
        await place.say("/card")
        await add(place)
        await place.clock.advance(3.0)
        await place.quiet()
        shown = [place.chat.shown(told.message).text for told in place.chat.told]
        assert any("Rover 3" in text and "omni" in text for text in shown)
        assert "Rover 3" in await place.say("/fleet")
        assert "Task" in await place.say("/task any wiggle")
        await place.clock.advance(3.0)
        await place.quiet()
        assert place.acted("rover") == 1
        assert "Rover 3" in await place.say("/book rover tomorrow 14:00 1h")
        assert "Rover 3" in await place.say("stop swarm")


async def test_its_alarms_are_followed_though_nobody_had_any() -> None:
    async with Place().open() as place:
        await add(place)
        place.robot("rover").values["battery"] = 10.0
        for _ in range(8):
            await place.clock.advance(0.5)
        await place.quiet()
        assert any("battery" in told.outbound.text for told in place.chat.told)


async def test_what_runs_goes_on_and_what_waits_is_done() -> None:
    async with Place().open() as place:
        kuka1 = place.robot("kuka1")
        kuka1.work_s = 1e6
        await place.say("kuka1 wave")
        assert "waiting" in await place.say("kuka1 move 1 m")
        await add(place)
        kuka1.finish()
        await place.quiet()
        assert place.acted("kuka1") == 2  # under rights that were drawn up anew meanwhile
        kuka1.finish()
        await place.quiet()
        shown = [place.chat.shown(told.message).text for told in place.chat.told]
        assert sum("done" in text for text in dict.fromkeys(shown)) == 2


async def test_the_decision_is_on_record_with_the_profile_before_its_effect() -> None:
    store = HoldingStore()
    async with Place(store).open() as place:
        adding = asyncio.create_task(add(place))
        await asyncio.wait_for(store.reached.wait(), 60 * pace())
        await settle()
        assert "rover" not in place.gateway.robots
        assert "rover" not in place.gateway.rooms.profiles
        store.ready.set()
        await adding
        assert "rover" in place.gateway.robots
    memory = await store.open()
    (fact,) = memory.facts["robot"]
    assert fact.key == "rover"


# ---- stops ----


async def test_a_stop_of_everything_has_it_at_once() -> None:
    async with Place().open() as place:
        await add(place)
        assert "Rover 3" in await place.say("stop", account=BO)
        assert place.gateway.rooms.stops["rover"].latched
        assert "stopped" in await place.say("rover wiggle")
        await place.say("resume rover")
        assert "done" in await place.say("rover wiggle")


async def test_a_stop_while_it_is_being_added_means_it_too() -> None:
    async with Lab().open() as place:
        adding = asyncio.create_task(add(place, draft(rover="slowrover")))
        await Reluctant.opening.wait()
        await place.say("stop", account=BO)
        before = len(Reluctant.stops)
        Reluctant.goes_on.set()
        said = await adding
        await place.quiet()
        assert "A stop came while it was being added, so it is stopped." in said
        assert place.gateway.rooms.stops["slowrover"].latched
        assert len(Reluctant.stops) == before + 1
        assert "stopped" in await place.say("slowrover wiggle")
        assert place.acted("slowrover") == 0


async def test_a_stop_while_it_is_written_down_means_it_too() -> None:
    store = HoldingStore()
    async with Place(store).open() as place:
        adding = asyncio.create_task(add(place))
        await asyncio.wait_for(store.reached.wait(), 60 * pace())
        await place.say("stop")
        store.ready.set()
        assert "so it is stopped" in await adding
        assert place.gateway.rooms.stops["rover"].latched
