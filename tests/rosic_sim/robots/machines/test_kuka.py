from __future__ import annotations

from math import dist, radians
from typing import TYPE_CHECKING

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rosic_sim.robots.machines.activity import ActivityRefused, ActivityState
from rosic_sim.robots.machines.kinematics import iiwa_points, iiwa_tool_down
from rosic_sim.robots.machines.kuka import HOME, IIWA_LIMITS, STATION_M, Kuka
from rosic_sim.robots.machines.objects import SimulatedObject
from rosic_sim.robots.machines.world import CUBE, build_world
from tests.rosic_sim.robots.machines.watching import JointWatch, Watched

if TYPE_CHECKING:
    from rosic_sim.robots.machines.world import SimulatedWorld


def watched() -> tuple[Watched, Kuka, SimulatedWorld]:
    world = build_world()
    return Watched(world.kuka, JointWatch(world.kuka.arm)), world.kuka, world


def test_a_grasp_approaches_closes_verifies_and_lifts() -> None:
    watch, kuka, world = watched()
    watch.do("grasp")
    activity = kuka.activity
    assert activity is not None
    assert activity.state is ActivityState.DONE
    assert activity.detail == "object held, lifted 10 cm"
    assert watch.stages == ["approaching", "closing", "verifying", "lifting"]
    assert activity.facts["lift_m"] == pytest.approx(0.10, abs=0.001)
    assert activity.facts["width_m"] == pytest.approx(0.05)
    assert activity.facts["force_n"] == 15.0
    cube = world.things.get(CUBE)
    assert cube is not None
    assert cube.holders == {"kuka1"}
    assert cube.position_m[2] == pytest.approx(STATION_M[2] + 0.10, abs=0.001)
    assert kuka.telemetry()["holding"] == "cube"


def test_a_grasp_without_an_object_fails_at_verifying_opens_and_returns() -> None:
    watch, kuka, world = watched()
    world.remove_thing(CUBE)
    watch.do("grasp")
    activity = kuka.activity
    assert activity is not None
    assert activity.state is ActivityState.FAILED
    assert activity.detail == "nothing between the fingers, opened and returned"
    assert watch.stages[-2:] == ["verifying", "returning"]
    assert activity.fraction < 1.0
    assert "lift_m" not in activity.facts
    assert kuka.gripper.width_m == pytest.approx(0.110)
    assert kuka.arm.positions == pytest.approx(HOME)


def test_an_object_beside_the_station_is_not_grasped() -> None:
    watch, kuka, world = watched()
    cube = world.things.get(CUBE)
    assert cube is not None
    cube.come_to((STATION_M[0], 0.05, STATION_M[2]))
    watch.do("grasp")
    assert kuka.activity is not None
    assert kuka.activity.state is ActivityState.FAILED
    assert cube.holders == set()


def test_too_little_force_lets_it_slip() -> None:
    watch, kuka, world = watched()
    watch.do("grasp", force_n=5.0)
    activity = kuka.activity
    assert activity is not None
    assert activity.state is ActivityState.FAILED
    assert activity.detail == "the object slipped at 5 N, opened and returned"
    cube = world.things.get(CUBE)
    assert cube is not None
    assert cube.holders == set()
    assert cube.position_m == STATION_M
    watch.do("grasp", force_n=9.5)
    assert kuka.activity is not None
    assert kuka.activity.state is ActivityState.DONE


def test_an_object_taken_away_while_lifting_is_noticed() -> None:
    watch, kuka, world = watched()
    activity = kuka.begin("grasp", {}, 0.0)
    while activity.stage != "lifting":
        watch.step()
    watch.run(0.2)
    world.remove_thing(CUBE)
    watch.to_rest()
    assert activity.state is ActivityState.FAILED
    assert "lost while lifting" in activity.detail


