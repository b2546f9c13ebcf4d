"""Invitations and what comes of their codes."""

from __future__ import annotations

import pytest

from rosic.authoriser import messages as words
from rosic.authoriser.enrolment_records import Answer, ApplicantWaits, CodeRedeemed, TurnedAway
from rosic.authoriser.invitations import InvitationRequest, InvitedRights
from rosic.core.records import Decided, Enrolled, Fact, KeyIssued
from tests.authoriser.office import ADA, CY, DI, Office, account

DAY_S = 86_400.0
HOUR_NS = 3_600_000_000_000


@pytest.fixture
async def office() -> Office:
    return await Office().with_admins()


def away(answer: Answer) -> TurnedAway:
    assert isinstance(answer, TurnedAway), answer
    return answer


def inside(answer: Answer) -> CodeRedeemed:
    assert isinstance(answer, CodeRedeemed), answer
    return answer


# ---- a good code ----


async def test_a_code_lets_a_newcomer_in(office: Office) -> None:
    code, made = await office.invite("operator", robots=("kuka1",), lasts_s=7200.0)
    done = inside(await office.redeem(code.lower()))

    assert done.newcomer
    assert done.sentence == (
        "You are in, as operator on kuka1 for 2 hours. "
        "Say stop at any time: whatever you may see, you may stop."
    )
    (grant,) = done.grants
    assert (grant.role, grant.robots, grant.scopes) == ("operator", ("kuka1",), ())
    assert grant.expires_ns == office.clock.wall_ns() + 2 * HOUR_NS
    # What ends by itself is the organiser's; nothing of it may stand among the roles for ever.
    assert done.person.roles == ()
    assert office.directory.at(CY) == (done.person, done.key)
    assert office.enrolment.invitations.open() == ()
    assert [type(record) for record in done.records] == [Decided, Fact, Enrolled, KeyIssued]
    assert made.issuer == done.key.issuer == "ada"


async def test_a_standing_right_is_a_role(office: Office) -> None:
    code, _ = await office.invite("viewer")
    done = inside(await office.redeem(code))
    assert done.grants == ()
    assert done.person.roles == ("viewer",)


async def test_whatever_has_an_end_or_a_bound_is_a_grant(office: Office) -> None:
    given = InvitedRights(
        roles=("operator", "viewer"),
        robots=("crazyflie-*",),
        scopes=("omni:*", "kuka1:grasp"),
        limits=("speed <= 0.2 m/s",),
        lasts_s=60.0,
    )
    offer = office.enrolment.invitations.invite(InvitationRequest(given=given), "ada")
    await office.write(offer.records)
    done = inside(await office.redeem(offer.code.reveal()))
    until_ns = office.clock.wall_ns() + 60_000_000_000
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


async def test_a_known_person_keeps_what_they_have(office: Office) -> None:
    await office.knows("cy", "Cy", CY, roles=("viewer",))
    code, _ = await office.invite("operator", lasts_s=60.0)
    done = inside(await office.redeem(code))
    assert (done.newcomer, done.person.id, done.person.roles) == (False, "cy", ("viewer",))
    assert done.key.id == "k-cy"
    assert done.sentence.startswith("You can do more now: operator for 60 seconds.")
    assert not any(isinstance(record, KeyIssued) for record in done.records)

    code, _ = await office.invite("operator")
    assert inside(await office.redeem(code)).person.roles == ("viewer", "operator")


async def test_whoever_lost_their_access_waits_for_an_admin(office: Office) -> None:
    await office.knows("cy", "Cy", CY, roles=("operator",))
    office.authoriser.revoke("k-cy")
    code, _ = await office.invite("viewer")
    answer = await office.redeem(code)
    assert isinstance(answer, ApplicantWaits)
    assert answer.applicant.question.startswith("The access of Cy was ended before. Cy wants")

    done = await office.confirm(answer.applicant.pending.id, "ada")
    assert done.person.id == "cy"
    assert done.person.roles == ("viewer",)  # what they had before does not come back
    assert office.directory.has_good_key("cy")


async def test_nobody_has_anothers_name(office: Office) -> None:
    names = []
    for number in range(3):
        code, _ = await office.invite("viewer")
        done = inside(await office.redeem(code, account(number), name="\u202eAda\n"))
        names.append(done.person.name)
    assert names == ["Ada 2", "Ada 3", "Ada 4"]
    code, _ = await office.invite("viewer")
    assert inside(await office.redeem(code, name="\u200b")).person.name == "guest"


async def test_the_name_of_the_invitation_counts(office: Office) -> None:
    offer = office.enrolment.invitations.invite(
        InvitationRequest(given=InvitedRights(roles=("viewer",)), name="Dr Cy"), "ada"
    )
    await office.write(offer.records)
    assert inside(await office.redeem(offer.code.reveal(), name="x")).person.name == "Dr Cy"


async def test_looking_uses_nothing_up(office: Office) -> None:
    code, made = await office.invite("operator", robots=("kuka1",))
    seen = office.enrolment.look(code, CY, private=True)
    assert seen == made
    assert words.invited(made.given.words) == "Hello. You are invited as operator on kuka1."
    inside(await office.redeem(code))


async def test_nobody_uses_their_own_invitation(office: Office) -> None:
    code, _ = await office.invite("operator")
    assert away(await office.redeem(code, ADA)).kind == "code-own"
    inside(await office.redeem(code, CY))


