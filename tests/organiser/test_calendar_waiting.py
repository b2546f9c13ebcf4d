"""Waiting for a robot: a queue that survives, a turn that does not wait for ever."""

from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rosic.core.records import Fact
from rosic.errors import Expired, OutOfBounds, RobotTaken
from rosic.organiser import wait_queue
from rosic.organiser.wait_queue import TurnOffer, WaitingLimits, WaitingList
from rosic.testing.clock import ManualClock
from tests.organiser.booking import HOUR, MIN, NOW, VIENNA, S


def a_list(*people: str, limits: WaitingLimits | None = None) -> tuple[WaitingList, ManualClock]:
    clock = ManualClock(NOW)
    waiting = WaitingList(clock, str, limits)
    for who in people:
        write(waiting, waiting.join(who, "kuka1"))
    return waiting, clock


def write(waiting: WaitingList, facts: tuple[Fact, ...]) -> tuple[Fact, ...]:
    for fact in facts:
        waiting.apply(fact)
    return facts


def offered(waiting: WaitingList) -> str:
    offer = waiting.offer("kuka1")
    assert isinstance(offer, TurnOffer)
    return offer.principal


def test_first_come_first_served() -> None:
    waiting, _ = a_list("ann", "ben", "cem")
    assert waiting.queue("kuka1") == ("ann", "ben", "cem")
    assert [waiting.place(who, "kuka1") for who in ("ann", "cem", "dan")] == [1, 3, 0]
    assert waiting.waits_for("ben") == ("kuka1",)
    assert waiting.queue("omni") == ()


def test_deciding_changes_nothing_and_joining_twice_keeps_the_place() -> None:
    waiting, _ = a_list("ann")
    waiting.join("ben", "kuka1")
    assert waiting.queue("kuka1") == ("ann",)
    assert waiting.join("ann", "kuka1") == ()


def test_who_leaves_is_out_and_may_come_again_at_the_end() -> None:
    waiting, _ = a_list("ann", "ben")
    write(waiting, waiting.leave("ann", "kuka1"))
    assert waiting.leave("ann", "kuka1") == ()
    write(waiting, waiting.join("ann", "kuka1"))
    assert waiting.queue("kuka1") == ("ben", "ann")


def test_a_turn_is_offered_for_a_minute_and_then_to_the_next() -> None:
    waiting, clock = a_list("ann", "ben")
    offer = waiting.offer("kuka1")
    assert offer is not None
    assert (offer.principal, offer.expires_ns) == ("ann", clock.monotonic_ns() + MIN)
    assert waiting.next_expiry_ns() == offer.expires_ns
    clock._loop_ns += MIN - 1
    assert waiting.offer("kuka1") == offer
    assert waiting.lapsed() == ()
    clock._loop_ns += 1
    assert [lapsed.principal for lapsed in waiting.lapsed()] == ["ann"]
    assert offered(waiting) == "ben"
    assert waiting.queue("kuka1") == ("ann", "ben")  # until it is written down
    for lapsed in waiting.lapsed():
        waiting.apply(lapsed.no_more())
    assert waiting.queue("kuka1") == ("ben",)
    assert waiting.lapsed() == ()
    assert offered(waiting) == "ben"


def test_nobody_left_is_nobody() -> None:
    waiting, clock = a_list("ann")
    offered(waiting)
    clock._loop_ns += MIN
    assert waiting.offer("kuka1") is None
    assert waiting.offer("omni") is None
    assert waiting.next_expiry_ns() is None


def test_who_takes_their_turn_waits_no_longer() -> None:
    waiting, _ = a_list("ann", "ben")
    offered(waiting)
    write(waiting, waiting.take("ann", "kuka1"))
    assert waiting.queue("kuka1") == ("ben",)
    assert offered(waiting) == "ben"


