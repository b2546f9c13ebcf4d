"""Keys: which are good, replaced at once or after a grace, taken back for ever."""

from __future__ import annotations

import pytest

from rosic.core.identity import OPERATOR, AuthorisationKey
from rosic.core.records import Decided, Fact, KeyIssued, KeyRevoked
from rosic.errors import NotUnderstood, OutOfBounds, Unrecognised
from tests.authoriser.enrolment_rooms import CY, EnrolmentRooms

HOUR_S = 3600.0
DAY_S = 86_400.0


@pytest.fixture
async def enrolling() -> EnrolmentRooms:
    enrolling = await EnrolmentRooms().with_admins()
    await enrolling.knows("cy", "Cy", CY, roles=("operator",))
    return enrolling


async def limited(
    enrolling: EnrolmentRooms, lasts_s: float, scopes: tuple[str, ...] = ()
) -> AuthorisationKey:
    key, records = enrolling.keys.issue("cy", "ada", scopes=scopes, lasts_s=lasts_s)
    await enrolling.write(records)
    return key


def reasons(enrolling: EnrolmentRooms) -> dict[str, int]:
    return {kind: n for kind, n in enrolling.counters.by_kind().items() if kind.startswith("key-")}


async def test_a_good_key_passes(enrolling: EnrolmentRooms) -> None:
    assert enrolling.keys.check("k-cy").principal == "cy"
    assert [key.id for key in enrolling.keys.of("cy")] == ["k-cy"]
    assert {key.id for key in enrolling.keys.all()} == {"k-ada", "k-bo", "k-cy"}
    assert reasons(enrolling) == {}


async def test_every_bad_key_is_refused_and_counted_by_kind(enrolling: EnrolmentRooms) -> None:
    key = await limited(enrolling, 60.0)
    await enrolling.write(enrolling.keys.revoke("k-cy", "ada").records)
    await enrolling.clock.advance(60.0)
    for bad in ("no such", "k-cy", key.id):
        with pytest.raises(Unrecognised, match="Your access here has ended"):
            enrolling.keys.check(bad)
        assert not enrolling.keys.good(bad)
    assert reasons(enrolling) == {"key-unknown": 1, "key-revoked": 1, "key-expired": 1}


async def test_a_clock_set_back_revives_no_key(enrolling: EnrolmentRooms) -> None:
    key = await limited(enrolling, 60.0)
    await enrolling.clock.advance(60.0)
    assert not enrolling.keys.good(key.id)
    enrolling.clock.jump_wall(-DAY_S)
    assert not enrolling.keys.good(key.id)


async def test_a_key_is_replaced_at_once(enrolling: EnrolmentRooms) -> None:
    old = await limited(enrolling, HOUR_S, ("kuka1:*",))
    rotation = enrolling.keys.rotate("cy", "ada")
    assert [type(r) for r in rotation.records] == [Decided, KeyIssued, KeyRevoked]
    assert enrolling.keys.good(old.id)  # deciding alone changes nothing
    await enrolling.write(rotation.records)
    assert not enrolling.keys.good(old.id)
    # No right grows by it.
    assert (rotation.key.scopes, rotation.key.expires_ns) == (old.scopes, old.expires_ns)
    assert enrolling.keys.current("cy") == rotation.key
    assert enrolling.keys.of("cy")[0] == rotation.key


async def test_a_key_is_replaced_after_a_grace(enrolling: EnrolmentRooms) -> None:
    rotation = enrolling.keys.rotate("cy", "ada", grace_s=HOUR_S)
    await enrolling.write(rotation.records)
    for place in (enrolling, await enrolling.restarted()):
        assert place.keys.good("k-cy")
        assert place.keys.current("cy") == rotation.key
    await enrolling.clock.advance(HOUR_S)
    again = await enrolling.restarted()
    for place in (enrolling, again):
        assert not place.keys.good("k-cy")
        assert place.keys.good(rotation.key.id)


async def test_a_grace_lengthens_no_key(enrolling: EnrolmentRooms) -> None:
    old = await limited(enrolling, 60.0)
    await enrolling.write(enrolling.keys.rotate("cy", "ada", grace_s=DAY_S).records)
    await enrolling.clock.advance(60.0)
    assert not enrolling.keys.good(old.id)


@pytest.mark.parametrize("grace_s", [-1.0, 31 * DAY_S, float("nan"), float("inf")])
async def test_a_grace_that_is_none_is_refused(enrolling: EnrolmentRooms, grace_s: float) -> None:
    with pytest.raises(OutOfBounds, match="at most 30 days"):
        enrolling.keys.rotate("cy", "ada", grace_s=grace_s)


@pytest.mark.parametrize("lasts_s", [0.0, -1.0, float("nan"), float("inf")])
async def test_a_time_that_is_none_is_refused(enrolling: EnrolmentRooms, lasts_s: float) -> None:
    with pytest.raises(OutOfBounds, match="Nothing was done"):
        enrolling.keys.issue("cy", "ada", lasts_s=lasts_s)


async def test_who_has_no_good_key_gets_none_by_rotation(enrolling: EnrolmentRooms) -> None:
    await enrolling.write(enrolling.keys.revoke("k-cy", "ada").records)
    for who in ("cy", "nobody"):
        with pytest.raises(NotUnderstood, match="no good key to replace"):
            enrolling.keys.rotate(who, "ada")


async def test_a_key_is_taken_back_once_and_for_ever(enrolling: EnrolmentRooms) -> None:
    revocation = enrolling.keys.revoke("k-cy", "ada")
    assert revocation.principal == "cy"
    await enrolling.write(revocation.records)
    with pytest.raises(NotUnderstood, match="taken back before"):
        enrolling.keys.revoke("k-cy", "ada")
    with pytest.raises(NotUnderstood, match="no such key"):
        enrolling.keys.revoke("k-none", "ada")
    again = await enrolling.restarted()
    assert not again.keys.good("k-cy")
    again.keys.apply(KeyIssued(key=enrolling.keys.of("cy")[0]))
    assert not again.keys.good("k-cy")


async def test_keys_near_their_end(enrolling: EnrolmentRooms) -> None:
    soon = await limited(enrolling, DAY_S)
    sooner = await limited(enrolling, HOUR_S)
    ended = await limited(enrolling, 1.0)
    await limited(enrolling, 30 * DAY_S)
    await enrolling.clock.advance(1.0)
    assert [(key.id, left_s) for key, left_s in enrolling.keys.near_expiry()] == [
        (sooner.id, HOUR_S - 1),
        (soon.id, DAY_S - 1),
    ]
    states = {key.id: enrolling.keys.state(key) for key in enrolling.keys.of("cy")}
    assert states[sooner.id] == "for 60 minutes"
    assert states[ended.id] == "ended"
    assert states["k-cy"] == "until taken back"
    await enrolling.write(enrolling.keys.revoke(soon.id, OPERATOR).records)
    assert enrolling.keys.state(enrolling.keys.of("cy")[-2]) == "taken back"


async def test_an_end_that_cannot_be_read_is_now(enrolling: EnrolmentRooms) -> None:
    enrolling.keys.apply(Fact(kind="key-end", key="k-cy", body=b"\xc1"))
    assert not enrolling.keys.good("k-cy")
    enrolling.keys.apply(Fact(kind="key-end", key="k-cy", body=b""))
    assert enrolling.keys.good("k-cy")
