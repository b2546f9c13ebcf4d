"""What a person weighs, and that deciding costs the same in a large place."""

from __future__ import annotations

import pytest

from tests.core.rights import measure


def test_a_person_among_ten_thousand_weighs_at_most_two_kibibytes() -> None:
    assert measure.bytes_a_person() <= 2048


@pytest.mark.campaign
@pytest.mark.parametrize("make", [measure.may, measure.whole])
def test_a_large_place_decides_as_fast_as_a_small_one(make: measure.Asking) -> None:
    clock, _ = measure.compare(measure.nothing)
    small, large = measure.compare(make)
    assert large - clock <= 1.2 * (small - clock), (clock, small, large)