def test_release_puts_it_down_where_it_was() -> None:
    watch, kuka, world = watched()
    watch.do("grasp")
    watch.do("home")
    cube = world.things.get(CUBE)
    assert cube is not None
    assert cube.holders == {"kuka1"}
    with pytest.raises(ActivityRefused, match="kuka1: already holds the cube"):
        kuka.begin("grasp", {}, watch.now_s)
    watch.do("release")
    assert kuka.activity is not None
    assert kuka.activity.detail == "cube put down"
    assert cube.holders == set()
    assert dist(cube.position_m, STATION_M) < 0.001
    watch.do("release")
    assert kuka.activity.detail == "gripper open, it held nothing"
    watch.do("grasp")
    assert kuka.activity.state is ActivityState.DONE


def test_a_halt_while_lifting_keeps_the_object() -> None:
    watch, kuka, world = watched()
    activity = kuka.begin("grasp", {}, 0.0)
    while activity.stage != "lifting":
        watch.step()
    watch.run(0.3)
    kuka.halt(watch.now_s)
    assert activity.state is ActivityState.CANCELLED
    watch.to_rest(0.2)
    cube = world.things.get(CUBE)
    assert cube is not None
    assert cube.holders == {"kuka1"}
    tips = iiwa_points(kuka.arm.positions)[2]
    assert cube.position_m == pytest.approx(tips)
    watch.do("release")
    assert dist(cube.position_m, STATION_M) < 0.001


def test_a_halt_while_closing_holds_nothing() -> None:
    watch, kuka, world = watched()
    activity = kuka.begin("grasp", {}, 0.0)
    while activity.stage != "closing":
        watch.step()
    kuka.halt(watch.now_s)
    watch.to_rest(0.2)
    cube = world.things.get(CUBE)
    assert cube is not None
    assert cube.holders == set()
    watch.do("grasp")
    assert kuka.activity is not None
    assert kuka.activity.state is ActivityState.DONE


@pytest.mark.parametrize("joint", range(1, 8))
def test_a_joint_moves_to_its_angle_and_not_beyond_its_range(joint: int) -> None:
    watch, kuka, _ = watched()
    watch.do("move_joint", joint=joint, angle_rad=0.3)
    assert kuka.arm.positions[joint - 1] == pytest.approx(0.3, abs=1e-9)
    assert kuka.activity is not None
    assert kuka.activity.detail == f"joint {joint} at 17.2 deg"
    others = [a for i, a in enumerate(kuka.arm.positions) if i != joint - 1]
    assert others == [a for i, a in enumerate(HOME) if i != joint - 1]
    limit = IIWA_LIMITS[joint - 1].upper_rad
    with pytest.raises(ActivityRefused, match=f"kuka1: joint {joint} reaches"):
        kuka.begin("move_joint", {"joint": joint, "angle_rad": limit + 0.01}, watch.now_s)
    assert not kuka.moving


def test_the_table_is_not_touched() -> None:
    watch, kuka, _ = watched()
    with pytest.raises(ActivityRefused, match="kuka1: the arm would touch the table"):
        kuka.begin("move_joint", {"joint": 2, "angle_rad": 2.0}, 0.0)
    assert not kuka.moving
    watch.do("move_joint", joint=2, angle_rad=-1.2)
    watch.do("home")
    assert kuka.arm.positions == pytest.approx(HOME)


def test_the_wrist_counts_too_when_the_tips_point_up() -> None:
    watch, kuka, _ = watched()
    watch.do("move_joint", joint=6, angle_rad=-2.0)
    watch.do("move_joint", joint=4, angle_rad=0.0)
    with pytest.raises(ActivityRefused, match="would touch the table"):
        kuka.begin("move_joint", {"joint": 2, "angle_rad": 2.0}, watch.now_s)


def test_a_motion_of_nothing_is_over_at_once() -> None:
    watch, kuka, _ = watched()
    watch.do("move_joint", joint=1, angle_rad=6.8e-270)
    assert kuka.activity is not None
    assert kuka.activity.state is ActivityState.DONE
    assert kuka.activity.facts["duration_s"] < 0.02


