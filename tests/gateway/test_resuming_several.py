"""Several go on one after another: who hears that one does not hears, too, which do."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

import pytest

from rosic.app.admin.api import ALL
from rosic.app.admin.dispatch import AdminDispatcher
from rosic.core.records import Decided, Resumed
from rosic.core.signal import Deferred
from rosic.errors import Fault, Refusal, RobotStopped, RobotUnreachable, StillMoves, StoreFault
from rosic.robots.memory import MemoryRobot
from tests.gateway.place import BrokenStore, Place, SlowStore

if TYPE_CHECKING:
    from collections.abc import Collection

    from rosic.core.records import Record


class Deaf(MemoryRobot):
    """One of them does not answer a resume."""

    why: Fault = RobotUnreachable("it did not answer.")

    async def resume(self, generation: int) -> None:
        if self.profile.id == "cf2":
            raise self.why
        await super().resume(generation)


class DeafPlace(Place):
    kind = Deaf


class BreaksAfterOne(BrokenStore):
    """Its disk is full once a task was let go on."""

    async def write(self, *records: Record) -> None:
        await super().write(*records)
        if any(isinstance(r, Decided) and r.act == "task-go" for r in records):
            self.broken = True


def _latched(place: Place) -> set[str]:
    return {robot for robot, stopped in place.gateway.rooms.stops.items() if stopped.latched}


def _begun_by(place: Place) -> list[Collection[str]]:
    """Return of which robots it is asked, from now on, what they begin by themselves."""
    asked: list[Collection[str]] = []

    def begins(robots: Collection[str]) -> str:
        asked.append(tuple(robots))
        return "cf1 begins task 7."

    place.gateway.pipeline.resuming.begins = Deferred(begins)
    return asked


async def test_which_were_resumed_before_one_was_not_is_said() -> None:
    async with DeafPlace().open() as place:
        await place.say("stop cf1 cf2 omni")
        asked = _begun_by(place)
        told = await place.say("resume cf1 cf2 omni")
        assert told == (
            "cf1 is ready again.\ncf1 begins task 7.\ncf2 stays stopped: it did not answer.\n"
            "Still stopped: omni."
        )
        assert asked == [("cf1",)], "only what was resumed begins anything"
        assert _latched(place) == {"cf2", "omni"}


@pytest.mark.parametrize(
    ("why", "code"),
    [
        (RobotUnreachable("it did not answer."), "robot-offline"),
        (StillMoves("it still moves."), "still-moves"),
        (StoreFault("the disk is full."), "record-unavailable"),
    ],
)
async def test_what_kept_it_stopped_is_told_by_its_code(
    why: Fault, code: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(Deaf, "why", why)
    async with DeafPlace().open() as place:
        await place.say("stop cf2")
        assert (await place.say("resume cf2")).startswith("cf2 stays stopped: ")
        assert place.chat.told[-1].outbound.code == code


async def test_where_none_was_resumed_it_says_why_and_which_are_left() -> None:
    async with DeafPlace().open() as place:
        await place.say("stop cf2 omni")
        asked = _begun_by(place)
        told = await place.say("resume cf2 omni")
        assert told == "cf2 stays stopped: it did not answer.\nStill stopped: omni."
        assert asked == []


async def test_the_operator_hears_it_as_well() -> None:
    async with DeafPlace().open() as place:
        await place.say("stop cf1 cf2 omni")
        asked = _begun_by(place)
        with pytest.raises(Refusal) as why:
            await AdminDispatcher(place.gateway).resume(("cf1", "cf2", "omni"))
        assert (
            str(why.value)
            == why.value.sentence
            == (
                "cf1 is ready again.\ncf1 begins task 7.\ncf2 stays stopped: it did not answer.\n"
                "Still stopped: omni."
            )
        )
        assert asked == [("cf1",)]


async def test_a_stop_that_comes_meanwhile_is_not_undone_by_the_operators_resume() -> None:
    store = SlowStore(Resumed)
    async with Place(store).open() as place:
        await place.say("stop cf1 cf2")
        resuming = asyncio.create_task(AdminDispatcher(place.gateway).resume((ALL,)))
        await place.quiet()
        place.chat.say("stop cf2")
        await place.quiet()
        store.ready.set()
        await place.quiet()
        with pytest.raises(RobotStopped, match=r"^cf1 is ready again\.\ncf2 was stopped again"):
            await resuming
        assert _latched(place) == {"cf2"}


async def test_which_tasks_went_on_before_one_could_not_is_said() -> None:
    store = BreaksAfterOne()
    async with Place(store).open() as place:
        for robot in ("cf1", "cf2"):
            place.robot(robot).work_s = 10_000.0
            await place.say(f"/task {robot} move 1 m")
        await place.clock.advance(1.0)
        assert "2 tasks are paused" in await place.say("pause")
        told = await place.say("continue")
        assert told.startswith("Task 1 goes on.\nI cannot write"), told
