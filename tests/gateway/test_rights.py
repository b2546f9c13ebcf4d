"""Rights in a whole gateway: limits, times, confirmations, a second person, taking over, a lock."""

from __future__ import annotations

from base64 import b32decode
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING

import pytest
from msgspec.structs import replace

from rosic.authoriser.two_factor import hotp, step_at
from rosic.core.policy.roles import DEFAULT_ROLES, Role, RoleRules, SkillPrecondition
from rosic.core.records import Fact, Letter
from rosic.core.robot.profile import Slots
from rosic.core.robot.skill import Parameter, Skill
from rosic.stores.memory import MemoryStore
from tests.gateway.place import ADA, BO, FLEET, Place

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

HOUR_S = 3600
JUNIOR = Role(scopes=("*:*",), limits=("distance <= 1 m",), priority=5)


@asynccontextmanager
async def lab(
    rulebook: RoleRules, roles: dict[str, str] | None = None, slots: Slots = Slots.RESPECTED
) -> AsyncIterator[Place]:
    """Run a place with rules of its own; ``roles`` by name instead of the usual ones."""
    place = Place(fleet=tuple(replace(profile, slots=slots) for profile in FLEET))
    settings = place.gateway._settings
    people = tuple(
        replace(seed, roles=(roles[seed.name],)) if roles and seed.name in roles else seed
        for seed in settings.people
    )
    place.gateway._settings = replace(settings, rulebook=rulebook, people=people)
    async with place.open():
        yield place


def rules(*care: SkillPrecondition, preempt: tuple[str, ...] = (), **roles: Role) -> RoleRules:
    return RoleRules(roles={**DEFAULT_ROLES, **roles}, care=care, preempt=preempt)


def who(place: Place, name: str) -> str:
    return place.gateway.rooms.authoriser.directory.named(name)[0].id


@pytest.mark.parametrize("skills", ["", "omni:move ", "*:* "])
async def test_a_limit_of_a_role_is_said_and_kept(skills: str) -> None:
    junior = replace(JUNIOR, limits=(f"{skills}distance <= 1 m",))
    async with lab(rules(junior=junior), {"Bo": "junior"}) as place:
        told = await place.say("omni move 2 m", account=BO, chat="2")
        assert place.acted() == 0
        assert "for you, move is allowed with distance <= 1 m. Nothing was done." in told
        await place.say("omni move 1 m", account=BO, chat="2")
        assert place.acted() == 1
        await place.say("omni move 2 m")
        assert place.acted() == 1, "Ada has to wait: Bo has it"
        await place.clock.advance(31)
        await place.say("omni move 2 m")
        assert place.acted() == 2


async def test_what_is_asked_before_a_tap_says_all_that_will_move_and_how_far() -> None:
    async with lab(rules(SkillPrecondition(scopes=("*:move",), confirm=True))) as place:
        for line, act in (
            ("swarm move 2 m left", "swarm (cf1, cf2): move, 2.00 m left"),
            ("kuka1 move 1 m", "kuka1: move, 1.00 m forward"),
        ):
            assert await place.say(line) == f"{act}? It moves only if you confirm it."
        assert (place.acted("cf1"), place.acted("cf2"), place.acted("kuka1")) == (0, 0, 0)
        await place.tap(*place.button("Do it"))
        assert place.acted("kuka1") == 1


async def test_what_is_over_a_limit_is_offered_within_it() -> None:
    async with lab(rules(junior=JUNIOR), {"Bo": "junior"}) as place:
        told = await place.say("omni move 2 m left", account=BO, chat=BO)
        assert "for you, move is allowed with distance <= 1 m" in told
        button, under = place.button("omni move direction=left distance=1 m")
        told = await place.tap(button, under, account=BO)
        assert "omni: move, 1.00 m left" in told
        assert place.acted() == 1
    other = replace(JUNIOR, limits=("distance >= 2 m",))
    async with lab(rules(junior=other), {"Bo": "junior"}) as place:
        await place.say("omni move 50 cm", account=BO, chat=BO)
        await place.tap(*place.button("omni move distance=2 m"), account=BO)
        assert place.acted() == 1


async def test_what_wants_a_tap_moves_only_after_it() -> None:
    async with lab(rules(SkillPrecondition(scopes=("omni:wave",), confirm=True))) as place:
        told = await place.say("omni wave")
        assert told == "omni: wave? It moves only if you confirm it."
        assert place.acted() == 0
        button, under = place.button("Do it")
        await place.tap(button, under, account=BO)
        assert place.acted() == 0, "it was asked of Ada"
        await place.tap(button, under)
        assert place.acted() == 1
        await place.tap(button, under)
        assert place.acted() == 1, "a button is good once"
        await place.say("!omni wave")
        assert place.acted() == 1, "nobody types a confirmation"