# ---- a code that is not good ----


async def test_every_code_that_is_not_good_gets_the_same_answer(office: Office) -> None:
    used, _ = await office.invite("viewer")
    inside(await office.redeem(used, CY))
    burnt, _ = await office.invite("viewer")
    await office.redeem(burnt, CY, private=False)
    withdrawn, made = await office.invite("viewer")
    await office.write(office.enrolment.invitations.withdraw(made.id, "ada"))
    expired, _ = await office.invite("viewer")
    await office.clock.advance(601.0)

    found = {}
    for number, code in enumerate((used, burnt, withdrawn, expired, "0000-0000", "x")):
        answer = away(await office.redeem(code, account(number)))
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
    assert office.tally["code-unknown"] == 2
    assert all(office.tally[kind] >= 1 for kind in found)


async def test_a_second_tap_on_ones_own_link_is_no_guess(office: Office) -> None:
    code, _ = await office.invite("viewer")
    done = inside(await office.redeem(code))
    for _ in range(10):
        assert away(await office.redeem(code)).sentence == words.AGAIN
    # Somebody else, though known here, does not learn that it was a code.
    await office.knows("di", "Di", DI, roles=("viewer",))
    assert away(await office.redeem(code, DI)).sentence == words.NOT_GOOD
    office.authoriser.revoke(done.key.id)
    assert away(await office.redeem(code)).sentence == words.NOT_GOOD


async def test_a_code_in_a_group_is_burnt_and_the_admins_hear_of_it(office: Office) -> None:
    code, _ = await office.invite("operator", robots=("kuka1",))
    answer = away(await office.redeem(code, private=False))
    assert answer.alarm is not None
    assert answer.alarm.sentence == (
        "A code for operator on kuka1 was shown in a group. It is not good any more. "
        "Invite again, and send the code to one person."
    )
    assert away(await office.redeem(code, DI)).kind == "code-burnt"
    # A code that is none looks the same to the group.
    assert away(await office.redeem("0000-0000", private=False)).sentence == answer.sentence
    assert code.replace("-", "") not in str(answer)


async def test_a_code_inside_any_message_of_a_group_is_burnt(office: Office) -> None:
    code, _ = await office.invite("viewer")
    shown = office.enrolment.shown_in
    assert shown("please move-back a bit, and let us join at 17-18") == ()
    [found] = shown(f"who wants {code.lower()}?")
    answer = office.enrolment.leaked(found, CY)
    assert answer is not None
    assert answer.alarm is not None
    await office.write(answer.records)
    assert shown(f"who wants {code.lower()}?") == ()
    assert office.enrolment.leaked(code, CY) is None
    assert office.tally["code-unknown"] == 0


async def test_a_burnt_code_is_burnt_even_while_joining_is_paused(office: Office) -> None:
    code, _ = await office.invite("viewer")
    for _ in range(6):
        await office.redeem("0000-0000")
    assert away(await office.redeem(code)).kind == "code-paused"
    assert away(await office.redeem(code, private=False)).kind == "code-in-group"


async def test_an_invitation_ends_with_its_issuer(office: Office) -> None:
    stolen, _ = await office.invite("operator", by="ada")
    other, _ = await office.invite("operator", by="bo")
    await office.write(office.locks.lock("ada", "bo"))
    office.authoriser.revoke("k-bo")
    assert away(await office.redeem(stolen)).kind == "code-withdrawn"
    assert away(await office.redeem(other)).kind == "code-withdrawn"


async def test_whoever_is_locked_does_not_come_in_by_another_code(office: Office) -> None:
    await office.knows("cy", "Cy", CY, roles=("viewer",))
    code, _ = await office.invite("operator")
    await office.write(office.locks.lock("cy", "ada"))
    assert away(await office.redeem(code)).kind == "code-locked"


# ---- the first admin ----


async def test_the_first_admin_comes_in_by_a_code_that_dies_with_the_next() -> None:
    office = await Office().opened()
    first = office.enrolment.first_admin_code()
    assert first is not None
    await office.write(first.records)
    again = await office.restarted()
    second = again.enrolment.first_admin_code()
    assert second is not None
    await again.write(second.records)

    assert away(await again.redeem(first.code.reveal())).kind == "code-withdrawn"
    done = inside(await again.redeem(second.code.reveal()))
    assert done.person.roles == ("admin",)
    assert again.enrolment.first_admin_code() is None
    assert f"join {second.code.reveal()}" in second.sentence


async def test_the_code_of_the_first_admin_ends_when_there_is_one() -> None:
    office = await Office().opened()
    offer = office.enrolment.first_admin_code()
    assert offer is not None
    await office.write(offer.records)
    await office.knows("ada", "Ada", ADA, roles=("admin",))
    assert away(await office.redeem(offer.code.reveal())).kind == "code-withdrawn"


async def test_an_only_admin_whose_access_ended_comes_back_by_the_owners_code() -> None:
    office = await Office().opened()
    await office.knows("ada", "Ada", ADA, roles=("admin",))
    office.authoriser.revoke("k-ada")
    offer = office.enrolment.first_admin_code()
    assert offer is not None
    await office.write(offer.records)
    assert inside(await office.redeem(offer.code.reveal(), ADA)).person.id == "ada"
