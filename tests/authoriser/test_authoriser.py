"""Who is this? Addresses, keys, sessions, and the time it takes."""

from __future__ import annotations

import msgspec
import pytest

from rosic.authoriser.authoriser import SESSIONS_AT_MOST, TIMES_KEPT, Authoriser
from rosic.authoriser.counters import Counters
from rosic.authoriser.directory import Directory
from rosic.authoriser.keys import KIND, KeyEnd, KeyRing
from rosic.authoriser.monotonic_clock import MonotonicWallClock
from rosic.core.identity import Address, AuthorisationKey, Principal
from rosic.core.message import Chat, Inbound
from rosic.core.records import Fact
from rosic.errors import Unrecognised
from rosic.testing.clock import ManualClock, SeededEntropy

ADA = Address("telegram", "1001")


def inbound(sender: Address = ADA, chat: str = "c") -> Inbound:
    return Inbound(
        sender=sender,
        chat=Chat(sender.platform, chat),
        message="1",
        text="hi",
        sent_ns=0,
        received_ns=0,
    )


class OnePerson:
    """An authoriser that knows Ada."""

    def __init__(self, *, expires_in_s: float | None = None) -> None:
        self.clock = ManualClock()
        entropy = SeededEntropy()
        self.counters = Counters()
        self.keys = KeyRing(MonotonicWallClock(self.clock), entropy, self.counters)
        self.authoriser = Authoriser(Directory(), self.keys, self.clock, entropy)
        expires_ns = None if expires_in_s is None else self._at(expires_in_s)
        self.key = AuthorisationKey(
            id="k1", principal="p1", issuer="test", issued_ns=0, expires_ns=expires_ns
        )
        person = Principal(id="p1", name="Ada", roles=("operator",), addresses=(ADA,))
        self.authoriser.enrol(person, self.key)

    def _at(self, seconds: float) -> int:
        return self.clock.wall_ns() + int(seconds * 1e9)


def test_a_caller_carries_the_id_of_the_key() -> None:
    caller = OnePerson().authoriser.identify(inbound())
    assert (caller.principal, caller.key, caller.name) == ("p1", "k1", "Ada")


@pytest.mark.parametrize(
    "address", [Address("telegram", "1002"), Address("matrix", "1001"), Address("telegram", "")]
)
def test_identity_is_platform_and_id(address: Address) -> None:
    one = OnePerson()
    with pytest.raises(Unrecognised, match="I do not know you yet"):
        one.authoriser.identify(inbound(address))
    assert one.counters.by_kind() == {"stranger": 1}


def test_a_session_key_per_conversation_that_never_repeats() -> None:
    authoriser = OnePerson().authoriser
    first = authoriser.identify(inbound(chat="a")).session
    assert authoriser.identify(inbound(chat="a")).session == first
    others = {authoriser.identify(inbound(chat=f"c{n}")).session for n in range(1_000)}
    assert len(others | {first}) == 1_001


def test_a_revoked_key_ends_every_conversation_at_once() -> None:
    one = OnePerson()
    one.authoriser.identify(inbound())
    assert one.authoriser.revoke("k1") == "p1"
    with pytest.raises(Unrecognised, match="Your access here has ended"):
        one.authoriser.identify(inbound())
    assert one.authoriser.revoke("no such key") is None


def test_a_key_ends_when_it_expires() -> None:
    one = OnePerson(expires_in_s=60.0)
    one.authoriser.identify(inbound())
    one.clock.jump_wall(60.0)
    with pytest.raises(Unrecognised):
        one.authoriser.identify(inbound())


def test_a_new_key_lets_in_again() -> None:
    one = OnePerson()
    one.authoriser.revoke("k1")
    person = one.authoriser.directory.person("p1")
    assert person is not None
    key = AuthorisationKey(id="k2", principal="p1", issuer="test", issued_ns=1)
    one.authoriser.enrol(person, key)
    assert one.authoriser.identify(inbound()).key == "k2"


def test_the_time_to_authenticate_is_measured() -> None:
    one = OnePerson()
    for _ in range(3):
        one.authoriser.identify(inbound())
    assert len(one.authoriser.times_to_authenticate_s()) == 3


def test_the_newest_times_to_authenticate_are_kept_oldest_first() -> None:
    one = OnePerson()
    ticks = iter(range(10_000_000))
    one.clock.monotonic_ns = lambda: next(ticks) ** 2  # type: ignore[method-assign]
    for _ in range(TIMES_KEPT + 2):
        one.authoriser.identify(inbound())
    times_s = one.authoriser.times_to_authenticate_s()
    assert len(times_s) == TIMES_KEPT
    assert times_s[0] == 9e-9, "the first two are forgotten: from 4 to 5 ticks, squared"
    assert list(times_s) == sorted(times_s)


def test_who_was_recognised_in_a_chat() -> None:
    one = OnePerson()
    one.authoriser.identify(inbound(chat="g"))
    assert one.authoriser.company(Chat("telegram", "g")) == {"p1"}
    assert one.authoriser.company(Chat("telegram", "h")) == frozenset()
    one.authoriser.forget("p1")
    assert one.authoriser.company(Chat("telegram", "g")) == frozenset()


def test_who_was_recognised_longest_ago_is_in_no_chat_any_more() -> None:
    one = OnePerson()
    for number in range(SESSIONS_AT_MOST + 1):
        one.authoriser.identify(inbound(chat=f"g{number}"))
    assert one.authoriser.company(Chat("telegram", "g0")) == frozenset()
    assert one.authoriser.company(Chat("telegram", "g1")) == {"p1"}


def test_somebody_stands_for_a_rule_of_theirs_only_under_a_good_key() -> None:
    one = OnePerson(expires_in_s=60.0)
    caller = one.authoriser.stand_for("p1")
    assert (caller.principal, caller.key, caller.address) == ("p1", "k1", ADA)
    with pytest.raises(Unrecognised):
        one.authoriser.stand_for("nobody")
    assert one.authoriser.has_access("p1")
    over = KeyEnd(by="test", at_ns=one.clock.wall_ns())  # a grace that is over
    one.keys.apply(Fact(kind=KIND, key="k1", body=msgspec.msgpack.encode(over)))
    with pytest.raises(Unrecognised):
        one.authoriser.stand_for("p1")
    assert not one.authoriser.has_access("p1")
    revoked = OnePerson()
    revoked.authoriser.revoke("k1")
    with pytest.raises(Unrecognised):
        revoked.authoriser.stand_for("p1")
