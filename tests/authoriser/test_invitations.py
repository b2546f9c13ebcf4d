"""What an invitation may be, what is written of it, and what outlives a restart or damage."""

from __future__ import annotations

from typing import TYPE_CHECKING

import msgspec
import pytest

from rosic.authoriser.enrolment_records import Answer, CodeRedeemed, EnrolmentRefused
from rosic.authoriser.invitations import InvitationRequest, InvitedRights
from rosic.authoriser.invite_codes import ALPHABET, CODE_BYTES
from rosic.core.identity import OPERATOR
from rosic.core.records import Fact
from rosic.errors import NotUnderstood, OutOfBounds, Refusal
from tests.authoriser.enrolment_rooms import BO, CY, DI, EnrolmentRooms, account

if TYPE_CHECKING:
    from rosic.contracts.clock import Entropy

DAY_S = 86_400.0


@pytest.fixture
async def enrolling() -> EnrolmentRooms:
    return await EnrolmentRooms().with_admins()


def away(answer: Answer) -> EnrolmentRefused:
    assert isinstance(answer, EnrolmentRefused), answer
    return answer


def inside(answer: Answer) -> CodeRedeemed:
    assert isinstance(answer, CodeRedeemed), answer
    return answer


# ---- what an invitation may be ----


@pytest.mark.parametrize(
    ("changes", "error"),
    [
        ({"roles": ()}, NotUnderstood),
        ({"roles": ("",)}, NotUnderstood),
        ({"scopes": ("kuka1",)}, NotUnderstood),
        ({"robots": ("kuka1:*",)}, NotUnderstood),
        ({"limits": ("fast",)}, NotUnderstood),
        ({"scopes": ("KUKA:*",)}, NotUnderstood),
        ({"lasts_s": 0.0}, OutOfBounds),
        ({"lasts_s": -1.0}, OutOfBounds),
        ({"lasts_s": float("nan")}, OutOfBounds),
        ({"lasts_s": float("inf")}, OutOfBounds),
    ],
)
async def test_what_is_no_invitation_is_refused(
    enrolling: EnrolmentRooms, changes: dict[str, object], error: type[Refusal]
) -> None:
    given = msgspec.structs.replace(InvitedRights(roles=("viewer",)), **changes)
    with pytest.raises(error, match="Nothing was done"):
        enrolling.enrolment.invitations.invite(InvitationRequest(given=given), "ada")
    for code_ttl_s in (0.0, 8 * DAY_S, float("nan")):
        wanted = InvitationRequest(given=InvitedRights(roles=("viewer",)), code_ttl_s=code_ttl_s)
        with pytest.raises(OutOfBounds, match="Nothing was done"):
            enrolling.enrolment.invitations.invite(wanted, "ada")
    assert enrolling.enrolment.invitations.open() == ()


class Unlucky:
    """Draws a code that says stop in Spanish, then others."""

    def __init__(self, entropy: Entropy) -> None:
        symbols = "4GS5PARA"
        number = sum(ALPHABET.index(s) << shift for s, shift in zip(symbols, range(35, -1, -5)))  # noqa: B905
        self.drawn = [number.to_bytes(CODE_BYTES, "big")]
        self._entropy = entropy

    def token(self, length: int) -> bytes:
        if length == CODE_BYTES and self.drawn:
            return self.drawn.pop()
        return self._entropy.token(length)


async def test_no_code_is_heard_as_a_stop(enrolling: EnrolmentRooms) -> None:
    invitations = enrolling.enrolment.invitations
    unlucky = invitations._entropy = Unlucky(invitations._entropy)
    offer = invitations.invite(InvitationRequest(given=InvitedRights(roles=("viewer",))), "ada")
    assert not unlucky.drawn, "the code was drawn"
    assert "PARA" not in offer.code.reveal()


async def test_deciding_alone_changes_nothing(enrolling: EnrolmentRooms) -> None:
    code, made = await enrolling.invite("viewer")
    for address in (CY, DI, account(1)):
        inside(enrolling.enrolment.redeem(code, address, private=True, name="Cy"))
    enrolling.enrolment.redeem(code, CY, private=False)
    enrolling.enrolment.invitations.withdraw(made.id, "ada")
    assert enrolling.enrolment.invitations.open() == (made,)


