"""Reports beside each other, and beside what is promised: without measuring anything."""

from __future__ import annotations

from pathlib import Path

import msgspec
import pytest

from rosic.bench import comparison
from rosic.bench.command import BENCHES, main
from rosic.bench.comparison import Budget, budgets, changes, judged, read_reports
from rosic.bench.report import BenchRatio, as_json
from rosic.errors import ConfigurationError
from tests.bench.test_reports import case, chart, report, write_report


@pytest.mark.parametrize(
    ("p50_us", "pace_us", "doubt", "verdict"),
    [
        (20.0, 1_600.0, 0.0, "noise"),  # twice as slow an hour, nothing else
        (10.0, 1_600.0, 0.0, "noise"),  # a wait, which does not follow the pace
        (5.0, 1_600.0, 0.0, "faster"),
        (12.0, 800.0, 0.0, "slower"),
        (12.0, 800.0, 0.2, "noise"),  # runs that lie apart by as much say nothing
        (10.4, 800.0, 0.0, "noise"),
    ],
)
def test_reports_are_compared_by_ratio_to_pace(
    p50_us: float,
    pace_us: float,
    doubt: float,
    verdict: str,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    old = write_report(tmp_path / "old", case("a step", 10.0, pace_us=800.0))
    new = write_report(tmp_path / "new", case("a step", p50_us, pace_us=pace_us, doubt=doubt))

    status = main(["compare", old, new])

    assert [one.verdict for one in changes(*map(read_reports, map(Path, (old, new))))] == [verdict]
    assert verdict in capsys.readouterr().out
    assert status == (1 if verdict == "slower" else 0)


def test_one_run_alone_is_judged_with_care_and_what_is_in_one_alone_is_said(
    tmp_path: Path,
) -> None:
    old = write_report(
        tmp_path / "old", case("a step", 10.0, pace_us=800.0), case("gone", 1.0, pace_us=1.0)
    )
    new = write_report(tmp_path / "new", case("a step", 12.0, pace_us=800.0, doubt=None))

    found = changes(*map(read_reports, map(Path, (old, new))))

    assert [(one.case, one.verdict) for one in found] == [
        ("a step", comparison.NOISE),
        ("gone", comparison.GONE),
    ]


@pytest.mark.parametrize("content", ["", "{", "[1]", '{"machine": 1}'])
def test_what_is_no_report_is_said_to_be_none(content: str, tmp_path: Path) -> None:
    path = tmp_path / "it"
    path.write_text(content)
    with pytest.raises(ConfigurationError, match="it is no report of rosic bench: "):
        main(["compare", str(path), str(path)])
    with pytest.raises(ConfigurationError, match="away cannot be read: No such file"):
        main(["budgets", str(tmp_path / "away")])


def test_budgets_name_benches_that_exist_and_are_judged(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert {one.bench for one in budgets()} <= set(BENCHES)
    for one in budgets():
        assert (one.at_most is None) != (one.at_least is None)
    promised = (
        Budget(bench="walk", ratio="a", why="", at_most=1.1),
        Budget(bench="walk", ratio="b", why="", at_least=2.0),
        Budget(bench="walk", ratio="c", why="", at_most=1.0),
    )
    seen = report(
        ratios=tuple(BenchRatio(name=n, value=v, of="") for n, v in (("a", 1.1), ("b", 1.9)))
    )
    assert [row[4] for row in judged([seen], promised).rows] == ["kept", "broken", "not measured"]

    first = budgets()[0]
    value = 99.0 if first.at_most is not None else 0.0
    broken = report(bench=first.bench, ratios=(BenchRatio(name=first.ratio, value=value, of=""),))
    path = tmp_path / "seen"
    path.write_text(as_json(broken))
    assert main(["budgets", str(path)]) == 1
    assert f"{first.ratio}" in capsys.readouterr().out
    # What another report says does not hide it, and a report without any is none that keeps them.
    kept = msgspec.structs.replace(
        broken, ratios=(BenchRatio(name=first.ratio, value=1.0 / (value or 0.01), of=""),)
    )
    (tmp_path / "kept").write_text(as_json(kept))
    assert main(["budgets", str(path), str(tmp_path / "kept")]) == 1
    assert main(["report", "--from", str(path), "--out", str(tmp_path / "page")]) == 1
    write_report(tmp_path / "none")
    assert main(["budgets", str(tmp_path / "none")]) == 1
    assert "Nothing that is promised was measured." in capsys.readouterr().err


def test_a_comparison_of_nothing_is_no_success(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    one = write_report(tmp_path / "one", case("a step", 1.0, pace_us=800.0))
    other = write_report(tmp_path / "other", case("a jump", 1.0, pace_us=800.0))
    both = write_report(
        tmp_path / "both",
        case("a step", 1.0, pace_us=800.0),
        case("a jump", 1.0, pace_us=800.0),
    )
    assert main(["compare", one, one]) == 0
    assert main(["compare", one, other]) == 1
    assert "They have no case in common." in capsys.readouterr().err
    assert main(["compare", both, one]) == 1
    assert "1 cases are in one of them alone." in capsys.readouterr().err
    (tmp_path / "failed").write_text(
        as_json(report(case("a step", 1.0, pace_us=800.0), failures=("It did not hold.",)))
    )
    assert main(["compare", one, str(tmp_path / "failed")]) == 1
    assert "failed: walk: It did not hold." in capsys.readouterr().err


@pytest.mark.parametrize("name", ["../there", "/there", "a b", ""])
def test_a_report_writes_nowhere_else(name: str, tmp_path: Path) -> None:
    for number, hostile in enumerate(
        (report(bench=name), report(charts=(msgspec.structs.replace(chart("lines"), name=name),)))
    ):
        path = tmp_path / str(number)
        path.write_text(as_json(hostile))
        with pytest.raises(ConfigurationError, match="no name"):
            main(["report", "--from", str(path), "--out", str(tmp_path / "page")])
    assert not (tmp_path / "page").exists()
