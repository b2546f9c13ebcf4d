"""One holder at most, fences that only grow, and buckets that refill."""

from __future__ import annotations

from hypothesis import given, settings
from hypothesis import strategies as st

from rosic.core.lease import Lease
from rosic.core.rate_limit import Bucket, RateLimit

IDLE_NS = 10
S = 1_000_000_000

steps = st.lists(
    st.tuples(st.sampled_from(["take", "settle", "wait", "release"]), st.sampled_from("abc")),
    max_size=40,
)


@settings(max_examples=500, deadline=None)
@given(steps)
def test_one_holder_and_a_growing_fence(history: list[tuple[str, str]]) -> None:
    lease, now, under_way = Lease(0), 0, dict[str, list[int]]()
    for step, who in history:
        fence = lease.fence
        if step == "take":
            holder = lease.holder_at(now, IDLE_NS)
            if holder in (None, who):
                grew = lease.take(who, now, IDLE_NS)
                assert grew is (holder is None)
                under_way.setdefault(who, []).append(lease.fence)
        elif step == "settle" and under_way.get(who):
            lease.settle(under_way[who].pop(), now)
        elif step == "wait":
            now += 6
        elif step == "release":
            lease.release()
        assert lease.fence >= fence
        active = {name for name, given in under_way.items() if lease.fence in given}
        assert len(active) <= 1, "I12: two holders under one fence"
        if lease.active:
            assert active <= {lease.holder}


def test_an_idle_lease_lapses_and_a_busy_one_does_not() -> None:
    lease = Lease(0)
    lease.take("a", 0, IDLE_NS)
    assert lease.holder_at(10_000, IDLE_NS) == "a"
    lease.settle(lease.fence, 10_000)
    assert lease.holder_at(10_009, IDLE_NS) == "a"
    assert lease.holder_at(10_010, IDLE_NS) is None
    assert lease.take("b", 10_010, IDLE_NS)
    assert lease.fence == 2


def test_an_old_holders_late_end_does_not_free_the_next_ones_lease() -> None:
    lease = Lease(0)
    lease.take("a", 0, IDLE_NS)
    old = lease.fence
    lease.release()
    lease.take("b", 0, IDLE_NS)
    lease.settle(old, 0)
    assert lease.active == 1


def test_a_bucket_gives_its_burst_then_its_rate() -> None:
    bucket = Bucket(RateLimit(burst=3.0, per_s=2.0), 0)
    assert [bucket.take(0) for _ in range(3)] == [0.0, 0.0, 0.0]
    assert bucket.take(0) == 0.5
    assert bucket.take(S // 2) == 0.0
    assert bucket.take(S // 2) == 0.5


def test_a_clock_that_stands_still_or_falls_back_fills_nothing() -> None:
    bucket = Bucket(RateLimit(burst=1.0, per_s=1.0), 5 * S)
    assert bucket.take(5 * S) == 0.0
    assert bucket.take(0) == 1.0
    assert bucket.take(5 * S) == 1.0


def test_a_bucket_never_holds_more_than_its_burst() -> None:
    bucket = Bucket(RateLimit(burst=2.0, per_s=100.0), 0)
    assert [bucket.take(3600 * S) for _ in range(3)] == [0.0, 0.0, 0.01]
