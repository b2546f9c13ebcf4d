"""The table of the campaign in the documentation: it is about what there is, and adds up."""

from __future__ import annotations

import re
from collections import Counter
from datetime import date
from typing import TYPE_CHECKING

from tests.mutants import report
from tests.mutants.__main__ import AT_LEAST
from tests.mutants.campaign import SOURCE, Found, Known, listed
from tests.mutants.modules import MODULES, Module
from tests.mutants.mutation import mutants
from tests.mutants.running import KILLED, SAME, SURVIVED, TIMED_OUT, Result

if TYPE_CHECKING:
    from pathlib import Path

PAGE = report.PAGE.read_text(encoding="utf-8")
ROWS = report.read(PAGE)


def test_every_module_of_the_campaign_has_its_line() -> None:
    """Else: make mutants MUTANTS='--at-most 40 --seed 2 --write --only MODULE'."""
    assert [(row.about, row.file) for row in ROWS] == [(one.about, one.file) for one in MODULES]


def test_every_line_adds_up_and_its_survivors_have_reasons() -> None:
    reasons = Counter(each.file for each in listed())
    for row in ROWS:
        assert row.noticed + row.executor + row.gaps == row.tried > 0, row
        assert row.tried <= row.changes, row
        assert row.executor <= reasons[row.file], f"{row}: a reason is gone, try it anew"
        assert date.fromisoformat(row.on).isoformat() == row.on, row
        assert re.fullmatch(r"all|seed \d+", row.drawn), row


def test_what_has_changed_much_since_it_was_tried_is_tried_anew() -> None:
    for row in ROWS:
        now = len(mutants((SOURCE / row.file).read_text(encoding="utf-8")))
        assert abs(now - row.changes) <= row.changes / 4, row


def test_the_sum_is_that_of_the_lines_and_enough() -> None:
    assert report.written(PAGE, {}) == PAGE, "nobody has written into the table by hand"
    tried, noticed = (sum(row.tried for row in ROWS), sum(row.noticed for row in ROWS))
    assert 100 * noticed / tried >= AT_LEAST


# ---- what writes it ----

SMALL = "def f(a):\n    return a > 3\n"
NAMES = tuple(mutants(SMALL))
EMPTY = f"Before.\n\n{report.HEAD}|---|\n\nAfter.\n"
GATE, BOARD = MODULES[:2]


def found(module: Module, *ends: str) -> Found:
    """Return how the changes of a module ended, in their order, as far as they were tried."""
    results = {name: Result(name, 1, end, 1, 0.1) for name, end in zip(NAMES, ends, strict=False)}
    return Found(module, NAMES, results, [])


def lines(page: str) -> list[str]:
    return [line for line in page.splitlines() if line.startswith("|")][2:]


def test_a_run_writes_the_lines_of_what_it_tried_and_leaves_the_others(tmp_path: Path) -> None:
    for module in (GATE, BOARD):
        (tmp_path / module.file).parent.mkdir(exist_ok=True)
        (tmp_path / module.file).write_text(SMALL)
    reason = Known(file=GATE.file, mutant=NAMES[2], why="it is never 4")
    both = [found(BOARD, KILLED, KILLED, SAME), found(GATE, KILLED, TIMED_OUT, SURVIVED)]
    page = report.written(EMPTY, report.rows_of(both, (reason,), 2, "2026-11-25", tmp_path))
    assert page.startswith("Before.\n\n")
    assert page.endswith("|\n\nAfter.\n")
    assert lines(page) == [
        "| gate | `core/order_gate.py` | 3 | all | 3 | 2 | 1 | 0 | 66.7 | 2026-11-25 |",
        "| stops | `core/stop_registry.py` | 3 | all | 2 | 2 | 0 | 0 | 100.0 | 2026-11-25 |",
        "| all | | 6 | | 5 | 4 | 1 | 0 | 80.0 | |",
    ]
    (tmp_path / BOARD.file).write_text(SMALL * 2)
    later = [found(BOARD, KILLED, KILLED, KILLED)]
    page = report.written(page, report.rows_of(later, (), 7, "2026-12-01", tmp_path))
    assert lines(page) == [
        "| gate | `core/order_gate.py` | 3 | all | 3 | 2 | 1 | 0 | 66.7 | 2026-11-25 |",
        ("| stops | `core/stop_registry.py` | 6 | seed 7 | 3 | 3 | 0 | 0 | 100.0 | 2026-12-01 |"),
        "| all | | 9 | | 6 | 5 | 1 | 0 | 83.3 | |",
    ]


def test_what_was_cut_off_gets_no_line_and_what_nobody_looked_into_is_said(tmp_path: Path) -> None:
    (tmp_path / BOARD.file).parent.mkdir()
    (tmp_path / BOARD.file).write_text(SMALL)
    cut_off, alive = found(GATE, KILLED, KILLED), found(BOARD, KILLED, KILLED, SURVIVED)
    [row] = report.rows_of([cut_off, alive], (), 2, "2026-11-25", tmp_path).values()
    assert (row.file, row.noticed, row.executor, row.gaps) == (BOARD.file, 2, 0, 1)
