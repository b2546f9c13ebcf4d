"""One drone behind another: measured over time, and every way in which it ends."""

from __future__ import annotations

from math import atan2, degrees, hypot, pi
from typing import TYPE_CHECKING

import pytest

from rosic_sim.robots.machines.activity import ActivityRefused, ActivityState
from rosic_sim.robots.machines.swarm import APART_M
from tests.rosic_sim.robots.machines.test_swarm import DatedTrio, DistantTrio, Trio

if TYPE_CHECKING:
    from collections.abc import Callable

    from rosic_sim.robots.machines.arguments import Value
    from rosic_sim.robots.machines.crazyflie import Crazyflie

GAP_M = 1.2


def gap_m(one: Crazyflie, other: Crazyflie) -> float:
    return hypot(one.flight.x_m - other.flight.x_m, one.flight.y_m - other.flight.y_m)


def bearing_deg(leader: Crazyflie, follower: Crazyflie) -> float:
    """Where the follower is, off straight behind its leader; positive is to the leader's left."""
    way, seen = leader.flight, follower.flight
    heading = atan2(way.vy_m_s, way.vx_m_s)
    behind = atan2(seen.y_m - way.y_m, seen.x_m - way.x_m) - heading - pi
    return -degrees((behind + pi) % (2 * pi) - pi)


def state(drone: Crazyflie) -> ActivityState:
    assert drone.activity is not None
    return drone.activity.state


def detail(drone: Crazyflie) -> str:
    assert drone.activity is not None
    return drone.activity.detail


def flying(trio: Trio) -> tuple[Crazyflie, Crazyflie, Crazyflie]:
    """Let all take off and the third leave the way; return leader, follower and the other."""
    trio.all("takeoff", height_m=1.0)
    leader, follower, other = trio.drones
    other.begin("goto", {"x_m": -2.5, "y_m": -2.5}, trio.now_s)
    trio.to_ends()
    leader.begin("goto", {"x_m": -2.0, "y_m": 1.0}, trio.now_s)
    trio.to_ends()
    follower.begin("goto", {"x_m": -2.0, "y_m": -0.2}, trio.now_s)
    trio.to_ends()
    return leader, follower, other


# What is heard late is taken for newer than it is: it lags by the way of that time.
@pytest.mark.parametrize(("make", "off_m"), [(Trio, 0.02), (lambda: DistantTrio(0.1), 0.1)])
@pytest.mark.parametrize(("bearing_rad", "off_deg"), [(0.0, 0.0), (pi / 4, 45.0)])
def test_it_keeps_its_distance_and_bearing_while_the_leader_moves(
    make: Callable[[], Trio], off_m: float, bearing_rad: float, off_deg: float
) -> None:
    trio = make()
    leader, follower, _ = flying(trio)
    arguments: dict[str, Value] = {"leader": "cf1", "distance_m": GAP_M, "bearing_rad": bearing_rad}
    follower.begin("follow", arguments, trio.now_s)
    trio.run(4.0)
    leader.begin("goto", {"x_m": 2.5, "y_m": 1.0}, trio.now_s)
    gaps: list[float] = []
    offs: list[float] = []
    way_m = -leader.flight.x_m
    for _ in range(2_000):
        trio.tick()
        if leader.flight.x_m > 1.1 and leader.flight.speed_m_s > 0.5:
            gaps.append(gap_m(leader, follower))
            offs.append(bearing_deg(leader, follower) - off_deg)
        if state(follower) is not ActivityState.RUNNING:
            break
    way_m += leader.flight.x_m
    assert way_m > 4.0
    assert len(gaps) > 60, "measured while both fly"
    assert max(gaps) < GAP_M + off_m
    assert min(gaps) > GAP_M - off_m
    assert max(map(abs, offs)) < 6.0
    assert state(leader) is ActivityState.DONE
    assert state(follower) is ActivityState.DONE
    assert detail(follower) == "followed cf1, 1.20 m behind it at the end"
    assert follower.holding, "it hovers there"
    assert trio.nearest_m >= APART_M


@pytest.mark.parametrize("make", [Trio, lambda: DatedTrio(0.1)])
def test_an_order_that_the_leader_has_just_ended_is_not_the_one_it_is_followed_in(
    make: Callable[[], Trio],
) -> None:
    """For a moment its last word is still of that order; words of it may be on their way, too."""
    trio = make()
    leader, follower, _ = flying(trio)
    leader.begin("goto", {"x_m": -2.0, "y_m": 1.3}, trio.now_s)
    trio.to_ends()
    heard = follower.swarm.last("cf1")
    assert heard is not None
    assert heard.busy, "what the follower knows is old"
    follower.begin("follow", {"leader": "cf1", "distance_m": GAP_M}, trio.now_s)
    trio.run(1.0)
    assert state(follower) is ActivityState.RUNNING
    leader.begin("goto", {"x_m": 2.5, "y_m": 1.0}, trio.now_s)
    trio.to_ends()
    assert leader.flight.x_m == pytest.approx(2.5, abs=0.02)
    assert gap_m(leader, follower) == pytest.approx(GAP_M, abs=0.02)


def test_one_that_comes_later_follows_in_the_order_under_way() -> None:
    trio = DatedTrio(0.1)
    leader, follower, _ = flying(trio)
    leader.begin("goto", {"x_m": 2.5, "y_m": 1.0}, trio.now_s)
    trio.run(2.0)
    follower.begin("follow", {"leader": "cf1", "distance_m": GAP_M}, trio.now_s)
    trio.to_ends(limit_s=20.0)
    assert state(follower) is ActivityState.DONE
    assert gap_m(leader, follower) == pytest.approx(GAP_M, abs=0.02)


