"""What is offered when something is missing in a task is a task, and would be accepted."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from rosic.core.policy.roles import DEFAULT_ROLES, RoleRules, SkillPrecondition
from rosic.core.rate_limit import RateLimit
from rosic.core.robot.profile import Link, Profile
from rosic.core.robot.skill import Parameter, Skill
from tests.features.fleet.test_tasks import Warehouse, heard, tasks
from tests.gateway.place import VI

if TYPE_CHECKING:
    from collections.abc import Iterable

    from rosic.core.message import Button

GOTO = Skill(
    id="goto",
    title="Go to a place",
    parameters={"place": Parameter(choices={"dock": (), "gate": (), "far_end": ()})},
)
DRIVE = Skill(
    id="drive",
    title="Drive to a point",
    parameters={name: Parameter(unit="m", min=-10, max=10) for name in ("x", "y")},
)
CREEP = Skill(id="creep", title="Creep", parameters={"length": Parameter(unit="m", min=0.1, max=5)})
TELL = Skill(id="tell", title="Tell", parameters={"text": Parameter(text=True)})
WAVE = Skill(id="wave", title="Wave")


def carrier(name: str) -> Profile:
    return Profile(
        id=name,
        link=Link(kind="memory"),
        groups=("carriers",),
        skills={skill.id: skill for skill in (GOTO, DRIVE, CREEP, TELL, WAVE)},
    )


LONG = " then ".join(["goto far end"] * 10)
CARRIERS = (carrier("carrier1"), carrier("carrier2"))
ARM = Profile(id="arm", link=Link(kind="memory"), skills={"wave": WAVE})


def place() -> Warehouse:
    return Warehouse(fleet=(*CARRIERS, ARM))


def commands(here: Warehouse) -> list[str]:
    """Return what the buttons say that were shown last."""
    return [button.command for button in _all(here.last()[1].buttons)]


def _all(rows: Iterable[Iterable[Button]]) -> list[Button]:
    return [button for row in rows for button in row]


async def test_where_to_is_asked_for_the_task_and_a_tap_gives_it() -> None:
    async with place().open() as here:
        told = await here.say("/task carrier2 goto priority 3 battery 20")
        assert told == "carrier2: goto needs a place: dock, gate or far_end."
        assert commands(here) == [
            f"/task carrier2 goto {where} priority 3 battery 20"
            for where in ("dock", "gate", "far end")
        ]
        button, under = here.button("/task carrier2 goto dock priority 3 battery 20")
        told = await here.tap(button, under)
        assert "Task 1: goto dock · carrier2 · priority 3 · battery at least 20 %" in told
        [task] = tasks(here).values()
        assert task.among == ("carrier2",)


@pytest.mark.parametrize(
    ("said", "offered"),
    [
        ("/task carrier2 wave then goto", "/task carrier2 wave then goto dock"),
        ("/task carriers goto", "/task carriers goto dock"),
        ("/task any goto", "/task any goto dock"),
        ("/task carrier2 goto dokc", "/task carrier2 goto dock"),
        ("/task carrier2 gotto dock", "/task carrier2 goto dock"),
        ("/task carrier2 creep 9 m once", "/task carrier2 creep 5 m once"),
        ("/task carrier2 creep", "/task carrier2 creep 1 m"),
        ("/together carriers goto", "/together carriers goto dock"),
        ("/together carrier1+carrier2 creep 9 m", "/together carrier1+carrier2 creep 5 m"),
    ],
)
async def test_nothing_that_is_offered_is_a_direct_order(said: str, offered: str) -> None:
    async with place().open() as here:
        await here.say(said)
        found = commands(here)
        assert offered in found
        assert all(command.startswith(said.split(maxsplit=1)[0]) for command in found)
        for command in found:  # and each of them is taken
            told = await here.say(command)
            assert "needs" not in told
            assert "cannot" not in told
        assert len(tasks(here)) == len(found) * said.startswith("/task")
        await heard(here)


@pytest.mark.parametrize(
    ("said", "example"),
    [
        ("/task carrier2 drive by 23:00", "/task carrier2 drive x=1 m y=1 m by 23:00"),
        ("/task carriers drive", "/task carriers drive x=1 m y=1 m"),
        ("/task carrier2 tell", "/task carrier2 tell ..."),
        ("/task carrier2 goto then goto", "/task carrier2 goto dock then goto dock"),
        (f"/task carrier2 {LONG} then goto", f"/task carrier2 {LONG} then goto dock"),
    ],
)
async def test_where_values_are_free_an_example_of_the_whole_line_is_said(
    said: str, example: str
) -> None:
    async with place().open() as here:
        told = await here.say(said)
        assert told.endswith(f" For example: {example}")
        assert not commands(here), "one tap would not be enough, or a robot goes anywhere"
        assert "Task 1" in await here.say(example)


async def test_whoever_may_not_is_asked_for_no_value() -> None:
    async with place().open() as here:
        told = await here.say("/task carrier2 goto", account=VI, chat=VI)
        assert told == "You may not let carrier2 do this: Go to a place."
        assert not commands(here)


async def test_what_wants_a_tap_is_asked_for_no_value_either() -> None:
    class Careful(Warehouse):
        rulebook = RoleRules(
            roles=DEFAULT_ROLES, care=(SkillPrecondition(scopes=("*:goto",), confirm=True),)
        )

    async with Careful(fleet=CARRIERS).open() as here:
        assert "only when somebody confirms it" in await here.say("/task carrier2 goto")
        assert not commands(here)


async def test_a_way_to_stop_stays_offered() -> None:
    async with place().open() as here:
        assert "in a line of its own" in await here.say("/task carrier2 goto dock stop")
        assert commands(here) == ["stop carrier2", "stop"]


async def test_steps_times_robots_are_bounded_and_what_they_cost_is_the_persons_own() -> None:
    fleet = tuple(carrier(f"carrier{n}") for n in range(60))
    async with Warehouse(fleet=fleet, limit=RateLimit(burst=20.0, per_s=0.01)).open() as here:
        for steps, told in (
            (34, "That is 34 different steps for 60 robots; steps times robots are at most 2000"),
            (33, "one of 60 robots"),  # costs nine lines more
            (33, "That is more than one person may ask."),
        ):
            said = " then ".join(f"creep length=1.{n:02} m" for n in range(steps))
            at_once = await here.say(f"/task carriers {said}")
            assert told in at_once + await heard(here)
        assert "carrier1" in await here.say("status carrier1")
