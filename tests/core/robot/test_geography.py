"""From Earth into a robot's frame, held against lengths that are known."""

from __future__ import annotations

from math import hypot, inf, nan

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rosic.core.robot.geography import FARTHEST_M, GeographicFrame, OutsidePlane, local_m

# Lengths of a hundredth of a degree on WGS 84, in metres: of latitude, of longitude.
KNOWN = {0: (1105.74, 1113.19), 45: (1111.32, 788.47), 60: (1114.12, 558.00)}


@pytest.mark.parametrize("latitude", KNOWN)
def test_lengths_are_those_of_the_ellipsoid(latitude: int) -> None:
    frame = GeographicFrame(latitude=latitude, longitude=15)
    north, left = local_m(frame, latitude + 0.01, 15)
    assert north == pytest.approx(KNOWN[latitude][0], abs=0.12)
    assert left == pytest.approx(0, abs=0.01)
    ahead, right = local_m(frame, latitude, 15.01)
    assert -right == pytest.approx(KNOWN[latitude][1], abs=0.06)
    assert abs(ahead) < 0.1  # a parallel is no straight line


@pytest.mark.parametrize(
    ("heading", "ahead"),
    [
        (0, (0.001, 0.0)),
        (90, (0.0, 0.001)),
        (180, (-0.001, 0.0)),
        (270, (0.0, -0.001)),
        (-90, (0.0, -0.001)),
    ],
)
def test_x_points_along_the_heading_and_y_to_its_left(
    heading: float, ahead: tuple[float, float]
) -> None:
    frame = GeographicFrame(latitude=10, longitude=20, heading_deg=heading)
    x, y = local_m(frame, 10 + ahead[0], 20 + ahead[1])
    assert x > 100
    assert abs(y) < 0.1
    x, y = local_m(frame, 10 + ahead[1], 20 - ahead[0])  # a quarter turn to the left
    assert y > 100
    assert abs(x) < 0.1


def test_the_antimeridian_is_no_border() -> None:
    frame = GeographicFrame(latitude=0, longitude=179.999)
    assert local_m(frame, 0, -179.999)[1] == pytest.approx(-222.64, abs=0.01)


@pytest.mark.parametrize(
    ("latitude", "longitude"),
    [(47.2, 15.4), (-47, 15.4), (47, -164.6), (nan, 15), (47, inf)],
)
def test_what_is_far_is_refused(latitude: float, longitude: float) -> None:
    with pytest.raises(OutsidePlane):
        local_m(GeographicFrame(latitude=47, longitude=15.4), latitude, longitude)


@given(st.floats(-80, 80), st.floats(-180, 180), st.floats(-0.08, 0.08), st.floats(-360, 360))
def test_a_heading_only_turns(lat: float, lon: float, off: float, heading: float) -> None:
    plain = local_m(GeographicFrame(latitude=lat, longitude=lon), lat + off, lon)
    turned = GeographicFrame(latitude=lat, longitude=lon, heading_deg=heading)
    there = local_m(turned, lat + off, lon)
    assert hypot(*there) == pytest.approx(hypot(*plain), abs=1e-6)
    assert hypot(*there) <= FARTHEST_M


@pytest.mark.parametrize("wrong", [{"latitude": 86.0}, {"longitude": 181.0}, {"latitude": nan}])
def test_a_frame_is_a_place(wrong: dict[str, float]) -> None:
    with pytest.raises(ValueError, match="85 degrees"):
        GeographicFrame(**{"latitude": 0.0, "longitude": 0.0} | wrong)
