from __future__ import annotations

from math import nan
from typing import TYPE_CHECKING

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rosic_sim.robots.machines.activity import ActivityRefused, ActivityState
from rosic_sim.robots.machines.crazyflie import Crazyflie
from rosic_sim.robots.machines.fast_forward import to_end
from rosic_sim.robots.machines.swarm import Swarm
from rosic_sim.robots.machines.world import build_world
from tests.rosic_sim.robots.machines.watching import FlightWatch, Watched

if TYPE_CHECKING:
    from rosic_sim.robots.machines.activity import Activity


def alone() -> tuple[Watched, Crazyflie]:
    drone = Crazyflie("cf1", Swarm(("cf1",)), (0.0, 0.0))
    return Watched(drone, FlightWatch(drone)), drone


def fly(watch: Watched, skill: str, **arguments: float | str) -> Activity:
    activity = watch.machine.begin(skill, arguments, watch.now_s)
    watch.to_end()
    return activity


def test_takeoff_goto_land() -> None:
    watch, drone = alone()
    assert fly(watch, "takeoff", height_m=1.2).detail == "hovering at 1.2 m"
    assert drone.moving, "a hovering drone must be stepped"
    assert not drone.at_rest()
    assert drone.holding
    assert drone.telemetry()["mode"] == "hovering"
    activity = fly(watch, "goto", x_m=1.0, y_m=-0.5, z_m=0.8)
    assert activity.state is ActivityState.DONE
    assert drone.flight.x_m == pytest.approx(1.0, abs=0.02)
    assert drone.flight.y_m == pytest.approx(-0.5, abs=0.02)
    assert drone.flight.height.position == pytest.approx(0.8, abs=0.02)
    assert activity.facts["distance_m"] == pytest.approx(1.187, abs=0.03)
    assert fly(watch, "land").detail == "landed"
    watch.to_rest(0.1)
    assert drone.flight.height.position == 0.0
    assert not drone.moving
    assert fly(watch, "land").detail == "on the ground"


def test_what_cannot_be_done_now_is_said() -> None:
    watch, drone = alone()
    for skill, arguments in (
        ("goto", {"x_m": 1.0, "y_m": 0.0}),
        ("formation", {"shape": "line"}),
    ):
        with pytest.raises(ActivityRefused, match="cf1: on the ground, take off first"):
            drone.begin(skill, arguments, watch.now_s)
    with pytest.raises(ActivityRefused, match="on the ground"):
        drone.set_position(0.0, 0.0, 1.0, watch.now_s)
    fly(watch, "takeoff")
    with pytest.raises(ActivityRefused, match="cf1: already flying"):
        drone.begin("takeoff", {}, watch.now_s)
    with pytest.raises(ActivityRefused, match="triangle needs three"):
        drone.begin("formation", {"shape": "triangle"}, watch.now_s)
    drone.halt(watch.now_s)
    with pytest.raises(ActivityRefused, match="cf1: landing"):
        drone.begin("goto", {"x_m": 1.0, "y_m": 0.0}, watch.now_s)
    watch.to_rest()


@pytest.mark.parametrize(("fraction", "percent"), [(0.18, 18), (0.1999, 19), (0.0, 0)])
def test_a_low_battery_refuses_to_take_off(fraction: float, percent: int) -> None:
    world = build_world()
    world.step(0.0)
    world.set_battery("cf3", fraction)
    with pytest.raises(ActivityRefused, match=f"^cf3: battery {percent} %: too low$"):
        world.machines["cf3"].begin("takeoff", {}, 0.0)
    world.set_battery("cf3", 0.2)
    assert world.machines["cf3"].begin("takeoff", {}, 0.0).running


def test_seven_minutes_in_the_air_and_it_lands_before_it_falls() -> None:
    drone = Crazyflie("cf1", Swarm(("cf1",)), (0.0, 0.0))
    drone.begin("takeoff", {}, 0.0)
    now_s = 0.0
    while drone.airborne or now_s == 0.0:
        assert now_s < 500.0
        now_s += 1.0
        drone.step(now_s)
    assert now_s == pytest.approx(0.9 * 420.0, abs=6.0)
    assert drone.note in {"battery 9 %, landing", "battery 10 %, landing"}
    assert drone.at_rest()


def test_a_halt_brakes_and_lands_where_it_is() -> None:
    watch, drone = alone()
    fly(watch, "takeoff", height_m=1.0)
    activity = drone.begin("goto", {"x_m": 2.5, "y_m": 0.0, "z_m": 1.0}, watch.now_s)
    watch.run(1.5)
    at_m, speed, since_s = drone.flight.x_m, drone.flight.speed_m_s, watch.now_s
    assert speed > 0.6
    drone.halt(watch.now_s)
    assert activity.state is ActivityState.CANCELLED
    watch.to_rest(4.0)
    assert drone.flight.x_m - at_m <= speed**2 / (2 * 2.0) + 0.02
    assert watch.now_s - since_s <= 1.0 / 0.5 + 0.5 + 0.1
    assert activity.facts["z_m"] == 0.0
    assert activity.facts["x_m"] == pytest.approx(drone.flight.x_m)


