"""Dynamic allocation (Algorithm 3): the plan is lawful, the best there is, and explains itself."""

from __future__ import annotations

import subprocess
import sys
import time
from random import Random
from threading import Event, Thread

import msgspec
import pytest

from rosic.bench.schedule import generated_week
from rosic.organiser.planning.figures import figures_of, plan_text
from rosic.organiser.planning.greedy import first_come_first_served, grid_for
from rosic.organiser.planning.problem import (
    Allocation,
    LeftOverReason,
    PlanCaveat,
    StandingSlot,
    Wish,
    broken_rules,
    parts_of,
)
from rosic.organiser.planning.solver import propose
from tests.cli.running import environment
from tests.organiser.planning import (
    a_problem,
    a_wish,
    at,
    best_by_trying,
    both,
    clashes,
    score,
    small_problem,
)
from tests.pace import pace, patience, slowness

# ---- lawful and best ----


@pytest.mark.parametrize("seed", range(40))
def test_the_plan_of_a_small_problem_is_the_best_of_all_plans(seed: int) -> None:
    problem = small_problem(Random(seed))  # noqa: S311 - made-up wishes

    proposal = propose(problem, grid_s=300)

    assert clashes(problem, proposal.allocations) == []
    assert proposal.parts.score == pytest.approx(score(problem, proposal.allocations))
    assert proposal.parts.score == pytest.approx(best_by_trying(problem, 5))
    assert proposal.bound == pytest.approx(proposal.parts.score)
    assert (proposal.solved, proposal.note) == (True, None)


@pytest.mark.limit(120)
@pytest.mark.parametrize("weeks", [6, pytest.param(20, marks=pytest.mark.campaign)])
def test_over_many_weeks_the_plan_is_lawful_and_never_worse_than_the_order_of_arrival(
    weeks: int,
) -> None:
    gained = []
    for seed in range(weeks):
        problem = generated_week(seed, wishes=90)
        arrival = first_come_first_served(problem, grid_s=900)
        proposal = propose(problem, grid_s=900, limit_s=0.5 * slowness())
        for plan in (arrival, proposal):
            assert clashes(problem, plan.allocations) == []
            assert broken_rules(problem, plan.allocations) == []
            kept = [a.wish.id for a in plan.allocations] + [left.wish.id for left in plan.left]
            assert sorted(kept) == [wish.id for wish in problem.wishes]
        assert proposal.parts.score >= arrival.parts.score
        assert proposal.bound is None or proposal.bound >= proposal.parts.score
        gained.append(figures_of(problem, proposal).use - figures_of(problem, arrival).use)
    assert sum(gained) / len(gained) > 0.03


def test_by_arrival_the_first_gets_the_earliest_place_that_is_left() -> None:
    problem = a_problem(
        a_wish("late but first", 60, at(9), at(12)),
        a_wish("second", 60, at(9), at(12)),
        a_wish("narrow", 60, at(9), at(10)),
        a_wish("either", 30, at(9), at(12), robots="kuka1 yumi"),
    )

    arrival, proposal = both(problem)

    assert [(a.wish.id, a.robot, a.start_ns) for a in arrival.allocations] == [
        ("late but first", "kuka1", at(9)),
        ("either", "yumi", at(9)),
        ("second", "kuka1", at(10)),
    ]
    assert [left.wish.id for left in arrival.left] == ["narrow"]
    assert not arrival.solved
    assert len(proposal.allocations) == 4


def test_priority_decides_when_only_one_can_have_it() -> None:
    problem = a_problem(
        a_wish("ordinary", 60, at(9), at(10)), a_wish("urgent", 60, at(9), at(10), priority=2)
    )

    _, proposal = both(problem)

    assert [a.wish.id for a in proposal.allocations] == ["urgent"]


def test_a_person_is_not_given_two_robots_at_one_time() -> None:
    problem = a_problem(
        a_wish("one", 60, at(9), at(10), person="ann"),
        a_wish("two", 60, at(9), at(10), person="ann", robots="yumi"),
    )

    for plan in both(problem):
        assert len(plan.allocations) == 1
        assert [left.why for left in plan.left] == [LeftOverReason.OWN_SLOTS]
        assert plan.left[0].free_ns == at(10)


