"""Whoever stops their own order may let its robot go on again; every answer to a stop offers it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from rosic.app.people import ConfiguredPerson
from rosic.core.identity import Address
from rosic.core.message import ChatKind
from rosic.core.policy.roles import DEFAULT_ROLES, Role, RoleRules
from rosic.core.stop_registry import StopRegistry, not_known_yet
from rosic.gateway.stopped_by import restore, stopped_by
from tests.gateway.place import ADA, BO, PEOPLE, VI, Place

if TYPE_CHECKING:
    from rosic.core.message import Button

STU, TOM = "4", "5"
MAY_NOT = "Resume needs the right"


class School(Place):
    """A student may move omni and cf1, and resume nothing."""

    people = (
        *PEOPLE,
        ConfiguredPerson("Stu", (Address("memory", STU),), ("student",)),
        ConfiguredPerson("Tom", (Address("memory", TOM),), ("student",)),
    )
    rulebook = RoleRules(
        roles={
            **DEFAULT_ROLES,
            "student": Role(scopes=("*:read", "omni:move", "cf1:move", "cf2:move", "kuka1:wave")),
        }
    )


def _latched(place: Place) -> list[str]:
    return [name for name, robot in place.gateway.robots.items() if robot.gate.latched]


def _labels(place: Place) -> list[str]:
    return [button.label for row in place.last()[1].buttons for button in row]


async def _drive(place: Place, robot: str = "omni") -> str:
    """Let the student drive; return the message that shows it."""
    place.robot(robot).work_s = 10_000.0
    await place.say(f"{robot} move 1 m", account=STU, chat=STU)
    return place.last()[0]


async def _tap(place: Place, found: tuple[Button, str], account: str = STU) -> str:
    await place.clock.advance(0.001)
    return await place.tap(*found, account=account)


async def test_the_stop_beneath_ones_own_order_offers_to_resume_and_may_be_resumed() -> None:
    async with School().open() as place:
        await _drive(place)
        told = await _tap(place, place.button("STOP"))
        assert "STOP: omni at rest" in told
        assert _latched(place) == ["omni"]
        assert await _tap(place, place.button("Resume omni")) == "omni is ready again."
        assert _latched(place) == []


async def test_stop_in_reply_to_ones_own_order_may_be_resumed() -> None:
    async with School().open() as place:
        message = await _drive(place)
        await place.say("stop", answers=message, account=STU, chat=STU)
        assert _latched(place) == ["omni"]
        assert await place.say("resume", account=STU, chat=STU) == "omni is ready again."


async def test_a_stop_of_everything_stays_though_ones_own_robot_is_among_it() -> None:
    async with School().open() as place:
        await _drive(place)
        told = await place.say("stop", account=STU, chat=STU)
        assert told.endswith(
            "cf2 at rest (0.00 s).\nAda or Bo can resume omni, kuka1, cf1 and cf2."
        )
        assert _labels(place) == [
            "Ask to resume omni",
            "Ask to resume kuka1",
            "Ask to resume cf1",
            "Ask to resume cf2",
        ]
        assert MAY_NOT in await place.say("resume omni", account=STU, chat=STU)
        assert "omni" in _latched(place)


async def test_the_stop_beneath_somebody_elses_order_stays() -> None:
    async with School().open() as place:
        message = await _drive(place)
        await place.say("stop", answers=message, account=TOM, chat=STU)
        assert _labels(place) == ["Ask for it"]
        assert MAY_NOT in await place.say("resume omni", account=TOM, chat=STU)
        assert MAY_NOT in await place.say("resume omni", account=STU, chat=STU), "Tom stopped it"


async def test_what_others_stopped_besides_is_not_ones_own() -> None:
    async with School().open() as place:
        await _drive(place)
        people = place.gateway.rooms.authoriser.directory
        ([vi], [stu]) = people.named("Vi"), people.named("Stu")
        place.gateway.stop_lane.stop_robots(("omni",), vi.id)
        place.gateway.stop_lane.stop_robots(("omni",), stu.id, ("omni",))
        assert MAY_NOT in await place.say("resume omni", account=STU, chat=STU)
    async with School().open() as place:
        message = await _drive(place)
        await place.say("stop", answers=message, account=STU, chat=STU)
        await place.say("stop omni", account=VI, chat="3")
        assert MAY_NOT in await place.say("resume omni", account=STU, chat=STU)


async def test_who_may_not_move_it_any_more_may_not_resume_it() -> None:
    async with School().open() as place:
        message = await _drive(place)
        await place.say("stop", answers=message, account=STU, chat=STU)
        await place.say("/lock Stu")
        await place.say("resume omni", account=STU, chat=STU)
        assert "omni" in _latched(place)


async def test_of_a_group_only_what_carries_ones_own_order_out_is_ones_own() -> None:
    async with School().open() as place:
        place.robot("cf1").work_s = place.robot("cf2").work_s = 10_000.0
        await place.say("swarm move 1 m", account=STU, chat=STU)
        message = place.last()[0]
        await place.say("stop swarm omni", answers=message, account=STU, chat=STU)
        assert _latched(place) == ["omni", "cf1", "cf2"]
        labels = ["Resume all", "Resume cf1", "Resume cf2", "Ask to resume omni"]
        assert _labels(place) == labels
        told = await _tap(place, place.button("Resume all"))
        assert told == "cf1 is ready again. cf2 is ready again."
        assert _latched(place) == ["omni"]


async def test_whoever_may_resume_by_right_is_offered_all_that_they_stopped() -> None:
    async with School().open() as place:
        await place.say("stop omni kuka1")
        assert _labels(place) == ["Resume all", "Resume omni", "Resume kuka1"]
        told = await _tap(place, place.button("Resume all"), "1")
        assert told == "omni is ready again. kuka1 is ready again."


async def test_in_a_group_it_is_offered_to_all_and_each_tap_is_checked() -> None:
    async with School().open() as place:
        await place.say("stop omni", account=VI, chat="g", kind=ChatKind.GROUP)
        resume = place.button("Resume omni")
        assert MAY_NOT in await _tap(place, resume, VI)
        assert "omni" in _latched(place)
        assert await _tap(place, resume, "1") == "omni is ready again."
        await place.say("stop omni", account=VI, chat="g", kind=ChatKind.GROUP)
        await _tap(place, resume, "1")
        assert "omni" in _latched(place), "a button resumes once"


async def test_a_stopped_robots_menu_leads_with_resume_for_those_who_may() -> None:
    async with School().open() as place:
        await place.say("stop omni")
        await place.say("use omni")
        assert _labels(place)[0] == "Resume omni"
        await place.say("use omni", account=STU, chat=STU)
        assert "Resume omni" not in _labels(place)


async def test_who_may_not_resume_is_offered_what_they_may_do_and_hears_who_can() -> None:
    async with School().open() as place:
        await place.say("stop omni kuka1", account=STU, chat=STU)
        told = await place.say("omni move 1 m", account=STU, chat=STU)
        assert told.startswith("omni is stopped, by you, since ")
        assert told.endswith(". Ada or Bo can resume it. Nothing was done.")
        assert _labels(place) == ["Ask for it"]
        await _tap(place, place.button("Ask for it"), STU)
        asked = "I have asked Ada: resume on omni, for 1 h. You hear from me within 1 h."
        assert asked in [place.chat.shown(told.message).text for told in place.chat.told]
        told = await place.say("resume omni", account=STU, chat=STU)
        assert told.endswith("Ada can give it. It counts at once. Ada or Bo can resume it.")
        await place.say("resume", account=STU, chat=STU)
        assert not [label for label in _labels(place) if "resume" in label.casefold()]

        told = await place.say("omni move 1 m")
        assert told.endswith("It stays stopped until you resume it. Nothing was done.")
        assert _labels(place) == ["Resume omni"]


async def test_help_and_me_say_only_what_is_theirs() -> None:
    async with School().open() as place:
        for page, lacks in (("move", ("/resume",)), ("share", ("/role", "/grant", "/people"))):
            students = await place.say(f"help {page}", account=STU, chat=STU)
            admins = await place.say(f"help {page}")
            assert [command for command in lacks if f"  {command} " in students] == []
            assert all(f"  {command} " in admins for command in lacks)
        told = await place.say("/me", account=STU, chat=STU)
        assert "kuka1: wave and look; not move or resume" in told
        assert "everything" not in told
        assert ": everything" in await place.say("/me")


async def test_several_that_are_stopped_may_be_resumed_at_once() -> None:
    async with School().open() as place:
        await place.say("stop omni kuka1")
        await place.say("resume")
        assert _labels(place) == ["Resume kuka1", "Resume omni", "Resume all"]
        await _tap(place, place.button("Resume all"), "1")
        assert _latched(place) == []


async def test_it_is_known_after_a_restart_whose_own_order_was_stopped() -> None:
    stops = StopRegistry(["omni", "kuka1"], {}, not_known_yet())
    for robot in stops:
        stops.stop(robot, "p1", 7)
    stops["omni"].own = "p1"
    facts = [stopped_by(robot, stops) for robot in stops]
    later = StopRegistry(
        ["omni", "kuka1"], {"omni": (1, True), "kuka1": (1, True)}, not_known_yet()
    )
    restore(later, facts)
    assert (later["omni"].own, later["kuka1"].own) == ("p1", "")


async def test_a_button_shown_before_another_stop_does_not_undo_that_stop() -> None:
    async with Place().open() as place:
        await place.say("stop omni")
        shown = place.button("Resume omni")
        await place.say("resume omni")
        await place.clock.advance(1)
        await place.say("stop omni", account=BO)
        await place.clock.advance(5)
        told = await _tap(place, shown, ADA)
        assert told == "omni was stopped again since this was shown. It stays stopped."
        assert place.robot("omni").gate.latched
        assert await place.say("resume omni") == "omni is ready again."


async def test_the_answer_to_a_stop_says_who_can_resume_and_offers_to_ask() -> None:
    async with School().open() as place:
        told = await place.say("stop omni", account=STU, chat=STU)
        assert told.endswith("STOP: omni at rest (0.00 s).\nAda or Bo can resume it.")
        assert _labels(place) == ["Ask for it"]
        await place.clock.advance(300)
        await _tap(place, place.button("Ask for it"))
        asked = "I have asked Ada: resume on omni, for 1 h. You hear from me within 1 h."
        assert asked in [place.chat.shown(told.message).text for told in place.chat.told]
        assert _latched(place) == ["omni"]
        told = await place.say("stop omni", account=VI, chat=VI)
        assert told.endswith("\nAda or Bo can resume it."), "who moves nothing is offered nothing"
        assert _labels(place) == []
        told = await place.say("stop omni")
        assert told.endswith("STOP: omni at rest (0.00 s)."), "who may is offered just that"


async def test_a_group_that_is_stopped_is_named_whole_with_one_button() -> None:
    async with School().open() as place:
        await place.say("stop swarm")
        told = await place.say("swarm move 1 m")
        assert told == (
            "cf1 and cf2 are stopped, by you, since 22:13. They stay stopped until you resume "
            "them. Nothing was done."
        )
        assert _labels(place) == ["Resume cf1, cf2"]
        told = await place.say("swarm move 1 m", account=STU, chat=STU)
        assert told == (
            "cf1 and cf2 are stopped, by Ada, since 22:13. Ada or Bo can resume cf1 and cf2. "
            "Nothing was done."
        )
        await _tap(place, place.button("Ask for it"))
        await place.say("swarm move 1 m")
        assert await _tap(place, place.button("Resume cf1, cf2"), ADA) == (
            "cf1 is ready again. cf2 is ready again."
        )
        await place.say("stop cf2", account=BO, chat=BO)
        told = await place.say("swarm move 1 m")
        assert told.startswith("cf2 is stopped, by Bo, since ")
        await place.clock.advance(120)
        await place.say("stop cf1")
        assert (await place.say("swarm move 1 m")).startswith("cf1 and cf2 are stopped. They stay")


@pytest.mark.parametrize("word", ["continue", "weiter", "omni weiter", "weitermachen omni"])
async def test_continue_resumes_what_one_has_stopped_oneself_by_the_same_rights(word: str) -> None:
    async with School().open() as place:
        await place.say("stop omni")
        assert await place.say(word) == "omni is ready again."
        assert _latched(place) == []
        await place.say("stop omni", account=STU, chat=STU)
        assert MAY_NOT in await place.say(word, account=STU, chat=STU)
        assert (await place.say(word)).startswith("omni is stopped, by Stu, since ")
        assert _labels(place) == ["Resume omni"], "somebody else's stop is offered only"
        assert _latched(place) == ["omni"]


async def test_continue_asks_which_of_several_and_is_resumed_by_name() -> None:
    async with School().open() as place:
        await place.say("stop omni kuka1")
        told = await place.say("continue")
        assert told == "Several robots are stopped. Say which one may go on."
        assert _labels(place) == ["Resume kuka1", "Resume omni", "Resume all"]
        assert _latched(place) == ["omni", "kuka1"]
        assert await place.say("continue kuka1") == "kuka1 is ready again."
        assert await place.say("continue kuka1") == "Nothing of yours is paused."


async def test_a_button_to_continue_resumes_nothing_that_was_stopped_since() -> None:
    async with School().open() as place:
        place.robot("omni").work_s = 10_000.0
        await place.say("/task omni move 1 m")
        await place.clock.advance(1.0)
        await place.say("pause")
        go_on = place.button("Continue")
        await place.say("cancel task 1")
        await place.clock.advance(1.0)
        await place.say("stop omni")
        assert (await _tap(place, go_on, ADA)).startswith("omni is stopped, by you, since ")
        assert _latched(place) == ["omni"]


@pytest.mark.parametrize(
    "word",
    [
        "omni freigeben",
        "freigeben alle",
        "omni weitermachen lassen",
        "omni weitermachen",
        "omni weiter",
    ],
)
async def test_what_a_german_button_says_may_be_typed(word: str) -> None:
    async with School().open() as place:
        await place.say("/language de")
        await place.say("stopp omni")
        assert _labels(place) == ["omni freigeben"]
        assert await place.say(word) == "omni ist wieder bereit."
        assert await place.say("weiter") == "Von dir ist nichts pausiert."


async def test_whose_order_was_stopped_hears_who_did_and_may_resume_before_again() -> None:
    async with School().open() as place:
        place.robot("omni").work_s = 10_000.0
        await place.say("omni move 1 m")
        message = place.last()[0]
        await place.say("stop omni", account=VI, chat=VI)
        await place.clock.advance(3.0)
        await place.quiet()
        shown = place.chat.shown(message)
        assert shown.text.endswith("stopped before it ended 12:00:00: a stop by Vi")
        [again] = [b for row in shown.buttons for b in row if b.label == "Again"]
        told = await _tap(place, (again, message), ADA)
        assert told == "omni is stopped, by Vi, since 22:13.\nomni: move, 1.00 m forward?"
        assert _labels(place)[0] == "Resume omni"
        assert _labels(place)[-2:] == ["Do it", "Leave it"]
        assert await _tap(place, place.button("Resume omni"), ADA) == "omni is ready again."
        assert _latched(place) == []
        assert await _tap(place, (again, message), ADA) == "omni: move, 1.00 m forward?"
        assert place.acted("omni") == 1


async def test_who_may_not_resume_is_told_of_the_stop_and_offered_no_button() -> None:
    async with School().open() as place:
        message = await _drive(place)
        await place.say("stop omni", account=STU, chat=STU)
        await place.clock.advance(3.0)
        await place.quiet()
        assert place.chat.shown(message).text.endswith("stopped before it ended 12:00:00")
        told = await place.say("again", account=STU, chat=STU)
        assert told.startswith("omni is stopped, by you, since 22:13.\nomni: move")
        assert "Resume omni" not in _labels(place)
