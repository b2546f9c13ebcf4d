"""I2, I3, I4, I5 and I13 on whole histories of what can reach one robot's side."""

from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

from rosic.core.identity import command_id
from rosic.core.order import Order, Permit, Stop
from rosic.core.order_gate import OrderGate
from rosic.core.robot.skill import Skill, SkillClass
from rosic.core.synchronised_start import TOO_LATE_NS
from rosic.errors import OrderVoid

MOVE = Skill(id="move")
LOOK = Skill(id="look", kind=SkillClass.OBSERVE)
NOW_NS = 1_000
WALL_NS = 5_000_000

events = st.lists(
    st.one_of(
        st.tuples(
            st.just("order"),
            st.integers(1, 8),  # n
            st.integers(0, 4),  # fence
            st.integers(0, 4),  # stop generation when admitted
            st.sampled_from([NOW_NS - 1, NOW_NS, NOW_NS + 1]),  # deadline
            st.sampled_from([WALL_NS - 1, WALL_NS, WALL_NS + 1]),  # the same on the wall clock
        ),
        st.tuples(st.just("stop"), st.integers(1, 4)),
        st.tuples(st.just("resume"), st.integers(1, 4)),
    ),
    max_size=25,
)


def order(
    n: int,
    fence: int,
    generation: int,
    deadline_ns: int,
    skill: Skill = MOVE,
    expires_ns: int = WALL_NS,
) -> Order:
    permit = Permit("p", "k", "r", skill.id, fence, False, generation, 1)
    return Order(command_id(str(n)), "r", skill, {}, n, deadline_ns, expires_ns, permit)


def passes(gate: OrderGate, given_order: Order) -> bool:
    try:
        gate.pass_order(given_order, NOW_NS, WALL_NS)
    except OrderVoid:
        return False
    return True


@settings(max_examples=1_000, deadline=None)
@given(events)
def test_no_history_lets_a_wrong_order_act(history: list[tuple[object, ...]]) -> None:
    gate = OrderGate.new("r")
    acted: list[int] = []
    fences, stops, latched = [0], [0], False
    for event in history:
        before = (gate.n, gate.fence, gate.generation)
        match event:
            case ("order", int(n), int(fence), int(generation), int(deadline_ns), int(expires_ns)):
                fences.append(fence)
                if passes(gate, order(n, fence, generation, deadline_ns, MOVE, expires_ns)):
                    assert not latched, "I5: acted while stopped"
                    assert generation >= max(stops), "I5: acted though ordered before a stop"
                    assert fence == max(fences), "I4: acted under an old lease"
                    assert all(n > earlier for earlier in acted), "I3: acted out of order"
                    assert deadline_ns >= NOW_NS, "I2: acted too late"
                    assert expires_ns >= WALL_NS, "I2: acted too late by the wall clock"
                    acted.append(n)
            case ("stop", int(generation)):
                gate.apply_stop(Stop("r", generation))
                latched = latched or generation > max(stops)
                stops.append(generation)
            case ("resume", int(generation)):
                gate.resume(generation)
                latched = latched and generation < max(stops)
        after = (gate.n, gate.fence, gate.generation)
        assert all(a >= b for a, b in zip(after, before, strict=True)), "I13: a number fell"


def test_a_good_order_passes() -> None:
    assert passes(OrderGate.new("r"), order(1, 1, 0, NOW_NS))


def test_looking_needs_no_lease_and_is_allowed_while_stopped_but_not_too_late() -> None:
    gate = OrderGate("r", n=0, fence=5, generation=0, latched=False)
    assert passes(gate, order(1, 0, 0, NOW_NS, LOOK))
    assert not passes(gate, order(2, 0, 0, NOW_NS - 1, LOOK))
    gate.apply_stop(Stop("r", 1))
    assert passes(gate, order(3, 0, 0, NOW_NS, LOOK))
    assert not passes(gate, order(4, 9, 1, NOW_NS, MOVE))


def test_an_order_for_another_robot_is_void() -> None:
    assert not passes(OrderGate.new("q"), order(1, 1, 0, NOW_NS))


def test_what_was_ordered_before_a_stop_does_not_go_on_after_the_resume() -> None:
    gate = OrderGate.new("r")
    before = order(1, 1, 0, NOW_NS)
    gate.pass_order(before, NOW_NS, WALL_NS)
    assert gate.still_allows(before)
    gate.apply_stop(Stop("r", 1))
    assert not gate.still_allows(before)
    gate.resume(1)
    assert not gate.still_allows(before), "I5: never again, though the robot may move"
    assert gate.still_allows(order(2, 1, 1, NOW_NS))


def test_looking_goes_on_through_a_stop() -> None:
    gate = OrderGate.new("r")
    looking = order(1, 1, 0, NOW_NS, LOOK)
    gate.apply_stop(Stop("r", 1))
    assert gate.still_allows(looking)


def test_the_same_stop_again_latches_nothing_that_was_resumed() -> None:
    gate = OrderGate.new("r")
    gate.apply_stop(Stop("r", 1))
    gate.resume(1)
    gate.apply_stop(Stop("r", 1))
    assert not gate.latched, "the registry says that it may move: nobody could resume it any more"


@pytest.mark.parametrize(
    ("late_ns", "why"),
    [
        (0, "This reached r too late to begin with the others. Nothing was done."),
        (1, "This reached r too late. Nothing was done."),
    ],
)
def test_what_is_too_late_is_told_for_what(late_ns: int, why: str) -> None:
    began_ns = NOW_NS - TOO_LATE_NS - 1
    together = replace(order(1, 1, 0, NOW_NS - late_ns), start_ns=began_ns)
    with pytest.raises(OrderVoid) as void:
        OrderGate.new("r").pass_order(together, NOW_NS, WALL_NS, together=True)
    assert str(void.value) == why


def test_a_robot_that_keeps_no_common_start_begins_as_its_order_arrives() -> None:
    gate, missed_ns = OrderGate.new("r"), NOW_NS - TOO_LATE_NS - 1
    gate.pass_order(replace(order(1, 1, 0, NOW_NS), start_ns=missed_ns), NOW_NS, WALL_NS)
    assert gate.n == 1


def test_a_new_gate_has_seen_nothing() -> None:
    gate = OrderGate.new("r")
    assert (gate.robot, gate.n, gate.fence, gate.generation) == ("r", 0, 0, 0)
    assert not gate.latched
