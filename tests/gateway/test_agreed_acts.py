"""Whoever agrees, agrees to what was shown: the robots, the values, the rules of that moment (I16).

Between a question and its tap everything may change: which robot is chosen, whose rights reach how
far, what a robot is and how it is called. What the tap then does is what was shown, or nothing.
"""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING, ClassVar

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

from rosic.app.features import command_table
from rosic.config.profiles import known_units
from rosic.core.language import Vocabulary
from rosic.core.policy.roles import Grant, Role, SkillPrecondition
from rosic.core.robot.skill import Parameter
from rosic.robots.memory import MemoryRobot
from tests.gateway.place import ADA, BO, MOVE, VI, Place
from tests.gateway.test_rights import JUNIOR, lab, rules, who
from tests.gateway.test_second_person import regrant

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable

    from rosic.contracts.robot import Tell
    from rosic.core.message import Button
    from rosic.core.order import Order, Outcome
    from rosic.core.robot.profile import Profile

METRE = ("omni", "move", {"direction": "forward", "distance": 1.0})
CONFIRM = SkillPrecondition(scopes=("*:move",), confirm=True)
SECOND = SkillPrecondition(scopes=("*:move",), second_person=True)
NOT_THE_SAME = "This is not what was shown any more: now it would be "
OTHER_RULES = "The rules here have changed since you were asked: "


class Noting(MemoryRobot):
    """Remembers what it was told to do."""

    done: ClassVar[list[tuple[str, str, dict[str, object]]]] = []

    async def execute(self, order: Order, tell: Tell) -> Outcome:
        """Note it, and do it."""
        Noting.done.append((order.robot, order.skill.id, dict(order.arguments)))
        return await super().execute(order, tell)


@pytest.fixture(autouse=True)
def _noting(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Place, "kind", Noting)
    Noting.done.clear()


async def asks(place: Place, line: str) -> str:
    return await place.say(line, account=BO, chat=BO)


# ---- what was found ----


async def test_what_two_agreed_to_is_done_whatever_is_chosen_by_then() -> None:
    async with lab(rules(SECOND)) as place:
        await asks(place, "/use omni")
        told = await asks(place, "move 1 m")
        assert "Bo wants: omni: move, 1.00 m forward. It needs a second person." in told
        await place.tap(*place.button("I agree"))
        assert "Ada agrees: omni: move, 1.00 m forward." in place.last()[1].text + str(
            [told.outbound.text for told in place.chat.told]
        )
        await asks(place, "/use cf1")
        await place.tap(*place.button("Do it"), account=BO)
        assert Noting.done == [METRE]


async def test_what_one_agrees_to_names_its_robot_and_every_value() -> None:
    async with lab(rules(CONFIRM)) as place:
        await asks(place, "/use omni")
        told = await asks(place, "move 1 m")
        assert told == "omni: move, 1.00 m forward? It moves only if you confirm it."
        button, under = place.button("Do it")
        await asks(place, "/use cf1")
        await place.tap(button, under, account=BO)
        assert Noting.done == [METRE]


async def test_what_is_offered_names_its_robot_whatever_is_chosen_by_then() -> None:
    async with lab(rules()) as place:
        await asks(place, "/use omni")
        await place.clock.advance(10)
        late_ns = place.clock.wall_ns() - 9_000_000_000
        await place.say("move 1 m", account=BO, chat=BO, sent_ns=late_ns)
        button, under = place.button("omni move 1 m")
        await asks(place, "/use cf1")
        await place.tap(button, under, account=BO)
        assert Noting.done == [METRE]


async def test_a_group_is_asked_with_all_who_are_in_it_and_every_value() -> None:
    async with lab(rules(CONFIRM)) as place:
        told = await asks(place, "swarm move 1 m")
        assert told.startswith("swarm (cf1, cf2): move, 1.00 m forward?")


async def test_a_second_person_agrees_for_all_of_a_group() -> None:
    """Whoever may not move one of them cannot agree that all of them move."""
    care = SkillPrecondition(scopes=("cf1:move", "cf2:move"), second_person=True)
    half = Role(scopes=("*:read", "cf1:*"), priority=5)
    async with lab(rules(care, half=half), {"Ada": "half", "Vi": "operator"}) as place:
        told = await asks(place, "swarm move 1 m")
        assert "I have asked Vi;" in told
        button, _ = place.button("I agree")
        command = place.gateway.rooms.authoriser.buttons._bound[button.nonce].command
        assert "Only somebody who may do that" in await place.say(command, account=ADA, chat=ADA)
        await place.tap(button, place.button("I agree")[1], account=VI)
        await place.tap(*place.button("Do it"), account=BO)
        assert [robot for robot, *_ in Noting.done] == ["cf1", "cf2"]


