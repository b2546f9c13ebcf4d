from __future__ import annotations

import time
from math import inf, nan
from typing import TYPE_CHECKING

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rosic_sim.robots.machines.activity import ActivityRefused, ActivityState
from rosic_sim.robots.machines.fast_forward import to_end, to_rest
from rosic_sim.robots.machines.omni import Omni
from rosic_sim.robots.machines.world import build_world

if TYPE_CHECKING:
    from rosic_sim.robots.machines.machine import Machine

HALF_A_METRE: dict[str, float | str] = {"direction": "forward", "distance_m": 0.5}
SIX = ("omni", "kuka1", "yumi", "cf1", "cf2", "cf3")
FIRST = {"omni": "move", "kuka1": "grasp", "yumi": "handover", "cf1": "takeoff"}


def test_the_world_has_the_six_robots_and_nothing_moves() -> None:
    world = build_world()
    assert tuple(world.machines) == SIX
    assert not world.moving
    assert all(machine.at_rest() for machine in world.machines.values())


def test_every_machine_keeps_the_protocol() -> None:
    world = build_world()
    machines: list[Machine] = list(world.machines.values())
    for machine in machines:
        keys = set(machine.telemetry())
        assert machine.activity is None
        assert not machine.moving
        machine.halt(1.0)
        machine.link_lost(2.0)
        assert machine.activity is None
        assert not machine.moving
        assert set(machine.telemetry()) == keys


def test_the_same_calls_give_the_same_motion_to_the_last_bit() -> None:
    def flight() -> list[object]:
        world = build_world()
        world.step(5.0)
        seen: list[object] = []
        world.omni.begin("move", HALF_A_METRE, 5.0)
        world.kuka.begin("grasp", {}, 5.0)
        world.yumi.begin("handover", {}, 5.0)
        for drone in world.drones:
            drone.begin("takeoff", {}, 5.0, start_s=5.5)
        for tick in range(600):
            world.step(5.0 + tick * 0.017)
            seen.append([dict(m.telemetry()) for m in world.machines.values()])
        return seen

    assert flight() == flight()


@settings(deadline=None, max_examples=30)
@given(ticks=st.lists(st.floats(0.0005, 0.4), min_size=1, max_size=12))
def test_the_end_does_not_depend_on_how_often_it_is_stepped(ticks: list[float]) -> None:
    omni = Omni()
    now_s, turn = 1_000_000.0, 0
    omni.begin("goto", {"x_m": 0.7, "y_m": -0.4, "yaw_rad": 1.0}, now_s)
    while omni.moving and now_s < 1_000_060.0:
        now_s += ticks[turn % len(ticks)] if turn < 500 else 0.05
        turn += 1
        omni.step(now_s)
    assert omni.activity is not None
    assert omni.activity.state is ActivityState.DONE
    assert abs(omni.base.x_m - 0.7) < 0.001
    assert abs(omni.base.y_m + 0.4) < 0.001
    assert abs(omni.base.yaw_rad - 1.0) < 0.001


def test_a_common_start_is_met_to_the_microsecond() -> None:
    world = build_world()
    world.step(0.0)
    for tick, drone in enumerate(world.drones):
        drone.begin("takeoff", {"height_m": 1.0}, 0.013 * tick, start_s=0.777)
    heights = set()
    for tick in range(1, 400):
        world.step(tick * 0.0173)
        if tick * 0.0173 <= 0.777:
            assert all(drone.at_rest() for drone in world.drones)
        heights.add(len({drone.flight.height.position for drone in world.drones}))
    assert heights == {1}, "they did not climb in step"
    for drone in world.drones:
        assert drone.activity is not None
        assert abs(drone.activity.facts["started_s"] - 0.777) < 1e-6
        assert drone.activity.begun_s == 0.777


def test_a_halt_while_waiting_for_the_start_moves_nothing() -> None:
    omni = Omni()
    omni.begin("move", HALF_A_METRE, 0.0, start_s=3.0)
    omni.step(1.0)
    assert omni.moving
    omni.halt(1.0)
    assert omni.activity is not None
    assert omni.activity.state is ActivityState.CANCELLED
    now_s = to_rest(omni, 1.0)
    omni.step(now_s + 5.0)
    assert omni.base.x_m == 0.0
    assert omni.activity.facts["distance_m"] == 0.0


@pytest.mark.parametrize("start_s", [61.0, inf, nan])
def test_a_start_too_far_ahead_is_declined(start_s: float) -> None:
    omni = Omni()
    with pytest.raises(ActivityRefused, match="ahead"):
        omni.begin("move", HALF_A_METRE, 0.0, start_s=start_s)
    assert not omni.moving


