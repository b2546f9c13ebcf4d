"""Who asked for what, and what became of it: the first answer counts, and none after the time."""

from __future__ import annotations

import pytest

from rosic.core.records import Fact
from rosic.errors import Expired, OutOfBounds, TooManyRequests
from rosic.organiser.access_requests import (
    ACCESS_REQUEST,
    LONGEST_S,
    MOST_OF_ALL,
    REMEMBERED_S,
    WAITS_S,
    AccessRequest,
    AccessRequests,
    WantedRight,
)
from rosic.testing.clock import ManualClock, SeededEntropy

WAVE = WantedRight(robot="omni", skill="wave", lasts_s=3600.0)


class Book:
    """Petitions over a clock that the test owns; what is decided is so at once."""

    def __init__(self) -> None:
        self.clock = ManualClock()
        self.written: dict[str, Fact] = {}
        self.access_requests = AccessRequests(self.clock.wall_ns, SeededEntropy())

    def write(self, *records: object) -> None:
        for record in records:
            if isinstance(record, Fact):
                self.written[record.key] = record
                self.access_requests.apply(record)

    def asks(self, principal: str, want: WantedRight = WAVE) -> AccessRequest:
        access_request, records = self.access_requests.ask(principal, want, b"what it gives")
        self.write(*records)
        return access_request

    def restarted(self) -> AccessRequests:
        again = AccessRequests(self.clock.wall_ns, SeededEntropy(1))
        again.restore(self.written.values())
        return again


async def test_the_first_answer_counts() -> None:
    book = Book()
    access_request = book.asks("p1")
    book.write(*book.access_requests.allow(access_request, "p2"))
    for answer in (book.access_requests.allow, book.access_requests.deny):
        with pytest.raises(Expired, match="settled already"):
            answer(access_request, "p3")
    assert book.access_requests.open() == ()


async def test_an_answer_that_comes_too_late_gives_nothing() -> None:
    book = Book()
    access_request = book.asks("p1")
    await book.clock.advance(WAITS_S - 1)
    assert book.access_requests.open() == (access_request,)
    assert book.access_requests.late() == ()
    await book.clock.advance(1)
    assert book.access_requests.open() == ()
    with pytest.raises(Expired):
        book.access_requests.allow(access_request, "p2")
    assert book.access_requests.late() == (access_request,)
    book.write(book.access_requests.lapse(access_request))
    assert book.access_requests.late() == ()


async def test_all_of_it_outlives_a_restart_and_is_forgotten_in_the_end() -> None:
    book = Book()
    book.write(*book.access_requests.deny(book.asks("p1"), "p2"))
    open_one = book.asks("p3")
    again = book.restarted()
    assert again.open() == (open_one,)
    with pytest.raises(TooManyRequests, match="The answer to that was no"):
        again.ask("p1", WAVE, b"")
    assert book.access_requests.stale() == ()
    await book.clock.advance(REMEMBERED_S)
    book.write(*book.access_requests.stale())
    assert [fact.key for fact in book.written.values() if fact.body] == [open_one.id]


async def test_another_length_is_the_same_question_and_another_robot_is_not() -> None:
    book = Book()
    book.asks("p1")
    with pytest.raises(TooManyRequests, match="I have asked that for you already") as refused:
        book.access_requests.ask("p1", WantedRight(robot="omni", skill="wave", lasts_s=60.0), b"")
    assert refused.value.retry_after_s == WAITS_S
    book.asks("p1", WantedRight(robot="kuka1", skill="wave", lasts_s=60.0))
    book.asks("p2")


async def test_there_is_a_bound_on_everybody_together() -> None:
    book = Book()
    for number in range(MOST_OF_ALL):
        book.asks(f"p{number}")
    with pytest.raises(TooManyRequests, match="Too many people ask"):
        book.access_requests.ask("another", WAVE, b"")


@pytest.mark.parametrize("lasts_s", [0.0, -5.0, 29.0, LONGEST_S + 1, float("inf"), float("nan")])
def test_nothing_is_asked_for_no_time_or_for_ever(lasts_s: float) -> None:
    with pytest.raises(OutOfBounds):
        Book().access_requests.ask(
            "p1", WantedRight(robot="omni", skill="wave", lasts_s=lasts_s), b""
        )


def test_what_cannot_be_read_gives_nobody_anything() -> None:
    book = Book()
    access_request = book.asks("p1")
    book.access_requests.apply(Fact(kind=ACCESS_REQUEST, key=access_request.id, body=b"\xff"))
    assert book.access_requests.get(access_request.id) is None
