"""Guessing codes: five tries an address, a breaker for all, and one word to the admins."""

from __future__ import annotations

from collections import Counter
from math import log
from pathlib import Path

import pytest

from rosic.authoriser import messages as words
from rosic.authoriser.enrolment_records import Answer, CodeRedeemed, EnrolmentRefused
from rosic.authoriser.guessing import ADDRESSES_AT_MOST, BruteForceGuard, GuessLimits
from rosic.authoriser.invite_codes import new_code
from rosic.testing.clock import SeededEntropy
from tests.authoriser.enrolment_rooms import DI, EnrolmentRooms, account


@pytest.fixture
async def enrolling() -> EnrolmentRooms:
    return await EnrolmentRooms().with_admins()


def away(answer: Answer) -> EnrolmentRefused:
    assert isinstance(answer, EnrolmentRefused), answer
    return answer


def guesses(count: int) -> list[str]:
    entropy = SeededEntropy(77)
    return [new_code(entropy).reveal() for _ in range(count)]


async def test_five_wrong_codes_then_a_pause_even_for_the_right_one(
    enrolling: EnrolmentRooms,
) -> None:
    code, _ = await enrolling.invite("viewer")
    for guess in guesses(5):
        assert away(await enrolling.redeem(guess)).sentence == words.NOT_GOOD
    paused = away(await enrolling.redeem(code))
    assert paused.kind == "code-paused"
    assert paused.sentence == (
        "Too many wrong codes. Try again in 15 minutes, or ask whoever invited you."
    )
    # Others are not held up, and the code was not used.
    await enrolling.clock.advance(300.0)
    assert away(await enrolling.redeem(code)).kind == "code-paused"
    assert isinstance(await enrolling.redeem(code, DI), CodeRedeemed)


async def test_after_the_pause_there_are_five_more(enrolling: EnrolmentRooms) -> None:
    for guess in guesses(5):
        await enrolling.redeem(guess)
    await enrolling.clock.advance(900.0)
    found = Counter([away(await enrolling.redeem(guess)).kind for guess in guesses(6)])
    assert found == {"code-unknown": 5, "code-paused": 1}


async def test_a_right_code_forgives_wrong_ones(enrolling: EnrolmentRooms) -> None:
    for guess in guesses(4):
        await enrolling.redeem(guess)
    code, _ = await enrolling.invite("viewer")
    assert isinstance(await enrolling.redeem(code), CodeRedeemed)
    for guess in guesses(4):
        assert away(await enrolling.redeem(guess)).kind == "code-unknown"


async def test_ten_thousand_guesses_of_one_account_get_five_answers(
    enrolling: EnrolmentRooms,
) -> None:
    await enrolling.invite("viewer")
    found = Counter([away(await enrolling.redeem(guess)).kind for guess in guesses(10_000)])
    assert found == {"code-unknown": 5, "code-paused": 9_995}
    assert enrolling.counters["code-breaker"] == 0
    # One account alone does not shut the door for the others.
    code, _ = await enrolling.invite("viewer")
    assert isinstance(await enrolling.redeem(code, DI), CodeRedeemed)


async def test_guesses_of_many_accounts_leave_each_fewer_tries_and_shut_nobody_out(
    enrolling: EnrolmentRooms,
) -> None:
    code, _ = await enrolling.invite("viewer")
    crowd = [account(number) for number in range(2_000)]
    answers = [
        away(await enrolling.redeem(guess, crowd[number % len(crowd)]))
        for number, guess in enumerate(guesses(10_000))
    ]
    # Fifty, and then two of each: the rest is not even looked at.
    found = Counter(answer.kind for answer in answers)
    assert found == {"code-unknown": 4_000, "code-paused": 6_000}
    # The admins hear of it once.
    alarms = [answer.alarm for answer in answers if answer.alarm is not None]
    assert len(alarms) == enrolling.counters["code-breaker"] == 1
    assert alarms[0].sentence.startswith("50 wrong codes came in within 60 minutes: somebody may")
    # Whoever has a code gets in, with a slip of a finger, too.
    assert away(await enrolling.redeem("0000-0000")).kind == "code-unknown"
    assert isinstance(await enrolling.redeem(code), CodeRedeemed)


