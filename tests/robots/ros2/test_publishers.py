"""When a message was sent, on our own clock, and who begins anew."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosic.robots.ros2.publishers import (
    SENDS_WITHIN_NS,
    WINDOW_NS,
    MessageInfoCallback,
    TopicPublishers,
)

if TYPE_CHECKING:
    from rosic.robots.ros2.publishers import About

MS = 10**6
AHEAD_NS = 7 * 10**18
"""Of their wall clock before our monotonic one."""


def about(sent_ns: int, gid: bytes = b"a") -> About:
    """Return what rclpy says of a message that was sent at a moment of our clock."""
    return {"source_timestamp": sent_ns + AHEAD_NS, "publisher_gid": {"data": gid}}


def test_what_was_held_back_is_dated_by_its_sending() -> None:
    senders = TopicPublishers()
    assert senders.take(about(0), 5 * MS) == 5 * MS, "the quickest so far counts as quick"
    assert senders.take(about(50 * MS), 54 * MS) == 54 * MS
    assert senders.take(about(100 * MS), 3_104 * MS) == 104 * MS, "three seconds on its way"


def test_a_clock_that_is_set_counts_as_it_is_after_a_while() -> None:
    senders = TopicPublishers()
    senders.take(about(0), 0)
    back_ns, now_ns, dated_ns = 10**10, 0, 0
    for _ in range(3):
        now_ns += WINDOW_NS + 1
        dated_ns = senders.take(about(now_ns - back_ns), now_ns)
    assert dated_ns == now_ns


def test_what_says_nothing_of_its_sending_was_sent_when_it_came() -> None:
    assert TopicPublishers().take({"source_timestamp": 0, "publisher_gid": None}, 7 * MS) == 7 * MS


def test_who_is_new_in_the_place_of_another_was_born_anew() -> None:
    senders = TopicPublishers()
    for now_ns, gid in enumerate((b"a", b"a", b"b", b"a", b"b"), start=1):
        senders.take(about(now_ns, gid), now_ns)
    assert (senders.restarts, senders.born_ns) == (1, 2), "two that speak in turn are known"


def test_one_that_takes_the_place_of_another_is_not_one_of_several() -> None:
    senders = TopicPublishers()
    for now_ns, gid in enumerate((b"a", b"a", b"b", b"b"), start=1):
        senders.take(about(now_ns, gid), now_ns)
        assert not senders.several(now_ns)


def test_two_that_are_heard_in_turn_are_several_until_one_falls_silent() -> None:
    senders = TopicPublishers()
    for now_ns, gid in enumerate((b"a", b"b", b"a"), start=1):
        senders.take(about(now_ns, gid), now_ns)
    assert senders.several(3)
    assert senders.several(2 + SENDS_WITHIN_NS)
    senders.take(about(SENDS_WITHIN_NS, b"a"), SENDS_WITHIN_NS)
    assert not senders.several(3 + SENDS_WITHIN_NS)


def test_both_ways_in_which_rclpy_calls_back_are_one() -> None:
    heard: list[tuple[bytes, About]] = []
    informed = MessageInfoCallback(lambda content, about: heard.append((content, about)))
    told = about(1)
    informed(b"x", told)
    informed((b"x", told))
    assert heard == [(b"x", told)] * 2


def test_what_was_kept_is_as_old_as_its_stamp_and_says_nothing_of_who_sends() -> None:
    senders, now_ns = TopicPublishers(), 60 * SENDS_WITHIN_NS
    assert senders.take_kept(about(0), now_ns + AHEAD_NS) == now_ns
    assert senders.take_kept(about(0), now_ns + AHEAD_NS) is None, "it is known"
    assert senders.take_kept(about(now_ns + MS), now_ns + AHEAD_NS) == 0, "of a clock ahead of ours"
    assert senders.take_kept(about(0, b"b"), now_ns + AHEAD_NS) == now_ns, "of one that came later"
    senders.take(about(now_ns), now_ns)
    assert (senders.restarts, senders.several(now_ns)) == (0, False)


def test_what_was_heard_is_not_taken_again_for_what_was_kept() -> None:
    senders = TopicPublishers()
    senders.take(about(5 * MS), 6 * MS)
    assert senders.take_kept(about(5 * MS), 6 * MS + AHEAD_NS) is None
    assert senders.take_kept(about(4 * MS), 6 * MS + AHEAD_NS) is None, "older than what was heard"
    assert senders.take_kept(about(6 * MS), 6 * MS + AHEAD_NS) == 0, "the other was lost on its way"
