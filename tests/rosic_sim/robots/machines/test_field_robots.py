"""Machines outside the room: a sensor that drifts, and ground that gives way."""

from __future__ import annotations

import pytest

from rosic_sim.robots.machines.activity import ActivityState
from rosic_sim.robots.machines.fast_forward import to_end, to_rest
from rosic_sim.robots.machines.field_robots import AIR_C, Fire, FireWatcher, Rover
from rosic_sim.robots.machines.world import build_world
from rosic_sim.robots.scenery.scene import EMBER, robot_scene


def test_heat_is_felt_nearer_the_more_and_drift_is_taken_away() -> None:
    watch = FireWatcher("watch")
    assert watch.telemetry()["heat_c"] == AIR_C
    watch.kindle(Fire(1.0, 0.0, 50.0))
    assert watch.telemetry()["heat_c"] == pytest.approx(AIR_C + 25.0)
    watch.drift_by(-24.0)
    assert watch.telemetry()["heat_c"] == pytest.approx(AIR_C + 1.0)
    done = watch.begin("recalibrate", {}, 0.0)
    end_s = to_end(watch, 0.0)
    assert (done.state, done.detail) == (
        ActivityState.DONE,
        "recalibrated; the sensor was -24.0 °C off",
    )
    assert 1.4 < end_s < 1.7
    assert watch.telemetry()["heat_c"] == pytest.approx(AIR_C + 25.0)
    driven = watch.begin("goto", {"x_m": 1.0, "y_m": 0.0}, end_s)
    to_end(watch, end_s)
    assert driven.state is ActivityState.DONE
    assert watch.telemetry()["heat_c"] == pytest.approx(AIR_C + 50.0, abs=0.1)


def test_a_recalibration_that_is_halted_takes_nothing_away() -> None:
    watch = FireWatcher("watch")
    watch.drift_by(3.0)
    asked = watch.begin("recalibrate", {}, 0.0)
    watch.step(0.5)
    watch.halt(0.5)
    assert (asked.state, watch.drift_c) == (ActivityState.CANCELLED, 3.0)


def test_in_the_mud_it_gets_some_way_fails_and_rests() -> None:
    rover = Rover("rover1")
    asked = rover.begin("goto", {"x_m": 2.0, "y_m": 0.0}, 0.0)
    rover.step(0.2)
    rover.enter_mud()
    now_s = to_rest(rover, 0.2)
    assert (asked.state, rover.at_rest()) == (ActivityState.FAILED, True)
    assert 0.15 < rover.base.x_m < 0.4
    rover.leave_mud()
    again = rover.begin("goto", {"x_m": 0.0, "y_m": 0.0}, now_s)
    to_end(rover, now_s)
    assert again.state is ActivityState.DONE


def test_one_more_machine_is_stepped_and_seen_and_no_name_is_taken_twice() -> None:
    world = build_world()
    watch = FireWatcher("watch")
    world.add(watch)
    watch.begin("goto", {"x_m": 0.1, "y_m": 0.0}, 0.0)
    for tenth in range(60):
        world.step(tenth / 10)
    assert watch.base.x_m == pytest.approx(0.1, abs=0.01)
    assert not any(getattr(s, "colour", None) == EMBER for s in robot_scene(world, "watch").solids)
    watch.kindle(Fire(1.0, 0.0, 50.0))
    assert any(getattr(s, "colour", None) == EMBER for s in robot_scene(world, "watch").solids)
    with pytest.raises(ValueError, match="omni"):
        world.add(FireWatcher("omni"))
