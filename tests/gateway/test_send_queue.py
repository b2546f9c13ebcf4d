"""What one client is yet to be told: in which order, how much of it, and who is slow."""

from __future__ import annotations

import asyncio
from itertools import pairwise

import pytest

from rosic.gateway.send_queue import (
    BYTES_AT_MOST,
    FRESH_S,
    MESSAGES_AT_MOST,
    OLDER_BYTES_AT_MOST,
    TOO_SLOW,
    Pacing,
    SendQueue,
    SlowConsumer,
)
from tests.pace import pace

BURST = Pacing(burst=256)
LARGE = 65_536


class Clock:
    """A clock that is set by hand."""

    def __init__(self) -> None:
        self.now_s = 100.0

    def __call__(self) -> float:
        return self.now_s


async def test_what_is_said_comes_first_and_all_of_it_and_of_what_is_shown_the_newest() -> None:
    queue: SendQueue[str] = SendQueue()
    for number in range(3):
        queue.show("robot omni", f"omni {number}", 10)
        queue.show("robot kuka1", f"kuka1 {number}", 10)
        queue.say(f"answer {number}", 10)
    assert (queue.messages, queue.waiting_bytes, queue.replaced) == (5, 50, 4)
    told = [await queue.next() for _ in range(5)]
    assert told == ["answer 0", "answer 1", "answer 2", "omni 2", "kuka1 2"]
    assert (queue.messages, queue.waiting_bytes) == (0, 0)


async def test_no_key_waits_behind_another() -> None:
    queue: SendQueue[str] = SendQueue()
    for number in range(100):
        queue.show("scan", f"scan {number}", 10, BURST)
    queue.show("battery", "battery", 10, BURST)
    assert [await queue.next() for _ in range(3)] == ["scan 0", "battery", "scan 1"]


async def test_whoever_takes_what_is_sent_is_told_all_of_a_burst() -> None:
    clock = Clock()
    queue: SendQueue[int] = SendQueue(clock)
    for number in range(200):
        queue.show("scan", number, 100, BURST)
    assert [await queue.next() for _ in range(200)] == list(range(200))
    assert queue.replaced == 0