async def test_while_many_guess_a_pause_is_longer_until_an_admin_ends_it(
    enrolling: EnrolmentRooms,
) -> None:
    code, _ = await enrolling.invite("viewer")
    for number, guess in enumerate(guesses(50)):
        await enrolling.redeem(guess, account(number))
    kinds = [away(await enrolling.redeem(guess)).kind for guess in guesses(3)]
    assert kinds == ["code-unknown", "code-unknown", "code-paused"]
    await enrolling.clock.advance(3_500.0)
    assert away(await enrolling.redeem(code)).kind == "code-paused"
    await enrolling.write(enrolling.enrolment.reopen("ada"))
    code, _ = await enrolling.invite("viewer")
    assert isinstance(await enrolling.redeem(code), CodeRedeemed)


async def test_the_breaker_closes_by_itself(enrolling: EnrolmentRooms) -> None:
    for number, guess in enumerate(guesses(50)):
        await enrolling.redeem(guess, account(number))
    await enrolling.clock.advance(3600.0)
    found = Counter([away(await enrolling.redeem(guess)).kind for guess in guesses(6)])
    assert found == {"code-unknown": 5, "code-paused": 1}


async def test_the_breaker_stays_open_while_guessing_goes_on_and_is_told_once(
    enrolling: EnrolmentRooms,
) -> None:
    alarms = 0
    for number, guess in enumerate(guesses(400)):
        await enrolling.clock.advance(60.0)
        alarms += away(await enrolling.redeem(guess, account(number))).alarm is not None
    assert alarms == 1
    assert [away(await enrolling.redeem(guess)).kind for guess in guesses(3)][2] == "code-paused"


def test_how_long_guessing_would_take_is_as_the_page_says() -> None:
    """Ten thousand accounts that guess day and night, and ten codes that are good all the time."""
    limits = GuessLimits()
    a_day = 10_000 * limits.breaker_each * 86_400.0 / limits.breaker_pause_s
    assert a_day == 480_000
    days = log(2) / (a_day * 10 / 2**40)
    assert 430 < days / 365.25 < 440
    page = Path("docs/rooms/authoriser.md").read_text(encoding="utf-8")
    assert "480,000 a day" in page
    assert "435 years" in page


async def test_wrong_codes_now_and_then_open_no_breaker(enrolling: EnrolmentRooms) -> None:
    for number, guess in enumerate(guesses(200)):
        await enrolling.clock.advance(80.0)
        assert away(await enrolling.redeem(guess, account(number))).kind == "code-unknown"


async def test_wrong_codes_in_groups_count(enrolling: EnrolmentRooms) -> None:
    for number, guess in enumerate(guesses(49)):
        await enrolling.redeem(guess, account(number), private=False)
    assert away(await enrolling.redeem("0000-0000", private=False)).alarm is not None


async def test_whoever_guesses_in_a_group_is_told_the_same_before_a_pause_and_in_it(
    enrolling: EnrolmentRooms,
) -> None:
    told = [away(await enrolling.redeem(guess, private=False)) for guess in guesses(7)]
    assert [each.kind for each in told] == ["code-unknown"] * 5 + ["code-paused"] * 2
    assert {each.sentence for each in told} == {words.IN_GROUP}


async def test_limits_are_settings() -> None:
    limits = GuessLimits(tries=1, pause_s=5.0, breaker_tries=3)
    enrolling = await EnrolmentRooms(limits=limits).with_admins()
    kinds = [away(await enrolling.redeem("0000-0000", account(n // 2))).kind for n in range(7)]
    assert kinds == [
        "code-unknown",
        "code-paused",
        "code-unknown",
        "code-paused",
        "code-unknown",
        "code-paused",
        "code-unknown",
    ]


@pytest.mark.parametrize("changes", [{"tries": 0}, {"pause_s": 0.0}, {"breaker_pause_s": -1.0}])
def test_limits_that_are_none_are_refused(changes: dict[str, float]) -> None:
    with pytest.raises(ValueError, match="greater than 0"):
        GuessLimits(**changes)  # type: ignore[arg-type]


def test_a_million_addresses_take_no_more_room() -> None:
    guessing = BruteForceGuard(GuessLimits(breaker_tries=10))
    for number in range(3 * ADDRESSES_AT_MOST):
        guessing.wrong(account(number), number)
    assert len(guessing._tries) == ADDRESSES_AT_MOST
