"""Rate limits in a whole gateway: of a person, a robot and a role, by cost, over a restart."""

from __future__ import annotations

from contextlib import asynccontextmanager
from itertools import count
from typing import TYPE_CHECKING

from msgspec.structs import replace

from rosic.core.policy.roles import DEFAULT_ROLES, Role, RoleRules
from rosic.core.rate_limit import RateLimit
from rosic.stores.memory import MemoryStore
from rosic.testing.clock import ManualClock
from tests.gateway.place import BO, FLEET, Place

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Mapping

    from rosic.core.robot.profile import Profile

NUMBERS = count(1_000)
STUDENT = Role(scopes=("*:*",), rate="3/h", priority=5)


def dear(profile: Profile, cost: float) -> Profile:
    skills = {**profile.skills, "wave": replace(profile.skills["wave"], cost=cost)}
    return replace(profile, skills=skills)


@asynccontextmanager
async def lab(
    *,
    limit: RateLimit | None = None,
    robots: Mapping[str, RateLimit] | None = None,
    roles: Mapping[str, Role] | None = None,
    of: Mapping[str, tuple[str, ...]] | None = None,
    cost: float = 1.0,
    run: tuple[MemoryStore, ManualClock] | tuple[None, None] = (None, None),
) -> AsyncIterator[Place]:
    fleet = tuple(dear(profile, cost) for profile in FLEET)
    place = Place(run[0], clock=run[1], limit=limit, fleet=fleet)
    settings = place.gateway._settings
    people = tuple(replace(p, roles=(of or {}).get(p.name, p.roles)) for p in settings.people)
    place.gateway._settings = replace(
        settings,
        people=people,
        robot_limits=dict(robots or {}),
        rulebook=RoleRules(roles={**DEFAULT_ROLES, **(roles or {})}),
    )
    async with place.open():
        yield place


async def waves(place: Place, times: int, robot: str = "omni", account: str = BO) -> list[str]:
    told = []
    for _ in range(times):
        message = f"m{next(NUMBERS)}"  # also after a restart nobody's is said again
        said = await place.say(f"{robot} wave", account=account, chat=account, message=message)
        told.append(said)
        place.gateway.rooms.organiser.release(robot)
    return told


async def test_a_robot_takes_so_much_from_everybody_together() -> None:
    async with lab(robots={"omni": RateLimit(burst=3, per_s=0.1)}) as place:
        await waves(place, 2)
        told = await waves(place, 2, account="1")
        assert place.acted() == 3
        assert "omni has had as many commands as it takes" in told[-1]
        assert "Again in 10 s." in told[-1]
        await waves(place, 1, "cf1")
        assert place.acted("cf1") == 1, "another robot has no such limit"
        await place.clock.advance(10)
        await waves(place, 1)
        assert place.acted() == 4


async def test_nobody_who_may_not_command_a_robot_uses_it_up() -> None:
    async with lab(robots={"omni": RateLimit(burst=1, per_s=0.001)}) as place:
        await waves(place, 10, account="3")  # a viewer
        await waves(place, 1)
        assert place.acted() == 1


async def test_what_a_skill_costs_is_taken_from_everybody_concerned() -> None:
    ten = RateLimit(burst=10, per_s=0.1)
    async with lab(limit=ten, cost=5.0) as place:
        told = await waves(place, 3)
        assert place.acted() == 2
        assert "more than one person may ask. Again in 10 s" in told[-1]
    async with lab(robots={"omni": ten}, cost=5.0) as place:
        await waves(place, 3)
        assert place.acted() == 2
    student = replace(STUDENT, rate="10/h")
    async with lab(roles={"student": student}, of={"Bo": ("student",)}, cost=5.0) as place:
        await waves(place, 3)
        assert place.acted() == 2


async def test_a_command_to_a_group_costs_one_and_each_of_its_robots_one() -> None:
    limits = {"cf1": RateLimit(burst=2, per_s=0.001), "cf2": RateLimit(burst=1, per_s=0.001)}
    async with lab(limit=RateLimit(burst=10, per_s=0.001), robots=limits, cost=5.0) as place:
        await place.say("swarm wave", account=BO, chat=BO)
        assert (place.acted("cf1"), place.acted("cf2")) == (1, 1)
        told = await place.say("swarm wave", account=BO, chat=BO)
        assert (place.acted("cf1"), place.acted("cf2")) == (1, 1), "all of a group or none"
        assert "cf1 has had" in told or "cf2 has had" in told


