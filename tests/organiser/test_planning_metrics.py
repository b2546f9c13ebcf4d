"""What a plan is said to do: its figures, its words, and both ways compared."""

from __future__ import annotations

import msgspec
import pytest

from rosic.bench.recorder import BenchRecorder
from rosic.bench.schedule import as_table, compare, measure
from rosic.organiser.planning.figures import figures_of, jain, plan_text
from rosic.organiser.planning.greedy import first_come_first_served
from rosic.organiser.planning.problem import StandingSlot
from rosic.organiser.planning.solver import propose
from tests.organiser.planning import a_problem, a_wish, at


def test_the_figures_of_a_plan_worked_out_by_hand() -> None:
    problem = a_problem(
        a_wish("one", 60, at(9), at(10), person="ann"),
        a_wish("two", 60, at(9), at(12), person="bob"),
        a_wish("three", 60, at(9), at(10), person="bob"),
        booked=[StandingSlot("yumi", at(9), at(12))],
        openings=[(at(9), at(13))],
    )

    figures = figures_of(problem, first_come_first_served(problem))

    assert (figures.granted, figures.wishes, figures.conflicts) == (2, 3, 0)
    assert figures.use == pytest.approx(2 / 5)
    assert (figures.idle_h, figures.between_h, figures.breaks) == (3, 0, 1)
    assert (figures.wait_mean_min, figures.wait_worst_min) == (30, 60)
    assert figures.fairness == pytest.approx((1 + 0.5) ** 2 / (2 * (1 + 0.25)))
    assert figures.least_share == 0.5


def test_the_index_of_fairness() -> None:
    assert jain([0.3, 0.3, 0.3]) == pytest.approx(1)
    assert jain([1, 0, 0, 0]) == pytest.approx(1 / 4)
    assert jain([]) == jain([0, 0]) == 1


def test_a_plan_as_it_is_read() -> None:
    problem = a_problem(
        a_wish("a", 90, at(9), at(11), person="p1"),
        a_wish("b", 30, at(9), at(11), person="p2"),
        a_wish("c", 30, at(9, day=1), at(10, day=1), person="p2", robots="yumi"),
        a_wish("d", 60, at(9), at(11), person="p3"),
    )

    text = plan_text(propose(problem), name_of={"p1": "Ann", "p2": "Bob", "p3": "Cem"}.__getitem__)

    assert text == (
        "3 of 4 wishes can be granted. Waiting: 30 min on average, 1 h 30 min at most.\n\n"
        "Mon 2026-11-02\n"
        "  09:00 to 10:30  kuka1  Ann\n"
        "  10:30 to 11:00  kuka1  Bob\n\n"
        "Tue 2026-11-03\n"
        "  09:00 to 09:30  yumi  Bob\n\n"
        "Left over\n"
        "  Cem, 1 h, Mon 2026-11-02 09:00 to 11:00: In the window, kuka1 goes to other wishes. "
        "kuka1 is free for that long from Mon 2026-11-02 11:00.\n\n"
        "No plan on a grid of 5 min is better."
    )


def test_the_comparison_shows_both_ways_and_no_conflicts() -> None:
    week = compare(3, limit_s=1.0, wishes=40)

    assert week.arrival.wishes == week.proposed.wishes == 40
    assert week.proposed.score >= week.arrival.score
    assert "| conflicts | 0 | 0 | 0 | 0 |" in as_table([week])


@pytest.mark.limit(180)
def test_the_bench_gives_the_figures_with_the_times() -> None:
    seen = measure(BenchRecorder("schedule", quick=True))
    report = msgspec.json.decode(msgspec.json.encode(seen))

    assert [case["name"] for case in report["cases"]] == ["order of arrival", "proposed plan"]
    for case in report["cases"]:
        assert 0 < case["p50_us"] <= case["p99_us"]
        assert case["figures"]["conflicts"] == 0
