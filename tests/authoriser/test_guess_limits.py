"""How many wrong codes are too many, counted to the nanosecond."""

from __future__ import annotations

import msgspec
import pytest

from rosic.authoriser.guessing import ADDRESSES_AT_MOST, BruteForceGuard, GuessLimits
from rosic.core.identity import Address

S = 1_000_000_000
START = 10 * S


def somebody(number: int = 0) -> Address:
    return Address("memory", str(number))


def opened(guessing: BruteForceGuard, now_ns: int = START) -> int:
    """Open the breaker with codes of as many addresses as it takes; return until when."""
    wrong = [guessing.wrong(somebody(1_000 + number), now_ns) for number in range(50)]
    assert wrong == [False] * 49 + [True]
    return now_ns + 3_600 * S


@pytest.mark.parametrize("name", ["tries", "breaker_tries", "breaker_each"])
def test_there_is_at_least_one_try(name: str) -> None:
    assert getattr(msgspec.convert({name: 1}, GuessLimits), name) == 1
    with pytest.raises(msgspec.ValidationError, match="greater than 0"):
        msgspec.convert({name: 0}, GuessLimits)


@pytest.mark.parametrize("name", ["pause_s", "breaker_within_s", "breaker_pause_s"])
def test_there_is_some_pause(name: str) -> None:
    assert getattr(msgspec.convert({name: 0.5}, GuessLimits), name) == 0.5
    with pytest.raises(msgspec.ValidationError, match="greater than 0"):
        msgspec.convert({name: 0.0}, GuessLimits)


def test_an_address_waits_from_its_fifth_wrong_code_on_until_the_pause_is_over() -> None:
    guessing = BruteForceGuard(GuessLimits())
    for tries in range(5):
        assert guessing.pause_s(somebody(), START + tries) == 0.0
        guessing.wrong(somebody(), START + tries)
    last = START + 4
    assert guessing.pause_s(somebody(), last) == 900.0
    assert guessing.pause_s(somebody(), last + 900 * S - 1) == 1e-9
    assert guessing.pause_s(somebody(), last + 900 * S) == 0.0
    assert guessing.pause_s(somebody(), last + 901 * S) == 0.0, "never less than nothing"
    assert guessing.pause_s(Address("other", "0"), last) == 0.0


@pytest.mark.parametrize(("later_ns", "waits"), [(900 * S - 1, True), (900 * S, False)])
def test_wrong_codes_are_forgotten_as_long_after_the_last(later_ns: int, *, waits: bool) -> None:
    guessing = BruteForceGuard(GuessLimits())
    for _ in range(4):
        guessing.wrong(somebody(), START)
    guessing.wrong(somebody(), START + later_ns)
    assert (guessing.pause_s(somebody(), START + later_ns) > 0) is waits


@pytest.mark.parametrize(("later_ns", "opens"), [(0, True), (1, False)])
def test_the_breaker_looks_back_just_so_long(later_ns: int, *, opens: bool) -> None:
    guessing = BruteForceGuard(GuessLimits())
    for number in range(49):
        assert not guessing.wrong(somebody(number), START + number)
    assert guessing.wrong(somebody(50), START + 3_600 * S + later_ns) is opens


@pytest.mark.parametrize(("early_ns", "anew"), [(1, False), (0, True)])
def test_a_breaker_that_has_closed_opens_anew_and_an_open_one_stays_so(
    early_ns: int, *, anew: bool
) -> None:
    guessing = BruteForceGuard(GuessLimits())
    until_ns = opened(guessing)
    for number in range(49):
        assert not guessing.wrong(somebody(number), until_ns - 2)
    assert guessing.wrong(somebody(50), until_ns - early_ns) is anew
    # Either way it is open for as long again.
    later_ns = until_ns + 3_600 * S - early_ns - 1
    for _ in range(2):
        guessing.wrong(somebody(77), later_ns)
    assert guessing.pause_s(somebody(77), later_ns) == 3_600.0


@pytest.mark.parametrize(("early_ns", "tries", "pause_s"), [(1, 2, 3_600.0), (0, 5, 900.0)])
def test_while_the_breaker_is_open_there_are_fewer_tries_and_a_longer_pause(
    early_ns: int, tries: int, pause_s: float
) -> None:
    guessing = BruteForceGuard(GuessLimits())
    now_ns = opened(guessing) - early_ns
    for _ in range(tries):
        assert guessing.pause_s(somebody(), now_ns) == 0.0
        guessing.wrong(somebody(), now_ns)
    assert guessing.pause_s(somebody(), now_ns) == pause_s


def test_an_open_breaker_makes_nothing_easier() -> None:
    guessing = BruteForceGuard(GuessLimits(tries=1, pause_s=7_200.0))
    now_ns = opened(guessing)
    guessing.wrong(somebody(), now_ns - 1)
    assert guessing.pause_s(somebody(), now_ns - 1) == 7_200.0


def test_whoever_has_a_right_code_begins_anew() -> None:
    guessing = BruteForceGuard(GuessLimits())
    for _ in range(4):
        guessing.wrong(somebody(), START)
    guessing.right(somebody())
    guessing.right(somebody(9))
    guessing.wrong(somebody(), START)
    assert guessing.pause_s(somebody(), START) == 0.0


def test_an_admin_lets_everybody_try_again_as_if_nothing_had_been() -> None:
    guessing = BruteForceGuard(GuessLimits())
    opened(guessing)
    for number in range(49):
        guessing.wrong(somebody(number // 2), START + 1)
    assert guessing.pause_s(somebody(), START + 1) > 0
    guessing.reopen()
    for tries in range(5):
        assert guessing.pause_s(somebody(), START + 1) == 0.0, tries
        assert not guessing.wrong(somebody(), START + 1), "49 before do not count any more"
    assert guessing.pause_s(somebody(), START + 1) == 900.0


def test_of_too_many_addresses_those_seen_longest_ago_are_forgotten() -> None:
    """Never the one that has just been wrong: it would have as many tries as it likes."""
    guessing = BruteForceGuard(GuessLimits(breaker_tries=10**9))
    for number in range(ADDRESSES_AT_MOST):
        for _ in range(4):
            guessing.wrong(somebody(number), START)
    guessing.wrong(somebody(0), START)
    for _ in range(5):
        guessing.wrong(somebody(-1), START)
    assert len(guessing._tries) == ADDRESSES_AT_MOST
    assert guessing.pause_s(somebody(0), START) > 0
    assert guessing.pause_s(somebody(-1), START) > 0
    guessing.wrong(somebody(1), START)
    assert guessing.pause_s(somebody(1), START) == 0.0, "forgotten, with its four"
    guessing.wrong(somebody(3), START)
    assert guessing.pause_s(somebody(3), START) > 0, "not forgotten"
