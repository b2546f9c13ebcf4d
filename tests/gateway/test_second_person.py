"""What wants a second person: who may agree, to what, and for how long that counts."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from rosic.core.identity import Address
from rosic.core.policy.query import Deny, PolicyCode, Query
from rosic.core.policy.roles import Assurance, Grant, Role, SkillPrecondition
from rosic.gateway.confirmation import ASKED_AT_MOST, _why_not
from tests.gateway.place import BO, VI
from tests.gateway.test_rights import JUNIOR, lab, rules, who

if TYPE_CHECKING:
    from tests.gateway.place import Place


async def test_a_second_person_has_to_agree_and_only_for_this_once() -> None:
    async with lab(rules(SkillPrecondition(scopes=("omni:wave",), second_person=True))) as place:
        told = await place.say("omni wave", account=BO, chat=BO)
        assert "Wave on omni needs a second person who agrees. I have asked Ada" in told
        assert place.acted() == 0
        button, under = place.button("I agree")
        told = await place.tap(button, under)
        assert "Bo is told that you agree." in told
        button, under = place.button("Do it")
        await place.tap(button, under, account=BO)
        assert place.acted() == 1
        await place.say("omni wave", account=BO, chat=BO)
        assert place.acted() == 1


async def test_nobody_agrees_with_themselves_and_a_no_is_told() -> None:
    async with lab(rules(SkillPrecondition(scopes=("omni:wave",), second_person=True))) as place:
        await place.say("omni wave", account=BO, chat=BO)
        button, _ = place.button("I agree")
        bound = place.gateway.rooms.authoriser.buttons._bound[button.nonce]
        told = await place.say(bound.command, account=BO, chat=BO)
        assert "Somebody else has to agree." in told
        button, under = place.button("No")
        await place.tap(button, under)
        assert (
            "Ada does not agree: omni: wave. Nothing was done."
            in place.chat.told[-2].outbound.text + place.chat.told[-1].outbound.text
        )
        assert place.acted() == 0


async def test_an_agreement_is_good_for_five_minutes_since_it_was_asked_for() -> None:
    async with lab(rules(SkillPrecondition(scopes=("omni:wave",), second_person=True))) as place:
        await place.say("omni wave", account=BO, chat=BO)
        agree, under = place.button("I agree")
        await place.clock.advance(299.0)
        await place.tap(agree, under)
        button, under = place.button("Do it")
        await place.clock.advance(2.0)
        told = await place.tap(button, under, account=BO)
        assert "Nothing was done." in told
        assert place.acted() == 0


@pytest.mark.parametrize(
    ("later_s", "told"),
    [(-1e-7, "Bo is told that you agree."), (1e-7, "That question is settled already.")],
)
async def test_five_minutes_are_five_minutes_and_no_more(later_s: float, told: str) -> None:
    async with lab(rules(SkillPrecondition(scopes=("omni:wave",), second_person=True))) as place:
        await place.say("omni wave", account=BO, chat=BO)
        agree, _ = place.button("I agree")
        command = place.gateway.rooms.authoriser.buttons._bound[agree.nonce].command
        [request] = place.gateway.pipeline.confirmation._requests.values()
        passed_s = (place.clock.monotonic_ns() - request.asked.monotonic_ns) / 1e9
        await place.clock.advance(300.0 - 0.001 - passed_s + later_s)  # and 1 ms as it is said
        assert told in await place.say(command)


async def test_nobody_agrees_after_five_minutes_by_typing_it_either() -> None:
    async with lab(rules(SkillPrecondition(scopes=("omni:wave",), second_person=True))) as place:
        await place.say("omni wave", account=BO, chat=BO)
        agree, _ = place.button("I agree")
        bound = place.gateway.rooms.authoriser.buttons._bound[agree.nonce]
        await place.clock.advance(301.0)
        told = await place.say(bound.command)
        assert told == "That question is settled already. Nothing was done."
        assert place.acted() == 0


async def test_nobody_agrees_to_more_than_they_may_do_themselves() -> None:
    tutor = Role(scopes=("*:*",), limits=("omni:move distance <= 1 m",), priority=5)
    care = SkillPrecondition(scopes=("omni:move",), second_person=True)
    async with lab(rules(care, junior=tutor), {"Bo": "junior"}) as place:
        told = await place.say("omni move 2 m")
        assert told == (
            "Move on omni needs a second person who agrees. Nobody else here may do exactly that, "
            "so nobody can agree."
        )
        told = await place.say("omni move 1 m")
        assert "I have asked Bo" in told
        button, under = place.button("I agree")
        await place.tap(button, under, account=BO)
        button, under = place.button("Do it")
        await place.tap(button, under)
        assert place.acted() == 1


async def test_of_several_robots_a_second_person_needs_the_right_to_those_that_want_one() -> None:
    pilot = Role(scopes=("cf1:*",), priority=5)
    care = SkillPrecondition(scopes=("cf1:wave",), second_person=True)
    async with lab(rules(care, pilot=pilot), {"Bo": "pilot"}) as place:
        told = await place.say("swarm wave")
        assert "Wave on cf1 needs a second person who agrees. I have asked Bo" in told
        button, under = place.button("I agree")
        await place.tap(button, under, account=BO)
        await place.tap(*place.button("Do it"))
        assert (place.acted("cf1"), place.acted("cf2")) == (1, 1)


@pytest.mark.parametrize(
    ("role", "why"),
    [
        (
            "junior",
            (
                "You cannot agree to this: omni: move, 2.00 m forward. For you it is allowed with "
                "distance <= 1 m."
            ),
        ),
        ("viewer", "Only somebody who may do that can agree to it."),
    ],
)
async def test_whoever_got_hold_of_the_number_is_told_why_they_cannot_agree(
    role: str, why: str
) -> None:
    care = SkillPrecondition(scopes=("omni:move",), second_person=True)
    async with lab(rules(care, junior=JUNIOR), {"Vi": role}) as place:
        told = await place.say("omni move 2 m")
        assert "I have asked Bo" in told
        agree, _ = place.button("I agree")
        bound = place.gateway.rooms.authoriser.buttons._bound[agree.nonce].command
        assert await place.say(bound, account=VI, chat=VI) == why
        assert place.acted() == 0


async def test_whose_limits_shrank_meanwhile_agrees_to_nothing() -> None:
    care = SkillPrecondition(scopes=("omni:move",), second_person=True)
    async with lab(rules(care, junior=JUNIOR), {"Bo": "viewer"}) as place:
        await regrant(place, "Bo", Grant(id="g1", role="operator"))
        await place.say("omni move 2 m")
        agree, under = place.button("I agree")
        command = place.gateway.rooms.authoriser.buttons._bound[agree.nonce].command
        await regrant(place, "Bo", Grant(id="g2", role="junior"))
        told = await place.tap(agree, under, account=BO)
        assert (
            "The rules here have changed since Ada asked for this: omni: move, 2.00 m forward. "
            "Nothing was done, and Ada can ask again."
        ) in told
        assert "since you asked for this: omni: move, 2.00 m forward." in told, "Ada is told"
        again = await place.say(command, account=BO, chat=BO)
        assert "Nothing was done." in again
        assert "have changed" not in again, "it was settled by then, and Ada is told once"
        assert place.acted() == 0


async def test_an_agreement_ends_with_the_right_of_whoever_agreed() -> None:
    care = SkillPrecondition(scopes=("omni:move",), second_person=True)
    async with lab(rules(care, junior=JUNIOR), {"Bo": "viewer"}) as place:
        await regrant(place, "Bo", Grant(id="g1", role="operator"))
        await place.say("omni move 2 m")
        button, under = place.button("I agree")
        await place.tap(button, under, account=BO)
        button, under = place.button("Do it")
        await regrant(place, "Bo", Grant(id="g2", role="junior"))
        told = await place.tap(button, under)
        assert told == (
            "The rules here have changed since you were asked: omni: move, 2.00 m forward. "
            "Nothing was done. Say it again."
        )
        assert "so nobody can agree" in await place.say("omni move 2 m")
        assert place.acted() == 0


async def regrant(place: Place, name: str, *grants: Grant) -> None:
    """Give somebody these rights beside the role they came with, and no others."""
    access, grants_book = place.gateway.access, place.gateway.authority.grants_book
    async with access.changes.turn() as turn:
        await turn.write(grants_book.take(who(place, name), ""))
        await turn.write(grants_book.give(who(place, name), grants, ""))


async def test_what_somebody_said_no_to_nobody_agrees_to_any_more() -> None:
    async with lab(rules(SkillPrecondition(scopes=("omni:wave",), second_person=True))) as place:
        await place.say("omni wave", account=BO, chat=BO)
        agree, _ = place.button("I agree")
        command = place.gateway.rooms.authoriser.buttons._bound[agree.nonce].command
        await place.tap(*place.button("No"))
        told = await place.say(command)
        assert "settled" in told
        assert "Nothing was done." in told
        assert place.acted() == 0


async def test_an_agreement_counts_once_though_its_button_came_back() -> None:
    async with lab(rules(SkillPrecondition(scopes=("omni:wave",), second_person=True))) as place:
        await place.say("omni wave", account=BO, chat=BO)
        await place.tap(*place.button("I agree"))
        button, under = place.button("Do it")
        bound = place.gateway.rooms.authoriser.buttons._bound
        again = bound[button.nonce]
        await place.tap(button, under, account=BO)
        bound[button.nonce] = again
        told = await place.tap(button, under, account=BO)
        assert "That question is settled already. Nothing was done." in told
        assert place.acted() == 1


async def test_what_waits_for_a_second_person_is_bounded_and_the_oldest_goes_first() -> None:
    async with lab(rules(SkillPrecondition(scopes=("omni:wave",), second_person=True))) as place:
        await place.say("omni wave", account=BO, chat=BO)
        requests = place.gateway.pipeline.confirmation._requests
        (first, request), *_ = requests.items()
        requests.update({f"s{number}": request for number in range(ASKED_AT_MOST - 2)})
        await place.say("omni wave", account=BO, chat=BO)
        assert len(requests) == ASKED_AT_MOST
        assert first in requests, "there was room for one more"
        await place.say("omni wave", account=BO, chat=BO)
        assert len(requests) == ASKED_AT_MOST
        assert first not in requests


def test_whoever_cannot_agree_is_told_what_is_in_the_way() -> None:
    ask = Query(principal="p", key="k", robot="omni", skill="wave", arguments={})
    chat = Deny(ask=ask, code=PolicyCode.CHANNEL_TOO_WEAK, rules=(), channel=Assurance.LOCAL)
    assert _why_not(chat, "wave on omni").startswith("You cannot agree to this in this chat: ")
    role = Deny(ask=ask, code=PolicyCode.NOT_GRANTED, rules=())
    assert _why_not(role, "wave") == "Only somebody who may do that can agree to it."


async def test_a_cancel_of_another_robot_leaves_the_question_and_one_of_this_withdraws_it() -> None:
    async with lab(rules(SkillPrecondition(scopes=("kuka1:wave",), second_person=True))) as place:
        await place.say("kuka1 wave", account=BO, chat=BO)
        told = await place.say("cancel omni", account=BO, chat=BO)
        assert told == "Nothing of yours is under way."
        await place.clock.advance(1.0)
        button, under = place.button("I agree")
        assert "Bo is told that you agree." in await place.tap(button, under)
        await place.tap(*place.button("Do it"), account=BO)
        assert place.acted("kuka1") == 1
        await place.say("kuka1 wave", account=BO, chat=BO)
        told = await place.say("cancel kuka1", account=BO, chat=BO)
        assert told == "Cancelled. The question to a second person is withdrawn."
        assert "Nothing was done." in await place.tap(*place.button("I agree"))
        assert place.acted("kuka1") == 1


@pytest.mark.parametrize(
    ("name", "account", "left", "acted"),
    [
        ("Bo", BO, 0, 0),
        ("Vi", VI, 1, 0),
        ("Bo", VI, 2, 1),
        ("Vi", BO, 2, 1),
        ("Bo", "another", 2, 1),
    ],
)
async def test_nothing_comes_of_what_an_account_that_was_lost_asked_for_or_agreed_to(
    name: str, account: str, left: int, acted: int
) -> None:
    needed = rules(SkillPrecondition(scopes=("omni:wave",), second_person=True))
    async with lab(needed, {"Vi": "operator"}) as place:
        await place.say("omni wave", account=BO, chat=BO)
        await place.say("omni wave", account=VI, chat=VI)
        agree, asked = place.button("I agree")
        await place.tap(agree, asked, account=BO)  # to what Vi asked for
        confirmation = place.gateway.pipeline.confirmation
        confirmation.forget_account(who(place, name), Address("memory", account))
        assert len(confirmation._requests) == left
        do_it, agreed = place.button("Do it")
        await place.tap(do_it, agreed, account=VI)
        assert place.acted() == acted