async def test_somebodys_time_keeps_others_out_and_says_when() -> None:
    async with lab(rules()) as place:
        calendar, access = place.gateway.rooms.organiser.calendar, place.gateway.access
        now_ns = place.clock.wall_ns()
        async with access.changes.turn() as turn:
            await turn.write(calendar.book(who(place, "Bo"), "omni", now_ns, HOUR_S, "test"))
        told = await place.say("omni wave")
        assert place.acted() == 0
        assert "Bo" in told
        assert "until" in told
        await place.say("omni wave", account=BO, chat=BO)
        assert place.acted() == 1
        await place.clock.advance(HOUR_S)
        await place.say("omni wave")
        assert place.acted() == 2


async def test_who_ends_a_session_within_their_time_reads_that_it_goes_on() -> None:
    async with lab(rules()) as place:
        await place.say("/book omni now 30 min", account=BO, chat=BO)
        await place.say("omni wave", account=BO, chat=BO)
        for _ in range(2):  # the second time without having moved it
            told = await place.say("/end omni", account=BO, chat=BO)
            assert told == "Session ended. omni is at rest, and yours until 22:43."
        await place.say("omni wave", account=BO, chat=BO)
        told = await place.say("/end omni")
        assert "Session ended. omni is at rest, and Bo's until 22:43." in told
        assert "Ada ended your time with omni." in told
        told = await place.tap(*place.button("Give that time back"))
        assert "omni" in told
        await place.say("omni wave")
        assert place.acted() == 3
        assert (await place.say("/end omni")) == "Session ended. omni is at rest, and free."


async def test_a_robot_that_has_to_be_booked_moves_for_nobody_else() -> None:
    async with lab(rules(), slots=Slots.REQUIRED) as place:
        told = await place.say("omni wave")
        assert place.acted() == 0
        assert "book" in told.lower()
        assert "look" in await place.say("omni look"), "who may read may look at any time"


async def test_a_senior_takes_over_where_that_is_allowed() -> None:
    async with lab(rules(preempt=("omni",))) as place:
        place.robot("omni").work_s = 60.0
        await place.say("omni move 1 m", account=BO, chat=BO)
        told = await place.say("omni wave")
        assert "omni is Bo's now. You may take it over; they are told." in told
        told = await place.say("take over omni")
        assert "omni is yours now. Bo was told." in told
        assert place.gateway.rooms.organiser.holder("omni") == who(place, "Ada"), (
            "before it is used"
        )
        assert "Ada takes omni over now." in told
        assert "stopped before it ended" in told, "what Bo's order did has ended"
        place.robot("omni").work_s = 0.0
        await place.say("omni wave")
        assert place.acted() == 2
        told = await place.say("take over omni", account=BO, chat=BO)
        assert "not yours to take over" in told


async def test_who_is_locked_may_only_stop_and_what_they_moved_is_at_rest() -> None:
    async with lab(rules()) as place:
        place.robot("omni").work_s = 60.0
        await place.say("omni move 1 m", account=BO, chat=BO)
        access = place.gateway.access
        async with access.changes.turn() as turn:
            await turn.act(access.locks.lock(who(place, "Bo"), who(place, "Ada")))
        await place.quiet()
        assert place.robot("omni").gate.latched
        assert place.robot("omni").presence().at_rest
        told = await place.say("status", account=BO, chat=BO)
        assert told.startswith("Your access is locked.")
        await place.say("resume omni")
        told = await place.say("stop", account=BO, chat=BO)
        assert "STOP" in told
        assert place.robot("omni").gate.latched


async def test_who_keeps_trying_what_is_not_theirs_loses_the_key_and_the_admins_hear_of_it() -> (
    None
):
    async with lab(rules()) as place:
        for _ in range(31):
            await place.say("omni wave", account="3", chat="3")
        said = [told.outbound for told in place.chat.told]
        assert any(out.chat.id == ADA and "Vi" in out.text for out in said), "an admin is told"
        told = await place.say("status", account="3", chat="3")
        assert told == "Your access here has ended. The admin of this place can renew it."
        assert place.acted() == 0


