"""Missions with numbers that are said at the start, and with times by which they are to be done."""

from __future__ import annotations

from typing import TYPE_CHECKING

from msgspec.structs import replace

from rosic.core.fleet.mission import Late, Mission, MissionPart
from rosic.core.fleet.task import TaskState
from rosic.core.fleet.template import Quantity
from rosic.core.order import OrderEnding
from rosic.features.fleet import FleetFeature
from rosic.stores.memory import MemoryStore
from tests.features.fleet.test_tasks import heard, tasks, warehouse, worker
from tests.gateway.place import VI

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rosic.core.robot.skill import Argument
    from tests.gateway.place import Place

FETCH = Mission(
    name="fetch",
    parameters={
        "distance": Quantity(unit="m", min=0.1, max=5.0),
        "back": Quantity(unit="cm", min=10.0, max=200.0, default=50.0),
    },
    do=(
        MissionPart(on="w1", steps=("move $distance",)),
        MissionPart(mission="home", values={"way": "$back"}),
    ),
)
HOME = Mission(
    name="home",
    parameters={"way": Quantity(unit="m", min=0.1, max=5.0, default=1.0)},
    do=(MissionPart(on="w1", steps=("move $way back",)),),
)
TIMED = Mission(
    name="timed",
    deadline="10 min",
    late=Late.CANCEL,
    do=(MissionPart(on="w1", steps=("wave",)), MissionPart(on="w2", steps=("wave",))),
)
BOTH = Mission(
    name="both",
    deadline="10 min",
    do=(
        MissionPart(
            together=(MissionPart(on="w1", steps=("wave",)), MissionPart(on="w2", steps=("wave",)))
        ),
    ),
)
SLOW = Mission(
    name="slow",
    do=(
        MissionPart(on="w1", steps=("wave",)),
        MissionPart(on="w2", steps=("wave",), deadline="2 min"),
        MissionPart(on="w3", steps=("wave",), deadline="2 min", late=Late.CANCEL),
        MissionPart(on="w1", steps=("wave",)),
    ),
)


def lab(store: MemoryStore | None = None) -> Place:
    here = warehouse(store)
    here.gateway._settings = replace(
        here.gateway._settings, missions=(FETCH, HOME, TIMED, BOTH, SLOW)
    )
    return here


def states(here: Place) -> list[TaskState]:
    return [task.state for task in tasks(here).values()]


def asked(here: Place) -> Mapping[str, Argument]:
    """Return what w1 is asked to do now."""
    order = here.gateway.rooms.linker.current("w1")
    assert order is not None
    return order.arguments


async def test_what_is_said_at_the_start_takes_its_place_in_every_step() -> None:
    async with lab().open() as here:
        told = await here.say("/mission fetch distance=250 cm")
        assert "fetch is begun as fetch-1 · 2 tasks" in told
        assert asked(here)["distance"] == 2.5
        worker(here, "w1").end(OrderEnding.DONE)
        await heard(here)
        assert (asked(here)["direction"], asked(here)["distance"]) == ("back", 0.5)
        shown = await here.say("/mission fetch")
        assert "distance: 0.1 m to 5 m" in shown
        assert "back: 10 cm to 200 cm, 50 cm if nothing is said" in shown
        assert "1. w1: move $distance" in shown


async def test_a_value_that_is_missing_wrong_or_unknown_begins_nothing() -> None:
    async with lab().open() as here:
        for said, sentence in (
            ("fetch distance=6 m", "distance goes from 0.1 m to 5 m. Nothing was done."),
            ("fetch distance=nan m", "Say distance, for example distance=0.1 m."),
            ("fetch distance=2 s", "Say distance, for example distance=0.1 m."),
            ("start fetch", "Say distance, for example distance=0.1 m."),
            ("fetch distance=1 m distance=2 m", "distance is said twice."),
            ("fetch distance=1 m width=2 m", "There is no width to be said."),
            ("start home way=1,500 m", "Say way, for example way=1 m."),
        ):
            assert sentence in await here.say(f"/mission {said}")
        assert not tasks(here)


async def test_what_is_said_is_kept_for_a_mission_that_begins_later_over_a_restart() -> None:
    store = MemoryStore()
    async with lab(store).open() as here:
        told = await here.say("/mission start fetch distance 2 in 5 min")
        assert "1: fetch begins by itself, " in told
    async with lab(store).open() as here:
        await heard(here, 310)
        assert asked(here)["distance"] == 2.0


