"""Two people with one code, two admins on one question: exactly one of each succeeds."""

from __future__ import annotations

import asyncio
from random import Random
from typing import TYPE_CHECKING

from rosic.authoriser.enrolment_records import ApprovalPending, CodeRedeemed, EnrolmentRefused
from rosic.authoriser.guessing import GuessLimits
from rosic.errors import Expired
from rosic.stores.memory import MemoryStore
from tests.authoriser.enrolment_rooms import CY, DI, EnrolmentRooms, account

if TYPE_CHECKING:
    from rosic.core.records import Record

ROUNDS = 10_000
ROUNDS_EACH = 100
MANY = GuessLimits(tries=10**6, breaker_tries=10**6)


class SlowStore(MemoryStore):
    """Lets others run while it writes, now for longer, now for less."""

    def __init__(self, chance: Random) -> None:
        super().__init__()
        self._chance = chance

    async def write(self, *records: Record) -> None:
        for _ in range(self._chance.randrange(4)):
            await asyncio.sleep(0)
        await super().write(*records)
        for _ in range(self._chance.randrange(3)):
            await asyncio.sleep(0)


class NoLock:
    """What a gateway would have that forgot to serialise changes."""

    async def __aenter__(self) -> None:
        return None

    async def __aexit__(self, *_: object) -> None:
        return None


async def race(rounds: int, *, locked: bool = True) -> dict[str, int]:
    """Count how rounds of two redeemers ended."""
    chance = Random(4)  # noqa: S311  which task yields when, no secret
    ends = {"one": 0, "none": 0, "both": 0}
    enrolling = EnrolmentRooms()
    for number in range(rounds):
        if number % ROUNDS_EACH == 0:
            enrolling = await EnrolmentRooms(
                limits=MANY, store=SlowStore(chance), seed=number
            ).with_admins()
            if not locked:
                enrolling.lock = NoLock()  # type: ignore[assignment]
        code, _ = await enrolling.invite("viewer", confirm=chance.random() < 0.5)
        first, second = CY, DI
        if chance.random() < 0.5:
            first, second = second, first
        answers = await asyncio.gather(
            enrolling.redeem(code, first), enrolling.redeem(code, second)
        )
        won = [answer for answer in answers if not isinstance(answer, EnrolmentRefused)]
        ends[("none", "one", "both")[len(won)]] += 1
        for answer in won:
            if isinstance(answer, ApprovalPending):
                declined = enrolling.enrolment.decline(
                    answer.applicant.pending.id, "ada", may_admit=True
                )
                await enrolling.write(declined.records)
            else:
                assert isinstance(answer, CodeRedeemed)
    return ends


async def test_one_code_lets_exactly_one_in_ten_thousand_times() -> None:
    assert await race(ROUNDS) == {"one": ROUNDS, "none": 0, "both": 0}


async def test_the_race_is_one() -> None:
    """Without the lock that the gateway holds, both come in: the test above can fail."""
    assert (await race(100, locked=False))["both"] > 50


async def test_many_redeemers_of_one_code() -> None:
    chance = Random(5)  # noqa: S311
    enrolling = await EnrolmentRooms(limits=MANY, store=SlowStore(chance)).with_admins()
    code, _ = await enrolling.invite("viewer")
    answers = await asyncio.gather(*(enrolling.redeem(code, a) for a in map(account, range(200))))
    assert sum(isinstance(answer, CodeRedeemed) for answer in answers) == 1
    assert enrolling.counters["code-used"] == 199


async def test_two_admins_tap_at_once() -> None:
    chance = Random(6)  # noqa: S311
    enrolling = await EnrolmentRooms(store=SlowStore(chance)).with_admins()
    for number in range(100):
        code, _ = await enrolling.invite("senior")
        waiting = await enrolling.redeem(code, account(number))
        assert isinstance(waiting, ApprovalPending)
        pending = waiting.applicant.pending.id
        taps = await asyncio.gather(
            enrolling.confirm(pending, "ada"),
            enrolling.confirm(pending, "bo"),
            return_exceptions=True,
        )
        assert sum(isinstance(tap, CodeRedeemed) for tap in taps) == 1
        assert sum(isinstance(tap, Expired) for tap in taps) == 1