def test_it_turns_with_the_leader_and_stays_clear_of_it_and_of_others() -> None:
    trio = Trio()
    leader, follower, _ = flying(trio)
    follower.begin("follow", {"leader": "cf1", "distance_m": 1.1}, trio.now_s)
    corners = ((1.5, 1.0), (1.5, -1.0), (-1.5, -1.0), (-1.5, 1.5), (1.0, -0.5))
    for x, y in corners:
        if state(follower) is ActivityState.DONE:
            follower.begin("follow", {"leader": "cf1", "distance_m": 1.1}, trio.now_s)
        leader.begin("goto", {"x_m": x, "y_m": y}, trio.now_s)
        trio.to_ends()
        assert gap_m(leader, follower) == pytest.approx(1.1, abs=0.1)
    assert trio.nearest_m >= APART_M


def test_a_stop_of_the_follower_ends_it_and_the_leader_goes_on() -> None:
    trio = Trio()
    leader, follower, _ = flying(trio)
    follower.begin("follow", {"leader": "cf1"}, trio.now_s)
    leader.begin("goto", {"x_m": 2.0, "y_m": 1.0}, trio.now_s)
    trio.run(2.0)
    follower.halt(trio.now_s)
    assert state(follower) is ActivityState.CANCELLED
    trio.run(6.0)
    assert follower.at_rest()
    assert state(leader) is ActivityState.DONE


def test_a_stop_of_the_leader_ends_it_and_the_follower_hovers() -> None:
    trio = Trio()
    leader, follower, _ = flying(trio)
    follower.begin("follow", {"leader": "cf1"}, trio.now_s)
    leader.begin("goto", {"x_m": 2.0, "y_m": 1.0}, trio.now_s)
    trio.run(3.0)
    assert follower.flight.speed_m_s > 0.3
    leader.halt(trio.now_s)
    trio.run(0.2)
    assert (state(follower), detail(follower)) == (
        ActivityState.FAILED,
        "cf1 does not fly any more, hovering",
    )
    trio.run(5.0)
    assert leader.at_rest()
    assert follower.holding
    assert trio.nearest_m >= APART_M


def test_a_leader_that_is_lost_ends_it_and_all_land() -> None:
    trio = DistantTrio(0.05)
    leader, follower, _ = flying(trio)
    follower.begin("follow", {"leader": "cf1"}, trio.now_s)
    leader.begin("goto", {"x_m": 2.0, "y_m": 1.0}, trio.now_s)
    trio.run(2.0)
    trio.cut_off.add("cf1")
    trio.run(1.5)
    assert state(follower) is ActivityState.FAILED
    assert detail(follower) == "cf1 not heard for 1 s, landing"
    trio.run(6.0)
    assert follower.at_rest()
    assert trio.nearest_m >= APART_M


def test_one_behind_the_other_is_a_row_and_a_circle_is_none() -> None:
    trio = Trio()
    trio.all("takeoff", height_m=1.0)
    first, second, third = trio.drones
    trio.all("formation", shape="column", spacing_m=0.8)
    third.begin("follow", {"leader": "cf2"}, trio.now_s)
    trio.run(0.2)
    with pytest.raises(ActivityRefused, match="cf3 follows this drone itself"):
        second.begin("follow", {"leader": "cf3"}, trio.now_s)
    second.begin("follow", {"leader": "cf1"}, trio.now_s)
    trio.run(0.2)
    with pytest.raises(ActivityRefused, match="cf3 follows this drone itself"):
        first.begin("follow", {"leader": "cf3"}, trio.now_s)
    first.begin("goto", {"x_m": 2.8, "y_m": 0.0}, trio.now_s)
    trio.to_ends()
    assert [state(drone) for drone in trio.drones] == [ActivityState.DONE] * 3
    assert gap_m(first, second) == pytest.approx(1.2, abs=0.05)
    assert gap_m(second, third) == pytest.approx(1.2, abs=0.05)


def test_two_that_begin_to_follow_each_other_at_once_both_end() -> None:
    trio = DistantTrio(0.1)
    leader, follower, _ = flying(trio)
    leader.begin("follow", {"leader": "cf2"}, trio.now_s)
    follower.begin("follow", {"leader": "cf1"}, trio.now_s)
    trio.run(1.0)
    assert {state(leader), state(follower)} <= {ActivityState.FAILED, ActivityState.DONE}
    assert "follows this drone itself, hovering" in detail(leader) + detail(follower)


def test_what_cannot_be_followed_is_declined_and_nobody_waits_for_ever() -> None:
    trio = Trio()
    first, second, _ = trio.drones
    first.begin("takeoff", {"height_m": 1.0}, trio.now_s)
    trio.to_ends()
    wrong: tuple[tuple[dict[str, Value], str], ...] = (
        ({"leader": "cf2"}, "cf2 does not fly"),
        ({"leader": "cf1"}, "leader must be one of cf2, cf3"),
        ({"leader": "cf2", "distance_m": 1.0}, "distance_m must be between"),
    )
    for arguments, why in wrong:
        with pytest.raises(ActivityRefused, match=why):
            first.begin("follow", arguments, trio.now_s)
    second.begin("takeoff", {"height_m": 1.0}, trio.now_s)
    trio.to_ends()
    second.begin("follow", {"leader": "cf1"}, trio.now_s)
    trio.run(35.0)
    assert (state(second), detail(second)) == (ActivityState.FAILED, "cf1 goes nowhere, hovering")
    assert second.holding