async def test_a_mission_that_is_late_is_said_once_and_the_rest_is_cancelled() -> None:
    store = MemoryStore()
    first = lab(store)
    async with first.open() as here:
        await here.say("/mission start timed")
        worker(here, "w1").end(OrderEnding.DONE)
        assert "is late" not in await heard(here, 590)
        assert states(here) == [TaskState.DONE, TaskState.RUNNING]
        told = await heard(here, 20)
        assert told.count("timed-1 is late: it was to be done by ") == 1
        assert "1 of 2 tasks are done. The rest of it is cancelled" in told
        assert states(here) == [TaskState.DONE, TaskState.CANCELLED]
        assert here.robot("w2").presence().doing == ""
        assert "is late" not in await heard(here, 60)


async def test_what_is_late_as_a_whole_is_said_once_and_goes_on_if_nothing_else_is_written() -> (
    None
):
    async with lab().open() as here:
        await here.say("/mission start both")
        told = await heard(here, 660)
        assert told.count("both-1 is late") == 1
        assert "0 of 2 tasks are done. It goes on." in told
        assert states(here) == [TaskState.RUNNING] * 2


async def test_a_deadline_goes_on_over_a_restart_also_while_nothing_runs() -> None:
    store = MemoryStore()
    first = lab(store)
    async with first.open() as here:
        await here.say("/mission start timed")
        await here.say("/mission pause timed")
        await heard(here, 5)
        assert states(here) == [TaskState.PAUSED] * 2
    second = lab(store)
    second.clock.jump_wall((first.clock.wall_ns() - second.clock.wall_ns()) / 1e9 + 590)
    async with second.open() as here:
        assert "timed-1 is late" in await heard(here, 30)
        assert states(here) == [TaskState.CANCELLED] * 2
    third = lab(store)
    third.clock.jump_wall((second.clock.wall_ns() - third.clock.wall_ns()) / 1e9 + 60)
    async with third.open() as here:
        assert "is late" not in await heard(here, 30), "said before"


async def test_a_part_is_late_from_when_it_could_begin_and_what_is_written_happens() -> None:
    async with lab().open() as here:
        await here.say("/mission start slow")
        assert "is late" not in await heard(here, 300), "it has no deadline, and no other began"
        worker(here, "w1").end(OrderEnding.DONE)
        assert "is late" not in await heard(here, 110)
        told = await heard(here, 20)
        assert told.count("Task 2 (wave) is late: it was to be done within 2 min. It goes on.") == 1
        assert states(here)[1] is TaskState.RUNNING
        worker(here, "w2").end(OrderEnding.DONE)
        assert "is late" not in await heard(here, 110)
        told = await heard(here, 20)
        assert "Task 3 (wave) is late: it was to be done within 2 min. The rest" in told
        assert states(here) == [
            TaskState.DONE,
            TaskState.DONE,
            TaskState.CANCELLED,
            TaskState.CANCELLED,
        ]
        assert here.acted("w1") == 1, "nothing begins because what was before it is cancelled"


async def test_a_time_within_this_minute_is_the_next_one_and_not_over() -> None:
    async with lab().open() as here:
        for said in ("in 5 s", "now"):
            told = await here.say(f"/mission start timed {said}")
            assert "timed begins by itself, 22:14" in told
        assert not tasks(here)
        await heard(here, 70)
        assert len(tasks(here)) == 4, "each of them, once"


async def test_two_times_at_the_same_moment_are_two() -> None:
    async with lab().open() as here:
        for metres in (1, 2):
            await here.say(f"/mission start fetch distance={metres} in 2 min")
        told = await heard(here, 200)
        assert told.count("fetch is begun") == 2
        assert len(tasks(here)) == 4


async def test_what_is_to_begin_later_is_planned_though_it_could_not_begin_now() -> None:
    """What would hinder it now is a remark: until then a right may be given, a robot be back."""
    async with lab().open() as here:
        told = await here.say("/mission start timed every mon 8:00")
        assert "begins by itself, next" in told
        assert "Now it could not" not in told
        told = await here.say("/mission start timed every mon 8:00", account=VI, chat=VI)
        assert told.startswith("2: timed begins by itself, next")
        assert "\nNow it could not begin: " in told
        assert told.endswith(" At its time that is asked again.")
        assert len(here.gateway.features.get(FleetFeature)._timetable.plans) == 2
        refused = await here.say("/mission start timed", account=VI, chat=VI)
        assert refused in told, "said as the start itself would say it"
