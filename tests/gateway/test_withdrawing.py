"""A question to others: until when it can be answered, and that whoever asked can take it back."""

from __future__ import annotations

import pytest

from rosic.core.policy.roles import SkillPrecondition
from tests.gateway.place import ADA, BO, VI, Place
from tests.gateway.test_rights import lab, rules

BOTH = rules(SkillPrecondition(scopes=("*:wave",), second_person=True))
SETTLED = "That question is settled already. Nothing was done."


def answer(place: Place, label: str = "I agree") -> str:
    """Return what the newest button with a label says."""
    button, _ = place.button(label)
    return place.gateway.rooms.authoriser.buttons._bound[button.nonce].command


async def test_what_somebody_cancels_nobody_agrees_to_any_more_and_other_questions_stay() -> None:
    async with lab(BOTH, {"Vi": "operator"}) as place:
        numbers = []
        for robot, who in (("omni", BO), ("cf1", VI), ("kuka1", BO)):
            await place.say(f"{robot} wave", account=who, chat=who)
            numbers.append(answer(place))
        told = await place.say("cancel", account=BO, chat=BO)
        assert "2 questions" in told
        again = await place.say("cancel", account=BO, chat=BO)
        assert "question" not in again
        answers = [await place.say(number, account=ADA, chat=ADA) for number in numbers]
        assert "was settled before" in answers[0]
        assert "was settled before" in answers[2]
        assert "Vi is told that you agree." in answers[1]
        await place.tap(*place.button("Do it"), account=VI)
        assert [place.acted(robot) for robot in ("omni", "cf1", "kuka1")] == [0, 1, 0]


async def test_whoever_does_not_agree_is_told_that_nothing_is_done() -> None:
    async with lab(BOTH) as place:
        await place.say("omni wave", account=BO, chat=BO)
        assert "Nothing is done." in (await place.say(answer(place, "No"))).split("\n")
        assert place.acted() == 0


@pytest.mark.parametrize(("later_s", "agreed"), [(0.0, True), (0.000_001, False)])
async def test_a_question_can_be_answered_for_five_minutes(later_s: float, *, agreed: bool) -> None:
    async with lab(BOTH) as place:
        await place.say("omni wave", account=BO, chat=BO)
        await place.clock.advance(299.999 + later_s)  # and a millisecond to say it
        told = await place.say(answer(place))
        assert ("Bo is told that you agree." in told) is agreed
        assert (SETTLED in told) is not agreed
