"""Taking a choice back: of a robot in a chat, of a value in a question; never of a motion."""

from __future__ import annotations

from rosic.app.people import ConfiguredPerson
from rosic.core.identity import Address, PrincipalId
from rosic.core.message import Chat
from rosic.core.policy.roles import DEFAULT_ROLES, Role, RoleRules
from rosic.gateway.builtin_commands import SelectionHistory
from tests.gateway.place import BO, PEOPLE, Place

CHAT = Chat("memory", "1")
DI = "4"
ADA = PrincipalId("p-ada")
NOTHING = "There is no choice to take back here. What a robot has done is not undone by this."


def _labels(place: Place) -> list[str]:
    return [button.label for row in place.last()[1].buttons for button in row]


async def test_a_choice_is_taken_back_by_a_button_to_what_was_chosen_before() -> None:
    async with Place().open() as place:
        await place.say("use omni")
        await place.say("use kuka1")
        told = await place.tap(*place.button("Previous"))
        assert told.startswith("omni: "), told
        assert "Move" in _labels(place), "its own menu"
        await place.say("move 1 m left")
        assert (place.acted("omni"), place.acted("kuka1")) == (1, 0)
        told = await place.say("undo")
        assert told == "No robot is chosen now. Say its name with each command."
        assert "omni" in _labels(place), "one step further back is the choice of robots"
        assert await place.say("/undo") == NOTHING
        assert (place.acted("omni"), place.acted("kuka1")) == (1, 0), "nothing moved by it"


async def test_a_choice_by_buttons_is_taken_back_too() -> None:
    async with Place().open() as place:
        await place.say("robots")
        await place.tap(*place.button("cf1"))
        await place.tap(*place.button("Another robot"))
        await place.tap(*place.button("cf2"))
        message = place.last()[0]
        await place.tap(*place.button("Previous"))
        assert place.last()[0] == message, "one message, edited"
        assert place.last()[1].text.startswith("cf1: ")
        await place.tap(*place.button("Previous"))
        assert "No robot is chosen now" in place.last()[1].text
        assert "Previous" not in _labels(place)


async def test_choosing_nothing_and_a_group_are_choices_like_others() -> None:
    async with Place().open() as place:
        await place.say("use swarm")
        await place.say("use nothing")
        await place.say("undo")
        await place.say("wave")
        assert (place.acted("cf1"), place.acted("cf2")) == (1, 1)
        await place.say("use swarm")  # again: that is no new choice
        await place.say("undo")
        assert await place.say("undo") == NOTHING


async def test_it_is_each_persons_own_and_each_chats() -> None:
    async with Place().open() as place:
        await place.say("use omni", chat="-5")
        assert await place.say("undo", account=BO, chat="-5") == NOTHING
        assert await place.say("undo") == NOTHING
        assert "No robot is chosen now" in await place.say("undo", chat="-5")


async def test_a_button_takes_back_its_own_choice_only() -> None:
    async with Place().open() as place:
        await place.say("use omni")
        old, under = place.button("Previous")
        await place.say("use kuka1")
        told = await place.tap(old, under)
        assert told == "Something else was chosen here since. Nothing was changed."
        await place.say("wave")
        assert place.acted("kuka1") == 1
        assert await place.tap(old, under) == "", "and it was good once"


async def test_it_is_as_good_as_the_menu_it_stands_in() -> None:
    async with Place().open() as place:
        await place.say("use omni")
        await place.clock.advance(300)
        assert "No robot is chosen now" in await place.tap(*place.button("Previous"))


class Narrow(Place):
    """A place where Di sees one robot, and another for a while."""

    rulebook = RoleRules(roles={**DEFAULT_ROLES, "narrow": Role(scopes=("omni:*",), priority=5)})
    people = (*PEOPLE, ConfiguredPerson("Di", (Address("memory", DI),), ("narrow",)))


async def test_it_leads_to_no_robot_that_is_hidden_by_now() -> None:
    async with Narrow().open() as place:
        await place.say("/grant Di operator cf1 for 20 s")
        for name in ("omni", "cf1", "nothing"):
            await place.say(f"use {name}", account=DI, chat=DI)
        await place.clock.advance(25)
        await place.say("use omni", account=DI, chat=DI)
        assert "Previous" not in _labels(place), "there is only one robot by now"
        await place.say("undo", account=DI, chat=DI)
        told = await place.say("undo", account=DI, chat=DI)
        assert told.startswith("omni: "), "cf1 is none of theirs any more"


async def test_after_a_restart_the_choice_holds_and_what_was_before_is_not_guessed() -> None:
    place = Place()
    async with place.open():
        await place.say("use omni")
        await place.say("use kuka1")
    again = Place(place.store, place.latch)
    async with again.open():
        assert await again.say("undo", message="a") == NOTHING
        await again.say("wave", message="b")
        assert again.acted("kuka1") == 1


async def test_in_a_question_it_goes_one_step_back_and_then_to_the_menu() -> None:
    async with Place().open() as place:
        await place.say("use omni")
        await place.tap(*place.button("Move"))
        await place.tap(*place.button("+"))
        await place.tap(*place.button("1.00 m"))  # the value itself: no step
        await place.tap(*place.button("left"))
        message = place.last()[0]
        assert place.last()[1].text == "omni: move, 1.00 m left?"
        await place.tap(*place.button("Previous"))
        assert place.last()[1].text == "omni: move, 1.00 m forward?"
        await place.tap(*place.button("Previous"))
        assert place.last()[1].text == "omni: move, 0.50 m forward?"
        await place.tap(*place.button("Previous"))
        assert place.last()[1].text.startswith("omni: at rest")
        assert "Move" in _labels(place)
        assert place.last()[0] == message, "one message, edited"
        assert place.acted() == 0
        await place.tap(*place.button("Move"))
        await place.tap(*place.button("+"))
        await place.tap(*place.button("Previous"))
        await place.tap(*place.button("Do it"))
        assert place.acted() == 1
        assert "0.50 m forward" in place.last()[1].text, "what is shown is done"


async def test_after_many_steps_it_still_finds_the_menu() -> None:
    async with Place().open() as place:
        await place.say("use omni")
        await place.tap(*place.button("Move"))
        for label in ("left", "back") * 10:
            await place.tap(*place.button(label))
        taps = 0
        while "Do it" in _labels(place):
            await place.tap(*place.button("Previous"))
            taps += 1
        assert taps == 12
        assert "Move" in _labels(place)


async def test_what_came_from_no_menu_has_none_to_go_back_to() -> None:
    async with Place().open() as place:
        await place.say("/start omni__move")
        assert "Previous" not in _labels(place)
        await place.tap(*place.button("left"))
        await place.tap(*place.button("Previous"))
        assert place.last()[1].text == "omni: move, 0.50 m forward?"
        assert "Previous" not in _labels(place)


def test_what_is_remembered_is_bounded() -> None:
    known = SelectionHistory(at_most=3)
    for n in range(20):
        known.note(ADA, CHAT, f"r{n}")
    taken = [known.take(ADA, CHAT) for _ in range(10)]
    assert taken == [*(f"r{n}" for n in range(19, 11, -1)), None, None]
    for n in range(5):
        known.note(ADA, Chat("memory", str(n)), "omni")
    assert [known.has(ADA, Chat("memory", str(n))) for n in range(5)] == [False] * 2 + [True] * 3
