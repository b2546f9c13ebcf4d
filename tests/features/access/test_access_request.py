"""`/ask` and its answers: a right for a while, by somebody else who may give it."""

from __future__ import annotations

import re

import pytest
from msgspec.structs import replace

from rosic.authoriser.invitations import InvitedRights
from rosic.features.access import AccessFeature
from rosic.organiser.access_requests import MOST_AN_HOUR, MOST_OPEN
from rosic.stores.memory import MemoryStore
from tests.features.access.access_gateway import ADA, BO, EVE, TIM, VI, House, house

HOUR_S = 3_600.0
QUESTION = "Vi asks for wave on omni, for 1 h. Do you allow it?"


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


async def test_a_right_on_a_whole_group_is_asked_for_and_given() -> None:
    async with house() as place:
        told = await place.line(VI, "/ask swarm wave for 30 min")
        assert told.startswith("I have asked Ada or Eve: wave on swarm, for 30 min.")
        assert not place.told(TIM), "it is not his to give"
        again = await place.line(VI, "/ask swarm wave")
        assert "asked" in again
        await place.press(ADA, "Allow 30 min")
        assert "You may now: wave on swarm, until 22:43." in place.told(VI)
        await place.line(VI, "swarm wave")
        assert (place.acted("cf1"), place.acted("cf2"), place.acted("omni")) == (1, 1, 0)
        assert "wave on swarm" in await place.line(VI, "/me")
        assert (await place.line(VI, "/ask swarm wave")).startswith("That is yours already")
        assert "operator on swarm, for 1 h" in await place.line(VI, "/ask swarm")
        await place.pass_s(HOUR_S)
        assert "Your right has ended: wave on swarm." in place.told(VI)
        await place.line(VI, "swarm wave")
        assert place.acted("cf1") == 1


async def test_who_gives_rights_on_a_part_of_a_group_is_not_asked_for_all_of_it() -> None:
    async with house() as place:
        rights = place.gateway.authority.rights
        tim = place.gateway.rooms.authoriser.directory.named("Tim")[0].id
        admin_policy = place.gateway.features.get(AccessFeature).request_commands._admin_policy
        one = InvitedRights(scopes=("kuka1:wave",))
        assert admin_policy.may_give(tim, one)
        assert rights.fleet.robots("*") != ("kuka1",)
        assert not admin_policy.may_give(tim, InvitedRights(scopes=("*:wave",))), (
            "only a part is his"
        )
        assert not admin_policy.may_give(tim, InvitedRights(scopes=("nobody:wave",)))


@pytest.mark.parametrize("yes", ["Allow 1 h", "Allow today", "/approve Vi for 2h"])
async def test_nobody_allows_for_longer_than_they_may_themselves(yes: str) -> None:
    async with house() as place:
        await place.line(ADA, "/grant Bo admin for 20 min")
        await place.line(VI, "/ask omni wave")
        told = await (place.line if yes.startswith("/") else place.press)(BO, yes)
        assert told == (
            "Vi may now: wave on omni, until 22:33. They have been told. No longer: your own "
            "right to give it ends then."
        )
        assert "You may now: wave on omni, until 22:33." in place.told(VI)
        await place.line(VI, "omni wave")
        assert place.acted() == 1
        await place.pass_s(1_201)
        assert "Your right has ended: wave on omni." in place.told(VI)
        await place.line(VI, "omni wave")
        assert place.acted() == 1


async def test_what_ends_sooner_or_is_theirs_otherwise_is_allowed_as_it_was_asked() -> None:
    async with house() as place:
        await place.line(ADA, "/grant Bo admin for 2h")
        await place.line(ADA, "/grant Tim admin for 20 min")
        await place.line(VI, "/ask kuka1 wave")
        told = await place.press(BO, "Allow 1 h")
        assert told == "Vi may now: wave on kuka1, until 23:13. They have been told."
        await place.line(VI, "/ask kuka1 move")
        told = await place.press(TIM, "Allow 1 h")
        assert told == "Vi may now: move on kuka1, until 23:13. They have been told.", (
            "on kuka1 he may for good"
        )


async def test_who_answers_nobody_by_name_is_shown_what_waits() -> None:
    async with house() as place:
        assert await place.line(ADA, "/approve") == "Nobody waits to come in. Nothing was done."
        await place.line(VI, "/ask omni wave")
        await place.line(VI, "/ask kuka1 wave for 2h")
        told = await place.line(ADA, "/approve")
        assert told.splitlines()[:3] == [
            "These wait for your answer:",
            "Vi · asks for wave on omni, for 1 h",
            "Or write: /approve Vi, or /decline Vi",
        ]
        assert "kuka1" in await place.line(EVE, "/decline Vi"), "both are hers: it is asked which"
        assert "kuka1" not in await place.press(EVE, "Not Vi")
        told = await place.line(TIM, "/decline")
        assert "wave on kuka1" in told
        assert "omni" not in told
        assert (await place.press(TIM, "Allow Vi 2 h")).startswith("Vi may now: wave on kuka1")
        assert "Nobody waits" in await place.line(ADA, "/approve")


