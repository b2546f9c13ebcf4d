"""What was sent while nobody listened."""

from __future__ import annotations

import re
from functools import partial
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import pytest

from rosic.gateway.delivery.catch_up import QUIET_S
from rosic.messengers.telegram.polling import CONFIRMED_EARLY
from rosic.stores.stop_latch import FileLatch
from tests.journeys.fleet import ROBOTS
from tests.journeys.lab import Lab, lab
from tests.journeys.record import refused_as
from tests.pace import patience

if TYPE_CHECKING:
    from pathlib import Path

    from tests.journeys.running import Launcher

SUMMARY = re.compile(
    r"While I could not listen, (\d+) commands came in here. None of them was carried out."
)
HOUR_S = 3600.0
CHATS = 40
SAID_TOGETHER = 25
OLD = "Your command is 60 minutes old: you sent it while I could not listen. Nothing was done."
UNHEARD = "You sent this while I could not listen. Nothing was done."


@pytest.mark.limit(400)
async def test_two_thousand_old_messages_move_nothing_and_stops_among_them_are_applied(
    tmp_path: Path, launcher: Launcher
) -> None:
    async with lab(tmp_path, launcher) as place:
        (await place.start()).kill()
        members = [place.ada, place.bo]
        rooms = [
            await place.control.create_chat("supergroup", f"Room {n}", members=members)
            for n in range(CHATS)
        ]
        for number, room in enumerate(rooms):
            robot = ROBOTS[number % len(ROBOTS)]
            await place.control.backlog(room, place.bo, f"{robot} hop", 50, age_s=HOUR_S)
            if number in {7, 21}:
                await place.say(place.bo, f"stop {robot}", chat=room, age_s=HOUR_S)
        await place.say(place.ada, "resume cat", age_s=HOUR_S)
        await place.say(place.bo, "bee hop", chat=rooms[0])
        assert await place.control.pending() >= 2004

        gateway = await place.start(listens=False)
        took_s = await gateway.listens(180)

        assert took_s < 60 * patience()
        await place.drained()
        assert place.acted() == 0
        assert refused_as(place.data, "expired") == 2002  # with the resume, and the fresh one
        stopped = {ROBOTS[7 % 5], ROBOTS[21 % 5]}
        assert {robot for robot in ROBOTS if place.counter.stops(robot)} == stopped
        latch = FileLatch(place.data / "stops")
        assert {robot for robot, (_, latched) in latch.read().items() if latched} == stopped
        await latch.close()

        await _goes_on(place, stopped)


async def _goes_on(place: Lab, stopped: set[str]) -> None:
    """Fresh commands work after a resume, and only then."""
    await place.ask(place.bo, "ant hop", "done ")
    robot = min(stopped)
    await place.ask(place.bo, f"{robot} hop", "is stopped")
    await place.ask(place.ada, f"resume {robot}", "is ready again.")
    await place.ask(place.bo, f"{robot} hop", "done ")
    assert place.acted() == 2


@pytest.mark.limit(400)
async def test_old_commands_are_answered_with_the_same_command_on_offer(
    tmp_path: Path, launcher: Launcher
) -> None:
    async with lab(tmp_path, launcher) as place:
        # What is fresh stays so, however long the start takes.
        profile = place.folder / "ant.yaml"
        text = profile.read_text()
        profile.write_text(text.replace("class: motion", "class: motion\n    lifetime_s: 600"))
        (await place.start()).kill()
        old = await place.say(place.bo, "ant hop", age_s=HOUR_S)
        young = await place.say(place.bo, "ant hop 2 m")

        await place.start()

        answer = await place.reads(place.bo, OLD, to=old)
        assert answer["buttons"][0][0]["text"] == "ant hop"
        await place.reads(place.bo, UNHEARD, to=young)
        assert place.acted() == 0
        await place.control.tap(place.bo, place.bo, answer["message_id"], "ant hop")
        assert await place.counter.wait_for(1, 60)


@pytest.mark.limit(400)
async def test_a_backlog_keeps_nobody_waiting_for_the_answer_to_something_fresh(
    tmp_path: Path, launcher: Launcher
) -> None:
    async with lab(tmp_path, launcher) as place:
        (await place.start()).kill()
        await place.control.backlog(place.bo, place.bo, "ant hop", 200, age_s=HOUR_S)
        await place.control.backlog(place.bo, place.bo, "ant hop {n} m", 5, age_s=HOUR_S)

        await place.start()

        await place.drained()
        await place.ask(place.bo, "ant hop", "done ")
        told = await summaries(place, place.bo, 205)
        assert len(told) == 1 or await paused(place)
        [summary] = [one for one in told if "4 m" in str(one["buttons"])]
        assert [row[0]["text"] for row in summary["buttons"]] == [
            "ant hop 3 m",
            "ant hop 4 m",
            "ant hop 5 m",
        ]
        assert len(await place.control.messages(place.bo, by_bot=True)) == 1 + len(told)
        await place.control.tap(place.bo, place.bo, summary["message_id"], "ant hop 4 m")
        assert await place.counter.wait_for(2, 60)