async def test_a_role_may_so_much_and_whoever_has_a_better_one_is_not_bound() -> None:
    of = {"Bo": ("student",), "Vi": ("student",), "Ada": ("student", "admin")}
    async with lab(roles={"student": STUDENT}, of=of) as place:
        await waves(place, 2)
        told = await waves(place, 2, account="3")
        assert place.acted() == 3
        assert "Your role has asked for as much as it may: everybody who is student" in told[-1]
        assert "Again in 20 min." in told[-1]
        await waves(place, 5, account="1")
        assert place.acted() == 8, "an admin is one by another right"


async def test_a_role_that_includes_a_limited_one_shares_its_limit() -> None:
    roles = {"student": STUDENT, "tutor": Role(includes=("student",))}
    async with lab(roles=roles, of={"Bo": ("tutor",), "Vi": ("student",)}) as place:
        await waves(place, 2)
        await waves(place, 5, account="3")
        assert place.acted() == 3


async def test_a_role_that_includes_an_unlimited_one_as_well_is_not_bound() -> None:
    free = Role(scopes=("*:*",))
    roles = {"student": STUDENT, "free": free, "both": Role(includes=("student", "free"))}
    async with lab(roles=roles, of={"Bo": ("both",)}) as place:
        await waves(place, 5)
        assert place.acted() == 5


async def test_a_limit_of_others_is_no_misuse() -> None:
    async with lab(robots={"omni": RateLimit(burst=1, per_s=0.0001)}) as place:
        await waves(place, 60)
        assert "Bo" in await place.say("/me", account=BO, chat=BO)


async def test_a_resume_that_was_too_much_does_nothing_when_it_comes_again() -> None:
    async with lab(limit=RateLimit(burst=1, per_s=0.5)) as place:
        await place.say("stop omni", account=BO, chat=BO)
        await place.clock.advance(2)
        await place.say("status", account=BO, chat=BO)
        told = await place.say("resume omni", account=BO, chat=BO, message="again")
        assert "more than one person may ask" in told
        await place.clock.advance(2)
        await place.say("resume omni", account=BO, chat=BO, message="again")
        assert place.robot("omni").gate.latched
        await place.clock.advance(2)
        await place.say("resume omni", account=BO, chat=BO)
        assert not place.robot("omni").gate.latched


async def test_a_restart_gives_nobody_more() -> None:
    run = MemoryStore(), ManualClock()
    many = {
        "limit": RateLimit(burst=8, per_s=0.001),
        "robots": {"omni": RateLimit(burst=3, per_s=0.001)},
        "roles": {"student": replace(STUDENT, rate="4/day")},
        "of": {"Bo": ("student",)},
    }
    async with lab(run=run, **many) as place:  # type: ignore[arg-type]
        await waves(place, 2)
        await waves(place, 1, "cf1")
    async with lab(run=run, **many) as place:  # type: ignore[arg-type]
        await waves(place, 2)
        assert place.acted() == 1, "the robot's"
        told = await waves(place, 2, "cf1")
        assert place.acted("cf1") == 0, "the role's"
        assert "Your role" in told[-1]
        told = await waves(place, 2, "cf2")
        assert "one person" in told[-1], "it is the ninth line"


async def test_a_crash_gives_nobody_more() -> None:
    run = MemoryStore(), ManualClock()
    robots = {"omni": RateLimit(burst=3, per_s=0.001)}
    async with lab(run=run, robots=robots) as place:
        await waves(place, 3)
        assert place.acted() == 3
        place.gateway.rooms.organiser.rates._unsaved = False  # it dies before it saves
    async with lab(run=run, robots=robots) as place:
        await waves(place, 1)
        assert place.acted() == 0


async def test_what_is_used_is_saved_at_a_bounded_pace() -> None:
    store = MemoryStore()
    async with lab(run=(store, ManualClock()), limit=RateLimit(burst=100, per_s=0.001)) as place:
        await waves(place, 20)
        assert [f.key for f in await store.facts("rate", "", 9)] == ["open"]
        await place.clock.advance(10)
        assert [f.key for f in await store.facts("rate", "", 9)] == ["fill"]
