"""Buckets of people, robots and roles; what a restart and a crash leave of them."""

from __future__ import annotations

from itertools import combinations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rosic.core.rate_limit import RateLimit, parse_rate
from rosic.core.records import Fact
from rosic.organiser.rate_limits import FILL, KIND, OPEN, SAVE_EVERY_S, RateLimits
from rosic.testing.clock import ManualClock

S = 1_000_000_000


class RatesOnDisk:
    """Rates with a record of their facts, as it is on the disk."""

    def __init__(
        self, person: RateLimit, robot: RateLimit | None = None, role: RateLimit | None = None
    ) -> None:
        self.clock = ManualClock()
        self.disk: dict[str, Fact] = {}
        self.limits = (person, robot, role)
        self.begin()

    def begin(self) -> None:
        self.up_s = 0
        person, robot, role = self.limits
        robots = {"omni": robot} if robot else {}
        self.roles = {"student": role} if role else {}
        self.rates = RateLimits(self.clock, person, robots, self.roles, self.keep, str.upper)
        self.rates.restore(self.disk.values())

    def keep(self, *facts: Fact) -> None:
        for fact in facts:
            assert fact.kind == KIND
            if fact.body:
                self.disk[fact.key] = fact
            else:
                self.disk.pop(fact.key, None)

    def save(self) -> None:
        self.keep(*self.rates.save())

    def waits(self, seconds: int) -> None:
        """Let time pass as the task that saves sees it."""
        for _ in range(seconds):
            self.clock._move_to(self.clock.monotonic_ns() + S)
            self.up_s += 1
            if self.up_s % SAVE_EVERY_S == 0:
                self.save()

    async def passes(self, seconds: float) -> None:
        await self.clock.advance(seconds)

    def enter(self, who: str = "ada") -> bool:
        return not self.rates.enter(who, self.clock.monotonic_ns())

    def robot(self, cost: float = 1.0) -> bool:
        return self.rates.spend("ada", 1.0, [("omni", cost)], {}) is None

    def role(self, cost: float = 1.0) -> bool:
        return self.rates.spend("ada", cost, [], self.roles) is None


SLOW = RateLimit(burst=4, per_s=0.1)
WIDE = RateLimit(burst=1e6, per_s=1e6)


@pytest.mark.parametrize(
    ("text", "burst", "per_s"),
    [("30/min", 30, 0.5), ("1/s", 1, 1), ("86400 / day burst 5", 5, 1), ("36/h, burst 2", 2, 0.01)],
)
def test_a_rate_is_read(text: str, burst: float, per_s: float) -> None:
    assert parse_rate(text) == RateLimit(burst=burst, per_s=per_s)


@pytest.mark.parametrize("text", ["", "30", "0/min", "30/year", "-1/s", "1/s burst 0", "nan/s"])
def test_what_is_no_rate(text: str) -> None:
    with pytest.raises(ValueError, match="is not a rate: write for example"):
        parse_rate(text)


async def test_a_robot_and_a_role_have_buckets_of_their_own() -> None:
    rates_on_disk = RatesOnDisk(
        WIDE, robot=RateLimit(burst=3, per_s=1), role=RateLimit(burst=5, per_s=1)
    )
    assert [rates_on_disk.robot() for _ in range(4)] == [True, True, True, False]
    assert [rates_on_disk.role(2) for _ in range(3)] == [True, True, False]
    await rates_on_disk.passes(1)
    assert (rates_on_disk.robot(), rates_on_disk.role(2)) == (True, True)


def test_whose_limit_it_is_is_said() -> None:
    rates_on_disk = RatesOnDisk(
        RateLimit(burst=3, per_s=0.5),
        robot=RateLimit(burst=1, per_s=0.01),
        role=RateLimit(burst=1, per_s=0.0001),
    )
    assert rates_on_disk.robot()
    assert rates_on_disk.role()
    said = str(rates_on_disk.rates.spend("ada", 1.0, [("omni", 1.0)], {}))
    assert said == (
        "OMNI has had as many commands as it takes, from everybody together. "
        "Nothing was done. Again in 100 s."
    )
    said = str(rates_on_disk.rates.spend("ada", 1.0, [], rates_on_disk.roles))
    assert said == (
        "Your role has asked for as much as it may: everybody who is student, together. "
        "Nothing was done. Again in 3 h."
    )
    assert rates_on_disk.rates.spend("ada", 3.0, [], {}) is None
    said = str(rates_on_disk.rates.spend("ada", 3.0, [], {}))
    assert said == "That is more than one person may ask. Again in 2 s."


def test_of_several_buckets_all_give_or_none_does() -> None:
    rates_on_disk = RatesOnDisk(
        WIDE, robot=RateLimit(burst=1, per_s=0.01), role=RateLimit(burst=2, per_s=0.01)
    )

    def both() -> bool:
        roles = rates_on_disk.roles
        return rates_on_disk.rates.spend("ada", 1.0, [("omni", 1.0)], roles) is None

    assert both()
    assert not any(both() for _ in range(5))
    assert rates_on_disk.role(), "what the robot refused took nothing from the role"


