"""Asking for a right one lacks, over the real way: who is told, who answers, what it gives."""

from __future__ import annotations

from typing import TYPE_CHECKING

from tests.journeys.fleet import Person
from tests.journeys.lab import Lab, lab
from tests.journeys.test_stepping import answer, asked, press

if TYPE_CHECKING:
    from pathlib import Path

    from tests.journeys.running import Launcher

QUESTION = "Vi asks for hop on Ant, for 1 h. Do you allow it?"


class People:
    """A viewer and a second admin, besides Ada and Bo."""

    def __init__(self, place: Lab, vi: int, eve: int) -> None:
        self.place = place
        self.vi = vi
        self.eve = eve


async def people(place: Lab) -> People:
    """Open two more accounts, and write them into the configuration."""
    vi, eve = (
        await place.control.create_user("Vi"),
        await place.control.create_user("Eve"),
    )
    text = place.config.read_text()
    for person in (Person(vi, "Vi", "viewer"), Person(eve, "Eve", "admin")):
        text += (
            f'\n[[principal]]\nname = "{person.name}"\naddress = "telegram:{person.account}"\n'
            f'role = "{person.role}"\n'
        )
    place.config.write_text(text)
    return People(place, vi, eve)


async def said_to(place: Lab, chat: int, text: str) -> bool:
    """Whether a chat was told something so far."""
    return any(text in m["text"] for m in await place.control.messages(chat, by_bot=True))


async def test_a_right_is_asked_for_by_a_tap_and_given_by_another_person(
    tmp_path: Path, launcher: Launcher
) -> None:
    async with lab(tmp_path, launcher) as place:
        who = await people(place)
        await place.start()

        refused = await place.ask(who.vi, "ant hop", "needs the right")
        assert "Ada or Eve can give it" in refused["text"]
        assert await press(place, who.vi, "Ask for it") == ""
        await place.reads(who.vi, "I have asked Ada or Eve: hop on Ant, for 1 h.")
        for admin in (place.ada, who.eve):
            await place.reads(admin, QUESTION)
        assert not await said_to(place, place.bo, "Vi")
        late = await asked(place, place.ada, "Allow 1 h")

        assert await press(place, who.eve, "Allow 1 h") == ""
        await place.reads(who.eve, "Vi may now: hop on Ant, until ")
        await place.reads(place.ada, "Eve allowed Vi: hop on Ant, until ")
        await place.reads(who.vi, "Eve allows it. You may now: hop on Ant, until ")
        await place.ask(who.vi, "ant hop", "done ")
        assert place.acted("ant") == 1
        await place.ask(who.vi, "cat hop", "needs the right")
        await place.ask(who.vi, "/me", "hop on ant, until ")
        await place.ask(place.ada, "/people", "Vi · viewer; hop on ant, until ")

        await place.control.tap(place.ada, place.ada, late["message_id"], "No")
        await place.reads(place.ada, "Eve allowed that already. Nothing was done.")
        await place.ask(who.vi, "ant hop", "done ")
        await place.ask(who.vi, "/ask cat hop", "I have asked")
        assert await press(place, place.ada, "No") == ""
        await place.reads(who.vi, "Ada does not allow it: hop on Cat, for 1 h. You can ask again")
        await place.ask(who.vi, "/ask cat hop", "The answer to that was no.")
        await place.drained()
        assert place.acted() == 2
        assert await place.control.violations() == []


async def test_an_answer_outlives_a_gap_in_listening(tmp_path: Path, launcher: Launcher) -> None:
    async with lab(tmp_path, launcher) as place:
        who = await people(place)
        gateway = await place.start()
        await place.ask(who.vi, "/ask ant hop", "I have asked")
        question = await asked(place, place.ada, "Allow 1 h")
        await place.ask(place.bo, "/use bee", "Its name may be left out now.")
        assert await press(place, place.bo, "Hop") == ""
        motion = await asked(place, place.bo, "Do it")
        await place.control.fail("hang", "getUpdates", seconds=6.0)
        assert await place.until(place.hangs)
        moves = await place.control.tap(place.bo, place.bo, motion["message_id"], "Do it")
        allows = await place.control.tap(place.ada, place.ada, question["message_id"], "Allow 1 h")
        assert await gateway.says("lab: listening", times=2)
        assert "too old" in await answer(place, moves)
        assert await answer(place, allows) == ""
        await place.reads(who.vi, "Ada allows it. You may now: hop on Ant")
        await place.drained()
        assert place.acted() == 0, "what was asked before the gap moves nothing"
        await place.ask(who.vi, "ant hop", "done ")


async def test_after_a_restart_a_dead_button_shows_the_question_anew(
    tmp_path: Path, launcher: Launcher
) -> None:
    async with lab(tmp_path, launcher) as place:
        who = await people(place)
        gateway = await place.start()
        await place.ask(who.vi, "/ask cat hop", "I have asked")
        question = await asked(place, who.eve, "Allow 1 h")
        gateway.kill()
        dead = await place.control.tap(who.eve, who.eve, question["message_id"], "Allow 1 h")
        await place.start()
        assert "no longer good" in await answer(place, dead)
        await place.reads(who.eve, "Or write: /approve Vi, or /decline Vi")
        await place.ask(who.vi, "cat hop", "needs the right")
        assert await press(place, who.eve, "Allow Vi 1 h") == ""
        await place.reads(who.vi, "Eve allows it. You may now: hop on Cat")
        await place.ask(who.vi, "cat hop", "done ")
        await place.drained()
        assert place.acted() == 1


async def test_what_was_given_for_some_seconds_ends_and_says_so(
    tmp_path: Path, launcher: Launcher
) -> None:
    async with lab(tmp_path, launcher) as place:
        who = await people(place)
        await place.start()
        await place.ask(place.ada, "/grant Vi operator ant for 10 s", "Vi has been told: operator")
        await place.reads(who.vi, "Ada gave you: operator on ant, until ")
        await place.ask(who.vi, "ant hop", "done ")
        await place.reads(who.vi, "Your right has ended: operator on ant.")
        await place.ask(who.vi, "ant hop", "needs the right")
        assert place.acted() == 1
