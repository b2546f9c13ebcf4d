"""Whether anybody is still there: for how long robots move on without a sign of life."""

from __future__ import annotations

import pytest

from rosic_sim.ros2.machine_node import LINK_LOST_S, LinkWatchdog


@pytest.mark.parametrize("lost_s", [LINK_LOST_S, 9.0])
def test_a_link_is_lost_after_as_long_as_was_said_and_that_is_said_once(lost_s: float) -> None:
    watch = LinkWatchdog(lost_s)
    watch.heard(100.0)
    watch.begin(100.0 + lost_s)

    assert not watch.lost(100.0 + lost_s)
    assert watch.lost(100.5 + lost_s)
    assert not watch.lost(101.0 + lost_s)


def test_a_motion_that_begins_unheard_is_not_watched() -> None:
    watch = LinkWatchdog(9.0)
    watch.heard(100.0)
    watch.begin(109.5)

    assert not watch.lost(200.0)
