"""`/ask`, its answers and `/grant`: a right for a while, by somebody else who may give it."""

from __future__ import annotations

from contextlib import asynccontextmanager
from typing import TYPE_CHECKING

import pytest
from msgspec.structs import replace

from rosic.app.people import Seed
from rosic.core.identity import Address
from rosic.core.roles import DEFAULT_ROLES, Role, Rulebook
from rosic.organiser.petitions import MOST_AN_HOUR, MOST_OPEN
from rosic.stores.memory import MemoryStore
from tests.rooms.pipeline.place import ADA, BO, VI, Place

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Mapping

    from rosic.core.message import Button, Outbound
    from rosic.testing.clock import ManualClock

EVE, TIM = "4", "5"
HOUR_S = 3_600.0
TUTOR = Role(scopes=("kuka1:*", "kuka1:grant"), priority=15)
JUNIOR = Role(scopes=("*:move",), limits=("distance <= 1 m",), priority=5)
QUESTION = "Vi asks for wave on omni, for 1 h. Do you allow it?"


class House(Place):
    """A place with a second admin, Eve, and Tim, who gives rights on kuka1 alone."""

    def __init__(
        self,
        store: MemoryStore | None = None,
        clock: ManualClock | None = None,
        roles: Mapping[str, str] | None = None,
    ) -> None:
        super().__init__(store, clock=clock)
        more = (
            Seed("Eve", (Address("memory", EVE),), ("admin",)),
            Seed("Tim", (Address("memory", TIM),), ("tutor",)),
        )
        people = tuple(
            replace(seed, roles=((roles or {}).get(seed.name, seed.roles[0]),))
            for seed in (*self._settings.people, *more)
        )
        rulebook = Rulebook(
            roles={
                **DEFAULT_ROLES,
                "tutor": TUTOR,
                "junior": JUNIOR,
                "registrar": Role(scopes=("fleet:grant",)),
            }
        )
        self.gateway._settings = replace(self._settings, people=people, rulebook=rulebook)

    async def line(self, account: str, text: str) -> str:
        """Say something in private; return what was told in that chat because of it."""
        before = len(self.chat.told)
        await self.say(text, account=account, chat=account)
        return self.told(account, before)

    def told(self, chat: str, before: int = 0) -> str:
        news = list(self.chat.told)[before:]
        return "\n".join(t.outbound.text for t in news if t.outbound.chat.id == chat)

    def newest(self, chat: str) -> Outbound:
        return next(t.outbound for t in reversed(self.chat.told) if t.outbound.chat.id == chat)

    def labels(self, chat: str) -> list[str]:
        return [button.label for row in self.newest(chat).buttons for button in row]

    def shown(self, chat: str, label: str) -> tuple[Button, str]:
        for told in reversed(self.chat.told):
            if told.outbound.chat.id == chat:
                for button in (b for row in told.outbound.buttons for b in row):
                    if button.label == label:
                        return button, told.message
        raise AssertionError(f"no button {label!r} in the chat {chat}")

    async def press(self, account: str, label: str) -> str:
        """Tap the newest button of a label in somebody's chat; return what was told there."""
        button, under = self.shown(account, label)
        return await self.press_again(account, button, under)

    async def press_again(self, account: str, button: Button, under: str) -> str:
        before = len(self.chat.told)
        await self.tap(button, under, account)
        return self.told(account, before)

    async def pass_s(self, seconds: float) -> None:
        await self.clock.advance(seconds)
        await self.quiet()


@asynccontextmanager
async def house(**roles: str) -> AsyncIterator[House]:
    place = House(roles=roles)
    async with place.open():
        yield place


async def test_a_right_is_asked_for_by_a_tap_given_by_another_and_ends() -> None:
    async with house() as place:
        told = await place.line(VI, "omni wave")
        why = 'Wave needs the right "operator" on omni.'
        assert told == f"{why} Ada or Eve can give it. It counts at once."
        told = await place.press(VI, "Ask for it")
        assert told == (
            "I have asked Ada or Eve: wave on omni, for 1 h. You hear from me within 1 h."
        )
        for admin in (ADA, EVE):
            assert place.newest(admin).text == QUESTION
            assert place.labels(admin) == ["Allow 1 h", "Allow today", "No"]
        assert not place.told(BO)
        assert not place.told(TIM), "omni is not his to give"
        await place.line(VI, "omni wave")
        assert place.acted() == 0

        told = await place.press(EVE, "Allow 1 h")
        assert told == "Vi may now: wave on omni, until 23:13. They have been told."
        assert place.newest(ADA).text == "Eve allowed Vi: wave on omni, until 23:13."
        assert place.newest(VI).text == "Eve allows it. You may now: wave on omni, until 23:13."
        await place.line(VI, "omni wave")
        assert place.acted() == 1
        refused = await place.line(VI, "omni move 1 m")
        assert refused.startswith("Move needs the right"), "nothing else was given"
        assert "wave on omni, until 23:13" in await place.line(VI, "/me")
        assert "Vi · viewer; wave on omni, until 23:13" in await place.line(ADA, "/people")

        assert await place.press(ADA, "Allow 1 h") == "Eve allowed that already. Nothing was done."
        await place.pass_s(HOUR_S + 1)
        assert place.newest(VI).text == "Your right has ended: wave on omni."
        await place.line(VI, "omni wave")
        assert place.acted() == 1
        assert "wave on omni" not in await place.line(VI, "/me")


