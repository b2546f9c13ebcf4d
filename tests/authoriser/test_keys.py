"""Keys: which are good, replaced at once or after a grace, taken back for ever."""

from __future__ import annotations

import pytest

from rosic.core.identity import OPERATOR, AuthorisationKey
from rosic.core.records import Decided, Fact, KeyIssued, KeyRevoked
from rosic.errors import NotUnderstood, OutOfBounds, Unrecognised
from tests.authoriser.office import CY, Office

HOUR_S = 3600.0
DAY_S = 86_400.0


@pytest.fixture
async def office() -> Office:
    office = await Office().with_admins()
    await office.knows("cy", "Cy", CY, roles=("operator",))
    return office


async def limited(office: Office, lasts_s: float, scopes: tuple[str, ...] = ()) -> AuthorisationKey:
    key, records = office.keys.issue("cy", "ada", scopes=scopes, lasts_s=lasts_s)
    await office.write(records)
    return key


def reasons(office: Office) -> dict[str, int]:
    return {kind: n for kind, n in office.tally.by_kind().items() if kind.startswith("key-")}


async def test_a_good_key_passes(office: Office) -> None:
    assert office.keys.check("k-cy").principal == "cy"
    assert [key.id for key in office.keys.of("cy")] == ["k-cy"]
    assert {key.id for key in office.keys.all()} == {"k-ada", "k-bo", "k-cy"}
    assert reasons(office) == {}


async def test_every_bad_key_is_refused_and_counted_by_kind(office: Office) -> None:
    key = await limited(office, 60.0)
    await office.write(office.keys.revoke("k-cy", "ada").records)
    await office.clock.advance(60.0)
    for bad in ("no such", "k-cy", key.id):
        with pytest.raises(Unrecognised, match="Your access here has ended"):
            office.keys.check(bad)
        assert not office.keys.good(bad)
    assert reasons(office) == {"key-unknown": 1, "key-revoked": 1, "key-expired": 1}


async def test_a_clock_set_back_revives_no_key(office: Office) -> None:
    key = await limited(office, 60.0)
    await office.clock.advance(60.0)
    assert not office.keys.good(key.id)
    office.clock.jump_wall(-DAY_S)
    assert not office.keys.good(key.id)


async def test_a_key_is_replaced_at_once(office: Office) -> None:
    old = await limited(office, HOUR_S, ("kuka1:*",))
    rotation = office.keys.rotate("cy", "ada")
    assert [type(r) for r in rotation.records] == [Decided, KeyIssued, KeyRevoked]
    assert office.keys.good(old.id)  # deciding alone changes nothing
    await office.write(rotation.records)
    assert not office.keys.good(old.id)
    # No right grows by it.
    assert (rotation.key.scopes, rotation.key.expires_ns) == (old.scopes, old.expires_ns)
    assert office.keys.current("cy") == rotation.key
    assert office.keys.of("cy")[0] == rotation.key


async def test_a_key_is_replaced_after_a_grace(office: Office) -> None:
    rotation = office.keys.rotate("cy", "ada", grace_s=HOUR_S)
    await office.write(rotation.records)
    for place in (office, await office.restarted()):
        assert place.keys.good("k-cy")
        assert place.keys.current("cy") == rotation.key
    await office.clock.advance(HOUR_S)
    again = await office.restarted()
    for place in (office, again):
        assert not place.keys.good("k-cy")
        assert place.keys.good(rotation.key.id)


async def test_a_grace_lengthens_no_key(office: Office) -> None:
    old = await limited(office, 60.0)
    await office.write(office.keys.rotate("cy", "ada", grace_s=DAY_S).records)
    await office.clock.advance(60.0)
    assert not office.keys.good(old.id)


@pytest.mark.parametrize("grace_s", [-1.0, 31 * DAY_S, float("nan"), float("inf")])
async def test_a_grace_that_is_none_is_refused(office: Office, grace_s: float) -> None:
    with pytest.raises(OutOfBounds, match="at most 30 days"):
        office.keys.rotate("cy", "ada", grace_s=grace_s)


@pytest.mark.parametrize("lasts_s", [0.0, -1.0, float("nan"), float("inf")])
async def test_a_time_that_is_none_is_refused(office: Office, lasts_s: float) -> None:
    with pytest.raises(OutOfBounds, match="Nothing was done"):
        office.keys.issue("cy", "ada", lasts_s=lasts_s)


async def test_who_has_no_good_key_gets_none_by_rotation(office: Office) -> None:
    await office.write(office.keys.revoke("k-cy", "ada").records)
    for who in ("cy", "nobody"):
        with pytest.raises(NotUnderstood, match="no good key to replace"):
            office.keys.rotate(who, "ada")


async def test_a_key_is_taken_back_once_and_for_ever(office: Office) -> None:
    revocation = office.keys.revoke("k-cy", "ada")
    assert revocation.principal == "cy"
    await office.write(revocation.records)
    with pytest.raises(NotUnderstood, match="taken back before"):
        office.keys.revoke("k-cy", "ada")
    with pytest.raises(NotUnderstood, match="no such key"):
        office.keys.revoke("k-none", "ada")
    again = await office.restarted()
    assert not again.keys.good("k-cy")
    again.keys.apply(KeyIssued(key=office.keys.of("cy")[0]))
    assert not again.keys.good("k-cy")


async def test_keys_near_their_end(office: Office) -> None:
    soon = await limited(office, DAY_S)
    sooner = await limited(office, HOUR_S)
    ended = await limited(office, 1.0)
    await limited(office, 30 * DAY_S)
    await office.clock.advance(1.0)
    assert [(key.id, left_s) for key, left_s in office.keys.near_expiry()] == [
        (sooner.id, HOUR_S - 1),
        (soon.id, DAY_S - 1),
    ]
    states = {key.id: office.keys.state(key) for key in office.keys.of("cy")}
    assert states[sooner.id] == "for 60 minutes"
    assert states[ended.id] == "ended"
    assert states["k-cy"] == "until taken back"
    await office.write(office.keys.revoke(soon.id, OPERATOR).records)
    assert office.keys.state(office.keys.of("cy")[-2]) == "taken back"


async def test_an_end_that_cannot_be_read_is_now(office: Office) -> None:
    office.keys.apply(Fact(kind="key-end", key="k-cy", body=b"\xc1"))
    assert not office.keys.good("k-cy")
    office.keys.apply(Fact(kind="key-end", key="k-cy", body=b""))
    assert office.keys.good("k-cy")
