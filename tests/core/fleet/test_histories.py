"""What a fleet promises, over generated histories with failures, losses, late answers, crashes.

A task is on at most one robot, no robot has two, nothing is lost, whoever counts as idle is at
rest, a task moves exactly once for each robot it leaves, and nobody's robot is given to another.
"""

from __future__ import annotations

import pytest
from hypothesis import HealthCheck, Phase, given, note, settings
from hypothesis import strategies as st

from tests.core.fleet.world import World, possible

A_FEW, MANY = 2_000, 100_000
LONGEST = 120

some = settings(
    max_examples=A_FEW,
    deadline=None,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.large_base_example],
    # A run that has to fail and is not read leaves out more: nothing is made shorter there.
    phases=[phase for phase in settings().phases if phase is not Phase.explain],
)
many = settings(some, max_examples=MANY)
histories = st.binary(min_size=40, max_size=LONGEST)


def live(history: bytes) -> World:
    """Live through a history, two bytes a step; should it fail, the report shows it."""
    world = World()
    try:
        for at in range(0, len(history) - 1, 2):
            ops, of = possible(world), history[at + 1]
            op = ops[history[at] % len(ops)]
            world.steps_told.append(f"{op} {of}")
            getattr(world, op)(of)
            world.check()
        world.steps_told.append("settle")
        world.settle()
    except BaseException:
        for step in world.steps_told:
            note(step)
        raise
    return world


@pytest.mark.limit(120)
@some
@given(histories)
def test_whatever_fails_no_promise_is_broken(history: bytes) -> None:
    live(history)


@pytest.mark.campaign
@pytest.mark.limit(3_600)
@many
@given(histories)
def test_many_histories(history: bytes) -> None:
    live(history)
