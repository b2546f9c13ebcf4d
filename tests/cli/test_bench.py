"""`rosic bench`: what it prints is well formed. What it measures is looked at by people."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from rosic.bench.batches import CommandBatch
from rosic.bench.command import BenchEntry, main
from rosic.bench.idle import IdleWindow, report_of
from rosic.bench.recorder import BenchRecorder
from rosic.bench.report import BenchCase, BenchReport
from rosic.bench.telegram import TelegramLoad, measured
from rosic.errors import ConfigurationError
from tests.cli.running import rosic
from tests.pace import patience

OF_ALL = (
    "bench",
    "command",
    "version",
    "versions",
    "started",
    "took_s",
    "machine",
    "pace_us",
    "method",
)
MOMENTS = ("handed to the adapter", "kept by the latch", "rest told", "before it is handed over")
STOPS = [
    f"{store}, {robots}: {moment}"
    for store in ("memory", "durable")
    for robots in ("one robot", "all robots")
    for moment in MOMENTS
]


@pytest.mark.limit(410)
def test_the_bench_of_stops_prints_one_object() -> None:
    ran = rosic("bench", "stop", "--quick", "--json", within_s=400)

    assert (ran.status, ran.err) == (0, "")
    report = json.loads(ran.out)
    assert set(report) == {*OF_ALL, "cases"}
    assert report["command"] == "rosic bench stop --quick --json"
    assert "at least 1000 orders wait" in report["method"]
    assert [case["name"] for case in report["cases"]] == STOPS
    for case in report["cases"]:
        assert set(case) == {"name", "rate_per_s", "p50_us", "p99_us", "pace_us"}
        assert 0 < case["p50_us"] <= case["p99_us"]
        assert case["rate_per_s"] > 0


@pytest.mark.limit(410)
def test_the_bench_of_strangers_says_how_far_above_quiet_and_the_longest_step() -> None:
    ran = rosic("bench", "strangers", "--quick", "--json", within_s=400)

    report = json.loads(ran.out)
    assert [case["name"] for case in report["cases"]] == [
        "a stop, quiet",
        "a stop behind a flood",
        "a stop behind everybody's",
    ]
    above, with_known, step = report["findings"]
    assert above.startswith("A stop behind a flood: p99 ")
    assert with_known.startswith("A stop behind floods of everybody: p99 ")
    step_ms = float(step.removeprefix("The longest step of the event loop: ").split()[0])
    assert 0 < step_ms <= 20 * max(1.0, float(step.rpartition("times ")[2].split(")")[0]))
    # What others do on this machine lies on the way through two processes.
    above_ms = float(above.removeprefix("A stop behind a flood: p99 ").split()[0])
    assert above_ms <= 100 * 4 * patience()


@pytest.mark.limit(410)
def test_the_bench_of_telegram_keeps_to_the_limits_and_uses_them() -> None:
    ran = rosic("bench", "telegram", "--quick", "--json", within_s=400)

    assert (ran.status, ran.err) == (0, "")
    report = json.loads(ran.out)
    assert set(report) == {*OF_ALL, "cases", "findings"}
    cases = {case["name"]: case for case in report["cases"]}
    batch, stops, naive, durable, memory, foreign, disk, *tmpfs = cases.values()
    without, durably, *_ = report["findings"]
    above_us = memory["p50_us"] - foreign["p50_us"]
    assert without.startswith(f"Without the durable claim: {above_us:.1f} us above") or (
        abs(float(without.split()[4]) - above_us) < 0.2
    )
    took_ms = float(durably.partition("With it: ")[2].split()[0])
    assert abs(took_ms - durable["p50_us"] / 1e3) < 0.011, "each is rounded for itself"
    takes_ms = float(durably.partition("the disk takes ")[2].split()[0])
    assert abs(takes_ms - disk["p50_us"] / 1e3) < 0.011, "each is rounded for itself"
    assert [case["name"] for case in tmpfs] == (
        ["receiving: ROSIC, durable claim on tmpfs"] if Path("/dev/shm").is_dir() else []  # noqa: S108
    )
    assert batch["permitted_share"] >= 0.95
    assert "permitted_share" not in stops
    assert stops["p50_us"] < 500_000 * patience()
    assert "naive" in naive["name"]
    for case, name in (
        (durable, "durable"),
        (memory, "in memory"),
        (foreign, "empty handler"),
        (disk, "synced"),
    ):
        assert name in case["name"]
        assert 0 < case["p50_us"] <= case["p99_us"]


def test_what_is_promised_of_many_chats_is_what_rosic_lets_itself_say() -> None:
    few = CommandBatch(name="few", commands=100, chats=10)
    many = CommandBatch(name="many", commands=500, chats=50)

    assert few.kept_per_s == few.permitted_per_s == 10.0
    assert many.permitted_per_s == 30.0
    assert 21.0 < many.kept_per_s < 23.0  # 24 in any second, until it is answered


@pytest.mark.limit(410)
def test_a_bench_whose_bound_fails_has_measured_all_the_same() -> None:
    batch = CommandBatch(name="few", commands=10, chats=5, faster=20.0, stops=1)

    report = measured(BenchRecorder("telegram"), TelegramLoad((batch,), orders=0, at_least=1_000.0))

    names = [case.name for case in report.cases]
    assert names == ["few", "few: stops meanwhile", "few: naive, 0 times 429"]
    [failure] = report.failures
    assert failure.startswith("few: ")
    assert failure.endswith("% of what is permitted, and 100000% is promised.")


@pytest.mark.parametrize("asked", [("walk",), ("walk", "--json")])
def test_what_did_not_hold_is_said_behind_all_that_was_seen(
    asked: tuple[str, ...], capsys: pytest.CaptureFixture[str]
) -> None:
    rows = [
        BenchCase(name=name, rate_per_s=2.0, p50_us=3.0, p99_us=4.0) for name in ("slow", "fast")
    ]
    seen = BenchReport(
        machine="here", method="by foot", cases=tuple(rows), failures=("slow: fell.",)
    )

    class Walk(BenchEntry):
        def measure(self, *_: object) -> BenchReport:
            return seen

    status = main(asked, {"walk": Walk("for a test")})

    printed = capsys.readouterr()
    assert status == 1
    assert printed.err == "failed: slow: fell.\n"
    assert "slow" in printed.out
    assert "fast" in printed.out
    if "--json" in asked:
        assert json.loads(printed.out)["failures"] == ["slow: fell."]


@pytest.mark.campaign
@pytest.mark.limit(410)
def test_the_bench_of_the_pipeline_covers_a_large_place() -> None:
    ran = rosic("bench", "pipeline", "--quick", "--json", within_s=400)

    assert (ran.status, ran.err) == (0, "")
    report = json.loads(ran.out)
    cases = {case["name"]: case for case in report["cases"]}
    for case in cases.values():
        assert {"name", "rate_per_s", "p50_us", "p99_us"} == set(case) - {"bytes_each"}
        assert 0 < case["p50_us"] <= case["p99_us"]
    size = "10000 people, 100 roles, 50 robots, 50000 slots"
    assert {f"decide: {size}", f"decide, all looked up: {size}"} < set(cases)
    assert "memory, 10000 people, 100 roles, 50000 slots" in cases
    assert 500 < cases["a person's memory: 10000 people, 100 roles"]["bytes_each"] <= 2048


@pytest.mark.limit(410)
def test_the_bench_of_fleets_assigns_tasks_and_compares_sizes() -> None:
    ran = rosic("bench", "fleet", "--quick", "--json", within_s=400)

    assert (ran.status, ran.err) == (0, "")
    report = json.loads(ran.out)
    assert set(report) == {*OF_ALL, "cases"}
    cases = {case["name"]: case for case in report["cases"]}
    for case in cases.values():
        assert {"name", "rate_per_s", "p50_us", "p99_us"} <= set(case)
        assert 0 < case["p50_us"] <= case["p99_us"]
    assert cases["1000 to 200: solver"]["p50_us"] < 1_000_000 * patience()
    small, near, tried, large, large_near = report["cases"][:5]
    assert small["cost_m"] == tried["cost_m"] < near["cost_m"]
    assert large["cost_m"] < large_near["cost_m"]
    assert large["pairs"] == large_near["pairs"] == 200
    for robots in (10, 200):
        commanded = cases[f"{robots} robots, 500 commanding: a command"]
        assert commanded["rate_per_s"] > 0
        assert commanded["refused"] >= 0
        assert cases[f"{robots} robots: a report"]["cpu_us"] > 0
        assert f"{robots} robots: stop" in cases
    assert cases["200 robots: a report"]["bytes_each"] > 0
    assert "p99 at 200 robots is" in report["method"]
    assert "neither is counted" in report["method"]


def test_an_unknown_bench_names_those_that_exist() -> None:
    ran = rosic("bench", "walk")

    assert ran.status == 2
    assert "pipeline" in ran.err
    assert "stop" in ran.err


def test_the_bench_of_an_idle_gateway_takes_out_what_others_cost_and_fails_above_its_promise() -> (
    None
):
    quiet, busy = IdleWindow(0.004, 0.01), IdleWindow(0.016, 0.02)
    held = report_of([quiet] * 3, [busy] * 3, 5.0)
    assert "With a page open: 0.80% of a processor (1.60% as measured" in held.findings[0]
    assert "with nobody 0.40%" in held.findings[0]
    assert not held.failures
    broken = report_of([quiet] * 3, [IdleWindow(0.011, 0.01)] * 3, 5.0)
    assert broken.failures == broken.findings


@pytest.mark.campaign
def test_an_idle_gateway_with_a_page_open_needs_under_one_per_cent() -> None:
    ran = rosic("bench", "idle", "--json", within_s=400)
    assert (ran.status, ran.err) == (0, "")


def test_a_checkout_beside_one_is_named_from_here(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(ConfigurationError, match=str(tmp_path / "nowhere")):
        main(["api", "--rosbridge", "nowhere"])