async def test_the_bot_of_the_paper_says_who_may_command() -> None:
    async with lab(rules(), slots=Slots.REQUIRED) as place:
        told = await place.say("/start", account=BO, chat=BO)
        assert told.startswith("You do not have permission to send and receive commands.")
        calendar, access = place.gateway.rooms.organiser.calendar, place.gateway.access
        async with access.changes.turn() as turn:
            now_ns = place.clock.wall_ns()
            await turn.write(calendar.book(who(place, "Bo"), "omni", now_ns, HOUR_S, "test"))
        told = await place.say("/start", account=BO, chat=BO)
        assert "You have permission to send and receive commands. Which robot?" in told
        told = await place.say("/start")  # it is Bo's time: whoever has the right only waits
        assert told.startswith("You have permission to send commands, but not just now. ")
        assert "Bo until" in told
        told = await place.say("request information", account=BO, chat=BO)
        assert told.startswith("Here's the information you requested.\n")
        assert "omni" in told
        told = await place.say("request information", account="99", chat="99")
        assert "Hello. I work for people I know" in told


async def test_a_session_is_ended_by_whoever_has_it_and_by_nobody_else() -> None:
    async with lab(rules()) as place:
        assert await place.say("/end omni") == "Nobody has omni."
        place.robot("omni").work_s = 60.0
        await place.say("omni move 1 m", account=BO, chat=BO)
        told = await place.say("/end omni", account="3", chat="3")
        assert told == (
            "omni is Bo's now. They can end that, or an admin. Wait for it, and I tell you when it "
            "is free."
        )
        told = await place.say("/end omni", account=BO, chat=BO)
        assert "Session ended. omni is at rest, and free." in told
        assert "Bo ended the session" in told
        assert not place.robot("omni").gate.latched
        await place.say("omni move 1 m")
        told = await place.say("/end omni", account=ADA)
        assert "Session ended." in told


async def test_the_robot_one_usually_means_need_not_be_named() -> None:
    async with lab(rules()) as place:
        assert await place.say("/settings robot omni", account=BO, chat=BO)
        await place.say("wave", account=BO, chat=BO)
        assert place.acted() == 1, "it is meant when none is named"


async def test_who_asks_to_be_forgotten_is() -> None:
    async with lab(rules()) as place:
        await place.say("omni wave", account=BO, chat=BO)
        assert "Bo" in await place.say("/me", account=BO, chat=BO)
        told = await place.say("/mydata", account=BO, chat=BO)
        assert "command" in told or "kept" in told
        await place.say("/forget me", account=BO, chat=BO)
        labels = [b.label for row in place.last()[1].buttons for b in row]
        button, under = place.button(labels[0])
        await place.tap(button, under, account=BO)
        await place.clock.advance(15)
        told = await place.say("omni wave", account=BO, chat=BO)
        assert place.acted() == 1
        assert "omni" not in told


async def test_a_backlog_of_late_commands_is_no_misuse() -> None:
    async with lab(rules()) as place:
        for number in range(400):
            late_ns = place.clock.wall_ns() - 60_000_000_000
            place.chat.say("omni wave", account=BO, chat=BO, sent_ns=late_ns, message=f"m{number}")
        await place.quiet()
        for _ in range(40):
            await place.quiet()
        assert "Bo" in await place.say("/me", account=BO, chat=BO)


async def test_a_key_that_is_narrowed_reaches_no_further() -> None:
    async with lab(rules()) as place:
        access = place.gateway.access
        async with access.changes.turn() as turn:
            _, records = access.keys.issue(who(place, "Bo"), "test", scopes=("omni:look",))
            await turn.write(records)
        told = await place.say("omni wave", account=BO, chat=BO)
        assert "is outside what your key is for" in told
        assert place.acted() == 0


async def test_an_archive_forgets_when_it_said_it_would() -> None:
    async with lab(rules()) as place:
        await place.say("/archive on 1 days")
        await place.say("omni wave")
        kept = place.gateway.archive
        assert not kept.outdated()
        place.clock.jump_wall(3 * 86_400)
        assert kept.outdated()
        await place.clock.advance(86_400 + 120)
        await place.quiet()
        assert not kept.outdated()


async def test_what_needs_a_good_channel_survives_a_change_of_policy_while_it_waits() -> None:
    async with lab(rules(SkillPrecondition(scopes=("kuka1:wave",), assurance="local"))) as place:
        kuka = place.robot("kuka1")
        kuka.work_s = 1.0
        await place.say("kuka1 move 1 m", account=BO, chat=BO)
        await place.say("kuka1 wave", account=BO, chat=BO)  # waits for its turn
        place.gateway.authority.renew(who(place, "Vi"))
        assert kuka._end is not None
        kuka._end.set_result(None)
        await place.quiet()
        assert place.acted("kuka1") == 2, "the message came over a channel that is good enough"


