"""An admin's tap: the same words on both sides, one answer, and everybody is told."""

from __future__ import annotations

from rosic.authoriser import messages
from rosic.authoriser.invitations import InvitationRequest, InvitedRights
from rosic.core.identity import Address
from rosic.core.language import Do
from rosic.core.policy.roles import Grant, StepRequired
from rosic.core.robot.skill import Skill
from rosic.errors import FirstNeeded
from rosic.features.access import messages as words
from rosic.stores.memory import MemoryStore
from tests.features.access.access_handlers import ADA, BO, CY, DI, ED, BrokenStore, Hall, a_hall

FOR_ADMINS = "Inviting people and letting them in is for admins. Ada or Bo can. Nothing was done."


async def applies(hall: Hall, line: str = "senior", account: str = DI) -> str:
    """Let somebody come with a code that wants an admin's tap; return the words they see."""
    await hall.say(account, await hall.invited(line))
    said = await hall.tap(account, "Join")
    assert said.startswith("An admin has to let you in and sees the words: "), said
    return said.split(": ")[1].split(".")[0]


def is_in(hall: Hall, account: str = DI) -> bool:
    known = hall.directory.at(Address("telegram", account))
    return known is not None and known[1].revoked_ns is None


async def test_both_sides_see_the_same_words_and_a_tap_lets_in() -> None:
    async with a_hall() as hall:
        shared = await applies(hall, "senior kuka1 for 2h")
        question = (
            "Di wants to come in as senior on kuka1 for 2 hours. Let them in only if they see "
            f"these words: {shared}."
        )
        assert hall.last(ADA).text == hall.last(BO).text == question
        assert hall.last(ADA).urgent
        assert hall.labels(ADA) == ["Let them in", "No"]
        assert not is_in(hall)
        assert not hall.told(CY)  # no admin, not asked

        assert await hall.tap(BO, "Let them in") == "Di is in, as senior on kuka1 for 2 hours."
        assert is_in(hall)
        assert hall.last(ADA).text == "Bo let Di in, as senior on kuka1 for 2 hours."
        assert hall.last(DI).text == (
            "You are in, as senior on kuka1 for 2 hours. Say stop at any time: whatever you may "
            "see, you may stop.\nWhich robot?"
        )
        assert await hall.tap(DI, "kuka1") == "(Use)"
        known = hall.directory.at(Address("telegram", DI))
        assert known is not None
        assert [g.role for g in hall.rights.grants(known[0].id)] == ["senior"]
        assert await hall.tap(ADA, "Let them in") == messages.SETTLED


async def test_no_is_told_to_the_newcomer_too() -> None:
    async with a_hall() as hall:
        await applies(hall)
        assert await hall.tap(ADA, "No") == "Di is not in, and has been told."
        assert hall.last(DI).text == "An admin did not let you in. Ask whoever invited you."
        assert hall.last(BO).text == "Ada did not let Di in."
        assert not is_in(hall)
        assert await hall.tap(BO, "Let them in") == messages.SETTLED
        assert not is_in(hall)


async def test_whoever_waits_is_told_so_whatever_they_say() -> None:
    async with a_hall() as hall:
        shared = await applies(hall)
        await hall.clock.advance(3_600.0)
        said = await hall.say(DI, "hello?")
        assert said == (
            f"An admin has to let you in and sees the words: {shared}. If asked, say these words. "
            "I wait for 23 hours."
        )
        assert await hall.in_group(DI, "hello?") == ""
        answers = [await hall.say(DI, "hello?") for _ in range(30)]
        assert answers.count(said) < 15  # seldom
        await hall.clock.advance(86_400.0)
        assert (await hall.say(DI, "hello?")).startswith("Hello. I work for people I know")


async def test_nobody_answered_in_time() -> None:
    async with a_hall() as hall:
        await applies(hall)
        assert await hall.admitting.lapse() == ()
        await hall.clock.advance(86_401.0)
        (late,) = await hall.admitting.lapse()
        await hall.quiet()
        assert late.newcomer
        assert hall.last(DI).text == messages.lapsed()
        assert await hall.admitting.lapse() == ()
        assert await hall.say(ADA, "/approve Di") == messages.SETTLED


async def test_an_answer_may_be_typed_by_name_or_by_the_words() -> None:
    async with a_hall() as hall:
        shared = await applies(hall)
        assert await hall.say(ADA, "/approve") == "Whom? Di waits to come in. Nothing was done."
        assert await hall.say(ADA, "/approve Nobody") == messages.SETTLED
        ada = hall.directory.named("Ada")[0].id
        assert [name for name, *_ in hall.admitting.questions(ada, "di")] == ["Di"]
        assert hall.admitting.questions(ada, "Cy Young") == ()
        assert await hall.say(ADA, f"/approve {shared}") == "Di is in, as senior."
        assert await hall.say(ADA, "/decline") == "Nobody waits to come in. Nothing was done."
        await applies(hall, account=ED)
        assert await hall.say(ADA, "/decline ED") == "Ed is not in, and has been told."


