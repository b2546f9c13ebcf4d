from __future__ import annotations

from math import cos, hypot, nan, pi, sin

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rosic_sim.robots.machines.activity import ActivityRefused, ActivityState
from rosic_sim.robots.machines.mecanum import BRAKING_M_S2, REST
from rosic_sim.robots.machines.omni import Omni
from rosic_sim.robots.machines.world import build_world
from tests.rosic_sim.robots.machines.watching import BaseWatch, JointWatch, Watched


def watched(omni: Omni | None = None) -> tuple[Watched, Omni]:
    machine = omni or Omni()
    return Watched(machine, BaseWatch(machine), JointWatch(machine.arm)), machine


@pytest.mark.parametrize(
    ("direction", "x_m", "y_m"),
    [("forward", 0.5, 0.0), ("back", -0.5, 0.0), ("left", 0.0, 0.5), ("right", 0.0, -0.5)],
)
def test_half_a_metre_ends_within_a_millimetre(direction: str, x_m: float, y_m: float) -> None:
    watch, omni = watched()
    watch.do("move", direction=direction, distance_m=0.5)
    activity = omni.activity
    assert activity is not None
    assert activity.state is ActivityState.DONE
    assert activity.detail == f"moved 0.50 m {direction}"
    assert hypot(omni.base.x_m - x_m, omni.base.y_m - y_m) < 0.001
    assert abs(activity.facts["distance_m"] - 0.5) < 0.001
    # 0.3 m/s with 0.7 m/s2 at both ends.
    assert activity.facts["duration_s"] == pytest.approx(0.5 / 0.3 + 0.3 / 0.7, abs=0.05)


def test_directions_are_those_of_the_robot() -> None:
    watch, omni = watched(Omni(pose=(1.0, 2.0, pi / 2)))
    watch.do("move", direction="forward", distance_m=1.0)
    assert omni.base.x_m == pytest.approx(1.0, abs=0.001)
    assert omni.base.y_m == pytest.approx(3.0, abs=0.001)
    watch.do("move", direction="left", distance_m=1.0)
    assert omni.base.x_m == pytest.approx(0.0, abs=0.001)


@pytest.mark.parametrize(("direction", "yaw_rad"), [("left", 1.2), ("right", -1.2)])
def test_a_turn_ends_where_it_was_asked(direction: str, yaw_rad: float) -> None:
    watch, omni = watched()
    watch.do("turn", direction=direction, angle_rad=1.2)
    assert omni.base.yaw_rad == pytest.approx(yaw_rad, abs=0.001)
    assert hypot(omni.base.x_m, omni.base.y_m) < 1e-9
    assert omni.activity is not None
    assert omni.activity.detail == f"turned 68.8 deg {direction}"


def test_goto_drives_diagonally_and_takes_the_short_way_round() -> None:
    watch, omni = watched(Omni(pose=(0.0, 0.0, 3.0)))
    watch.do("goto", x_m=1.0, y_m=1.0, yaw_rad=-3.0)
    assert omni.base.x_m == pytest.approx(1.0, abs=0.001)
    assert omni.base.y_m == pytest.approx(1.0, abs=0.001)
    assert cos(omni.base.yaw_rad) == pytest.approx(cos(-3.0), abs=0.001)
    assert omni.base.yaw_rad == pytest.approx(2 * pi - 3.0, abs=0.001)
    assert watch.stages == ["driving", "turning"]


def test_the_arm_takes_its_poses() -> None:
    watch, omni = watched()
    for pose in ("reach", "carry", "up", "home"):
        watch.do("arm", pose=pose)
        assert omni.activity is not None
        assert omni.activity.detail == f"arm in pose {pose}"
    assert omni.base.distance_m == 0.0


