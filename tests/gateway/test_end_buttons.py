"""What stands beneath an order that has ended: nobody's, for good; it moves nothing by itself."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest
from msgspec.structs import replace

from rosic.authoriser.button_tokens import CARRIED_BYTES, is_open, open_button
from rosic.core.fleet.task import Task, TaskNeed
from rosic.core.message import Button, ChatKind
from rosic.core.order import OrderEnding, Outcome
from rosic.features.fleet.task_parser import given_again, read_wish
from rosic.organiser.timezones import zone_named
from rosic.robots.memory import MemoryRobot
from rosic.stores.memory import MemoryStore
from rosic.testing.clock import ManualClock
from tests.features.media.media_gateway import Sketcher, booth
from tests.gateway.place import ADA, BO, STRANGER, VI, Place, line_by_line

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rosic.contracts.robot import Tell
    from rosic.core.message import Outbound
    from rosic.core.order import Order

ROW = ["Again", "Back", "Menu"]


def _labels(shown: Outbound) -> list[list[str]]:
    return [[button.label for button in row] for row in shown.buttons]


class Ends(MemoryRobot):
    """Ends as it was told to, once its time is over."""

    ending = OrderEnding.DONE

    async def execute(self, order: Order, tell: Tell) -> Outcome:
        """Do it, and say something of it."""
        await super().execute(order, tell)
        return Outcome(self.ending)


class EndsPlace(Place):
    """Whose robots do."""

    kind = Ends


@pytest.mark.parametrize("ending", list(OrderEnding))
async def test_every_end_has_them_and_no_stop(ending: OrderEnding) -> None:
    async with EndsPlace().open() as place:
        robot = place.robot("omni")
        assert isinstance(robot, Ends)
        robot.work_s, robot.ending = 10_000.0, ending
        await place.say("omni move 1 m")
        assert _labels(place.last()[1]) == [["STOP"]]
        robot.finish()
        await place.quiet()
        assert _labels(place.last()[1]) == [ROW]


async def test_where_something_draws_there_is_a_picture_to_see() -> None:
    place = booth(Sketcher())
    async with place.open():
        place.prepare()
        await place.say("omni move 1 m")
        assert _labels(place.last()[1]) == [["Again", "Back", "Picture", "Menu"]]
        picture, under = place.button("Picture")
        before = len(place.chat.told)
        place.chat.tap(picture, under=under, account=ADA)
        shown = await place.shown(before)
        assert shown.attachment is not None
        assert place.acted() == 1, "and nothing moves of it"
        await place.say("kuka1 wave")
        assert _labels(place.last()[1]) == [ROW], "of a robot that shows nothing"


@pytest.mark.parametrize("word", ["stop", "cancel"])
async def test_what_was_stopped_or_called_off_has_them_too(word: str) -> None:
    async with Place().open() as place:
        place.robot("omni").work_s = 10_000.0
        await place.say("omni move 1 m")
        message = place.last()[0]
        await place.say(word)
        await place.clock.advance(3.0)
        await place.quiet()
        assert _labels(place.chat.shown(message)) == [ROW]


async def test_again_asks_with_the_same_values_and_moves_once() -> None:
    async with Place().open() as place:
        await place.say("omni move 2 m left")
        again, under = place.button("Again")
        await place.tap(again, under)
        assert place.last()[1].text == "omni: move, 2.00 m left?"
        assert place.last()[0] != under
        assert place.acted() == 1
        do_it, asked = place.button("Do it")
        await place.tap(do_it, asked)
        await place.tap(do_it, asked)
        assert place.acted() == 2
        assert "done" in place.chat.shown(under).text, "how it ended stays where it is"


async def test_again_means_the_order_that_it_stands_under() -> None:
    async with Place().open() as place:
        await place.say("omni move 2 m left")
        older = place.button("Again")
        await place.say("use kuka1")
        await place.say("wave")
        await place.tap(*older)
        assert place.last()[1].text == "omni: move, 2.00 m left?"
        await place.tap(*next(_tappable(place, "Again", "kuka1: wave")))
        assert place.last()[1].text == "kuka1: wave?"


def _tappable(place: Place, label: str, text: str) -> Iterator[tuple[Button, str]]:
    for told in reversed(place.chat.told):
        shown = place.chat.shown(told.message)
        for row in shown.buttons:
            for button in row:
                if button.label == label and text in shown.text:
                    yield button, told.message


async def test_they_are_good_for_as_long_as_they_are_shown_and_more_than_once() -> None:
    async with Place().open() as place:
        await place.say("omni move 2 m")
        again, under = place.button("Again")
        menu, _ = place.button("Menu")
        await place.clock.advance(90_000.0)
        await place.quiet()
        for _ in range(2):
            assert "Which robot?" in await place.tap(menu, under)
            assert "omni: move, 2.00 m forward?" in await place.tap(again, under)
        assert "Its name may be left out now." in await place.tap(*place.button("Back"))
        assert place.acted() == 1


async def test_whoever_taps_is_who_asks_and_is_checked() -> None:
    async with Place().open() as place:
        await place.say("omni move 2 m", chat="g", kind=ChatKind.GROUP)
        again, under = place.button("Again")
        place.chat.tap(again, under=under, account=VI)
        await place.quiet()
        do_it, asked = place.button("Do it")
        place.chat.tap(do_it, under=asked, account=VI)
        await place.quiet()
        assert place.acted() == 1, "a viewer may ask, and is refused"
        place.chat.tap(again, under=under, account=STRANGER)
        await place.quiet()
        assert place.acted() == 1
        place.chat.tap(again, under=under, account=BO)
        await place.quiet()
        do_it, asked = place.button("Do it")
        place.chat.tap(do_it, under=asked, account=ADA)
        await place.quiet()
        assert place.acted() == 1, "the question is Bo's"
        await place.say("/end omni")
        place.chat.tap(do_it, under=asked, account=BO)
        await place.quiet()
        assert place.acted() == 2


@pytest.mark.parametrize(
    "forged",
    [
        "=omni move 1 m",
        "=!omni move 1 m",
        "=>omni move 1 m",
        "=use omni\nomni move 1 m",
        "=help\x1f!omni move 1 m",
        "=/grant bo operator",
        "=resume omni",
        "=",
    ],
)
async def test_nothing_else_can_be_asked_for_that_way(forged: str) -> None:
    async with Place().open() as place:
        await place.say("stop")
        await place.say("resume all")
        told = await place.tap(Button("Again", forged, forged), place.last()[0])
        assert place.acted() == 0
        assert told == ""
        assert place.chat.answers[-1][1] == "This button is no longer good. Nothing was done."


async def test_a_line_too_long_for_a_button_is_asked_by_whoever_said_it_last() -> None:
    long = "omni move direction=forward distance=1.23456789012345678901234567890 m"
    assert open_button("Again", f"?{long}") is None
    async with Place().open() as place:
        await place.say(long)
        again, under = place.button("Again")
        assert again.command == "again"
        assert "omni: move, 1.235 m forward?" in await place.tap(again, under)


async def test_what_is_carried_fits_into_every_messenger() -> None:
    assert is_open("?" + "ä" * 40)
    assert open_button("Again", "?" + "ä" * 40) is None
    fits = open_button("Again", "?" + "a" * (CARRIED_BYTES - 2))
    assert fits is not None
    assert len(fits.nonce.encode()) == CARRIED_BYTES


async def test_several_robots_are_asked_about_together() -> None:
    async with Place().open() as place:
        await place.say("/together cf1+cf2 wave")
        await place.clock.advance(3.0)
        await place.quiet()
        await place.tap(*place.button("Again"))
        assert place.last()[1].text == "cf1, cf2: wave?"
        acted = place.acted("cf1")
        await place.tap(*place.button("Do it"))
        await place.clock.advance(3.0)
        await place.quiet()
        assert (acted, place.acted("cf1"), place.acted("cf2")) == (1, 2, 2)


async def test_a_group_goes_back_to_its_robots() -> None:
    async with Place().open() as place:
        await place.say("swarm wave")
        await place.clock.advance(3.0)
        await place.quiet()
        await place.tap(*place.button("Back"))
        assert [b.label for row in place.last()[1].buttons for b in row] == ["cf1", "cf2"]


async def test_where_nothing_can_be_edited_the_last_line_has_them() -> None:
    async with Place(chat=line_by_line).open() as place:
        await place.say("omni move 1 m")
        rows = [_labels(told.outbound) for told in place.chat.told]
        assert rows == [[]] * (len(rows) - 1) + [[ROW]]


async def test_what_nobody_saw_the_end_of_has_them_after_a_restart() -> None:
    store, clock = MemoryStore(), ManualClock()
    async with Place(store, clock=clock).open() as place:
        place.chat.down = True
        await place.say("omni move 1 m")
    async with Place(store, clock=clock).open() as place:
        await place.quiet()
        assert _labels(place.last()[1]) == [ROW]
        await place.tap(*place.button("Again"))
        assert place.last()[1].text == "omni: move, 1.00 m forward?"


async def test_the_end_of_a_task_has_them_and_again_gives_it_anew_once_confirmed() -> None:
    async with Place().open() as place:
        await place.say("/task omni wave priority 3")
        await place.clock.advance(5.0)
        button, under = place.button("Again")
        assert place.chat.shown(under).text == "Task 1 (wave): done by omni."
        assert _labels(place.chat.shown(under)) == [ROW]
        assert button.command == "?/task omni wave priority 3"
        assert place.acted() == 1
        await place.tap(button, under)
        assert place.last()[1].text == "Task: omni wave priority 3?"
        assert place.acted() == 1, "it is asked first"
        await place.tap(*place.button("Do it"))
        await place.clock.advance(5.0)
        assert place.acted() == 2
        assert place.last()[1].text == "Task 2 (wave): done by omni."


async def test_what_is_too_long_to_be_carried_has_no_again_that_means_something_else() -> None:
    async with Place().open() as place:
        await place.say("/task omni move 1 m then move 1 m then move 1 m then move 1 m then wave")
        await place.clock.advance(30.0)
        shown = place.last()[1]
        assert "done by omni" in shown.text
        assert _labels(shown) == [["Back", "Menu"]]


@pytest.mark.parametrize(
    ("name", "back"),
    [("swarm", ["Back"]), ("Swarm", ["Back"]), ("cf1+cf2", ["cf1", "cf2"])],
)
async def test_the_end_of_several_leads_back_to_them(name: str, back: list[str]) -> None:
    async with Place().open() as place:
        await place.say(f"/broadcast {name} wave")
        await place.clock.advance(5.0)
        assert _labels(place.last()[1]) == [["Again", *back, "Menu"]]


def test_what_gives_a_task_anew_says_all_that_was_asked_of_it() -> None:
    line = "omni move 1 m then wave priority 3 battery 30 localised once within 300 s"
    wish = read_wish(line, 0, zone_named("UTC"))
    task = Task(
        id="1",
        author=ADA,
        among=("omni",),
        wanted="omni",
        steps=2,
        skills=("move", "wave"),
        priority=wish.priority,
        given_ns=0,
        expected_ns=int(wish.expected_s * 1e9),
        once=wish.once,
        need=TaskNeed(wish.battery, wish.localised),
    )
    assert given_again(task, wish.lines(1)) == f"/task {line}"
    anew = given_again(replace(task, wanted=""), ("wave",))
    anybody = read_wish(anew.removeprefix("/task "), 0, zone_named("UTC"))
    assert anybody.words == ["any", "wave"]
    assert (anybody.priority, anybody.battery, anybody.once) == (3, 30.0, True)


def test_a_condition_of_a_task_holds_though_its_word_stands_in_a_step_as_well() -> None:
    wish = read_wish("omni wave once then wave localised once", 0, zone_named("UTC"))
    assert (wish.words, wish.once, wish.localised) == (
        ["omni", "wave", "once", "then", "wave"],
        True,
        True,
    )
