"""What a bench reports, keeps, writes and compares: without measuring anything."""

from __future__ import annotations

import io
import json
import signal
import sys
from pathlib import Path
from typing import TYPE_CHECKING

import msgspec
import pytest
from openpyxl import load_workbook
from PIL import Image

from rosic.bench import charts, output
from rosic.bench.command import BenchEntry, main
from rosic.bench.comparison import budgets, read_reports
from rosic.bench.page import as_html, as_markdown
from rosic.bench.recorder import BenchRecorder
from rosic.bench.report import (
    BenchCase,
    BenchRatio,
    BenchReport,
    BenchTable,
    Chart,
    ChartSeries,
    as_csv,
    as_json,
    as_text,
)
from rosic.bench.suite import measured
from rosic.errors import ConfigurationError
from tests.bench.interrupted import cases_kept

if TYPE_CHECKING:
    from collections.abc import Callable

MS_NS = 1_000_000


class Terminal(io.StringIO):
    """A terminal, as far as progress goes."""

    def isatty(self) -> bool:
        return True


class StandInBench(BenchEntry):
    """A bench of a test: whatever it does instead of measuring."""

    @classmethod
    def that(cls, does: Callable[[BenchRecorder], BenchReport]) -> StandInBench:
        made = cls("for a test")
        made.__class__ = type(
            "Made", (cls,), {"measure": lambda _self, _name, recorder, _options: does(recorder)}
        )
        return made


def report(*cases: BenchCase, **more: object) -> BenchReport:
    found = BenchReport(machine="a machine", method="How.", cases=cases, bench="walk")
    return msgspec.structs.replace(found, **more)


def case(name: str, p50_us: float, *, pace_us: float, doubt: float | None = 0.0) -> BenchCase:
    return BenchCase(
        name=name,
        rate_per_s=1.0,
        p50_us=p50_us,
        p99_us=p50_us,
        pace_us=pace_us,
        doubt=doubt,
    )


# ---- while it runs ----


def test_each_turn_has_the_pace_beside_it_and_is_shown_on_a_terminal() -> None:
    shown = Terminal()
    recorder = BenchRecorder("walk", progress=shown)
    for seen in (1.0, 3.0):
        with recorder.turn("a step", of=2) as turn:
            turn.saw(seen, [seen * MS_NS])

    found = recorder.finished(report(*recorder.cases()))

    assert "a step (2 of 2)" in shown.getvalue()
    assert shown.getvalue().endswith("\r\x1b[K")
    assert found.cases[0].rate_per_s == 2.0
    assert found.cases[0].pace_us is not None
    assert found.pace_us > 0
    assert (found.bench, found.started[-6:]) == ("walk", "+00:00")


def test_a_case_made_elsewhere_gets_the_pace_of_the_turn_that_its_name_begins_with() -> None:
    recorder = BenchRecorder("walk")
    for name in ("durable", "memory"):
        with recorder.turn(name):
            pass

    bare = BenchCase(name="durable, one robot", rate_per_s=1.0, p50_us=1.0, p99_us=1.0)
    found = recorder.finished(report(bare))

    assert found.cases[0].pace_us == pytest.approx(recorder.paces_us("durable")[0], abs=0.01)