def test_a_start_that_is_over_is_declined_unless_only_just() -> None:
    late, just = Omni(), Omni()
    with pytest.raises(ActivityRefused, match="heard of the common start too late"):
        late.begin("move", HALF_A_METRE, 5.0, start_s=4.85)
    assert not late.moving
    assert just.begin("move", HALF_A_METRE, 5.0, start_s=4.95).begun_s == 5.0


def test_time_never_runs_back() -> None:
    omni = Omni()
    omni.begin("move", HALF_A_METRE, 10.0)
    omni.step(11.0)
    before = omni.telemetry()
    omni.step(3.0)
    assert omni.telemetry() == before
    for bad in (inf, nan):
        with pytest.raises(ValueError, match="finite"):
            omni.step(bad)


def test_one_thing_at_a_time() -> None:
    omni = Omni()
    first = omni.begin("move", HALF_A_METRE, 0.0)
    with pytest.raises(ActivityRefused, match="omni: busy with move"):
        omni.begin("turn", {"angle_rad": 1.0}, 0.1)
    assert omni.activity is first
    omni.halt(0.8)
    with pytest.raises(ActivityRefused, match="coming to rest"):
        omni.begin("move", HALF_A_METRE, 0.81)
    now_s = to_rest(omni, 0.81)
    assert omni.begin("move", HALF_A_METRE, now_s).number == 2


@pytest.mark.parametrize("robot", SIX)
@pytest.mark.parametrize(
    ("skill", "arguments"),
    [
        ("dance", {}),
        ("", {}),
        ("x" * 10_000, {}),
        ("move", {"distance_m": nan}),
        ("move", {"distance_m": inf}),
        ("move", {"distance_m": -1.0}),
        ("move", {"distance_m": 0.0}),
        ("move", {"distance_m": 1e300}),
        ("move", {"distance_m": True}),
        ("move", {"distance_m": "1"}),
        ("move", {"distance_m": 1.0, "speed_m_s": 0.9}),
        ("move", {"distance_m": 1.0, "direction": "up"}),
        ("move", {"distance_m": 1.0, "colour": "red"}),
        ("move", {}),
        ("turn", {"angle_rad": 7.0}),
        ("goto", {"x_m": 1e9, "y_m": 0.0, "z_m": 1.0}),
        ("arm", {"pose": "wave"}),
        ("move_joint", {"joint": 8, "angle_rad": 0.0}),
        ("move_joint", {"joint": 1.5, "angle_rad": 0.0}),
        ("move_joint", {"joint": 2, "angle_rad": 2.2}),
        ("grasp", {"force_n": 41.0}),
        ("handover", {"to": "me"}),
        ("takeoff", {"height_m": 9.0}),
        ("takeoff", {"height_m": nan}),
        ("formation", {"shape": "star"}),
    ],
)
def test_bad_requests_are_declined_and_move_nothing(
    robot: str, skill: str, arguments: dict[str, float | str]
) -> None:
    world = build_world()
    machine = world.machines[robot]
    machine.step(0.0)
    before = machine.telemetry()
    with pytest.raises(ActivityRefused) as caught:
        machine.begin(skill, arguments, 0.0)
    sentence = str(caught.value)
    assert sentence.startswith(f"{robot}: ")
    assert len(sentence) < 160
    assert machine.telemetry() == before
    assert not machine.moving
    assert machine.activity is None


def test_one_step_costs_less_than_50_microseconds() -> None:
    world = build_world()
    now_s = 0.0
    for drone in world.drones:
        drone.begin("takeoff", {}, now_s)
    while any(d.activity is not None and d.activity.running for d in world.drones):
        now_s += 0.01
        world.step(now_s)
    for robot, skill in FIRST.items():
        arguments: dict[str, float | str] = {"distance_m": 5.0} if skill == "move" else {}
        if robot == "cf1":
            skill, arguments = "goto", {"x_m": -2.0, "y_m": -2.0}  # noqa: PLW2901
        machine = world.machines[robot]
        machine.begin(skill, arguments, now_s)
        best = inf
        at_s = now_s
        for _ in range(5):
            begun = time.process_time()
            for _ in range(40):
                at_s += 0.01
                machine.step(at_s)
            best = min(best, (time.process_time() - begun) / 40)
        assert machine.moving
        assert best < 50e-6, f"{robot}: {best * 1e6:.0f} us"


def test_fast_forward_gives_up_in_time() -> None:
    omni = Omni()
    omni.begin("move", {"distance_m": 5.0, "speed_m_s": 0.01}, 0.0)
    with pytest.raises(TimeoutError, match="omni"):
        to_end(omni, 0.0, limit_s=1.0)
    with pytest.raises(TimeoutError, match="omni"):
        to_rest(omni, 2.0, limit_s=1.0)
