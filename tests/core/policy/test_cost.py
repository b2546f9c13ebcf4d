"""What a person weighs, and that deciding costs the same in a large place."""

from __future__ import annotations

import pytest

from rosic.bench import admission
from rosic.bench.sites import LARGE, SMALL
from tests.core.policy import measure


def test_a_person_among_ten_thousand_weighs_at_most_two_kibibytes() -> None:
    assert measure.bytes_a_person() <= 2048


@pytest.mark.campaign
def test_a_right_is_looked_up_as_fast_in_a_large_place_as_in_a_small_one() -> None:
    clock, _ = measure.compare(measure.nothing)
    small, large = measure.compare(measure.may)
    assert large - clock <= 1.2 * (small - clock), (clock, small, large)


@pytest.mark.campaign
def test_a_large_place_decides_as_fast_as_a_small_one() -> None:
    """Ten thousand people, a hundred roles, fifty thousand slots: at most a fifth more."""
    _, cases = admission.measure()
    p50_us = {case.name: case.p50_us for case in cases}
    for what in admission.ASKING:
        assert p50_us[f"{what}: {LARGE}"] <= 1.2 * p50_us[f"{what}: {SMALL}"], p50_us
