"""Who is at the other end: the same, another of the same name, or somebody who looks on."""

from __future__ import annotations

import pytest

from rosic.robots.ros2.publishers import UnidentifiedEndpoints, born_anew

BASE = {b"1": "/base/base"}


@pytest.mark.parametrize(
    ("now", "anew"),
    [
        (BASE, False),
        (BASE | {b"2": "/base/base"}, True),
        ({b"2": "/base/base"}, True),
        ({b"2": "/other"}, True),
        (BASE | {b"2": "/ros2cli_echo"}, False),
        (BASE | {b"2": ""}, False),
        ({}, False),
    ],
)
def test_only_who_takes_a_place_is_born_anew(now: dict[bytes, str], *, anew: bool) -> None:
    assert born_anew(BASE, now) is anew


def test_where_nobody_was_at_first_nobody_is_born_anew() -> None:
    assert not born_anew({}, BASE)
    assert not born_anew({b"1": ""}, {b"1": "", b"2": ""}), "two without a name are not one"


S = 1_000_000_000


def test_whoever_joins_is_waited_for_until_a_name_is_known_and_no_longer() -> None:
    newcomers = UnidentifiedEndpoints(BASE, 0.25)
    assert not newcomers.nameless(BASE, 0)
    assert not newcomers.waits
    assert not newcomers.nameless(BASE | {b"2": ""}, 5 * S)
    assert newcomers.waits, "nothing is sent"
    assert not newcomers.nameless(BASE | {b"2": "/ros2cli_echo"}, 5 * S + S // 10)
    assert not newcomers.waits
    assert not newcomers.nameless(BASE | {b"3": ""}, 9 * S)
    assert newcomers.nameless(BASE | {b"3": ""}, 9 * S + S // 4)
    assert newcomers.waits


def test_who_had_no_name_from_the_first_is_not_waited_for() -> None:
    newcomers = UnidentifiedEndpoints({b"1": ""}, 0.25)
    assert not newcomers.nameless({b"1": ""}, 9 * S)
    assert not newcomers.waits


def test_a_name_that_comes_later_is_taken_in_and_told_again_when_it_is_born_anew() -> None:
    newcomers = UnidentifiedEndpoints({b"1": ""}, 0.25)
    assert not newcomers.nameless(BASE, 1 * S)
    assert newcomers.first == BASE
    assert not newcomers.nameless(BASE | {b"2": "/base/base"}, 2 * S), "its name is known"
    assert born_anew(newcomers.first, BASE | {b"2": "/base/base"})
    assert not newcomers.nameless(BASE | {b"2": "/ros2cli_echo"}, 2 * S)
    assert not newcomers.waits
    newcomers.nameless({b"2": "/base/base"}, 3 * S)
    assert newcomers.first == BASE, "a name that was known is not forgotten"


def test_while_one_of_the_first_has_no_name_whoever_joins_may_be_that_one() -> None:
    now = {b"1": "", b"2": "/base/base"}
    newcomers = UnidentifiedEndpoints({b"1": ""}, 0.25)
    assert not newcomers.nameless(now, 5 * S)
    assert newcomers.waits, "nothing is sent"
    assert newcomers.nameless(now, 5 * S + S // 4)
    assert not newcomers.nameless(now | {b"1": "/other"}, 6 * S)
    assert not newcomers.waits
