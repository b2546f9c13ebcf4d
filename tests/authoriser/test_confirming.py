"""An admin's tap: by somebody else, in time, once, with the same words on both sides."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from rosic.authoriser import messages as words
from rosic.authoriser.enrolment_records import ApprovalPending, CodeRedeemed, EnrolmentRefused
from rosic.core.records import Fact
from rosic.errors import Expired, NotPermitted
from tests.authoriser.enrolment_rooms import CY, DI, EnrolmentRooms, account

if TYPE_CHECKING:
    from rosic.core.identity import Address


@pytest.fixture
async def enrolling() -> EnrolmentRooms:
    return await EnrolmentRooms().with_admins()


async def waiting(
    enrolling: EnrolmentRooms, address: Address = CY, role: str = "senior", name: str = "Cy"
) -> ApprovalPending:
    code, _ = await enrolling.invite(role, confirm=True)
    answer = await enrolling.redeem(code, address, name=name)
    assert isinstance(answer, ApprovalPending), answer
    return answer


async def test_a_senior_waits_and_both_sides_see_the_same_words(enrolling: EnrolmentRooms) -> None:
    code, made = await enrolling.invite("senior", lasts_s=7200.0)
    assert made.needs_confirmation
    answer = await enrolling.redeem(code)
    assert isinstance(answer, ApprovalPending)
    applicant = answer.applicant
    assert applicant.words in answer.sentence
    assert applicant.question == (
        "Cy wants to come in as senior for 2 hours. "
        f"Let them in only if they see these words: {applicant.words}."
    )
    assert enrolling.directory.at(CY) is None

    await enrolling.clock.advance(1000.0)
    done = await enrolling.confirm(applicant.pending.id, "bo")
    assert done.person.id == applicant.pending.principal
    assert enrolling.directory.at(CY) == (done.person, done.key)
    # The right lasts from the tap, not from the code.
    assert done.grants[0].expires_ns == enrolling.clock.wall_ns() + 7_200_000_000_000


async def test_an_ordinary_role_does_not_wait(enrolling: EnrolmentRooms) -> None:
    _, made = await enrolling.invite("operator")
    assert not made.needs_confirmation


async def test_no_two_open_questions_show_the_same_words(enrolling: EnrolmentRooms) -> None:
    shown = [(await waiting(enrolling, account(n))).applicant.words for n in range(600)]
    assert len(set(shown)) == 600  # by chance, two of 600 would share theirs nine times in ten


async def test_whoever_has_no_right_cannot_let_anybody_in(enrolling: EnrolmentRooms) -> None:
    pending = (await waiting(enrolling)).applicant.pending.id
    with pytest.raises(NotPermitted, match="Only an admin lets people in"):
        await enrolling.confirm(pending, "di", may_admit=False)
    with pytest.raises(NotPermitted, match="Only an admin"):
        enrolling.enrolment.decline(pending, "di", may_admit=False)
    assert enrolling.counters["confirm-no-right"] == 2
    assert isinstance(await enrolling.confirm(pending, "ada"), CodeRedeemed)


async def test_nobody_confirms_their_own(enrolling: EnrolmentRooms) -> None:
    # An admin who redeems another admin's code for more: still not by their own tap.
    await enrolling.knows("di", "Di", DI, roles=("admin",))
    pending = (await waiting(enrolling, DI)).applicant.pending
    assert pending.principal == "di"
    for may_admit in (True, False):
        with pytest.raises(NotPermitted, match="Another admin has to let you in"):
            await enrolling.confirm(pending.id, "di", may_admit=may_admit)
    assert enrolling.counters["confirm-own"] == 2
    assert (await enrolling.confirm(pending.id, "ada")).person.roles == ("admin", "senior")


async def test_a_double_tap_lets_in_once(enrolling: EnrolmentRooms) -> None:
    pending = (await waiting(enrolling)).applicant.pending.id
    await enrolling.confirm(pending, "ada")
    for by in ("ada", "bo"):
        with pytest.raises(Expired, match="settled before"):
            await enrolling.confirm(pending, by)
    with pytest.raises(Expired, match="settled before"):
        enrolling.enrolment.decline(pending, "bo", may_admit=True)
    assert enrolling.counters["confirm-late"] == 3


async def test_whoever_is_declined_is_out_and_the_code_is_gone(enrolling: EnrolmentRooms) -> None:
    code, _ = await enrolling.invite("senior")
    answer = await enrolling.redeem(code)
    assert isinstance(answer, ApprovalPending)
    pending = answer.applicant.pending
    declined = enrolling.enrolment.decline(pending.id, "bo", may_admit=True)
    assert (declined.address, declined.newcomer) == (CY, True)
    assert enrolling.counters["declined"] == 1
    await enrolling.write(declined.records)
    with pytest.raises(Expired):
        await enrolling.confirm(pending.id, "ada")
    again = await enrolling.redeem(code, DI)
    assert isinstance(again, EnrolmentRefused)
    assert again.kind == "code-used"


async def test_the_first_admin_is_still_to_come_until_somebody_is_one(
    enrolling: EnrolmentRooms,
) -> None:
    admins = [p for p in enrolling.directory.people() if "admin" in p.roles]
    assert enrolling.enrolment.nobody_is_admin() is (not admins)
    await enrolling.knows("zoe", "Zoe", DI, roles=("admin",))
    assert enrolling.enrolment.nobody_is_admin() is False


async def test_an_applicant_may_go_away(enrolling: EnrolmentRooms) -> None:
    pending = (await waiting(enrolling)).applicant.pending
    declined = enrolling.enrolment.decline(pending.id, pending.principal, may_admit=False)
    await enrolling.write(declined.records)
    assert enrolling.enrolment.applicants.all() == ()


async def test_a_question_ends_after_a_day(enrolling: EnrolmentRooms) -> None:
    pending = (await waiting(enrolling)).applicant.pending
    await enrolling.clock.advance(86_399.0)
    assert enrolling.enrolment.lapsed() == ()
    await enrolling.clock.advance(1.0)
    with pytest.raises(Expired, match="waited too long"):
        await enrolling.confirm(pending.id, "ada")
    lapsed = enrolling.enrolment.lapsed()
    assert [end.sentence for end in lapsed] == [words.lapsed()]
    await enrolling.write(lapsed[0].records)
    assert enrolling.enrolment.lapsed() == ()
    # A clock set back does not open it again.
    enrolling.clock.jump_wall(-86_400.0)
    with pytest.raises(Expired):
        await enrolling.confirm(pending.id, "ada")


async def test_who_waits_cannot_use_a_second_code_up(enrolling: EnrolmentRooms) -> None:
    first = await waiting(enrolling)
    code, _ = await enrolling.invite("senior")
    again = await enrolling.redeem(code)
    assert isinstance(again, EnrolmentRefused)
    assert first.applicant.words in again.sentence
    assert again.sentence.endswith("I wait for 24 hours.")
    await enrolling.clock.advance(7_200.0)
    code, _ = await enrolling.invite("senior")
    third = await enrolling.redeem(code)
    assert isinstance(third, EnrolmentRefused)
    assert third.sentence.endswith("I wait for 22 hours.")
    assert isinstance(await enrolling.redeem(code, DI), ApprovalPending)


async def test_nobody_comes_in_while_locked(enrolling: EnrolmentRooms) -> None:
    await enrolling.knows("cy", "Cy", CY, roles=("viewer",))
    pending = (await waiting(enrolling)).applicant.pending.id
    await enrolling.write(enrolling.locks.lock("cy", "bo"))
    with pytest.raises(NotPermitted, match="Cy is locked"):
        await enrolling.confirm(pending, "ada")
    await enrolling.write(enrolling.locks.unlock("cy", "ada", "Cy"))
    assert isinstance(await enrolling.confirm(pending, "ada"), CodeRedeemed)


async def test_a_question_outlives_a_restart_with_its_words(enrolling: EnrolmentRooms) -> None:
    before = (await waiting(enrolling)).applicant
    again = await enrolling.restarted()
    assert again.enrolment.applicants.at(CY) == before
    assert again.enrolment.applicants.all()[0].words == before.words
    done = await again.confirm(before.pending.id, "ada")
    assert again.directory.at(CY) == (done.person, done.key)


async def test_a_damaged_question_is_none(enrolling: EnrolmentRooms) -> None:
    pending = (await waiting(enrolling)).applicant.pending.id
    good = (await enrolling.store.open()).facts["pending"][0]
    for fact in (
        Fact(kind="pending", key=pending, body=b"\xc1"),
        Fact(kind="pending", key=pending, body=good.body),  # its letter was shredded
        Fact(kind="pending", key="w-other", body=good.body, letter=good.letter),
    ):
        enrolling.enrolment.apply(fact)
    assert enrolling.enrolment.applicants.get("w-other") is None
    with pytest.raises(Expired):
        await enrolling.confirm(pending, "ada")


async def test_who_became_known_meanwhile_is_not_doubled(enrolling: EnrolmentRooms) -> None:
    pending = (await waiting(enrolling)).applicant.pending.id
    await enrolling.knows("cy", "Cy", CY, roles=("viewer",))
    with pytest.raises(Expired):
        await enrolling.confirm(pending, "ada")
