"""What was measured before a break is no rest after it, also between two orders (I6, I7)."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING

import pytest

from rosic.testing.ros2.graph import RosGraph
from tests.real.ros2.stream_site import Site

if TYPE_CHECKING:
    from collections.abc import Iterator

JUMPED = "its odometry jumped, so how far could not be measured; broken off because "
UNKNOWN = "broken off because somebody unknown took its velocities, too"
SETTLED_S = 1.0
WITHIN_S = 20.0
"""What was measured stays fresh: only a break can make it worth nothing."""


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Site]:
    folder = tmp_path_factory.mktemp("breaks")
    with RosGraph(folder) as graph:
        yield Site(graph, folder, WITHIN_S)


def test_a_rest_from_before_the_gateway_was_frozen_is_none(site: Site) -> None:
    site.base.say("odometry off")
    site.base.expect("ok odometry off")
    try:
        site.tell("presence")
        assert site.told("online") == "True at_rest True"
        site.frozen(site.gateway, 2.0)
        site.tell("presence")
        assert site.told("online") == "True at_rest None", "nobody saw what it did meanwhile"
    finally:
        site.measure_again()


def test_a_jump_of_its_odometry_is_no_way_that_it_drove(site: Site) -> None:
    site.drive(20.0, 0.5)
    site.base.say("jump")
    site.base.expect("ok jump")
    time.sleep(0.5)
    site.frozen(site.gateway, 2.0)
    told = site.ended()
    assert told.startswith("failed drove for 1."), told
    assert JUMPED + "ROSIC itself stood still for" in told


def test_a_robot_that_was_reborn_before_it_was_missed_is_driven_no_further(site: Site) -> None:
    heir = site.heir()
    site.drive(20.0, 0.5)
    site.base.kill()
    born_ns = time.time_ns()
    site.base = heir
    heir.say("begin")
    heir.expect("begun")
    told = site.ended()
    time.sleep(SETTLED_S)
    assert site.velocities(born_ns) == []
    assert told.startswith("failed drove for "), told
    # On a busy machine the graph knows for seconds that somebody is there, and not who.
    assert told.endswith((JUMPED + "its software began anew", UNKNOWN)), told
    site.drive(0.5, 0.0)
    assert site.ended().startswith("done"), "a new order moves it again"