async def test_a_resume_that_needs_a_good_channel_is_possible_there() -> None:
    async with lab(rules(SkillPrecondition(scopes=("omni:resume",), assurance="local"))) as place:
        await place.say("stop omni")
        await place.clock.advance(1)
        assert "omni" in await place.say("resume omni")
        assert not place.robot("omni").gate.latched


async def test_whose_cap_on_speed_is_damaged_goes_slowly_and_hears_of_it_once() -> None:
    pace = Parameter(unit="m/s", min=0.05, max=1.0, default=0.1)
    drive = Skill(id="drive", parameters={"speed": pace})
    robot = replace(FLEET[0], skills={**FLEET[0].skills, "drive": drive})
    store = MemoryStore()
    async with Place(store, fleet=(robot,)).open() as place:
        bo = who(place, "Bo")
        await place.say("/settings speed 0.3 m/s", account=BO, chat=BO)
        letter = Letter(bo, b"\xc1")
        await store.write(Fact(kind="preference", key=bo, body=b"1", letter=letter))
    async with Place(store, fleet=(robot,)).open() as place:
        told = [(t.outbound.chat.id, t.outbound.text) for t in place.chat.told]
        assert [chat for chat, text in told if "you go slowly" in text] == [BO]
        said = await place.say("omni drive speed=0.3", account=BO, chat=BO, message="n1")
        assert place.acted() == 0
        assert "speed <= 0.1 m/s by your own settings. Nothing was done." in said
        await place.say("omni drive speed=0.1", account=BO, chat=BO, message="n2")
        assert place.acted() == 1
        await place.say("/settings speed none", account=BO, chat=BO, message="n3")
        await place.say("omni drive speed=0.3", account=BO, chat=BO, message="n4")
        assert place.acted() == 2


def phone_code(text: str, place: Place) -> str:
    """Return what a phone shows now that was set up by this text."""
    letters = text.split("secret=")[1].partition("&")[0]
    secret = b32decode(letters + "=" * (-len(letters) % 8))
    return hotp(secret, step_at(place.clock.wall_ns()))


async def test_a_second_factor_is_asked_again_after_an_idle_hour_and_no_sooner() -> None:
    async with lab(rules(SkillPrecondition(scopes=("omni:wave",), step_up=True))) as place:
        asked = await place.say("omni wave")
        assert "needs your second factor first" in asked
        assert "You have not set one up yet: send /authenticator" in asked
        shown = await place.say("/authenticator")
        assert "Your phone is set up" in await place.say(f"/code {phone_code(shown, place)}")
        for waves in (1, 2, 3):  # each use begins the hour anew
            await place.say("omni wave")
            assert place.acted() == waves
            await place.clock.advance(HOUR_S - 10)
        await place.say("omni move 1 m")  # what wants no proof is no use of it
        await place.clock.advance(11)
        asked = await place.say("omni wave")
        assert "needs your second factor first" in asked
        assert "/authenticator" not in asked, "the phone is set up"
        assert place.acted() == 4
        assert "I ask again after" in await place.say(f"/code {phone_code(shown, place)}")
        await place.say("omni wave")
        assert place.acted() == 5


def offered(place: Place) -> list[str]:
    """Return what may be tapped beneath the newest message."""
    return [button.command for row in place.last()[1].buttons for button in row]


async def test_nothing_is_offered_that_lies_above_ones_limits() -> None:
    async with lab(rules(junior=JUNIOR), {"Bo": "junior"}) as place:
        for line in ("omni move 40 m", "omni move"):
            await place.say(line, account=BO, chat=BO)
            assert not {"omni move 5 m", "omni move 2 m"} & set(offered(place))
            assert place.last()[1].buttons
            for command in offered(place):
                told = await place.say(command, account=BO, chat=BO)
                assert "is allowed with" not in told, command
        assert place.acted("omni") == 3
        await place.say("omni move 40 m")  # whoever has no such limit is offered what omni can
        assert offered(place) == ["omni move 5 m"]


async def test_a_step_stays_within_ones_limits() -> None:
    async with lab(rules(junior=JUNIOR), {"Bo": "junior"}) as place:
        await place.say("use omni", account=BO, chat=BO)
        await place.tap(*place.button("Move"), account=BO)
        for _ in range(4):
            await place.tap(*place.button("+"), account=BO)
        assert place.last()[1].text == "omni: move, 1.00 m forward?"
        await place.tap(*place.button("Do it"), account=BO)
        assert place.acted("omni") == 1
