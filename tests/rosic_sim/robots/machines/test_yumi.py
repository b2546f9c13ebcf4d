from __future__ import annotations

from math import dist
from typing import TYPE_CHECKING

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rosic_sim.robots.machines.activity import ActivityRefused, ActivityState
from rosic_sim.robots.machines.world import PART, build_world
from rosic_sim.robots.machines.yumi import APART_M, HOME, JOINTS, MEET
from tests.rosic_sim.robots.machines.watching import JointWatch, Watched

if TYPE_CHECKING:
    from rosic_sim.robots.machines.objects import SimulatedObject
    from rosic_sim.robots.machines.world import SimulatedWorld
    from rosic_sim.robots.machines.yumi import Side, Yumi

MEETING = (
    "meeting",
    "right closes",
    "left closes",
    "verifying both hold",
    "left opens",
    "right opens",
    "parting",
)


def watched() -> tuple[Watched, Yumi, SimulatedWorld, SimulatedObject]:
    world = build_world()
    yumi = world.yumi
    part = world.things.get(PART)
    assert part is not None
    watch = Watched(yumi, JointWatch(yumi.arms))

    def always_held() -> None:
        assert part.holders, "nobody holds the part"
        assert part.holders <= {"yumi/left", "yumi/right"}

    watch.also.append(always_held)
    return watch, yumi, world, part


def stage(yumi: Yumi) -> str:
    return yumi.activity.stage if yumi.activity is not None else ""


def test_a_handover_passes_the_part_and_never_drops_it() -> None:
    watch, yumi, _, part = watched()
    holders: list[frozenset[str]] = []
    watch.also.append(lambda: holders.append(frozenset(part.holders)))
    watch.do("handover")
    assert yumi.activity is not None
    assert yumi.activity.state is ActivityState.DONE
    assert yumi.activity.detail == "the right gripper holds the part"
    assert list(dict.fromkeys(holders)) == [
        {"yumi/left"},
        {"yumi/left", "yumi/right"},
        {"yumi/right"},
    ]
    assert watch.stages == [
        "approaching",
        "meeting",
        "right closes",
        "verifying both hold",
        "left opens",
        "parting",
        "going home",
    ]
    assert yumi.arms.positions == pytest.approx(HOME)


def test_the_arms_are_in_step_and_apart_except_at_the_meeting() -> None:
    watch, yumi, _, _ = watched()
    nearest = {True: 9.0, False: 9.0}

    def look() -> None:
        left, right = yumi.arms.positions[:JOINTS], yumi.arms.positions[JOINTS:]
        for a, b in zip(left, right, strict=True):
            assert abs(a) == pytest.approx(abs(b), abs=1e-12)
        met = stage(yumi) in MEETING
        nearest[met] = min(nearest[met], yumi.separation_m())

    watch.also.append(look)
    watch.do("handover")
    assert nearest[False] >= APART_M
    assert 0.04 < nearest[True] < 0.07, "they did not meet, or collided"


def test_it_can_be_handed_back() -> None:
    watch, yumi, _, part = watched()
    watch.do("handover")
    with pytest.raises(ActivityRefused, match="yumi: the right gripper already holds something"):
        yumi.begin("handover", {}, watch.now_s)
    watch.do("handover", to="left")
    assert part.holders == {"yumi/left"}
    with pytest.raises(ActivityRefused, match="already holds"):
        yumi.begin("handover", {"to": "left"}, watch.now_s)


def test_without_a_part_there_is_nothing_to_hand_over() -> None:
    world = build_world()
    world.remove_thing(PART)
    with pytest.raises(ActivityRefused, match="yumi: the left gripper holds nothing to hand over"):
        world.yumi.begin("handover", {}, 0.0)
    assert not world.yumi.moving