async def test_allow_today_lasts_until_midnight() -> None:
    async with house() as place:
        await place.line(VI, "/ask omni wave")
        told = await place.press(ADA, "Allow today")
        assert told == "Vi may now: wave on omni, until tomorrow 00:00. They have been told."


async def test_a_no_is_told_and_not_asked_again_within_the_hour() -> None:
    async with house() as place:
        await place.line(VI, "/ask omni wave for 30 min")
        assert place.labels(ADA)[0] == "Allow 30 min"
        assert await place.press(ADA, "No") == "Vi is told that you do not allow it."
        assert place.newest(EVE).text == "Ada did not allow Vi: wave on omni, for 30 min."
        assert place.newest(VI).text == (
            "Ada does not allow it: wave on omni, for 30 min. You can ask again in 1 h."
        )
        before = len(place.chat.told)
        told = await place.line(VI, "/ask omni wave for 2h")
        assert told == "The answer to that was no. You can ask again in 1 h. Nothing was asked."
        assert not place.told(ADA, before)
        said = await place.press(EVE, "Allow 30 min")
        assert said == "Ada said no to that already. Nothing was done."
        await place.pass_s(HOUR_S)
        assert (await place.line(VI, "/ask omni wave")).startswith("I have asked Ada or Eve")


async def test_nobody_answers_their_own_question_and_only_who_may_give_it_answers() -> None:
    async with house() as place:
        await place.line(VI, "/ask omni wave")
        number = place.gateway.access.petitions.open()[0].id
        for account in (VI, BO, TIM):
            told = await place.line(account, f"/approve {number} 3600")
            assert told in {
                "Somebody else has to answer that. Nothing was done.",
                "That is not yours to give. Ada or Eve can. Nothing was done.",
            }
        assert not place.gateway.rooms.organiser.allows(
            place.gateway.access.petitions.open()[0].principal, "omni", "wave"
        )
        assert (await place.line(ADA, "/approve Vi for 2h")).startswith(
            "Vi may now: wave on omni, until tomorrow 00:13."
        )


async def test_who_gives_rights_and_has_none_cannot_answer_themselves() -> None:
    async with house(Vi="registrar") as place:
        await place.line(VI, "/ask omni wave")
        assert not place.told(VI).count("Do you allow it?")
        number = place.gateway.access.petitions.open()[0].id
        told = await place.line(VI, f"/approve {number} 3600")
        assert told == "Somebody else has to answer that. Nothing was done."
        await place.line(VI, "omni wave")
        assert place.acted() == 0


async def test_an_admin_asks_for_nothing_and_gives_themselves_nothing() -> None:
    async with house() as place:
        told = await place.line(ADA, "/ask omni wave")
        assert told == "That is yours already: wave on omni. Nothing was asked."
        told = await place.line(ADA, "/grant Ada senior omni for 2h")
        assert told == "Nobody gives a right to themselves. Nothing was done."


async def test_who_gives_rights_on_one_robot_is_asked_about_that_one() -> None:
    async with house() as place:
        await place.line(VI, "/ask kuka1 wave")
        assert "Vi asks for wave on kuka1" in place.newest(TIM).text
        assert (await place.press(TIM, "Allow 1 h")).startswith("Vi may now: wave on kuka1")


async def test_a_whole_robot_is_asked_for_as_the_least_role() -> None:
    async with house() as place:
        told = await place.line(VI, "/ask kuka1 for 3h")
        assert told.startswith("I have asked Ada, Eve or Tim: operator on kuka1, for 3 h.")
        assert place.labels(TIM)[0] == "Allow 3 h"
        await place.press(TIM, "Allow 3 h")
        await place.line(VI, "kuka1 move 1 m")
        assert place.acted("kuka1") == 1
        assert "operator on kuka1, until tomorrow 01:13" in await place.line(VI, "/me")