async def test_what_is_told_was_never_older_than_a_moment_however_slowly_it_is_taken() -> None:
    clock = Clock()
    queue: SendQueue[float] = SendQueue(clock)
    ages = []
    for number in range(3_000):  # a hundred a second come, and ten a second are taken
        clock.now_s += 0.01
        queue.show("scan", clock.now_s, LARGE, BURST)
        if number % 10 == 9:
            ages.append(clock.now_s - await queue.next())
    assert max(ages) <= FRESH_S
    assert sorted(ages)[len(ages) // 2] < 0.02


async def test_after_it_was_behind_a_client_is_told_everything_again() -> None:
    clock = Clock()
    queue: SendQueue[int] = SendQueue(clock)
    for number in range(10):
        queue.show("scan", number, 100, BURST)
    clock.now_s += 2 * FRESH_S
    assert await queue.next() == 9
    waiting = asyncio.ensure_future(queue.next())
    await asyncio.sleep(0)
    for number in range(20, 30):
        queue.show("scan", number, 100, BURST)
    assert [await waiting, *[await queue.next() for _ in range(9)]] == list(range(20, 30))


async def test_a_client_that_takes_nothing_is_kept_one_message_of_each_topic() -> None:
    clock, never = Clock(), asyncio.Event()
    queue: SendQueue[bytes] = SendQueue(clock)

    async def send(_: bytes) -> None:
        await never.wait()

    queue.say(b"hello", 5)
    telling = asyncio.ensure_future(queue.tell(send))
    await asyncio.sleep(0)
    most = 0
    for number in range(10_000):
        clock.now_s += 0.001
        queue.show(f"topic {number % 3}", bytes(16), LARGE, BURST)
        most = max(most, queue.waiting_bytes)
    assert most <= OLDER_BYTES_AT_MOST + 3 * LARGE
    assert (queue.messages, queue.waiting_bytes) == (3, 3 * LARGE)
    assert not queue.overflowed
    telling.cancel()


async def test_the_topic_that_has_most_gives_way_and_not_the_others() -> None:
    clock = Clock()
    queue: SendQueue[str] = SendQueue(clock)
    for number in range(100):
        queue.show("words", f"words {number}", 10, BURST)
    for _ in range(200):
        queue.show("camera", "camera", LARGE, BURST)
    assert queue.waiting_bytes <= OLDER_BYTES_AT_MOST + LARGE + 10
    told = [await queue.next() for _ in range(queue.messages)]
    assert [each for each in told if each != "camera"] == [f"words {n}" for n in range(100)]
    assert queue.waiting_bytes == 0


async def test_what_is_paced_comes_no_more_often_and_keeps_as_many_as_were_asked_for() -> None:
    clock = Clock()
    queue: SendQueue[int] = SendQueue(clock)
    for number in range(10):
        queue.show("slow", number, 100, Pacing(every_s=1.0, keep=2, burst=256))
        queue.show("quick", 100 + number, 100, BURST)
    assert queue.take_all() == [8, *range(100, 110)]
    assert queue.take_all() == []
    clock.now_s += 1.0
    assert queue.take_all() == [9]
    queue.show("slow", 10, 100)  # and is not paced any more from then on
    clock.now_s += 1.0
    queue.show("slow", 11, 100)
    assert queue.take_all() == [11]


async def test_what_is_paced_waits_for_its_moment_and_nothing_else_waits_for_it() -> None:
    queue: SendQueue[str] = SendQueue()
    often = Pacing(every_s=0.05)
    queue.show("slow", "first", 1, often)
    assert await queue.next() == "first"
    queue.show("slow", "second", 1, often)
    queue.show("quick", "other", 1)
    async with asyncio.timeout(30 * pace()):
        assert [await queue.next(), await queue.next()] == ["other", "second"]


async def test_a_topic_that_is_let_go_is_told_no_more() -> None:
    queue: SendQueue[str] = SendQueue()
    for number in range(5):
        queue.show("scan", f"scan {number}", 10, BURST)
    queue.show("battery", "battery", 10)
    queue.forget("scan")
    queue.forget("nothing")
    assert (queue.messages, queue.waiting_bytes) == (1, 10)
    assert await queue.next() == "battery"


@pytest.mark.parametrize(
    ("size", "most"), [(10, MESSAGES_AT_MOST), (LARGE, BYTES_AT_MOST // LARGE)]
)
@pytest.mark.parametrize("shown", [True, False])
async def test_whoever_lets_too_much_wait_is_slow_and_nothing_more_is_kept(
    size: int, most: int, *, shown: bool
) -> None:
    queue: SendQueue[int] = SendQueue()
    for number in range(most + 1):
        assert not queue.overflowed
        if shown:
            queue.show(number, number, size)
        else:
            queue.say(number, size)
    assert queue.overflowed
    queue.say(0, 10)
    queue.show(0, 0, 10)
    assert (queue.messages, queue.waiting_bytes) == (0, 0)
    with pytest.raises(SlowConsumer, match=TOO_SLOW):
        await queue.next()
    with pytest.raises(SlowConsumer, match=TOO_SLOW):
        queue.take_all()


async def test_one_message_that_is_larger_than_all_that_is_kept_is_told() -> None:
    queue: SendQueue[str] = SendQueue()
    queue.show("map", "map", 2 * BYTES_AT_MOST)
    queue.show("map", "newer map", 2 * BYTES_AT_MOST)
    assert await queue.next() == "newer map"


async def test_it_is_told_one_after_the_other_and_what_sending_raises_ends_it() -> None:
    queue: SendQueue[int] = SendQueue()
    told: list[int] = []

    async def send(content: int) -> None:
        told.append(content)
        await asyncio.sleep(0)
        if content == 4:
            raise OSError

    for number in range(6):
        queue.say(number, 1)
    with pytest.raises(OSError):  # noqa: PT011 - it is ours
        await queue.tell(send)
    assert all(later - earlier == 1 for earlier, later in pairwise(told))
    assert told[-1] == 4
