from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from rosic_sim.robots.machines.joints import Axis

STEPS = st.lists(st.floats(1e-6, 0.01), min_size=1, max_size=40)


@given(
    target=st.floats(-3, 3),
    speed=st.floats(0.05, 2.0),
    acceleration=st.floats(0.1, 10.0),
    steps=STEPS,
)
def test_an_axis_arrives_exactly_and_never_passes_its_target(
    target: float, speed: float, acceleration: float, steps: list[float]
) -> None:
    axis = Axis(0.0, speed, acceleration)
    axis.target = target
    needed_s = abs(target) / speed + 2.0 * speed / acceleration + 1.0
    time_s, turn = 0.0, 0
    while not axis.arrived and time_s < needed_s:
        dt_s = steps[turn % len(steps)] if turn < 200 else 0.01
        turn += 1
        before = axis.velocity
        axis.step(dt_s)
        time_s += dt_s
        assert abs(axis.velocity) <= speed + 1e-9
        assert abs(axis.velocity - before) <= acceleration * dt_s + 1e-9
        # One step's worth of rounding is all that braking in steps may cost.
        assert abs(axis.position) <= abs(target) + acceleration * 0.01**2 / 8 + 1e-9
    assert axis.arrived


@given(targets=st.lists(st.floats(-2, 2), min_size=1, max_size=5), every=st.integers(1, 80))
def test_an_axis_keeps_its_acceleration_when_the_target_jumps(
    targets: list[float], every: int
) -> None:
    axis = Axis(0.0, 1.0, 2.0)
    for target in targets:
        axis.target = target
        for _ in range(every):
            before = axis.velocity
            axis.step(0.01)
            assert abs(axis.velocity - before) <= 2.0 * 0.01 + 1e-9
            assert abs(axis.velocity) <= 1.0 + 1e-9


@given(after=st.integers(1, 100))
def test_braking_rests_within_what_the_deceleration_implies(after: int) -> None:
    axis = Axis(0.0, 0.8, 1.0)
    axis.target = 10.0
    for _ in range(after):
        axis.step(0.01)
    speed, start, steps = axis.velocity, axis.position, 0
    while axis.velocity:
        axis.brake(0.01, 2.0)
        steps += 1
    assert steps * 0.01 <= speed / 2.0 + 0.011
    assert axis.position - start <= speed * speed / 4.0 + speed * 0.01
    assert axis.arrived