@pytest.mark.limit(400)
@pytest.mark.parametrize(
    "many", [5_000, pytest.param(100_000, marks=[pytest.mark.campaign, pytest.mark.limit(900)])]
)
async def test_a_day_of_outage_is_drained_within_a_minute(
    tmp_path: Path, launcher: Launcher, many: int
) -> None:
    async with lab(tmp_path, launcher) as place:
        (await place.start()).kill()
        rooms = [
            await place.control.create_chat("supergroup", f"Room {n}", members=[place.bo])
            for n in range(CHATS)
        ]
        each = many // CHATS
        for hour in range(each // SAID_TOGETHER):  # people talk at the same time, in many rooms
            age_s = 20 * HOUR_S * (1 - hour / each * SAID_TOGETHER)
            for number, room in enumerate(rooms):
                text = f"{ROBOTS[number % len(ROBOTS)]} hop"
                await place.control.backlog(room, place.bo, text, SAID_TOGETHER, age_s=age_s + 60)
            if hour == 2:
                await place.say(place.bo, "stop cat", chat=rooms[7], age_s=age_s)

        gateway = await place.start(listens=False)
        took_s = await gateway.listens(600)

        print(f"{many} updates: {took_s:.1f} s")  # noqa: T201 - a figure for whoever runs the campaign
        assert took_s < 60 * patience(), f"{many} updates took {took_s:.0f} s"
        assert place.acted() == 0
        assert len(place.counter.stops("cat")) == 1
        for room in rooms:
            told = await summaries(place, room, each)
            assert len(told) == 1 or await paused(place)
        assert refused_as(place.data, "expired") == each * CHATS


async def summaries(place: Lab, chat: int, many: int) -> list[dict[str, Any]]:
    """Wait until a chat was told of so many commands together; return what it was told."""
    found: list[dict[str, Any]] = []

    async def all_told() -> bool:
        shown = await place.control.messages(chat, by_bot=True)
        found[:] = [one for one in shown if SUMMARY.match(one["text"])]
        return told_of(found) >= many

    assert await place.until(all_told, 180), [one["text"] for one in found]
    assert told_of(found) == many
    return found


@pytest.mark.limit(180)
async def test_killed_again_and_again_while_it_drains_nothing_is_lost_and_nothing_moves(
    tmp_path: Path, launcher: Launcher
) -> None:
    """What was confirmed to Telegram was on disk: every command has its refusal, once.

    But for what the log calls confirmed before that, on a disk that takes long: no more is lost.
    """
    many, rooms = 3_000, 4
    async with lab(tmp_path, launcher) as place:
        (await place.start()).kill()
        for number in range(rooms):
            room = await place.control.create_chat("group", f"Room {number}", members=[place.bo])
            await place.control.backlog(room, place.bo, "ant hop", many // rooms, age_s=HOUR_S)
        left = many
        while left > many // 3:
            gateway = await place.start(listens=False)
            assert await place.until(partial(_fewer, place, left), 60)
            gateway.kill()
            left = await place.control.pending()
        gateway = await place.start(listens=False)
        await gateway.listens(90)
        await place.drained()
        assert many - early(place) <= refused_as(place.data, "expired") <= many
        assert place.acted() == 0


def early(place: Lab) -> int:
    """Return how many messages the log calls confirmed before they were on disk."""
    log = (place.folder / "gateway.log").read_text(errors="replace")
    return sum(int(many) for many in re.findall(rf"{CONFIRMED_EARLY}: (\d+)", log))


async def _fewer(place: Lab, than: int) -> bool:
    return await place.control.pending() < than


def told_of(summaries: list[dict[str, Any]]) -> int:
    """Return of how many commands these messages tell."""
    return sum(int(number) for one in summaries for number in SUMMARY.findall(one["text"]))


async def paused(place: Lab) -> bool:
    """Whether this machine is so slow that what had piled up came with pauses: told in parts."""
    came = await place.control.call("changes", kinds=["delivered"])
    times = [one["time_s"] for one in came if len(one["update_ids"]) > 1]
    return any(later - sooner > QUIET_S / 2 for sooner, later in pairwise(times))


@pytest.mark.limit(400)
async def test_a_resume_sent_before_a_stop_does_not_undo_it(
    tmp_path: Path, launcher: Launcher
) -> None:
    async with lab(tmp_path, launcher) as place:
        gateway = await place.start()
        await place.say(place.bo, "stop ant")
        await place.reads(place.bo, "STOP: Ant at rest")
        gateway.kill()
        resume = await place.say(place.ada, "resume ant")
        await place.say(place.bo, "stop ant")

        await place.start()

        await place.reads(place.ada, "Nothing was done.", to=resume)
        await place.ask(place.bo, "ant hop", "is stopped")
        assert place.acted() == 0


async def test_a_resume_that_a_stop_overtakes_does_not_undo_it(
    tmp_path: Path, launcher: Launcher
) -> None:
    async with lab(tmp_path, launcher) as place:
        await place.start()
        await place.say(place.bo, "stop ant")
        await place.reads(place.bo, "STOP: Ant at rest")
        # Too short for a gap, long enough for both to come in one answer: stops are taken first.
        await place.control.fail("hang", "getUpdates", seconds=1.5)
        assert await place.until(place.hangs)
        resume = await place.say(place.ada, "resume ant")
        await place.say(place.bo, "stop ant")

        await place.reads(place.ada, "Ant was stopped after you sent this.", to=resume)

        await place.ask(place.bo, "ant hop", "is stopped")
        assert place.acted() == 0