async def test_only_who_may_lets_people_in() -> None:
    async with a_hall() as hall:
        await applies(hall)
        pending = hall.enrolment.applicants.all()[0].pending.id
        for line in ("/approve Di", f"/approve {pending}", "/decline Di", "/approve", "/approve x"):
            assert await hall.say(CY, line) == FOR_ADMINS, line
        await hall.knows(ED, "Ed", "tutor")
        assert await hall.say(ED, "/approve Di") == messages.NO_RIGHT
        assert not is_in(hall)


async def test_a_tutor_is_asked_about_their_own_robot_alone() -> None:
    async with a_hall() as hall:
        await hall.knows(ED, "Ed", "tutor")
        await applies(hall, "senior kuka1 for 2h")
        assert not hall.told(ED)  # a senior ranks above a tutor
        await hall.say("6", await hall.invited("viewer"))
        assert not hall.told(ED)


async def test_nobody_lets_themselves_in() -> None:
    async with a_hall() as hall:
        await hall.say(BO, await hall.invited("senior"))
        await hall.tap(BO, "Join")
        assert hall.last(BO).text.startswith("An admin has to let you in")
        assert await hall.say(BO, "/approve Bo") == messages.CONFIRM_OWN
        assert await hall.say(ADA, "/approve Bo") == "Bo is in, as senior."


async def test_no_admin_can_be_reached() -> None:
    async with Hall().open() as hall:
        await hall.knows(CY, "Cy Young", "operator")
        # The operator of the machine invites; there is no admin yet.
        offer = hall.enrolment.invitations.invite(
            InvitationRequest(given=InvitedRights(roles=("senior",))), "operator"
        )
        async with hall.changes.turn() as turn:
            await turn.write(offer.records)
        await hall.say(DI, offer.code.reveal())
        said = await hall.tap(DI, "Join")
        assert said.endswith("I wait for 24 hours. I can reach no admin now, so ask one yourself.")


async def test_an_answer_that_cannot_be_written_changes_nothing() -> None:
    store = BrokenStore()
    async with a_hall(store) as hall:
        await applies(hall)
        store.broken = True
        said = await hall.tap(ADA, "Let them in")
        assert said.startswith("I cannot write this down now, so nothing was changed.")
        assert not is_in(hall)
        store.broken = False
        assert await hall.say(ADA, "/approve Di") == "Di is in, as senior."


async def test_after_a_restart_the_list_of_people_asks_again() -> None:
    store = MemoryStore()
    async with a_hall(store) as hall:
        shared = await applies(hall)
        clock = hall.clock
    async with Hall(store, clock=clock, seed=1).open() as again:
        said = await again.say(ADA, "/people")
        assert said.splitlines()[-1] == f"Di · waits to come in as senior · words: {shared}"
        assert again.labels(ADA) == ["Let Di in", "Not Di"]
        assert await again.tap(ADA, "Let Di in") == "Di is in, as senior."
        assert again.last(DI).text.startswith("You are in, as senior.")


async def test_whoever_lost_their_access_waits_and_keeps_nothing() -> None:
    async with a_hall() as hall:
        await hall.knows(DI, "Di", "operator", grants=(Grant(id="g1", role="senior"),))
        await hall.say(ADA, "/revoke Di")
        await hall.tap(ADA, "Revoke")
        await applies(hall, "viewer")
        assert hall.last(ADA).text.startswith(
            "The access of Di was ended before. Di wants to come in as viewer."
        )
        await hall.tap(ADA, "Let them in")
        assert [g.role for g in hall.rights.grants("p-4")] == ["viewer"]


async def test_the_labels() -> None:
    assert (words.let_in_label(""), words.decline_label("")) == ("Let them in", "No")


async def test_a_yes_goes_to_whoever_asked() -> None:
    async with a_hall() as hall:
        await applies(hall)
        caller = hall.authoriser.identify(hall.chat.say("x", account=CY, chat=CY))
        needed = FirstNeeded(
            "Waving needs a second person.",
            need=StepRequired.SECOND_PERSON.value,
            robot="omni",
            text="omni wave",
        )
        wave = Do(robots=("omni",), skills=(Skill(id="wave"),), spoken=(), text="omni wave")
        hall.confirmation.ask(caller, wave, needed)
        await hall.quiet()
        assert await hall.tap(ADA, "I agree") == "Cy Young is told that you agree."
        hall.confirmation.ask(caller, wave, needed)
        await hall.quiet()
        button, under = next(
            (b, told.message)
            for told in reversed(hall.chat.told)
            for row in told.outbound.buttons
            for b in row
            if b.label == "No" and told.outbound.chat.id == ADA
        )
        assert await hall.tap_again(ADA, button, under) == "Nothing is done."
        assert hall.enrolment.applicants.all()
        assert await hall.say(ADA, "/approve Di") == "Di is in, as senior."
