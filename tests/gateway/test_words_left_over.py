"""Nothing is done by a line of which a word was not understood, and nobody is let go on by one."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from rosic.core.message import ChatKind
from rosic.core.records import Decided, Fact
from rosic.stores.memory import MemoryStore
from tests.gateway.place import Place

if TYPE_CHECKING:
    from collections.abc import Callable

    from rosic.core.records import Record

ALL = {"omni", "kuka1", "cf1", "cf2"}


def _latched(place: Place) -> set[str]:
    return {robot for robot, stopped in place.gateway.rooms.stops.items() if stopped.latched}


@pytest.mark.parametrize(
    ("text", "stay"),
    [
        ("resume all but omni", {"omni"}),
        ("/resume all except omni and kuka1", {"omni", "kuka1"}),
        ("resume everything but the swarm", {"cf1", "cf2"}),
        ("freigeben alle außer omni", {"omni"}),
        ("alle außer omni und kuka1 freigeben", ALL),
        ("resume all swarm", {"omni", "kuka1"}),
        ("resume swarm without cf1", {"omni", "kuka1", "cf1"}),
        ("/resume all foo bar", ALL),
        ("resume everything but the drones", ALL),
        ("resume all later", ALL),
        ("omni resume in 5 minutes", ALL),
        ("continue all but omni", ALL),
        ("weiter alle außer omni", ALL),
        ("resume all", set()),
    ],
)
async def test_whom_a_resume_does_not_mean_stays_stopped(text: str, stay: set[str]) -> None:
    async with Place().open() as place:
        await place.say("stop")
        assert _latched(place) == ALL
        told = await place.say(text)
        assert _latched(place) == stay, told
        assert told
        if stay and stay != ALL and " but" in text:
            shown = ", ".join(robot for robot in place.gateway.robots if robot in stay)
            assert told.endswith(f"\nStill stopped: {shown}.")


async def test_all_but_one_is_nobody_named_in_a_group() -> None:
    async with Place().open() as place:
        await place.say("stop")
        told = await place.say("resume all but omni", kind=ChatKind.GROUP)
        assert _latched(place) == ALL, told


@pytest.mark.parametrize(
    "text", ["stop all but omni", "halt alles außer omni", "stop swarm except cf1"]
)
async def test_a_stop_of_all_but_one_stops_all_and_says_so(text: str) -> None:
    async with Place().open() as place:
        told = await place.say(text)
        assert _latched(place) == ALL
        assert "A stop leaves nobody out: all of them were stopped." in told


@pytest.mark.parametrize("text", ["stop", "stop omni", "stop all", "stop omni and cf1, not later"])
async def test_another_stop_says_nothing_of_the_kind(text: str) -> None:
    async with Place().open() as place:
        assert "leaves nobody out" not in await place.say(text)


async def test_a_cancel_of_all_but_one_ends_all_and_says_so() -> None:
    async with Place().open() as place:
        for robot in ("omni", "kuka1"):
            place.robot(robot).work_s = 10_000.0
            await place.say(f"{robot} move 1 m")
        told = await place.say("cancel all but omni")
        assert "That left nothing out: all of yours was ended." in told
        assert all(place.gateway.rooms.linker.current(robot) is None for robot in ALL)


class Watched(MemoryStore):
    """Knows which kinds of records were written."""

    def __init__(self) -> None:
        super().__init__()
        self.kinds: set[str] = set()

    async def write(self, *records: Record) -> None:
        self.kinds |= {_kind(record) for record in records}
        await super().write(*records)

    def keep(self, record: Record, then: Callable[[], None]) -> None:
        self.kinds.add(_kind(record))
        super().keep(record, then)

    def note(self, *records: Record) -> None:
        self.kinds |= {_kind(record) for record in records}
        super().note(*records)


def _kind(record: Record) -> str:
    """Return what a record is about; of facts and decisions, which."""
    about = {Fact: "kind", Decided: "act"}.get(type(record), "")
    return getattr(record, about) if about else type(record).__name__


LEFT_OVER = ("foo", "but omni", "außer kuka1", "in 5 minutes", "later foo")
BEHIND = (
    "take over omni",
    "/take omni",
    "/end omni",
    "/lock Bo",
    "/revoke Bo",
    "/grant Bo admin",
    "/language de",
    "/settings units imperial",
    "/quiet omni off",
    "/mute omni",
    "/pause all",
    "/continue all",
    "/book omni now 1h",
    "/archive on",
    "/forget me",
    "/robot remove cf2",
    "/task omni move 1 m",
    "/broadcast swarm wave",
    "/together swarm wave",
    "omni move 1 m",
    "omni wave",
    "use cf1",
)


@pytest.mark.parametrize("head", BEHIND)
async def test_a_word_that_is_not_understood_keeps_the_rest_from_being_done(head: str) -> None:
    store = Watched()
    async with Place(store).open() as place:
        for rest in LEFT_OVER:
            store.kinds.clear()
            told = await place.say(f"{head} {rest}")
            assert told
            assert store.kinds <= {"Refused", "Told", "rate"}, told
            assert not any(place.acted(robot) for robot in ALL), told


async def test_take_over_reads_the_whole_name() -> None:
    async with Place().open() as place:
        assert (
            await place.say("take over omni but later") == "I know no robot called omni but later."
        )
        assert "omni is free" in await place.say("take over omni")
