"""Help about a robot shows what its reader may let it do, and how far."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest
from msgspec.structs import replace

from rosic.core.identity import Address
from rosic.core.message import Chat
from rosic.core.policy.roles import DEFAULT_ROLES, Role, RoleRules
from tests.gateway.loop_steps import none_is_long, run
from tests.gateway.place import BO, VI, Place, profile
from tests.gateway.received import ADA as ADA_ID

if TYPE_CHECKING:
    from rosic.core.robot.profile import Profile
    from tests.gateway.received import Receiving

MAY = "omni can:\n  move: direction (forward, back, left), distance 0.01 to 0.3 m\n  look"


class School(Place):
    """Bo may only move, and not far."""

    rulebook = RoleRules(
        roles={
            **DEFAULT_ROLES,
            "student": Role(scopes=("*:read", "*:move"), limits=("distance <= 30 cm",)),
        }
    )
    people = tuple(
        replace(person, roles=("student",)) if person.name == "Bo" else person
        for person in Place.people
    )


async def test_bounds_are_those_of_whoever_asks() -> None:
    async with School().open() as place:
        assert "wave" in await place.say("help omni")
        assert "distance 0.01 to 5 m" in await place.say("help omni")
        told = await place.say("help omni", account=BO, chat="2")
        assert told == MAY


@pytest.mark.parametrize("asked", ["help swarm", "omni", "help"])
async def test_no_skill_and_no_example_beyond_their_rights(asked: str) -> None:
    async with School().open() as place:
        told = await place.say(asked, account=BO, chat="2")
        assert "wave" not in told
        assert " 0.5 m" not in told
        assert "to 5 m" not in told
        if asked == "help swarm":
            assert told == MAY.replace("omni", "cf1, cf2")
        if asked == "help":
            example = told.splitlines()[1].strip()
            assert "above" not in (said := await place.say(example, account=BO, chat="2"))
            assert "accepted" in said or "done" in said


async def test_robots_are_told_of_together_as_far_as_it_reads_the_same() -> None:
    """Whatever else sets them apart, in the order in which they are."""
    move = profile("omni").skills["move"]
    distance = move.parameters["distance"]

    def body(name: str, *, title: str = "", most_m: float = 5.0) -> Profile:
        far = replace(distance, title=title, max=most_m)
        skill = replace(move, parameters={**move.parameters, "distance": far})
        return replace(profile(name, groups=("swarm",)), skills={"move": skill})

    fleet = (body("a1"), body("a2", most_m=5.0000001), body("a3", title="How far"))
    async with Place(fleet=(*fleet, body("a4", most_m=4.0))).open() as place:
        can = "move: direction (forward, back, left), distance 0.01 to"
        assert await place.say("help swarm") == (
            f"a1, a2, a3 can:\n  {can} 5 m\na4 can:\n  {can} 4 m"
        )


def test_help_on_a_thousand_robots_makes_no_step_long() -> None:
    async def act(place: Receiving) -> None:
        await none_is_long(place, ADA_ID, ["help swarm"])

    run(act, tuple(profile(f"cf{n}", groups=("swarm",)) for n in range(1_000)))


async def test_whoever_may_only_look_is_told_so() -> None:
    fleet = (replace(profile("omni"), skills={"move": profile("omni").skills["move"]}),)
    async with Place(fleet=fleet).open() as place:
        told = await place.say("help omni", account=VI, chat="3")
        assert told == "You may look at omni. What you lack, ask for: /ask"


async def test_what_they_often_asked_is_not_offered_beyond_their_limits() -> None:
    async with School().open() as place:
        found = place.gateway.rooms.authoriser.directory.at(Address("memory", BO))
        assert found is not None
        bo = found[0].id
        history, chat = place.gateway.pipeline.command_history, Chat("memory", "2")
        for asked in ("omni move 2 m", "omni move 0.2 m", "omni wave") * 2:
            history.note(bo, chat, "omni", asked)
        await place.say("use omni", account=BO, chat="2")
        often = [b.label for row in place.last()[1].buttons for b in row if "\u2605" in b.label]
        assert often == ["\u2605 move, 0.20 m"]


async def test_nobody_is_told_to_sign_in_where_there_is_no_page() -> None:
    async with School().open() as place:
        shared = await place.say("help share")
        assert "/archive" in shared or "/files" in shared
        assert "signin" not in shared
