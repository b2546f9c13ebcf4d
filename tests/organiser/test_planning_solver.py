"""Which robot takes which task: as cheap as can be, urgent ones first, and nobody's by mistake."""

from __future__ import annotations

import sys
from time import thread_time

import pytest
from msgspec.structs import replace

from rosic.bench.fleet import NOW_NS, SMALL, best_pairs, floor
from rosic.core.fleet.candidates import CandidateRobot, by_priority
from rosic.core.fleet.events import MembershipSet, TaskGiven
from rosic.core.fleet.state import FleetState
from rosic.core.fleet.task import FleetMembership, Task, TaskNeed
from rosic.core.fleet.transitions import react
from rosic.organiser.planning.solver import Assignment
from rosic.organiser.planning.solver import assign as choose
from tests.pace import sample_of_work_s


def assign(fleet: FleetState, glances: dict[str, CandidateRobot], now_ns: int) -> Assignment:
    return choose(fleet, by_priority(fleet, glances, now_ns), glances, now_ns)


def fleet_of(*tasks: Task) -> FleetState:
    fleet = FleetState()
    for task in tasks:
        feed(fleet, TaskGiven(task))
    return fleet


def feed(fleet: FleetState, event: TaskGiven | MembershipSet) -> None:
    for fact in fleet.facts(react(fleet, event, NOW_NS)):
        fleet.apply(fact)


def task(key: str, **more: object) -> Task:
    return Task(**{"id": key, "author": "ann", "among": ("r1", "r2"), **more})  # type: ignore[arg-type]


def robots(*glances: CandidateRobot) -> dict[str, CandidateRobot]:
    return {glance.robot: glance for glance in glances}


FREE = robots(CandidateRobot(robot="r1"), CandidateRobot(robot="r2"))


@pytest.mark.parametrize("seed", range(12))
def test_it_is_the_best_there_is_on_floors_so_small_that_every_way_can_be_tried(seed: int) -> None:
    small = floor(seed, SMALL, SMALL)
    found = assign(small.fleet, small.glances, NOW_NS)
    assert found.best
    if len(found.pairs) == SMALL:
        assert small.cost_m(found.pairs) == pytest.approx(small.cost_m(best_pairs(small)))


def test_a_thousand_tasks_and_two_hundred_robots_take_little_work() -> None:
    large = floor(1, 1_000, 200)
    assign(floor(0, 2, 2).fleet, FREE, NOW_NS)  # the solver is loaded
    took, samples = [], []
    for _ in range(3):
        samples.append(sample_of_work_s())
        began = thread_time()
        assign(large.fleet, large.glances, NOW_NS)
        took.append(thread_time() - began)
    assert min(took) < 10 * min(samples)  # a second where a sample takes its usual 0.1 s
    found = assign(large.fleet, large.glances, NOW_NS)
    assert len(found.pairs) == 200
    assert len(dict(found.pairs)) == len({robot for _, robot in found.pairs}) == 200


def test_what_is_urgent_chooses_first_even_if_that_costs_more() -> None:
    fleet = fleet_of(
        task("1", place=(0, 0)),
        task("2", place=(90, 0), priority=5),
    )
    near = robots(CandidateRobot(robot="r1", place=(0, 0)))
    assert assign(fleet, near, NOW_NS).pairs == [("2", "r1")]


def test_whoever_has_waited_long_is_not_passed_over_for_ever_by_what_is_near() -> None:
    hour_ns = 3_600_000_000_000
    fleet = fleet_of(
        task("1", place=(0, 0), given_ns=NOW_NS),
        task("2", place=(90, 0), given_ns=NOW_NS - hour_ns),
    )
    near = robots(CandidateRobot(robot="r1", place=(0, 0)))
    assert assign(fleet, near, NOW_NS).pairs == [("2", "r1")]


@pytest.mark.parametrize(
    "glance",
    [
        CandidateRobot(robot="r1", free=False),
        CandidateRobot(robot="r1", holder="ben"),
        CandidateRobot(robot="r1", battery=29.0, place=(0, 0)),
        CandidateRobot(robot="r1", battery=None, place=(0, 0)),
        CandidateRobot(robot="r1", battery=90.0, place=None),
        CandidateRobot(robot="r3", battery=90.0, place=(0, 0)),
    ],
    ids=["at work", "another's", "empty", "says no battery", "lost", "cannot"],
)
@pytest.mark.parametrize("solver", [True, False], ids=["solver", "nearest idle"])
def test_no_robot_is_chosen_that_does_not_fit(
    glance: CandidateRobot, solver: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    if not solver:
        monkeypatch.setitem(sys.modules, "scipy.optimize", None)
    fleet = fleet_of(task("1", need=TaskNeed(battery=30.0, localised=True)))
    assert assign(fleet, robots(glance), NOW_NS).pairs == []
    good = CandidateRobot(robot="r1", battery=30.0, place=(0, 0), holder="ann")
    assert assign(fleet, robots(good), NOW_NS).pairs == [("1", "r1")]


def test_a_robot_that_takes_no_part_and_a_task_that_is_too_late_or_too_early_wait() -> None:
    fleet = fleet_of(task("1", until_ns=NOW_NS - 1), task("2", after=("9",)), task("3"))
    feed(fleet, MembershipSet("r1", FleetMembership.DISABLED))
    assert assign(fleet, FREE, NOW_NS).pairs == [("3", "r2")]


def test_without_the_solver_each_task_takes_the_best_that_is_left(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    large = floor(3, 100, 40)
    best = assign(large.fleet, large.glances, NOW_NS)
    monkeypatch.setitem(sys.modules, "scipy.optimize", None)
    found = assign(large.fleet, large.glances, NOW_NS)
    assert not found.best
    assert len(found.pairs) == len(best.pairs) == 40
    assert large.cost_m(best.pairs) < large.cost_m(found.pairs)


def test_as_many_tasks_as_can_be_are_given_a_robot() -> None:
    fleet = fleet_of(task("1", among=("r1",), place=(50, 0)), task("2", place=(0, 0)))
    here = robots(
        CandidateRobot(robot="r1", place=(0, 0)), replace(FREE["r2"], place=(99, 0), battery=1.0)
    )
    assert sorted(assign(fleet, here, NOW_NS).pairs) == [("1", "r1"), ("2", "r2")]