def test_a_halt_after_a_failed_flight_still_lands() -> None:
    world = build_world()
    world.step(0.0)
    cf1 = world.drones[0]
    cf1.begin("takeoff", {}, 0.0)
    now_s = 0.0
    while cf1.activity is not None and cf1.activity.running:
        now_s += 0.02
        world.step(now_s)
    # cf2 stays on the ground at the origin: nobody can hover above it, and it cannot be known
    # that it will not leave before one is there.
    world.swarm.hear(world.swarm.last("cf2")._replace(goal_x_m=9.0))  # type: ignore[union-attr]
    activity = cf1.begin("goto", {"x_m": 0.0, "y_m": 0.0}, now_s)
    while activity.running:
        now_s += 0.02
        world.step(now_s)
    assert activity.state is ActivityState.FAILED
    assert activity.detail == "cf2 is in the way, hovering"
    assert cf1.airborne
    cf1.halt(now_s)
    for _ in range(300):
        now_s += 0.02
        world.step(now_s)
    assert cf1.at_rest()


def test_a_lost_link_lands() -> None:
    watch, drone = alone()
    fly(watch, "takeoff")
    drone.link_lost(watch.now_s)
    assert drone.note == "link lost, landing"
    watch.to_rest(4.0)


def test_streamed_positions_are_followed_and_their_loss_levels_then_lands() -> None:
    watch, drone = alone()
    fly(watch, "takeoff", height_m=1.0)
    for _ in range(8):
        drone.set_position(2.5, 0.0, 1.0, watch.now_s)
        watch.run(0.2)
    last_s = watch.now_s - 0.2
    watch.run(last_s + 0.99 - watch.now_s)
    assert drone.flight.speed_m_s > 0.6, "it flies on for a second"
    watch.run(0.5)
    assert drone.flight.speed_m_s < 0.05, "then it levels out"
    assert drone.flight.height.position == pytest.approx(1.0)
    assert drone.telemetry()["mode"] == "hovering"
    watch.run(last_s + 2.05 - watch.now_s)
    assert drone.telemetry()["mode"] == "landing"
    assert drone.note == "no set-point for 2 s, landing"
    watch.to_rest(4.0)


def test_streamed_positions_have_bounds_and_do_not_break_into_a_skill() -> None:
    watch, drone = alone()
    fly(watch, "takeoff")
    for place in ((nan, 0.0, 1.0), (9.0, 0.0, 1.0), (0.0, 0.0, 0.0), (0.0, 0.0, 9.0)):
        with pytest.raises(ActivityRefused):
            drone.set_position(*place, watch.now_s)
    drone.begin("goto", {"x_m": 1.0, "y_m": 0.0}, watch.now_s)
    with pytest.raises(ActivityRefused, match="busy with goto"):
        drone.set_position(0.0, 0.0, 1.0, watch.now_s)
    watch.to_end()
    drone.set_position(0.0, 0.0, 1.0, watch.now_s)
    watch.run(0.5)
    assert fly(watch, "goto", x_m=1.0, y_m=1.0).state is ActivityState.DONE
    watch.run(3.0)
    assert drone.holding, "a skill ends the stream, so its end lands nobody"


@settings(deadline=None, max_examples=40)
@given(
    legs=st.lists(
        st.tuples(
            st.floats(-2.9, 2.9),
            st.floats(-2.9, 2.9),
            st.floats(0.2, 2.5),
            st.sampled_from(["skill", "stream"]),
            st.floats(0.02, 3.0),
        ),
        min_size=1,
        max_size=4,
    ),
    height_m=st.floats(0.2, 2.5),
)
def test_no_step_ever_exceeds_a_limit(
    legs: list[tuple[float, float, float, str, float]], height_m: float
) -> None:
    watch, drone = alone()
    fly(watch, "takeoff", height_m=height_m)
    for x_m, y_m, z_m, how, duration_s in legs:
        if how == "skill":
            assert fly(watch, "goto", x_m=x_m, y_m=y_m, z_m=z_m).state is ActivityState.DONE
            assert drone.flight.left_m() < 0.02
        elif drone.airborne and drone.note == "":
            drone.set_position(x_m, y_m, z_m, watch.now_s)
            watch.run(min(duration_s, 1.9))
    drone.halt(watch.now_s)
    watch.to_rest(8.0)


def test_to_end_leaves_a_drone_hovering() -> None:
    drone = Crazyflie("cf1", Swarm(("cf1",)), (0.0, 0.0))
    drone.begin("takeoff", {}, 0.0)
    to_end(drone, 0.0)
    assert drone.holding