def test_what_costs_more_than_a_full_bucket_takes_a_full_one() -> None:
    rates_on_disk = RatesOnDisk(RateLimit(burst=3, per_s=1), robot=RateLimit(burst=2, per_s=1))
    assert rates_on_disk.enter()
    assert rates_on_disk.rates.spend("ada", 100.0, [("omni", 100.0)], {}) is None
    assert rates_on_disk.rates.spend("ada", 100.0, [("omni", 100.0)], {}) is not None


async def test_a_restart_gives_back_what_was_left_and_what_came_meanwhile() -> None:
    rates_on_disk = RatesOnDisk(SLOW, robot=SLOW)
    assert [rates_on_disk.enter() for _ in range(3)] == [True] * 3
    assert [rates_on_disk.robot() for _ in range(5)] == [True] * 4 + [False]
    rates_on_disk.save()
    await rates_on_disk.passes(10)
    rates_on_disk.begin()
    assert [rates_on_disk.enter() for _ in range(3)] == [True, True, False]
    assert [rates_on_disk.robot() for _ in range(2)] == [True, False]
    assert rates_on_disk.enter("bo"), "who asked for nothing has a full bucket"


async def test_a_crash_with_nothing_unsaved_gives_back_what_was_left() -> None:
    rates_on_disk = RatesOnDisk(SLOW)
    rates_on_disk.enter()
    rates_on_disk.save()
    await rates_on_disk.passes(1_000)
    rates_on_disk.begin()
    assert [rates_on_disk.enter() for _ in range(5)] == [True] * 4 + [False]


async def test_after_a_crash_nobody_gets_more_than_the_limit() -> None:
    rates_on_disk = RatesOnDisk(SLOW)
    rates_on_disk.save()
    assert [rates_on_disk.enter() for _ in range(5)] == [True] * 4 + [False]
    assert OPEN in rates_on_disk.disk
    rates_on_disk.begin()
    assert not rates_on_disk.enter()
    assert not rates_on_disk.enter("bo"), "nobody knows what he took"
    await rates_on_disk.passes(2 * SAVE_EVERY_S + 9)
    assert rates_on_disk.enter()
    again = RatesOnDisk(SLOW)
    again.enter()
    await again.passes(2 * SAVE_EVERY_S + 40)
    again.begin()
    assert [again.enter() for _ in range(5)] == [True] * 4 + [False], "it filled while it was down"


async def test_what_was_taken_long_after_the_mark_counts_after_a_crash_too() -> None:
    rates_on_disk = RatesOnDisk(SLOW)
    assert rates_on_disk.enter()
    await rates_on_disk.passes(SAVE_EVERY_S - 1)
    assert [rates_on_disk.enter() for _ in range(4)] == [True] * 3 + [False]
    await rates_on_disk.passes(1)
    rates_on_disk.begin()
    assert not rates_on_disk.enter()


def test_what_cannot_be_read_counts_as_empty(caplog: pytest.LogCaptureFixture) -> None:
    rates_on_disk = RatesOnDisk(SLOW)
    rates_on_disk.disk[FILL] = Fact(kind=KIND, key=FILL, body=b"\xff")
    rates_on_disk.begin()
    assert not rates_on_disk.enter()
    assert "cannot be read" in caplog.text


async def test_only_buckets_in_use_are_kept() -> None:
    rates_on_disk = RatesOnDisk(SLOW)
    for number in range(100):
        rates_on_disk.enter(f"p{number}")
    rates_on_disk.save()
    await rates_on_disk.passes(60)
    rates_on_disk.enter()
    rates_on_disk.save()
    assert len(rates_on_disk.rates._people) == 1
    assert not rates_on_disk.rates.save(), "nothing was taken since"


steps = st.lists(
    st.one_of(
        st.tuples(st.just("take"), st.integers(1, 4)),
        st.tuples(st.just("wait"), st.integers(1, 40)),
        st.tuples(st.sampled_from(["save", "crash", "close"]), st.just(0)),
    ),
    max_size=40,
)


@settings(max_examples=300, deadline=None)
@given(steps)
def test_no_history_of_crashes_gives_more_than_the_limit(history: list[tuple[str, int]]) -> None:
    """Between any two moments: at most a burst and what fills meanwhile."""
    rates_on_disk = RatesOnDisk(SLOW)
    taken: list[int] = []
    for step, much in history:
        if step == "take":
            now_ns = rates_on_disk.clock.monotonic_ns()
            taken += [now_ns for _ in range(much) if rates_on_disk.enter()]
        elif step == "wait":
            rates_on_disk.waits(much)
        else:
            if step != "crash":
                rates_on_disk.save()
            if step != "save":
                rates_on_disk.begin()
    for first, last in combinations(range(len(taken)), 2):
        allowed = SLOW.burst + (taken[last] - taken[first]) / S * SLOW.per_s
        assert last - first + 1 <= allowed + 1e-6
