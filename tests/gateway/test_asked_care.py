"""Whatever ``[[care]]`` accepts is asked for, and what nothing would ask for is refused (I18)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest
from msgspec.structs import replace

from rosic.config.profiles import known_units
from rosic.core.policy.limits import unit_converter
from rosic.core.policy.permissions import fleet_of
from rosic.core.policy.roles import DEFAULT_ROLES, Role, RoleRules, SkillPrecondition
from rosic.core.policy.scope import FLEET, FLEET_VERBS, NO_SKILLS, RESUME
from rosic.core.policy.validation import rulebook_mistakes
from rosic.errors import ConfigurationError
from rosic.messengers.memory import MemoryMessenger
from tests.gateway.place import BO, PEOPLE, Place
from tests.gateway.place import FLEET as ROBOTS

if TYPE_CHECKING:
    from rosic.testing.clock import ManualClock

SKILLS = {"move": "omni move 1 m", "wave": "omni wave", "look": "omni look"}
SCOPES = (
    *(f"omni:{word}" for word in (*SKILLS, *NO_SKILLS)),
    *(f"{FLEET}:{verb}" for verb in (*FLEET_VERBS, "*")),
)
WANTED: dict[str, dict[str, bool | str]] = {
    "confirm": {"confirm": True},
    "step_up": {"step_up": True},
    "second_person": {"second_person": True},
    "assurance": {"assurance": "local"},
}
ACCEPTED = {
    *((f"omni:{skill}", wanted) for skill in SKILLS for wanted in WANTED),
    (f"omni:{RESUME}", "assurance"),
}


def read_along(clock: ManualClock) -> MemoryMessenger:
    """Return a messenger whose provider can read along."""
    chat = MemoryMessenger("memory", clock=clock)
    chat.assurance = "provider-readable"
    return chat


def ruled(scope: str, wanted: str, **roles: Role) -> RoleRules:
    care = SkillPrecondition(scopes=(scope,), **WANTED[wanted])  # type: ignore[arg-type]
    return RoleRules(roles={**DEFAULT_ROLES, **roles}, care=(care,))


def place_with(rulebook: RoleRules, role: str = "operator") -> Place:
    """Return a place with rules of its own, in which Bo has a role."""

    class Ruled(Place):
        people = (PEOPLE[0], replace(PEOPLE[1], roles=(role,)), PEOPLE[2])

    Ruled.rulebook = rulebook
    return Ruled(chat=read_along)


@pytest.mark.parametrize("wanted", WANTED)
@pytest.mark.parametrize("scope", SCOPES)
async def test_what_care_accepts_is_asked_for_and_the_rest_is_refused(
    scope: str, wanted: str
) -> None:
    rulebook = ruled(scope, wanted)
    found = rulebook_mistakes(rulebook, fleet_of(ROBOTS), unit_converter(known_units()))
    assert (not found) is ((scope, wanted) in ACCEPTED)
    if found:
        (mistake,) = found
        assert mistake.place == ("care", 0, "scopes", 0)
        assert mistake.sentence.startswith(f"'{scope}' is no skill: ")
        with pytest.raises(ConfigurationError, match=r"^care\.0\.scopes\.0: .* is no skill: "):
            async with place_with(rulebook).open():
                pass
        return
    async with place_with(rulebook).open() as place:
        if scope == f"omni:{RESUME}":
            await place.say("stop omni", account=BO, chat=BO)
            assert place.robot("omni").gate.latched, "a stop asks for nothing"
            await place.clock.advance(1.5)
            await place.say("resume omni", account=BO, chat=BO)
            assert place.robot("omni").gate.latched
        else:
            await place.say(SKILLS[scope.partition(":")[2]], account=BO, chat=BO)
            assert place.acted() == 0


async def test_every_word_that_may_follow_a_robot_is_gone_over() -> None:
    async with place_with(RoleRules(roles=DEFAULT_ROLES)).open() as place:
        fleet = place.gateway.rooms.organiser.rights.fleet
        words = {f"{robot}:{word}" for robot in ("omni", FLEET) for word in fleet.words(robot)}
        assert words < set(SCOPES)
        for number, text in enumerate(SKILLS.values(), 1):
            await place.say(text, account=BO, chat=BO)
            assert place.acted() == number, "what is not asked for here is done"


async def test_what_a_resume_wants_holds_for_ones_own_stop_and_not_for_the_operator() -> None:
    student = Role(scopes=("omni:move",))
    for wants in (True, False):
        rulebook = ruled(f"omni:{RESUME}" if wants else "omni:wave", "assurance", student=student)
        async with place_with(rulebook, "student").open() as place:
            place.robot("omni").work_s = 10_000.0
            await place.say("omni move 1 m", account=BO, chat=BO)
            message, _ = place.last()
            await place.say("stop", answers=message, account=BO, chat=BO)
            assert place.robot("omni").gate.latched
            await place.clock.advance(1.5)
            await place.say("resume omni", account=BO, chat=BO)
            assert place.robot("omni").gate.latched is wants
            at_ns = place.clock.wall_ns()
            await place.gateway.pipeline.resuming.by_operator(["omni"], at_ns)
            assert not place.robot("omni").gate.latched


async def test_a_gateway_made_in_python_has_no_rule_that_asks_for_nothing() -> None:
    """A file with it is refused when it is read; here nobody read one."""
    nothing = SkillPrecondition(scopes=("omni:move",))
    place = place_with(RoleRules(roles=DEFAULT_ROLES, care=(nothing,)))
    with pytest.raises(ConfigurationError, match=r"^care\.0: This asks for nothing\. Set confirm"):
        async with place.open():
            pass


async def test_a_rule_for_robots_that_are_yet_to_be_added_is_none_that_asks_for_nothing() -> None:
    care = SkillPrecondition(scopes=("*:move",), confirm=True)
    ruled_place = place_with(RoleRules(roles=DEFAULT_ROLES, care=(care,)))
    empty = type(ruled_place)(fleet=())
    async with empty.open():
        pass
