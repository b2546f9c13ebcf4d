"""Invitations and what comes of their codes."""

from __future__ import annotations

import pytest

from rosic.authoriser import messages as words
from rosic.authoriser.enrolment_records import (
    Answer,
    ApprovalPending,
    CodeRedeemed,
    EnrolmentRefused,
)
from rosic.authoriser.invitations import InvitationRequest, InvitedRights
from rosic.core.records import Decided, Enrolled, Fact, KeyIssued
from tests.authoriser.enrolment_rooms import ADA, CY, DI, EnrolmentRooms, account

DAY_S = 86_400.0
HOUR_NS = 3_600_000_000_000


@pytest.fixture
async def enrolling() -> EnrolmentRooms:
    return await EnrolmentRooms().with_admins()


def away(answer: Answer) -> EnrolmentRefused:
    assert isinstance(answer, EnrolmentRefused), answer
    return answer


def inside(answer: Answer) -> CodeRedeemed:
    assert isinstance(answer, CodeRedeemed), answer
    return answer


# ---- a good code ----


async def test_a_code_lets_a_newcomer_in(enrolling: EnrolmentRooms) -> None:
    code, made = await enrolling.invite("operator", robots=("kuka1",), lasts_s=7200.0)
    done = inside(await enrolling.redeem(code.lower()))

    assert done.newcomer
    assert done.sentence == (
        "You are in, as operator on kuka1 for 2 hours. "
        "Say stop at any time: whatever you may see, you may stop."
    )
    (grant,) = done.grants
    assert (grant.role, grant.robots, grant.scopes) == ("operator", ("kuka1",), ())
    assert grant.expires_ns == enrolling.clock.wall_ns() + 2 * HOUR_NS
    # What ends by itself is the organiser's; nothing of it may stand among the roles for ever.
    assert done.person.roles == ()
    assert enrolling.directory.at(CY) == (done.person, done.key)
    assert enrolling.enrolment.invitations.open() == ()
    assert [type(record) for record in done.records] == [Decided, Fact, Enrolled, KeyIssued]
    assert made.issuer == done.key.issuer == "ada"


async def test_a_standing_right_is_a_role(enrolling: EnrolmentRooms) -> None:
    code, _ = await enrolling.invite("viewer")
    done = inside(await enrolling.redeem(code))
    assert done.grants == ()
    assert done.person.roles == ("viewer",)


async def test_whatever_has_an_end_or_a_bound_is_a_grant(enrolling: EnrolmentRooms) -> None:
    given = InvitedRights(
        roles=("operator", "viewer"),
        robots=("crazyflie-*",),
        scopes=("omni:*", "kuka1:grasp"),
        limits=("speed <= 0.2 m/s",),
        lasts_s=60.0,
    )
    offer = enrolling.enrolment.invitations.invite(InvitationRequest(given=given), "ada")
    await enrolling.write(offer.records)
    done = inside(await enrolling.redeem(offer.code.reveal()))
    until_ns = enrolling.clock.wall_ns() + 60_000_000_000
    assert [(g.role, g.robots, g.scopes) for g in done.grants] == [
        ("operator", ("crazyflie-*",), ()),
        ("viewer", ("crazyflie-*",), ()),
        ("", (), ("omni:*", "kuka1:grasp")),
    ]
    assert {(g.limits, g.expires_ns) for g in done.grants} == {(given.limits, until_ns)}
    assert len({g.id for g in done.grants}) == 3
    assert done.person.roles == ()
    assert given.words == (
        "operator and viewer on crazyflie-*, everything on omni and grasp on kuka1, "
        "with speed <= 0.2 m/s, for 60 seconds"
    )
    bounds = ({"lasts_s": 5.0}, {"robots": ("omni",)}, {"limits": ("speed <= 1 m/s",)})
    assert not any(InvitedRights(roles=("viewer",), **bound).standing for bound in bounds)


async def test_a_known_person_keeps_what_they_have(enrolling: EnrolmentRooms) -> None:
    await enrolling.knows("cy", "Cy", CY, roles=("viewer",))
    code, _ = await enrolling.invite("operator", lasts_s=60.0)
    done = inside(await enrolling.redeem(code))
    assert (done.newcomer, done.person.id, done.person.roles) == (False, "cy", ("viewer",))
    assert done.key.id == "k-cy"
    assert done.sentence.startswith("You can do more now: operator for 60 seconds.")
    assert not any(isinstance(record, KeyIssued) for record in done.records)

    code, _ = await enrolling.invite("operator")
    assert inside(await enrolling.redeem(code)).person.roles == ("viewer", "operator")