@pytest.mark.parametrize("at", ["approaching", "right closes", "verifying both hold"])
def test_a_part_that_vanishes_fails_the_handover(at: str) -> None:
    watch, yumi, world, _ = watched()
    watch.also.clear()
    yumi.begin("handover", {}, 0.0)
    while stage(yumi) != at:
        watch.step()
    world.remove_thing(PART)
    watch.to_rest()
    assert yumi.activity is not None
    assert yumi.activity.state is ActivityState.FAILED
    assert "did not get hold" in yumi.activity.detail
    assert yumi.arms.positions == pytest.approx(HOME)


@settings(deadline=None, max_examples=60)
@given(
    after_s=st.floats(0.01, 8.0),
    side=st.sampled_from(["left", "right"]),
)
def test_one_arm_failing_stops_both_and_nothing_is_dropped(after_s: float, side: Side) -> None:
    watch, yumi, world, part = watched()
    activity = yumi.begin("handover", {}, 0.0)
    watch.run(after_s)
    if not activity.running:
        return
    world.fail_arm(side, watch.now_s)
    assert activity.state is ActivityState.FAILED
    assert f"the {side} arm has failed, both arms stopped" in activity.detail
    assert all(name.split("/")[1] in activity.detail for name in part.holders)
    holders = set(part.holders)
    watch.to_rest(0.2)
    assert all(v == 0.0 for v in yumi.arms.velocities)
    assert part.holders == holders
    resting = yumi.arms.positions
    watch.run(1.0)
    assert yumi.arms.positions == resting
    with pytest.raises(ActivityRefused, match=f"yumi: the {side} arm has failed"):
        yumi.begin("home", {}, watch.now_s)
    world.repair_arm(side)
    watch.do("home")
    assert yumi.arms.positions == pytest.approx(HOME)
    assert len(part.holders) == 1


@settings(deadline=None, max_examples=60)
@given(
    orders=st.lists(
        st.tuples(st.sampled_from(["home", "handover", "back"]), st.floats(0.01, 9.0)),
        min_size=1,
        max_size=4,
    )
)
def test_whatever_is_asked_limits_hold_and_the_part_is_held(
    orders: list[tuple[str, float]],
) -> None:
    watch, yumi, _, _ = watched()

    def no_collision() -> None:
        left, right = yumi.tips("left"), yumi.tips("right")
        assert dist(left, right) > 0.05
        assert left[1] > right[1], "the arms have crossed"

    watch.also.append(no_collision)
    for what, halt_after_s in orders:
        arguments = {"to": "left"} if what == "back" else {}
        try:
            yumi.begin("handover" if what == "back" else what, arguments, watch.now_s)
        except ActivityRefused:
            continue
        watch.run(halt_after_s)
        yumi.halt(watch.now_s)
        watch.to_rest(0.3)


def test_a_halt_at_the_meeting_leaves_a_way_home() -> None:
    watch, yumi, _, part = watched()
    yumi.begin("handover", {}, 0.0)
    while stage(yumi) != "verifying both hold":
        watch.step()
    assert yumi.arms.positions == pytest.approx(MEET)
    yumi.halt(watch.now_s)
    watch.to_rest(0.2)
    assert part.holders == {"yumi/left", "yumi/right"}
    watch.do("home")
    assert watch.stages == ["right opens", "parting", "going home"]
    assert part.holders == {"yumi/left"}


def test_an_idle_arm_that_fails_is_noted() -> None:
    watch, yumi, world, _ = watched()
    world.fail_arm("right", 1.0)
    assert yumi.note == "the right arm has failed, both arms stopped"
    assert yumi.telemetry()["failed"] == "right"
    assert yumi.activity is None
    watch.run(0.1)
    assert not yumi.moving


def test_a_lost_link_holds_both_arms() -> None:
    watch, yumi, _, _ = watched()
    activity = yumi.begin("handover", {}, 0.0)
    watch.run(1.0)
    yumi.link_lost(watch.now_s)
    assert activity.state is ActivityState.CANCELLED
    watch.to_rest(0.3)