async def test_somebody_with_a_limit_asks_for_more() -> None:
    async with house(Bo="junior") as place:
        told = await place.line(BO, "omni move 2 m")
        assert "for you, move is allowed with distance <= 1 m" in told
        await place.press(BO, "Ask for it")
        assert place.newest(ADA).text.endswith(
            "Do you allow it? Without the limit that Bo has now: distance <= 1 m."
        )
        await place.press(ADA, "Allow 1 h")
        await place.line(BO, "omni move 2 m")
        assert place.acted() == 1


async def test_nobody_floods_those_who_answer() -> None:
    async with house() as place:
        before = len(place.chat.told)
        lines = ("/ask omni wave", "/ask omni move", "/ask kuka1 wave", "/ask kuka1 move")
        for line in lines[:MOST_OPEN]:
            assert (await place.line(VI, line)).startswith("I have asked")
        told = await place.line(VI, lines[0])
        assert told.startswith("I have asked that for you already.")
        for line in lines[MOST_OPEN:]:
            told = await place.line(VI, line)
            assert told.startswith("You wait for too many answers already.")
        assert place.told(ADA, before).count("Vi asks") == MOST_OPEN
        for _ in range(MOST_OPEN):
            [first, *_] = place.gateway.access.petitions.open()
            await place.line(ADA, f"/approve {first.id} 60")
        for line in ("/ask cf1 wave", "/ask cf1 move")[: MOST_AN_HOUR - MOST_OPEN]:
            assert (await place.line(VI, line)).startswith("I have asked")
        told = await place.line(VI, "/ask cf2 wave")
        assert told.startswith("You have asked often enough for now. You can ask again in ")


async def test_what_nobody_answers_expires_with_a_sentence() -> None:
    async with house() as place:
        await place.line(VI, "/ask omni wave")
        button, under = place.shown(ADA, "Allow 1 h")
        await place.pass_s(HOUR_S + 61)
        assert place.newest(VI).text == (
            "Nobody answered in time, so nothing has changed: wave on omni, for 1 h. You "
            "can ask again, or speak to Ada or Eve yourself."
        )
        assert place.newest(ADA).text == "Vi does not wait any more: wave on omni, for 1 h."
        await place.press_again(ADA, button, under)
        await place.line(VI, "omni wave")
        assert place.acted() == 0


LINES = (
    "/ask {} wave for 1h", "/ask {}", "/book {} now 1h", "/slots {}", "/wait {}", "/take over {}",
    "/end {}", "/use {}", "/help {}", "/status {}", "/resume {}", "{} wave", "{} move 1 m", "{}",
    "/wait take {}", "/wait keep {}", "/wait none {}",
)  # fmt: skip


@pytest.mark.parametrize("line", LINES)
async def test_robots_that_somebody_does_not_see_are_not_there(line: str) -> None:
    """Whatever is asked, a robot that is not theirs to see and one that is not are the same."""
    async with house(Vi="tutor") as place:
        there = await place.line(VI, line.format("omni"))
        labels = place.labels(VI)
        not_there = await place.line(VI, line.format("uxyz"))
        assert there
        assert there.replace("omni", "uxyz") == not_there
        assert [label.replace("omni", "uxyz") for label in labels] == place.labels(VI)
        assert not place.told(ADA)
        assert "cf1" not in there


@pytest.mark.parametrize("line", LINES)
async def test_a_stranger_learns_no_robots_name(line: str) -> None:
    async with house() as place:
        said = await place.line("99", line.format("omni"))
        assert said == await place.line("99", line.format("uxyz"))
        assert "I do not know you yet" in said or not said
        assert not any(robot in said for robot in ("omni", "kuka1", "cf1", "cf2", "swarm"))


async def test_who_was_locked_meanwhile_gets_nothing() -> None:
    async with house() as place:
        await place.line(VI, "/ask omni wave")
        await place.line(EVE, "/lock Vi")
        told = await place.press(ADA, "Allow 1 h")
        assert told == "Vi has no access now. Nothing was done."
        assert await place.line(VI, "/ask omni move") != ""
        assert len(place.gateway.access.petitions.open()) == 1


async def test_after_a_restart_the_question_still_stands_and_the_button_is_shown_again() -> None:
    store = MemoryStore()
    first = House(store)
    async with first.open():
        await first.line(VI, "/ask omni wave")
        dead, _ = first.shown(ADA, "Allow 1 h")
    again = House(store, clock=first.clock)
    async with again.open():
        shown = await again.line(ADA, "/people")
        assert "Vi · asks for wave on omni, for 1 h" in shown
        [people] = [t.message for t in again.chat.told][-1:]
        told = await again.press_again(ADA, dead, people)
        assert told == (
            "That button is no good any more. These still wait for your answer:\n"
            "Vi · asks for wave on omni, for 1 h\n"
            "Or write: /approve Vi, or /decline Vi"
        )
        assert (await again.press(ADA, "Allow Vi 1 h")).startswith("Vi may now: wave on omni")