async def test_whoever_lost_their_access_waits_for_an_admin(enrolling: EnrolmentRooms) -> None:
    await enrolling.knows("cy", "Cy", CY, roles=("operator",))
    enrolling.authoriser.revoke("k-cy")
    code, _ = await enrolling.invite("viewer")
    answer = await enrolling.redeem(code)
    assert isinstance(answer, ApprovalPending)
    assert answer.applicant.question.startswith("The access of Cy was ended before. Cy wants")

    done = await enrolling.confirm(answer.applicant.pending.id, "ada")
    assert done.person.id == "cy"
    assert done.person.roles == ("viewer",)  # what they had before does not come back
    assert enrolling.directory.has_good_key("cy")


async def test_nobody_has_anothers_name(enrolling: EnrolmentRooms) -> None:
    names = []
    for number in range(3):
        code, _ = await enrolling.invite("viewer")
        done = inside(await enrolling.redeem(code, account(number), name="\u202eAda\n"))
        names.append(done.person.name)
    assert names == ["Ada 2", "Ada 3", "Ada 4"]
    code, _ = await enrolling.invite("viewer")
    assert inside(await enrolling.redeem(code, name="\u200b")).person.name == "guest"


async def test_the_name_of_the_invitation_counts(enrolling: EnrolmentRooms) -> None:
    offer = enrolling.enrolment.invitations.invite(
        InvitationRequest(given=InvitedRights(roles=("viewer",)), name="Dr Cy"), "ada"
    )
    await enrolling.write(offer.records)
    assert inside(await enrolling.redeem(offer.code.reveal(), name="x")).person.name == "Dr Cy"


async def test_looking_uses_nothing_up(enrolling: EnrolmentRooms) -> None:
    code, made = await enrolling.invite("operator", robots=("kuka1",))
    seen = enrolling.enrolment.look(code, CY, private=True)
    assert seen == made
    assert words.invited(made.given.words) == "Hello. You are invited as operator on kuka1."
    inside(await enrolling.redeem(code))


async def test_nobody_uses_their_own_invitation(enrolling: EnrolmentRooms) -> None:
    code, _ = await enrolling.invite("operator")
    assert away(await enrolling.redeem(code, ADA)).kind == "code-own"
    inside(await enrolling.redeem(code, CY))


# ---- a code that is not good ----


async def test_every_code_that_is_not_good_gets_the_same_answer(enrolling: EnrolmentRooms) -> None:
    used, _ = await enrolling.invite("viewer")
    inside(await enrolling.redeem(used, CY))
    burnt, _ = await enrolling.invite("viewer")
    await enrolling.redeem(burnt, CY, private=False)
    withdrawn, made = await enrolling.invite("viewer")
    await enrolling.write(enrolling.enrolment.invitations.withdraw(made.id, "ada"))
    expired, _ = await enrolling.invite("viewer")
    await enrolling.clock.advance(601.0)

    found = {}
    for number, code in enumerate((used, burnt, withdrawn, expired, "0000-0000", "x")):
        answer = away(await enrolling.redeem(code, account(number)))
        found[answer.kind] = answer.sentence
        assert answer.records == ()
        assert answer.alarm is None
    assert set(found) == {
        "code-used",
        "code-burnt",
        "code-withdrawn",
        "code-expired",
        "code-unknown",
    }
    assert set(found.values()) == {words.NOT_GOOD}
    assert enrolling.counters["code-unknown"] == 2
    assert all(enrolling.counters[kind] >= 1 for kind in found)


async def test_a_second_tap_on_ones_own_link_is_no_guess(enrolling: EnrolmentRooms) -> None:
    code, _ = await enrolling.invite("viewer")
    done = inside(await enrolling.redeem(code))
    for _ in range(10):
        assert away(await enrolling.redeem(code)).sentence == words.AGAIN
    # Somebody else, though known here, does not learn that it was a code.
    await enrolling.knows("di", "Di", DI, roles=("viewer",))
    assert away(await enrolling.redeem(code, DI)).sentence == words.NOT_GOOD
    enrolling.authoriser.revoke(done.key.id)
    assert away(await enrolling.redeem(code)).sentence == words.NOT_GOOD