def test_granting_is_always_worth_it_however_late_short_and_alone() -> None:
    """Otherwise a wish could be left over beside an idle robot."""
    problem = a_problem(a_wish("short", 1, at(9), at(9, 1, day=5)))
    late = Allocation(problem.wishes[0], "kuka1", at(9, 0, day=5))

    assert parts_of(problem, [late]).score > parts_of(problem, []).score


# ---- obstacles, windows, grids ----


def test_a_gap_that_fits_to_the_minute_is_used_whatever_the_grid() -> None:
    booked = [StandingSlot("kuka1", at(8), at(9, 7)), StandingSlot("kuka1", at(9, 54), at(12))]
    problem = a_problem(
        a_wish("gap", 47, at(9), at(11)), a_wish("window", 13, at(13, 1), at(13, 14)), booked=booked
    )

    for plan in both(problem):
        assert [a.start_ns for a in plan.allocations] == [at(9, 7), at(13, 1)]


def test_nothing_is_proposed_across_closing_time_but_across_a_seamless_midnight() -> None:
    night = a_wish("night", 120, at(23), at(1, day=1))

    closed = a_problem(night, openings=[(at(8), at(23, 59)), (at(0, day=1), at(9, day=1))])
    open_ = a_problem(night, openings=[(at(8), at(0, day=1)), (at(0, day=1), at(9, day=1))])

    for plan in both(closed):
        assert [left.why for left in plan.left] == [LeftOverReason.CLOSED]
        assert plan.left[0].free_ns == at(0, day=1)
    for plan in both(open_):
        assert [a.start_ns for a in plan.allocations] == [at(23)]


@pytest.mark.parametrize(
    ("wish", "why", "said"),
    [
        (a_wish("x", 60, at(9), at(9, 30)), LeftOverReason.WINDOW_TOO_SHORT, "shorter than that"),
        (a_wish("x", 60, at(12), at(11)), LeftOverReason.WINDOW_TOO_SHORT, "shorter than that"),
        (
            a_wish("x", 60, at(9), at(11), robots="hal"),
            LeftOverReason.NO_SUCH_ROBOT,
            "no robot called hal",
        ),
        (a_wish("x", 60, at(2), at(5)), LeftOverReason.CLOSED, "opening hours"),
        (a_wish("x", 60, at(14), at(16)), LeftOverReason.BOOKED, "kuka1 is booked"),
    ],
)
def test_a_wish_that_cannot_be_granted_is_named_with_the_reason(
    wish: Wish, why: LeftOverReason, said: str
) -> None:
    problem = a_problem(
        a_wish("fine", 60, at(9), at(10), robots="yumi"),
        wish,
        booked=[StandingSlot("kuka1", at(14), at(15, 30))],
        openings=[(at(8), at(18))],
    )

    for plan in both(problem):
        assert [a.wish.id for a in plan.allocations] == ["fine"]
        assert [(left.wish, left.why) for left in plan.left] == [(wish, why)]
        assert said in plan_text(plan)


def test_whoever_is_crowded_out_is_told_the_next_free_time() -> None:
    problem = a_problem(*(a_wish(f"w{n}", 60, at(9), at(11)) for n in range(3)))

    for plan in both(problem):
        (left,) = plan.left
        assert (left.why, left.free_ns, left.free_robot) == (
            LeftOverReason.CROWDED,
            at(11),
            "kuka1",
        )
        assert "kuka1 is free for that long from Mon 2026-11-02 11:00." in plan_text(plan)


def test_no_wishes_give_an_empty_plan() -> None:
    for plan in both(a_problem()):
        assert (plan.allocations, plan.left, plan.parts.score) == ((), (), 0)
        assert plan_text(plan).startswith("Nobody wishes for anything.")
    assert figures_of(a_problem(), propose(a_problem())).use == 0


def test_the_grid_is_fine_for_few_wishes_and_coarse_for_many() -> None:
    assert grid_for(a_problem(a_wish("x", 60, at(9), at(12)))) == 300
    assert grid_for(generated_week(0)) == 900


# ---- bounded, checked, without the library ----