async def test_an_order_that_waited_while_the_rules_changed_counts_as_agreed_to_no_more() -> None:
    async with lab(rules(SkillPrecondition(scopes=("kuka1:*",), confirm=True))) as place:
        place.robot("kuka1").work_s = 60.0
        for _ in range(2):
            await asks(place, "kuka1 move 1 m")
            await place.tap(*place.button("Do it"), account=BO)
        await regrant(place, "Vi", Grant(id="g1", role="operator"))
        before = len(place.chat.told)
        place.robot("kuka1").finish()
        await place.quiet()
        await place.clock.advance(1)
        await place.quiet()
        assert len(Noting.done) == 1
        told = " ".join(told.outbound.text for told in list(place.chat.told)[before:])
        assert "The rules here changed before kuka1 could begin" in told


# ---- whatever changes ----


async def chooses(place: Place, name: str) -> None:
    await asks(place, f"/use {name}")


async def sets(place: Place, line: str) -> None:
    await asks(place, line)


async def is_given(place: Place, role: str) -> None:
    await regrant(place, "Bo", Grant(id="g9", role=role))


async def is_locked(place: Place, _: str) -> None:
    await place.say("/lock Bo")
    await place.say("/unlock Bo")


async def is_other(place: Place, how: str) -> None:
    """Let the robots be others from now on, under the same names or under new ones."""
    profiles = {name: _changed(profile, how) for name, profile in place.gateway.profiles.items()}
    place.gateway.profiles.update(profiles)
    rooms = place.gateway.rooms
    rooms.container.add_robot("omni", 10)
    rooms.vocabularies.replace(
        Vocabulary.build(tuple(profiles.values()), known_units(), command_table())
    )
    place.gateway.pipeline.ends.clear()


def _changed(profile: Profile, how: str) -> Profile:
    far = {**MOVE.parameters, "distance": Parameter(unit="ft", min=0.1, max=15.0)}
    back = {**MOVE.parameters, "direction": Parameter(choices={"back": ()}, default="back")}
    moves = {"feet": far, "backwards": back}.get(how)
    if moves is not None:
        skills = {**profile.skills, "move": replace(MOVE, parameters=moves)}
        return replace(profile, skills=skills)
    if how == "renamed":
        return replace(profile, title=f"The {profile.id}")
    if how == "swapped":  # what is said for one means the other
        words = {"omni": ("old",), "cf1": ("omni1",)}
        return replace(profile, words=words.get(profile.id, ()))
    if how == "regrouped":
        return replace(profile, groups=("swarm",) if profile.id in {"omni", "cf1"} else ())
    if how == "retired":
        return replace(profile, skills={"wave": profile.skills["wave"]})
    return profile


CHANGES: dict[str, tuple[Callable[[Place, str], Awaitable[None]], tuple[str, ...]]] = {
    "chosen": (chooses, ("cf1", "kuka1", "swarm", "nothing")),
    "set": (
        sets,
        (
            "/settings units imperial",
            "/language de",
            "/settings robot cf1",
            "cf1 wave",
            "/settings speed 0.2 m/s",
        ),
    ),
    "given": (is_given, ("junior", "admin", "viewer")),
    "locked": (is_locked, ("",)),
    "robots": (is_other, ("feet", "backwards", "renamed", "swapped", "regrouped", "retired")),
}
CHANGE = st.sampled_from([(what, how) for what, (_, hows) in CHANGES.items() for how in hows])
QUESTIONS = ("move 1", "omni move 1 m", "swarm move 1", "/together swarm move 1")


async def question(place: Place, line: str, second: bool) -> tuple[Button, str]:
    """Ask something that ends in a button that moves; return it."""
    await asks(place, "/use omni")
    if line.startswith("/together"):
        place.robot("cf1").online = False
        await asks(place, line)
        place.robot("cf1").online = True
        return place.button("Begin with cf2")
    await asks(place, line)
    if second:
        await place.tap(*place.button("I agree"))
    return place.button("Do it")


def allowed(line: str) -> list[tuple[str, str, dict[str, object]]]:
    """Return what was shown, and may therefore be done."""
    move = METRE[2]
    if line.startswith("/together"):
        return [("cf2", "move", move)]
    if line.startswith("swarm"):
        return [("cf1", "move", move), ("cf2", "move", move)]
    return [METRE]


@settings(max_examples=60, deadline=None)
@given(
    line=st.sampled_from(QUESTIONS),
    care=st.sampled_from(["confirm", "second"]),
    changes=st.lists(CHANGE, max_size=3),
)
@pytest.mark.limit(600)
def test_a_tap_does_what_was_shown_or_nothing(
    line: str, care: str, changes: list[tuple[str, str]]
) -> None:
    asyncio.run(_taps(line, care, changes))