async def test_a_code_in_a_group_is_burnt_and_the_admins_hear_of_it(
    enrolling: EnrolmentRooms,
) -> None:
    code, _ = await enrolling.invite("operator", robots=("kuka1",))
    answer = away(await enrolling.redeem(code, private=False))
    assert answer.alarm is not None
    assert answer.alarm.sentence == (
        "A code for operator on kuka1 was shown in a group. It is not good any more. "
        "Invite again, and send the code to one person."
    )
    assert away(await enrolling.redeem(code, DI)).kind == "code-burnt"
    # A code that is none looks the same to the group.
    assert away(await enrolling.redeem("0000-0000", private=False)).sentence == answer.sentence
    assert code.replace("-", "") not in str(answer)


async def test_a_code_inside_any_message_of_a_group_is_burnt(enrolling: EnrolmentRooms) -> None:
    code, _ = await enrolling.invite("viewer")
    shown = enrolling.enrolment.shown_in
    assert shown("please move-back a bit, and let us join at 17-18") == ()
    [found] = shown(f"who wants {code.lower()}?")
    answer = enrolling.enrolment.leaked(found, CY)
    assert answer is not None
    assert answer.alarm is not None
    await enrolling.write(answer.records)
    assert shown(f"who wants {code.lower()}?") == ()
    assert enrolling.enrolment.leaked(code, CY) is None
    assert enrolling.counters["code-unknown"] == 0


async def test_a_burnt_code_is_burnt_even_while_joining_is_paused(
    enrolling: EnrolmentRooms,
) -> None:
    code, _ = await enrolling.invite("viewer")
    for _ in range(6):
        await enrolling.redeem("0000-0000")
    assert away(await enrolling.redeem(code)).kind == "code-paused"
    assert away(await enrolling.redeem(code, private=False)).kind == "code-in-group"


async def test_an_invitation_ends_with_its_issuer(enrolling: EnrolmentRooms) -> None:
    stolen, _ = await enrolling.invite("operator", by="ada")
    other, _ = await enrolling.invite("operator", by="bo")
    await enrolling.write(enrolling.locks.lock("ada", "bo"))
    enrolling.authoriser.revoke("k-bo")
    assert away(await enrolling.redeem(stolen)).kind == "code-withdrawn"
    assert away(await enrolling.redeem(other)).kind == "code-withdrawn"


async def test_whoever_is_locked_does_not_come_in_by_another_code(
    enrolling: EnrolmentRooms,
) -> None:
    await enrolling.knows("cy", "Cy", CY, roles=("viewer",))
    code, _ = await enrolling.invite("operator")
    await enrolling.write(enrolling.locks.lock("cy", "ada"))
    assert away(await enrolling.redeem(code)).kind == "code-locked"


# ---- the first admin ----


async def test_the_first_admin_comes_in_by_a_code_that_dies_with_the_next() -> None:
    enrolling = await EnrolmentRooms().opened()
    first = enrolling.enrolment.first_admin_code()
    assert first is not None
    await enrolling.write(first.records)
    again = await enrolling.restarted()
    second = again.enrolment.first_admin_code()
    assert second is not None
    await again.write(second.records)

    assert away(await again.redeem(first.code.reveal())).kind == "code-withdrawn"
    done = inside(await again.redeem(second.code.reveal()))
    assert done.person.roles == ("admin",)
    assert again.enrolment.first_admin_code() is None
    assert f"join {second.code.reveal()}" in second.sentence


async def test_the_code_of_the_first_admin_ends_when_there_is_one() -> None:
    enrolling = await EnrolmentRooms().opened()
    offer = enrolling.enrolment.first_admin_code()
    assert offer is not None
    await enrolling.write(offer.records)
    await enrolling.knows("ada", "Ada", ADA, roles=("admin",))
    assert away(await enrolling.redeem(offer.code.reveal())).kind == "code-withdrawn"


async def test_an_only_admin_whose_access_ended_comes_back_by_the_owners_code() -> None:
    enrolling = await EnrolmentRooms().opened()
    await enrolling.knows("ada", "Ada", ADA, roles=("admin",))
    enrolling.authoriser.revoke("k-ada")
    offer = enrolling.enrolment.first_admin_code()
    assert offer is not None
    await enrolling.write(offer.records)
    assert inside(await enrolling.redeem(offer.code.reveal(), ADA)).person.id == "ada"