COMMANDS = st.one_of(
    st.tuples(
        st.just("move"),
        st.fixed_dictionaries(
            {
                "direction": st.sampled_from(["forward", "back", "left", "right"]),
                "distance_m": st.floats(0.001, 2.0),
                "speed_m_s": st.floats(0.05, 0.8),
            }
        ),
    ),
    st.tuples(
        st.just("turn"),
        st.fixed_dictionaries(
            {
                "direction": st.sampled_from(["left", "right"]),
                "angle_rad": st.floats(0.001, 6.0),
                "speed_rad_s": st.floats(0.1, 1.5),
            }
        ),
    ),
    st.tuples(
        st.just("goto"),
        st.fixed_dictionaries(
            {
                "x_m": st.floats(-2, 2),
                "y_m": st.floats(-2, 2),
                "yaw_rad": st.floats(-3, 3),
                "speed_m_s": st.floats(0.05, 0.8),
            }
        ),
    ),
    st.tuples(
        st.just("arm"),
        st.fixed_dictionaries({"pose": st.sampled_from(["home", "carry", "reach", "up"])}),
    ),
)


@settings(deadline=None, max_examples=60)
@given(
    orders=st.lists(
        st.tuples(COMMANDS, st.one_of(st.none(), st.floats(0.01, 4.0))), min_size=1, max_size=4
    )
)
def test_no_step_ever_exceeds_a_limit(
    orders: list[tuple[tuple[str, dict[str, float | str]], float | None]],
) -> None:
    watch, omni = watched()
    for (skill, arguments), halt_after_s in orders:
        activity = omni.begin(skill, arguments, watch.now_s)
        if halt_after_s is None:
            watch.to_rest(120.0)
            assert activity.state is ActivityState.DONE
            continue
        watch.run(halt_after_s)
        omni.halt(watch.now_s)
        watch.to_rest(1.0)


@settings(deadline=None, max_examples=60)
@given(
    velocities=st.lists(
        st.tuples(st.floats(-2, 2), st.floats(-2, 2), st.floats(-4, 4), st.floats(0.02, 0.7)),
        min_size=1,
        max_size=8,
    )
)
def test_velocities_of_any_size_stay_within_what_the_wheels_can(
    velocities: list[tuple[float, float, float, float]],
) -> None:
    watch, omni = watched()
    for x_m_s, y_m_s, yaw_rad_s, hold_s in velocities:
        if (x_m_s, y_m_s, yaw_rad_s) != REST and omni.note == "":
            omni.set_velocity(x_m_s, y_m_s, yaw_rad_s, watch.now_s)
        watch.run(hold_s)
    watch.to_rest(2.0)


@settings(deadline=None, max_examples=40)
@given(after_s=st.floats(0.05, 3.0), speed=st.floats(0.1, 0.8))
def test_a_halt_rests_within_what_the_brakes_imply(after_s: float, speed: float) -> None:
    watch, omni = watched()
    activity = omni.begin("move", {"distance_m": 4.0, "speed_m_s": speed}, 0.0)
    watch.run(after_s)
    reached, at_m, at_s = omni.base.velocity.x_m_s, omni.base.x_m, watch.now_s
    omni.halt(watch.now_s)
    assert activity.state is ActivityState.CANCELLED
    watch.to_rest()
    assert watch.now_s - at_s <= reached / BRAKING_M_S2 + 0.02
    assert omni.base.x_m - at_m <= reached**2 / (2 * BRAKING_M_S2) + 0.01 * reached + 1e-9
    # The facts of a cancelled move tell where it really came to rest.
    assert activity.facts["distance_m"] == pytest.approx(omni.base.x_m, abs=1e-4)
    assert activity.facts["distance_m"] > at_m or reached < 0.01


def test_a_lost_link_holds() -> None:
    watch, omni = watched()
    activity = omni.begin("move", {"distance_m": 2.0}, 0.0)
    watch.run(1.0)
    omni.link_lost(watch.now_s)
    watch.to_rest(0.3)
    assert activity.state is ActivityState.CANCELLED
    assert activity.detail == "link lost, holding"
    assert omni.base.x_m < 0.35