async def _taps(line: str, care: str, changes: list[tuple[str, str]]) -> None:
    second = care == "second"
    cares = () if line.startswith("/together") else ((SECOND if second else CONFIRM),)
    async with lab(rules(*cares, junior=JUNIOR)) as place:
        asked = await question(place, line, second)
        Noting.done.clear()
        for what, how in changes:
            await CHANGES[what][0](place, how)
        done = [one for one in Noting.done if one[1] != "wave"]
        assert not done
        Noting.done.clear()
        before = len(place.chat.told)
        await place.tap(*asked, account=BO)
        assert Noting.done in ([], allowed(line))
        told = [told.outbound.text for told in list(place.chat.told)[before:]]
        assert told, "whatever becomes of a tap is said"
        if not changes:
            assert Noting.done == allowed(line)


@pytest.mark.parametrize(
    ("what", "how", "why"),
    [
        ("given", "admin", OTHER_RULES),
        ("locked", "", OTHER_RULES),
        ("robots", "feet", NOT_THE_SAME),
        ("robots", "renamed", NOT_THE_SAME),
        ("robots", "retired", "omni"),
    ],
)
async def test_what_has_changed_is_said(what: str, how: str, why: str) -> None:
    async with lab(rules(CONFIRM, junior=JUNIOR)) as place:
        asked = await question(place, "omni move 1", second=False)
        await CHANGES[what][0](place, how)
        told = await place.tap(*asked, account=BO)
        assert why in told
        assert not Noting.done


@pytest.mark.parametrize(
    ("changed", "why"),
    [
        ("", ""),
        ("/grant Bo operator omni for 2h", NOT_THE_SAME),
        ("/robot retire cf2", NOT_THE_SAME),
        ("/grant Bo viewer omni for 2h", OTHER_RULES),
    ],
)
async def test_a_task_is_for_those_who_could_do_it_when_it_was_agreed_to(
    changed: str, why: str
) -> None:
    small = Role(scopes=("*:read", "cf1:*", "cf2:*"))
    async with lab(rules(small=small), {"Bo": "small"}) as place:
        await asks(place, "/task any move 1 m")
        await place.clock.advance(1.0)
        await place.tap(*place.button("Again"), account=BO)
        assert "Task: any move 1 m?" in place.last()[1].text
        button = place.button("Do it")
        await place.say("stop cf1", account=ADA, chat=ADA)
        if changed:
            await place.say(changed, account=ADA, chat=ADA)
        Noting.done.clear()
        told = await place.tap(*button, account=BO)
        await place.clock.advance(1.0)
        await place.quiet()
        if why:
            assert why in told
            assert not Noting.done
        else:
            assert [robot for robot, _, _ in Noting.done] == ["cf2"]


async def test_an_agreement_counts_for_its_own_act_alone() -> None:
    """Even if its number came to stand in a button that is bound to something else."""
    async with lab(rules(SECOND)) as place:
        await asks(place, "omni move 1 m")
        await place.tap(*place.button("I agree"))
        button, under = place.button("Do it")
        bound = place.gateway.rooms.authoriser.buttons._bound
        bound[button.nonce] = replace(bound[button.nonce], act=b"another act")
        told = await place.tap(button, under, account=BO)
        assert told == "That was agreed to for something else. Nothing was done."
        assert not Noting.done


async def test_an_agreement_counts_for_whoever_asked_for_it_alone() -> None:
    """Even if its number came to stand in a button of somebody else's."""
    async with lab(rules(SECOND)) as place:
        await asks(place, "omni move 1 m")
        await place.tap(*place.button("I agree"))
        button, under = place.button("Do it")
        bound = place.gateway.rooms.authoriser.buttons._bound
        bound[button.nonce] = replace(bound[button.nonce], principal=who(place, "Ada"))
        told = await place.tap(button, under, account=ADA)
        assert told == "That was agreed to for something else. Nothing was done."
        assert not Noting.done


async def test_a_button_that_was_bound_to_nothing_moves_nothing() -> None:
    """What was forgotten to be bound is refused, and not done as it comes (I18)."""
    async with lab(rules()) as place:
        await asks(place, "/help")
        button, under = place.button("omni")
        buttons = place.gateway.rooms.authoriser.buttons
        buttons._bound[button.nonce] = replace(buttons._bound[button.nonce], command="omni wave")
        told = await place.tap(button, under, account=BO)
        assert NOT_THE_SAME in told
        assert not Noting.done
        assert who(place, "Bo")