@settings(deadline=None, max_examples=40)
@given(
    orders=st.lists(
        st.tuples(
            st.integers(1, 7),
            st.floats(-3.1, 3.1),
            st.sampled_from(["", "home", "grasp", "release"]),
            st.one_of(st.none(), st.floats(0.01, 5.0)),
        ),
        min_size=1,
        max_size=5,
    )
)
def test_no_step_ever_exceeds_a_limit_or_touches_the_table(
    orders: list[tuple[int, float, str, float | None]],
) -> None:
    watch, kuka, _ = watched()

    def above_the_table() -> None:
        elbow, wrist, tips = iiwa_points(kuka.arm.positions)
        assert min(elbow[2], wrist[2]) > 0.09
        assert tips[2] > 0.01

    watch.also.append(above_the_table)
    for joint, angle_rad, skill, halt_after_s in orders:
        try:
            if skill:
                kuka.begin(skill, {}, watch.now_s)
            else:
                kuka.begin("move_joint", {"joint": joint, "angle_rad": angle_rad}, watch.now_s)
        except ActivityRefused:
            assert not kuka.moving
            continue
        if halt_after_s is not None:
            watch.run(halt_after_s)
            speeds = [abs(v) for v in kuka.arm.velocities]
            since_s = watch.now_s
            kuka.halt(since_s)
            watch.to_rest(1.0)
            fastest_s = max(
                v / limit.braking_rad_s2 for v, limit in zip(speeds, IIWA_LIMITS, strict=True)
            )
            assert watch.now_s - since_s <= fastest_s + 0.03
        watch.to_rest()


def test_at_rest_is_measured() -> None:
    watch, kuka, _ = watched()
    assert kuka.at_rest()
    kuka.begin("move_joint", {"joint": 1, "angle_rad": 1.0}, watch.now_s)
    watch.run(0.5)
    assert not kuka.at_rest()
    kuka.halt(watch.now_s)
    assert not kuka.at_rest()
    watch.to_rest(0.2)
    assert kuka.at_rest()


@given(x_m=st.floats(0.35, 0.6), y_m=st.floats(-0.3, 0.3), z_m=st.floats(0.03, 0.3))
def test_the_inverse_puts_the_tips_where_they_belong_pointing_down(
    x_m: float, y_m: float, z_m: float
) -> None:
    angles = iiwa_tool_down(x_m, y_m, z_m)
    if angles is None:
        assert (x_m**2 + y_m**2 + (z_m + 0.276 - 0.34) ** 2) ** 0.5 >= 0.8
        return
    _, wrist, tips = iiwa_points(angles)
    assert tips == pytest.approx((x_m, y_m, z_m), abs=1e-9)
    assert wrist[2] - tips[2] == pytest.approx(0.276)


def test_the_reach_is_that_of_the_data_sheet() -> None:
    # 800 mm from the shoulder to the wrist's centre; 1266 mm to the flange, arm straight up.
    elbow, wrist, tips = iiwa_points((0.0,) * 7)
    assert (elbow[2], wrist[2], tips[2]) == pytest.approx((0.74, 1.14, 1.266 + 0.15))
    assert [round(limit.speed_rad_s, 4) for limit in IIWA_LIMITS] == [
        round(radians(speed), 4) for speed in (98, 98, 100, 130, 140, 180, 180)
    ]


def test_a_heavy_thing_needs_more_than_the_gripper_has() -> None:
    watch, kuka, world = watched()
    world.things.add(SimulatedObject(CUBE, "kuka1", STATION_M, mass_kg=3.0, width_m=0.05))
    watch.do("grasp", force_n=40.0)
    assert kuka.activity is not None
    assert kuka.activity.state is ActivityState.FAILED
    assert "slipped at 40 N" in kuka.activity.detail