def test_a_velocity_without_a_new_setpoint_ends_by_itself() -> None:
    watch, omni = watched()
    omni.set_velocity(0.3, 0.0, 0.0, 0.0)
    watch.run(0.49)
    assert omni.base.velocity.x_m_s == pytest.approx(0.3)
    watch.to_rest(0.3)
    assert watch.now_s == pytest.approx(0.5 + 0.3 / BRAKING_M_S2, abs=0.03)
    assert omni.note == "no set-point for 0.5 s, stopped"
    assert 0.1 < omni.base.x_m < 0.15


def test_a_stream_of_setpoints_drives_and_zero_ends_it() -> None:
    watch, omni = watched()
    for _ in range(20):
        omni.set_velocity(0.2, 0.1, 0.3, watch.now_s)
        watch.run(0.1)
    assert omni.base.velocity == pytest.approx((0.2, 0.1, 0.3))
    assert omni.note == ""
    with pytest.raises(ActivityRefused, match="driven by velocities"):
        omni.begin("move", {"distance_m": 1.0}, watch.now_s)
    omni.set_velocity(0.0, 0.0, 0.0, watch.now_s)
    watch.to_rest(0.3)
    assert omni.begin("move", {"distance_m": 0.1}, watch.now_s).running


def test_a_velocity_does_not_break_into_a_skill_but_zero_does() -> None:
    watch, omni = watched()
    activity = omni.begin("move", {"distance_m": 1.0}, 0.0)
    watch.run(0.5)
    with pytest.raises(ActivityRefused, match="busy with move"):
        omni.set_velocity(0.1, 0.0, 0.0, watch.now_s)
    with pytest.raises(ActivityRefused, match="finite"):
        omni.set_velocity(nan, 0.0, 0.0, watch.now_s)
    assert activity.running
    omni.set_velocity(0.0, 0.0, 0.0, watch.now_s)
    assert activity.state is ActivityState.CANCELLED
    watch.to_rest(0.3)


def test_odometry_closes_a_circle() -> None:
    watch, omni = watched()
    omni.set_velocity(0.3, 0.0, 0.5, watch.now_s)
    while omni.base.yaw_rad < 2 * pi:
        omni.set_velocity(0.3, 0.0, 0.5, watch.now_s)
        watch.step()
    # Radius 0.6 m; the start of the circle is a spiral of a few centimetres.
    assert omni.base.distance_m == pytest.approx(2 * pi * 0.6, abs=0.15)
    assert hypot(omni.base.x_m, omni.base.y_m) < 0.1


def test_the_battery_drains_faster_in_motion_and_stops_the_base_when_empty() -> None:
    world = build_world()
    omni = world.omni
    omni.step(0.0)
    omni.step(600.0)
    assert omni.battery is not None
    idle = 1.0 - omni.battery.fraction
    assert 0.0 < idle < 0.1
    before = omni.battery.fraction
    omni.begin("move", {"distance_m": 5.0, "speed_m_s": 0.1}, 600.0)
    omni.step(610.0)
    assert before - omni.battery.fraction > 2 * idle / 60
    world.set_battery("omni", 0.0)
    omni.step(612.0)
    assert omni.activity is not None
    assert omni.activity.state is ActivityState.FAILED
    assert omni.activity.detail == "battery empty"
    assert omni.at_rest()
    with pytest.raises(ActivityRefused, match="omni: battery 0 %: too low"):
        omni.begin("move", {"distance_m": 1.0}, 613.0)
    with pytest.raises(ActivityRefused, match="too low"):
        omni.set_velocity(0.1, 0.0, 0.0, 613.0)


def test_turned_odometry_follows_the_heading() -> None:
    watch, omni = watched(Omni(pose=(0.0, 0.0, 0.7)))
    watch.do("move", direction="forward", distance_m=1.0)
    assert omni.base.x_m == pytest.approx(cos(0.7), abs=0.001)
    assert omni.base.y_m == pytest.approx(sin(0.7), abs=0.001)