async def test_what_is_written_names_nobody_and_tells_no_code(enrolling: EnrolmentRooms) -> None:
    offer = enrolling.enrolment.invitations.invite(
        InvitationRequest(given=InvitedRights(roles=("viewer",)), name="Zenobia"), "ada"
    )
    await enrolling.write(offer.records)
    answer = await enrolling.redeem(offer.code.reveal(), BO)
    await enrolling.redeem("0000-0000", DI, name="Zenobia")
    bodies = b"".join(
        record.body for record in (*offer.records, *answer.records) if isinstance(record, Fact)
    )
    for secret in (offer.code.reveal(), offer.code.reveal().replace("-", ""), "Zenobia", "1002"):
        assert secret.encode() not in bodies
    pepper = [r for r in offer.records if isinstance(r, Fact) and r.kind == "code-key"]
    assert pepper[0].letter is not None
    assert pepper[0].letter.content not in bodies
    assert pepper[0].letter.container == OPERATOR


# ---- over a restart, and with damage ----


async def test_a_restart_forgets_nothing_that_counts(enrolling: EnrolmentRooms) -> None:
    used, _ = await enrolling.invite("viewer")
    inside(await enrolling.redeem(used))
    good, _ = await enrolling.invite("viewer")
    again = await enrolling.restarted()
    assert away(await again.redeem(used, DI)).kind == "code-used"
    inside(await again.redeem(good, DI))


async def test_a_damaged_invitation_lets_nobody_in_and_stops_nobody(
    enrolling: EnrolmentRooms,
) -> None:
    bad, made = await enrolling.invite("viewer")
    good, _ = await enrolling.invite("viewer")
    for body in (b"\xc1", b"\x80", b"{}", msgspec.msgpack.encode({"id": "other"})):
        enrolling.enrolment.apply(Fact(kind="invitation", key=made.id, body=body))
        assert away(await enrolling.redeem(bad, account(len(body)))).kind == "code-unknown"
    inside(await enrolling.redeem(good))


async def test_without_the_sealed_key_no_code_is_good_until_one_is_made_anew(
    enrolling: EnrolmentRooms,
) -> None:
    old, _ = await enrolling.invite("viewer")
    enrolling.enrolment.apply(Fact(kind="code-key", key="code-key", body=b"\x01"))
    assert away(await enrolling.redeem(old)).kind == "code-unknown"
    new, _ = await enrolling.invite("viewer")
    inside(await enrolling.redeem(new))


async def test_a_clock_set_back_revives_no_code(enrolling: EnrolmentRooms) -> None:
    code, _ = await enrolling.invite("viewer")
    await enrolling.clock.advance(601.0)
    await enrolling.write(enrolling.time.due())
    enrolling.clock.jump_wall(-DAY_S)
    assert away(await enrolling.redeem(code)).kind == "code-expired"
    again = await enrolling.restarted()
    assert away(await again.redeem(code)).kind == "code-expired"


async def test_a_clock_set_back_lengthens_no_code(enrolling: EnrolmentRooms) -> None:
    code, _ = await enrolling.invite("viewer")
    enrolling.clock.jump_wall(-DAY_S)
    await enrolling.clock.advance(601.0)
    assert away(await enrolling.redeem(code)).kind == "code-expired"


async def test_what_ended_long_ago_is_forgotten(enrolling: EnrolmentRooms) -> None:
    await enrolling.invite("viewer")
    await enrolling.clock.advance(600.0 + 6 * DAY_S)
    assert enrolling.enrolment.invitations.stale() == ()
    await enrolling.clock.advance(DAY_S + 1)
    stale = enrolling.enrolment.invitations.stale()
    assert [fact.body for fact in stale] == [b""]
    await enrolling.write(stale)
    assert (await enrolling.store.open()).facts.get("invitation") is None
