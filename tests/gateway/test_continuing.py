"""``continue`` undoes a stop of one's own, and nothing that somebody else has stopped as well."""

from __future__ import annotations

import msgspec
import pytest
from msgspec.structs import replace

from rosic.core.message import Chat, ChatKind
from rosic.core.stop_registry import StopRegistry, not_known_yet
from rosic.gateway.stopped_by import StoppedBy, restore, stopped_by
from tests.gateway.place import ADA, BO, Place


def _latched(place: Place) -> list[str]:
    return [name for name, robot in place.gateway.robots.items() if robot.gate.latched]


def _labels(place: Place) -> list[str]:
    return [button.label for row in place.last()[1].buttons for button in row]


async def test_ones_own_stop_covers_nobody_elses_and_continue_does_not_undo_theirs() -> None:
    async with Place().open() as place:
        await place.say("stop omni", account=BO, chat=BO)
        await place.clock.advance(120)
        await place.say("stop omni")
        told = await place.say("continue")
        assert told.startswith("omni is stopped, by Bo and you, since 22:13. It stays stopped")
        assert (_latched(place), _labels(place)) == (["omni"], ["Resume omni"])
        assert await place.say("resume omni") == "omni is ready again.", "that is said of it"
        await place.say("stop omni")
        await place.say("stop omni")
        assert await place.say("continue") == "omni is ready again.", "Bo's was over"


async def _in_group(place: Place, text: str, *, addressed: bool = False) -> str:
    """Have Ada say something in a group, to us or to others; return what was told."""
    before = len(place.chat.told)
    await place.clock.advance(0.001)
    inbound = place.chat._inbound(ADA, Chat("memory", "g", ChatKind.GROUP), None, None)
    place.chat.deliver(replace(inbound, text=text, addressed=addressed))
    await place.quiet()
    return "\n".join(told.outbound.text for told in list(place.chat.told)[before:])


CHATTER = ["weiter", "continue please", "weiter bitte wieder"]


@pytest.mark.parametrize("word", CHATTER)
async def test_what_is_said_to_others_in_a_group_resumes_nothing_and_is_offered(word: str) -> None:
    async with Place().open() as place:
        await place.say("stop omni")
        told = await _in_group(place, word)
        assert told.startswith("omni is stopped, by you, since 22:13. It stays stopped until you")
        assert (_latched(place), _labels(place)) == (["omni"], ["Resume omni"])
        assert await _in_group(place, word, addressed=True) == "omni is ready again."


@pytest.mark.parametrize("word", ["/continue", "omni weiter", "weiter omni"])
async def test_in_a_group_it_is_meant_where_it_is_a_command_or_names_the_robot(word: str) -> None:
    async with Place().open() as place:
        await place.say("stop omni")
        assert await _in_group(place, word) == "omni is ready again."


@pytest.mark.parametrize("word", [*CHATTER, "weiter so", "continue with the talk"])
async def test_chatter_of_whom_nothing_waits_is_not_answered(word: str) -> None:
    async with Place().open() as place:
        await place.say("stop omni", account=BO, chat=BO)
        assert await _in_group(place, word) == ""
        await place.say("stop omni")
        assert (await _in_group(place, word) == "") is (word not in CHATTER)
        assert _latched(place) == ["omni"]


@pytest.mark.parametrize("word", ["resume", "resume please", "resume all", "freigeben"])
async def test_a_resume_that_may_be_said_to_others_is_asked_about(word: str) -> None:
    async with Place().open() as place:
        for chosen in (False, True):
            if chosen:
                await _in_group(place, "use omni")
            await place.say("stop omni")
            await place.say("/task omni wave")
            acted = place.acted()
            told = await _in_group(place, word)
            assert told.startswith("omni is stopped, by you, since 22:13. It stays stopped until")
            await place.clock.advance(3.0)
            assert (_latched(place), _labels(place)) == (["omni"], ["Resume omni"])
            assert place.acted() == acted
            told = await place.tap(*place.button("Resume omni"))
            assert told.startswith("omni is ready again.")


@pytest.mark.parametrize(
    ("word", "addressed"),
    [("resume", True), ("/resume", False), ("omni resume", False), ("resume omni", False)],
)
async def test_a_resume_that_is_said_to_us_or_names_the_robot_is_done(
    word: str,
    addressed: bool,
) -> None:
    async with Place().open() as place:
        await place.say("stop omni")
        assert await _in_group(place, word, addressed=addressed) == "omni is ready again."


async def test_several_that_are_stopped_are_asked_about_one_by_one_in_a_group_too() -> None:
    async with Place().open() as place:
        await place.say("stop omni")
        await place.say("stop cf1")
        await _in_group(place, "resume all")
        assert _latched(place) == ["omni", "cf1"]


async def test_a_chosen_robot_is_not_named_by_it() -> None:
    async with Place().open() as place:
        await _in_group(place, "use omni")
        await place.say("stop omni")
        await _in_group(place, "weiter")
        assert _latched(place) == ["omni"]


async def test_paused_tasks_do_not_go_on_by_what_is_said_to_others() -> None:
    async with Place().open() as place:
        place.robot("omni").work_s = 10_000.0
        await place.say("/task omni move 1 m")
        await place.clock.advance(1.0)
        await place.say("pause")
        await place.clock.advance(3.0)
        acted = place.acted()
        told = await _in_group(place, "weiter")
        assert told == "Task 1 stays paused until you continue it."
        await place.clock.advance(3.0)
        assert place.acted() == acted
        assert _labels(place) == ["Continue"]
        assert "Task 1 goes on." in await place.tap(*place.button("Continue"))
        await place.clock.advance(3.0)
        assert place.acted() == acted + 1


async def test_where_a_task_would_begin_by_itself_it_is_asked_first() -> None:
    async with Place().open() as place:
        await place.say("stop omni")
        await place.say("/task omni wave")
        for word in ("continue", "continue omni"):
            told = await place.say(word)
            assert told == (
                "omni is stopped, by you, since 22:13. It stays stopped until you resume it. "
                "Nothing was done.\n"
                "It moves by itself as soon as it is given a task that waits: 1."
            )
            assert _labels(place) == ["Resume omni: task 1 goes on"]
        await place.clock.advance(3.0)
        assert (_latched(place), place.acted()) == (["omni"], 0)
        told = await place.tap(*place.button("Resume omni: task 1 goes on"))
        assert told.startswith("omni is ready again.\nIt moves by itself")
        await place.clock.advance(3.0)
        assert place.acted() == 1


async def test_it_is_known_after_a_restart_whether_somebody_else_has_stopped_it() -> None:
    found = {"omni": (2, True), "kuka1": (1, True), "cf1": (1, True)}
    stops = StopRegistry(found, {}, not_known_yet())
    stops.stop("omni", "p2", 5)
    for robot in stops:
        stops.stop(robot, "p1", 7)
    facts = [stopped_by(robot, stops) for robot in stops]
    before = msgspec.to_builtins(StoppedBy(1, "p1", 7))
    del before["stoppers"]  # as versions wrote it that did not keep them
    facts[2] = replace(facts[2], body=msgspec.msgpack.encode(before))
    later = StopRegistry(found, found, not_known_yet())
    assert not any(entry.alone("p1") for entry in later.values())
    restore(later, facts)
    assert later["omni"].stoppers == {"p2": 5, "p1": 7}
    assert [later[robot].alone("p1") for robot in found] == [False, True, False]
    later.stop("kuka1", "p2", 9)
    assert not later["kuka1"].alone("p1")