async def test_no_answer_gives_for_longer_than_can_be_asked() -> None:
    async with house() as place:
        await place.line(VI, "/ask omni wave")
        for line in ("/approve Vi for 9 days", "/approve Vi for 3 s"):
            assert await place.line(ADA, line) == (
                "What is asked for is given for half a minute at least and for a week at most. "
                "Nothing was given."
            )


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
        number = place.gateway.access.access_requests.open()[0].id
        for account in (VI, BO, TIM):
            told = await place.line(account, f"/approve {number} 3600")
            assert told in {
                "Somebody else has to answer that. Nothing was done.",
                "That is not yours to give. Ada or Eve can. Nothing was done.",
            }
        assert not place.gateway.rooms.organiser.allows(
            place.gateway.access.access_requests.open()[0].principal, "omni", "wave"
        )
        assert (await place.line(ADA, "/approve Vi for 2h")).startswith(
            "Vi may now: wave on omni, until tomorrow 00:13."
        )


async def test_who_gives_rights_and_has_none_cannot_answer_themselves() -> None:
    async with house(Vi="registrar") as place:
        await place.line(VI, "/ask omni wave")
        assert not place.told(VI).count("Do you allow it?")
        number = place.gateway.access.access_requests.open()[0].id
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
            [first, *_] = place.gateway.access.access_requests.open()
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
    "/ask {} wave for 1h",
    "/ask {}",
    "/book {} now 1h",
    "/slots {}",
    "/wait {}",
    "/take over {}",
    "/end {}",
    "/use {}",
    "/help {}",
    "/status {}",
    "/resume {}",
    "{} wave",
    "{} move 1 m",
    "{}",
    "/wait take {}",
    "/wait keep {}",
    "/wait none {}",
)


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
        assert said == await place.line("98", line.format("uxyz"))
        assert "I do not know you yet" in said or not said
        assert not any(robot in said for robot in ("omni", "kuka1", "cf1", "cf2", "swarm"))


async def test_who_was_locked_meanwhile_gets_nothing() -> None:
    async with house() as place:
        await place.line(VI, "/ask omni wave")
        await place.line(EVE, "/lock Vi")
        told = await place.press(ADA, "Allow 1 h")
        assert told == "Vi has no access now. Nothing was done."
        assert await place.line(VI, "/ask omni move") != ""
        assert len(place.gateway.access.access_requests.open()) == 1


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


async def test_what_is_allowed_is_what_was_asked_about() -> None:
    """A role that has grown since, a robot that has come into a group: it has to be asked anew."""
    async with house() as place:
        await place.line(VI, "/ask kuka1 for 30 min")
        [access_request] = place.gateway.access.access_requests.open()
        role = access_request.want.role
        rolebook = place.gateway.authority.rolebook
        roles = rolebook.rulebook.roles
        wider = {**roles, role: replace(roles[role], scopes=(*roles[role].scopes, "*:*"))}
        rolebook.rulebook = replace(rolebook.rulebook, roles=wider)
        place.gateway.authority.draw_up()
        place.gateway.authority.moved()
        assert await place.press(ADA, "Allow 30 min") == (
            "The roles or robots that Vi asked about have changed since, so that was not given. "
            "Vi can ask again."
        )
        assert not place.gateway.authority.grants_book.grants_of(access_request.principal)[1:]
        await place.gateway.features.get(AccessFeature).request_commands.lapse()
        await place.quiet()
        assert place.newest(VI).text.startswith("What you asked for is void: ")
        assert not place.gateway.access.access_requests.open()


async def test_what_an_older_version_wrote_is_void_and_that_is_said() -> None:
    async with house() as place:
        await place.line(VI, "/ask omni wave")
        access_requests = place.gateway.access.access_requests
        [access_request] = access_requests.open()
        access_requests._known[access_request.id] = replace(access_request, digest=b"")
        assert "Vi can ask again." in await place.press(ADA, "Allow 1 h")
        await place.gateway.features.get(AccessFeature).request_commands.lapse()
        await place.quiet()
        assert place.newest(VI).text == (
            "What you asked for is void: wave on omni, for 1 h. The roles or robots, or ROSIC "
            "itself, have changed since. Ask again if you still want it."
        )
        assert (await place.line(VI, "/ask omni wave")).startswith("I have asked Ada or Eve")


async def test_what_an_account_asked_for_that_is_lost_nobody_can_give_any_more() -> None:
    async with house() as place:
        await place.line(VI, "omni wave")
        await place.press(VI, "Ask for it")
        code = re.search(r"\b[0-9A-Z]{4,5}(-[0-9A-Z]{4,5})+\b", await place.line(VI, "/link"))
        assert code is not None
        await place.line("99", f"link {code[0]}")
        await place.line("99", f"/unlink memory:{VI}")
        await place.press("99", "Take it away")

        await place.press(EVE, "Allow 1 h")

        await place.line("99", "omni wave")
        assert place.acted() == 0