def test_out_of_time_the_best_so_far_is_returned_with_an_honest_gap() -> None:
    problem = generated_week(0, wishes=400)
    began = time.monotonic()

    proposal = propose(problem, limit_s=0.1)

    assert time.monotonic() - began < 20 * patience()
    assert clashes(problem, proposal.allocations) == []
    assert proposal.note in (PlanCaveat.NOT_PROVEN, PlanCaveat.NOTHING_FOUND)
    if proposal.gap is not None:
        assert proposal.gap > 0
        assert "% short of the best there is" in plan_text(proposal)


def test_too_many_possibilities_are_answered_by_arrival() -> None:
    problem = a_problem(*(a_wish(f"w{n}", 30, at(0), at(0, day=60)) for n in range(12)))

    proposal = propose(problem, grid_s=300)

    assert (proposal.note, proposal.solved, len(proposal.allocations)) == (
        PlanCaveat.TOO_MANY,
        False,
        12,
    )


def test_without_scipy_the_order_of_arrival_and_the_name_of_the_extra() -> None:
    program = (
        "import sys; sys.modules['scipy'] = None\n"
        "from rosic.bench.schedule import generated_week\n"
        "from rosic.organiser.planning.solver import propose\n"
        "from rosic.organiser.planning.figures import plan_text\n"
        "print(plan_text(propose(generated_week(0, wishes=9))))"
    )

    ran = subprocess.run(  # noqa: S603 - our own words
        [sys.executable, "-c", program],
        env=environment(),
        capture_output=True,
        text=True,
        check=True,
        timeout=150 * pace(),
    )

    assert ran.stdout.splitlines()[-1] == (
        "This is the order of arrival. Weighing all wishes together needs one more library: "
        "pip install 'rosic[schedule]' (in a checkout: .venv/bin/pip install -e '.[schedule]')"
    )
    assert " to " in ran.stdout.splitlines()[3]


def test_while_the_solver_works_other_threads_run() -> None:
    """A stop must not wait for a plan."""
    propose(generated_week(1, wishes=5))  # loads the library
    over, ticks = Event(), [time.monotonic()]

    def tick() -> None:
        while not over.wait(0.005):
            ticks.append(time.monotonic())

    ticker = Thread(target=tick)
    ticker.start()
    try:
        propose(generated_week(0), grid_s=900, limit_s=1.0)
    finally:
        over.set()
        ticker.join()
    assert len(ticks) > 20


def test_every_broken_rule_is_seen() -> None:
    wish = a_wish("w", 60, at(9), at(11), person="ann")
    other = a_wish("v", 60, at(9), at(11), person="ann", robots="yumi")
    problem = a_problem(
        wish, other, booked=[StandingSlot("kuka1", at(10, 30), at(11))], openings=[(at(9), at(12))]
    )
    stranger = msgspec.structs.replace(wish, length_s=60)

    def said(*given: Allocation) -> str:
        return " / ".join(broken_rules(problem, given))

    assert said(Allocation(wish, "kuka1", at(9))) == ""
    assert "before its window" in said(Allocation(wish, "kuka1", at(8, 59)))
    assert "after its window" in said(Allocation(wish, "kuka1", at(10, 1)))
    assert "closed" in said(Allocation(wish, "kuka1", at(8, 30)))
    assert "not wished for" in said(Allocation(wish, "yumi", at(9)))
    assert "kuka1 is given twice" in said(Allocation(wish, "kuka1", at(9, 45)))
    assert "not a wish" in said(Allocation(stranger, "kuka1", at(9)))
    assert "granted twice" in said(*[Allocation(wish, "kuka1", at(9))] * 2)
    assert "ann has two robots" in said(
        Allocation(wish, "kuka1", at(9)), Allocation(other, "yumi", at(9, 30))
    )


@pytest.mark.parametrize(
    "change", [{"length_s": 0}, {"length_s": -60}, {"priority": 0}, {"priority": 6}]
)
def test_a_wish_without_length_or_with_a_strange_priority_cannot_be_made(
    change: dict[str, int],
) -> None:
    with pytest.raises(ValueError, match="must be"):
        msgspec.structs.replace(a_wish("x", 60, at(9), at(11)), **change)
