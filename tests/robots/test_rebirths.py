"""Who is at the other end: the same, another of the same name, or somebody who looks on."""

from __future__ import annotations

import pytest

from rosic.robots.ros2.rebirths import born_anew, unnamed

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


def test_whoever_joins_has_no_name_at_first() -> None:
    assert unnamed(BASE, BASE | {b"2": ""})
    assert not unnamed({b"1": ""}, {b"1": ""})