async def test_a_gap_in_listening_voids_what_moves_but_not_an_answer_to_a_question() -> None:
    async with house() as place:
        await place.line(VI, "/ask omni wave")
        await place.line(BO, "use omni")
        await place.press(BO, "Wave")
        await place.clock.advance(1)
        place.chat.listening_since_ns = place.clock.wall_ns()
        told = await place.press(BO, "Do it")
        assert place.acted() == 0, told
        assert (await place.press(ADA, "Allow 1 h")).startswith("Vi may now")
        told = await place.press(EVE, "No")
        assert told == "Ada allowed that already. Nothing was done."


# ---- /grant ----


async def test_an_admin_gives_a_role_for_a_while_and_takes_it_back() -> None:
    async with house() as place:
        told = await place.line(ADA, "/grant Vi operator kuka1 with distance <= 1 m for 2h")
        what = "operator on kuka1, with distance <= 1 m, until tomorrow 00:13"
        assert told == f"Vi has been told: {what}."
        assert place.newest(VI).text == f"Ada gave you: {what}."
        assert place.newest(EVE).text == f"Ada gave Vi: {what}."
        assert what in await place.line(VI, "/me")
        assert what in await place.line(ADA, "/people")
        await place.line(VI, "kuka1 move 2 m")
        assert place.acted("kuka1") == 0
        await place.line(VI, "kuka1 move 1 m")
        assert place.acted("kuka1") == 1
        told = await place.line(ADA, "/grant Vi operator omni for 2h")
        await place.press(ADA, "Take it back")
        assert place.newest(VI).text == "Ada took back: operator on omni, until tomorrow 00:13."
        await place.line(VI, "omni wave")
        assert place.acted() == 0


async def test_what_ends_soon_ends_what_moves_under_it_though_it_was_given_just_now() -> None:
    async with house() as place:
        place.robot("omni").work_s = 60.0
        await place.line(ADA, "/grant Vi operator omni for 10 s")
        await place.line(VI, "omni move 1 m")
        before = len(place.chat.told)
        await place.pass_s(9.5)
        assert not place.told(VI, before)
        await place.pass_s(1.0)
        assert "Your right has ended: operator on omni." in place.told(VI, before)
        assert place.gateway.rooms.organiser.holder("omni") is None
        [life] = [t for t in place.chat.told if "omni: move" in t.outbound.text][-1:]
        assert "stopped before it ended" in place.chat.shown(life.message).text


async def test_what_is_given_for_good_is_confirmed_first() -> None:
    async with house() as place:
        told = await place.line(ADA, "/grant Vi operator omni")
        assert told == "Give Vi for good: operator on omni?"
        await place.line(VI, "omni wave")
        assert place.acted() == 0
        assert await place.press(ADA, "Give it") == "Vi has been told: operator on omni."
        await place.line(VI, "omni wave")
        assert place.acted() == 1


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("/grant", "Whom, what, where and for how long?"),
        ("/grant Xaver operator omni", 'I know nobody called "Xaver". Nothing was done.'),
        ("/grant Vi", "As what? The roles here are"),
        ("/grant Vi operator omni for ever", 'I cannot read "ever" as a length of time.'),
        ("/grant Vi operator omni with force <= 5 N", "No skill given here has a parameter"),
        ("/grant Vi operatr omni", 'I know no role and no robot called "operatr".'),
    ],
)
async def test_a_gift_that_makes_no_sense_gives_nothing(line: str, said: str) -> None:
    async with house() as place:
        assert (await place.line(ADA, line)).startswith(said)
        assert not place.gateway.authority.roster.next_end_ns(0)


async def test_who_gives_no_rights_learns_nobodys_name() -> None:
    async with house() as place:
        for line in ("/grant Vi operator omni for 1h", "/grant Xaver operator omni", "/grant"):
            told = await place.line(BO, line)
            assert told == "That is not yours to give. Ada or Eve can. Nothing was done."
        told = await place.line(TIM, "/grant Vi operator omni for 1h")
        assert told.startswith("You cannot give operator on omni")
        assert (await place.line(TIM, "/grant Vi operator kuka1 for 1h")).startswith("Vi has been")
        assert (await place.line(TIM, "/grant Vi senior kuka1 for 1h")).startswith("You cannot")