def test_a_turn_that_is_over_or_somebody_elses_cannot_be_taken() -> None:
    waiting, clock = a_list("ann", "ben")
    with pytest.raises(RobotTaken, match="You are number 1"):
        waiting.take("ann", "kuka1")
    offered(waiting)
    with pytest.raises(RobotTaken, match=r"offered to somebody else now\. You are number 2"):
        waiting.take("ben", "kuka1")
    with pytest.raises(RobotTaken, match="You are not waiting for kuka1"):
        waiting.take("dan", "kuka1")
    clock._loop_ns += MIN
    with pytest.raises(Expired, match="has passed on"):
        waiting.take("ann", "kuka1")
    offered(waiting)
    with pytest.raises(Expired, match="has passed on"):
        waiting.take("ann", "kuka1")
    assert waiting.queue("kuka1") == ("ann", "ben")


def test_an_offer_that_is_taken_back_costs_nobody_their_place() -> None:
    waiting, _ = a_list("ann", "ben")
    offered(waiting)
    waiting.withdraw("kuka1")
    assert waiting.lapsed() == ()
    assert offered(waiting) == "ann"


def test_who_leaves_while_it_is_their_turn_hands_it_on() -> None:
    waiting, _ = a_list("ann", "ben")
    offered(waiting)
    write(waiting, waiting.leave("ann", "kuka1"))
    assert offered(waiting) == "ben"


def test_a_restart_keeps_the_queue_and_asks_the_first_again() -> None:
    waiting, clock = a_list()
    facts = [f for who in ("cem", "ann", "ben") for f in write(waiting, waiting.join(who, "kuka1"))]
    offered(waiting)
    again = WaitingList(clock, str)
    again.restore([facts[2], facts[0], Fact(kind="waiting", key="x", body=b"\xc1"), facts[1]])
    assert again.queue("kuka1") == ("cem", "ann", "ben")
    assert offered(again) == "cem"
    write(again, again.join("dan", "kuka1"))
    assert again.queue("kuka1")[-1] == "dan"


def test_queues_are_bounded() -> None:
    waiting, _ = a_list("ann", "ben", limits=WaitingLimits(most_per_robot=2, most_per_person=1))
    with pytest.raises(OutOfBounds, match="2 people wait for kuka1 already"):
        waiting.join("cem", "kuka1")
    with pytest.raises(OutOfBounds, match="You wait for 1 robots already"):
        waiting.join("ann", "omni")
    write(waiting, waiting.leave_all("ann"))
    assert waiting.join("cem", "kuka1")


def test_about_when_it_is_somebodys_turn() -> None:
    waiting, _ = a_list("ann", "ben")
    free_ns = NOW + HOUR
    about = waiting.estimate_ns("ben", "kuka1", free_ns)
    assert about == free_ns + 1800 * S
    assert waiting.estimate_ns("dan", "kuka1", free_ns) is None
    assert wait_queue.your_place("KUKA iiwa", 2, about, NOW, VIENNA) == (
        "You are number 2 in the queue for KUKA iiwa: about 11:30."
    )
    assert "tap" in wait_queue.your_turn("KUKA iiwa", 60.0).lower()


@settings(max_examples=150)
@given(
    st.lists(
        st.tuples(st.sampled_from(["join", "leave", "offer", "take", "wait"]), st.integers(0, 3))
    )
)
def test_a_queue_is_a_list(steps: list[tuple[str, int]]) -> None:
    waiting, clock = a_list()
    naive: list[str] = []
    for what, number in steps:
        who = f"p{number}"
        if what == "join":
            write(waiting, waiting.join(who, "kuka1"))
            naive += [] if who in naive else [who]
        elif what == "leave":
            write(waiting, waiting.leave(who, "kuka1"))
            naive = [one for one in naive if one != who]
        elif what == "wait":
            clock._loop_ns += number * 20 * S
            for lapsed in waiting.lapsed():
                assert naive[0] == lapsed.principal
                waiting.apply(lapsed.no_more())
                naive = naive[1:]
        elif naive and offered(waiting) == who and what == "take":
            write(waiting, waiting.take(who, "kuka1"))
            naive = naive[1:]
        assert waiting.queue("kuka1") == tuple(naive)