def test_what_was_measured_before_an_interrupt_is_printed(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    def interrupted(recorder: BenchRecorder) -> BenchReport:
        with recorder.turn("the first") as turn:
            turn.saw(7.0, [1.0 * MS_NS, 2.0 * MS_NS])
        with recorder.turn("the second"):
            raise KeyboardInterrupt

    file = tmp_path / "seen.csv"
    status = main(["walk", "--json", "--csv", str(file)], {"walk": StandInBench.that(interrupted)})

    said = capsys.readouterr()
    printed = json.loads(said.out)
    assert status == 130
    assert [one["name"] for one in printed["cases"]] == ["the first"]
    assert said.err == ("failed: It was interrupted: what was measured until then is above.\n")
    assert "the first,7.0" in file.read_text()


@pytest.mark.limit(200)
@pytest.mark.parametrize(
    ("name", "first"),
    [
        ("fleet", "6 to 6: solver"),
        ("idle", "nobody"),
        ("pipeline", "memory, 256 in flight"),
        ("schedule", "order of arrival"),
        ("stop", "memory, one robot: handed to the adapter"),
        ("strangers", "a stop, quiet"),
        ("telegram", "50 commands, 10 chats, 1.5 times as fast"),
    ],
)
def test_a_bench_keeps_what_it_had_seen_when_it_is_interrupted(name: str, first: str) -> None:
    assert cases_kept(name)[0] == first


def test_what_was_measured_before_the_disk_was_full_is_printed(
    capsys: pytest.CaptureFixture[str],
) -> None:
    def full(recorder: BenchRecorder) -> BenchReport:
        with recorder.turn("the first") as turn:
            turn.saw(7.0, [1.0 * MS_NS])
        with recorder.turn("the second"):
            raise OSError(28, "No space left on device")

    assert main(["walk"], {"walk": StandInBench.that(full)}) == 1

    said = capsys.readouterr()
    assert "the first" in said.out
    assert said.err == (
        "failed: It ended early: No space left on device. What was measured until then is above.\n"
    )


def test_what_was_measured_before_a_fault_is_printed(capsys: pytest.CaptureFixture[str]) -> None:
    def wrong(recorder: BenchRecorder) -> BenchReport:
        with recorder.turn("the first") as turn:
            turn.saw(7.0, [1.0 * MS_NS])
        raise ExceptionGroup("both", [ValueError("no figure")])

    assert main(["walk", "--quick"], {"walk": StandInBench.that(wrong)}) == 1

    said = capsys.readouterr()
    assert "the first" in said.out
    assert "ValueError: no figure" in said.err
    assert "failed: It ended early: ExceptionGroup: both" in said.err


def test_what_ends_it_from_elsewhere_is_heard_as_an_interrupt(
    capsys: pytest.CaptureFixture[str],
) -> None:
    """So that no process of it is left behind, and what was measured is printed."""

    def ended(recorder: BenchRecorder) -> BenchReport:
        with recorder.turn("the first") as turn:
            turn.saw(7.0, [1.0 * MS_NS])
        signal.raise_signal(signal.SIGTERM)
        pytest.fail("it went on")

    before = signal.getsignal(signal.SIGTERM)
    assert main(["walk"], {"walk": StandInBench.that(ended)}) == 130
    assert signal.getsignal(signal.SIGTERM) is before
    assert "the first" in capsys.readouterr().out


@pytest.mark.parametrize("name", ["schedule", "fleet"])
def test_a_part_that_a_bench_needs_is_named_if_it_is_not_installed(
    name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "scipy", None)
    with pytest.raises(ConfigurationError, match=f"rosic bench {name} needs .*: scipy") as refused:
        main([name, "--quick"])
    assert "rosic[schedule]" in str(refused.value.hint)


NO_COUNT = "a number from 1 to 100000"
NO_SECONDS = "seconds, above 0 and at most 100000"
NO_HOURS = "hours, above 0 and at most 1000"
NONSENSE = [
    *(("latency", "--messages", value, NO_COUNT) for value in ("0", "-1", "1.5", "x", "100001")),
    *(("latency", "--runs", value, NO_COUNT) for value in ("0", "-1", "")),
    ("latency", "--over", "pigeon", "invalid choice: 'pigeon'"),
    ("scale", "--over", "pigeon", "invalid choice: 'pigeon'"),
    ("throughput", "--over", "pigeon", "invalid choice: 'pigeon'"),
    *(("throughput", "--duration", value, NO_SECONDS) for value in ("0", "-1", "nan", "inf", "x")),
    *(("throughput", "--interval", value, NO_SECONDS) for value in ("0", "-1", "nan", "inf", "x")),
    *(("messages", "--seconds", value, NO_SECONDS) for value in ("0", "-1", "nan", "inf", "x")),
    *(("resources", "--hours", value, NO_HOURS) for value in ("0", "-2", "nan", "inf", "x")),
    ("report", "--only", "walk", "invalid choice: 'walk'"),
    ("api", "--rosbridge", None, "expected one argument"),
    ("peers", "--environment", None, "expected one argument"),
]


@pytest.mark.parametrize(("bench", "option", "value", "sentence"), NONSENSE)
def test_an_option_of_nonsense_is_refused_in_a_sentence(
    bench: str, option: str, value: str | None, sentence: str, capsys: pytest.CaptureFixture[str]
) -> None:
    given = [option] if value is None else [f"{option}={value}"]
    with pytest.raises(SystemExit) as refused:
        main([bench, *given])

    assert refused.value.code == 2
    said = capsys.readouterr().err
    assert f"argument {option}: {sentence}" in said.splitlines()[-1]


@pytest.mark.parametrize(
    ("option", "where", "sentence"),
    [
        ("--csv", "nowhere/it", "nowhere/it cannot be written: there is no folder"),
        ("--csv", ".", "cannot be written: it is a folder"),
        ("--xlsx", "nowhere/it", "nowhere/it cannot be written: there is no folder"),
        ("--charts", "file", "file cannot be made: File exists"),
    ],
)
def test_what_cannot_be_written_is_said_before_anything_is_measured(
    option: str, where: str, sentence: str, tmp_path: Path
) -> None:
    def measured(_recorder: BenchRecorder) -> BenchReport:
        pytest.fail("it was measured")

    (tmp_path / "file").write_text("")
    with pytest.raises(ConfigurationError, match=sentence):
        main(["walk", option, str(tmp_path / where)], {"walk": StandInBench.that(measured)})


@pytest.mark.parametrize("bench", ["latency", "report"])
def test_a_report_cannot_go_where_there_is_a_file(bench: str, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(ConfigurationError, match="file cannot be made: File exists"):
        main([bench, "--out", str(tmp_path / "file")])


# ---- files ----

TABLE = BenchTable(title="The paper", columns=("what", "ms"), rows=(("=1+1", 63.2), ("x", None)))


def test_every_table_is_in_the_text_the_csv_and_the_workbook() -> None:
    ratio = BenchRatio(name="ours beside theirs", value=0.5, of="ours by theirs")
    seen = report(case("a step", 2.5, pace_us=800.0), tables=(TABLE,), ratios=(ratio,))

    text, values = as_text(seen), as_csv(seen)
    book = load_workbook(io.BytesIO(output.as_xlsx((TABLE,))))

    for found in (text, values):
        assert "ours beside theirs" in found
        assert "The paper" in found
        assert "63.2" in found
    sheet = book["The paper"]
    assert [[cell.value for cell in row] for row in sheet] == [
        ["what", "ms"],
        ["=1+1", 63.2],
        ["x", None],
    ]
    assert sheet["A2"].data_type == "s"  # no formula


def test_a_file_that_cannot_be_written_is_named_and_what_was_there_stays(tmp_path: Path) -> None:
    there = tmp_path / "seen.csv"
    there.write_text("before")

    with pytest.raises(ConfigurationError, match=r"nowhere/seen\.csv cannot be written: No such"):
        output.write_csv(report(), tmp_path / "nowhere" / "seen.csv")
    full = Path("/dev/full")
    with pytest.raises(ConfigurationError, match="cannot be written"):
        output.write(full / "seen.csv", b"after")

    assert there.read_text() == "before"
    assert list(tmp_path.iterdir()) == [there]


def chart(kind: str) -> Chart:
    names: tuple[str, ...] = ("10", "50") if kind == "bars" else ()
    series = tuple(
        ChartSeries(name=name, x=names, y=(3.0, 4.0), error=(0.5, 0.2) if kind == "bars" else ())
        for name in ("one", "other")
    )
    return Chart(name=kind, title=f"<b>{kind}", kind=kind, x="x, s", y="y, ms", series=series)


@pytest.mark.parametrize("kind", sorted(charts.DRAWN))
def test_each_kind_of_chart_is_drawn_as_png_and_svg_and_the_same_twice(
    kind: str, tmp_path: Path
) -> None:
    written = output.write_charts(report(charts=(chart(kind),)), tmp_path / "charts")

    assert [path.name for path in written] == [f"{kind}.png", f"{kind}.svg"]
    picture = Image.open(written[0])
    assert picture.size == (792, 396)
    colours = picture.convert("RGB").getcolors(1 << 20)
    assert colours is not None
    assert len(colours) > 20  # something is drawn
    assert charts.drawn(chart(kind), "svg") == written[1].read_bytes()


def test_an_extra_that_is_missing_is_named_before_anything_is_measured(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    def measured(_recorder: BenchRecorder) -> BenchReport:
        pytest.fail("it was measured")

    benches = {"walk": StandInBench.that(measured)}
    for name, option in (("matplotlib", "--charts"), ("openpyxl", "--xlsx")):
        monkeypatch.setitem(sys.modules, name, None)
        with pytest.raises(ConfigurationError, match=f"need.* {name}") as refused:
            main(["walk", option, str(tmp_path / "there")], benches)
        assert "rosic[bench]" in str(refused.value.hint)


def test_the_page_holds_everything_and_no_markup_of_what_was_measured() -> None:
    broken = BenchRatio(name="memory, 5000 skills beside the first", value=9.0, of="a by b")
    page = as_html(
        [
            report(
                case("<script>alert(1)</script>", 2.5, pace_us=800.0),
                bench="pipeline",
                command="rosic bench pipeline --quick",
                tables=(TABLE,),
                ratios=(broken,),
                charts=(chart("lines"),),
                failures=("It did not <i>hold</i>.",),
            )
        ]
    )

    assert "<script" not in page
    assert "<i>" not in page
    assert "class=broken>broken<" in page
    unseen = sum(each.bench == "pipeline" for each in budgets()) - 1
    assert f"Of {unseen + 1} budgets: 0 kept, 1 broken, {unseen} not measured." in page
    assert "<code>rosic bench pipeline --quick</code>" in page
    assert "<th class=n>p50, us</th>" in page
    assert "data:image/svg+xml;base64," in page
    assert "http" not in page.replace("http://www.w3.org", "")


def test_what_was_measured_on_another_machine_is_said_where_it_stands() -> None:
    here = report(bench="idle")
    there = report(bench="stop", machine="another machine", findings=("It came to rest.",))
    for page in (as_html([here, there]), as_markdown([here, there])):
        assert page.count("a machine. ") == 1
        assert page.count("another machine. ") == 1
        assert page.index("stop") < page.index("another machine") < page.index("It came to rest.")


def test_the_same_is_written_as_markdown_beside_its_charts() -> None:
    broken = BenchRatio(name="memory, 5000 skills beside the first", value=9.0, of="a by b")
    text = as_markdown(
        [
            report(
                case("<b>a | b</b>", 2.5, pace_us=800.0),
                bench="pipeline",
                command="rosic bench pipeline --quick",
                tables=(TABLE,),
                ratios=(broken,),
                charts=(chart("lines"),),
                failures=("It did not *hold*.",),
            )
        ]
    )

    lines = text.splitlines()
    assert lines[0] == "# ROSIC, measured"
    assert "**It did not \\*hold\\*.**" in lines
    assert "![\\<b\\>lines](lines.svg)" in lines
    assert any(line.startswith("`rosic bench pipeline --quick`, ") for line in lines)
    assert "## pipeline" in lines
    rows = [line for line in lines if line.startswith("| ")]
    assert any(row.startswith("| \\<b\\>a \\| b\\</b\\> | ") for row in rows)
    assert any("| broken |" in row for row in rows)
    for row in rows:
        assert row.endswith(" |")


def test_a_page_is_written_of_what_other_runs_saw(tmp_path: Path) -> None:
    first, second = report(bench="fleet"), report(bench="resources", charts=(chart("lines"),))
    soak = report(bench="resources", command="rosic bench resources --hours 2")
    (tmp_path / "report.json").write_text(msgspec.json.encode([second, first]).decode())
    (tmp_path / "soak.json").write_text(as_json(soak))
    written = [str(tmp_path / name) for name in ("report.json", "soak.json")]
    assert main(["report", "--out", str(tmp_path / "page"), "--from", *written]) == 0

    text = (tmp_path / "page" / "report.md").read_text()
    assert text == as_markdown([soak, first])
    assert "rosic bench resources --hours 2" in text
    assert read_reports(tmp_path / "page" / "report.json") == [soak, first]
    main(["report", "--out", str(tmp_path / "page"), "--from", written[0]])
    assert (tmp_path / "page" / "lines.svg").is_file()  # of a report that is not the last


def test_a_report_names_no_folder_of_this_machine(tmp_path: Path) -> None:
    [told] = measured([("idle", "--rosbridge", str(tmp_path))], tmp_path, quick=True)
    assert told.command == "rosic bench idle --rosbridge PATH --quick"
    assert "unrecognized arguments" in told.failures[0]


def write_report(path: Path, *cases: BenchCase) -> str:
    path.write_text(as_json(report(*cases)))
    return str(path)
