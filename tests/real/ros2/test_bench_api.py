"""`rosic bench api`: a whole gateway and real ROS 2; what it prints can fail."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING

import pytest

from rosic.bench.api import SMALL, CaseRun, TopicCase, _compared, _lost
from rosic.bench.command import main
from rosic.bench.topic_process import MessageTimes, StreamFigures
from rosic.errors import ConfigurationError
from tests.bench.interrupted import cases_kept

if TYPE_CHECKING:
    from pathlib import Path

PACED = TopicCase(True, SMALL, 200, 100)
FLOOD = TopicCase(True, SMALL, 0, 100)


@pytest.mark.limit(300)
def test_the_bench_of_topics_prints_one_object(capsys: pytest.CaptureFixture[str]) -> None:
    main(["api", "--quick", "--json"])  # on a busy machine it may be idle for less than is promised

    report = json.loads(capsys.readouterr().out)
    cases = {case["name"]: case for case in report["cases"]}
    assert list(cases) == [
        "ROSIC: to ROS, 64 B, 200/s, 1 client",
        "ROSIC: to ROS, 64 B, flooded, 1 client",
        "ROSIC: from ROS, 64 B, 200/s, 1 client",
        "bare echo, there and back: to ROS, 64 B, 200/s, 1 client",
        "bare echo, there and back: to ROS, 64 B, flooded, 1 client",
        "bare rclpy: from ROS, 64 B, 200/s, 1 client",
        "bare rclpy: from ROS, 64 B, flooded, 1 client",
    ]
    for case in cases.values():
        assert 0 < case["p50_us"] <= case["p99_us"]
        assert case["processor_us"] > 0
    assert cases["ROSIC: to ROS, 64 B, flooded, 1 client"]["lost_share"] == 0
    idle, page = report["findings"]
    assert idle.startswith("Idle, with the events of a page open: ")
    assert page.startswith("All of the page: ")


def run(p50_us: float, rate: float, count: int = 100) -> CaseRun:
    return CaseRun(100, StreamFigures(count=count, p50_us=p50_us, rate_per_s=rate), 0.01)


def test_what_is_not_as_promised_fails() -> None:
    ours = {PACED: [run(30, 200)], FLOOD: [run(9, 140)]}
    theirs = {PACED: [run(100, 200)], FLOOD: [run(9, 100)]}
    failures = [failure for _, failure in _compared((PACED, FLOOD), ours, theirs)]
    assert [failure.partition(": ")[2].split()[:2] for failure in failures] == [
        ["p50", "0.30"],
        ["1.40", "times"],
    ]
    better = {PACED: [run(20, 200)], FLOOD: [run(9, 160)]}
    assert not any(failure for _, failure in _compared((PACED, FLOOD), better, theirs))
    assert not list(_lost(ours))
    [(_, lost)] = _lost({FLOOD: [run(9, 140, count=99)]})
    assert "1.00% of the messages were lost" in lost


def test_what_comes_again_is_not_counted_twice() -> None:
    arrivals = MessageTimes()
    for number in (-1, 0, 1, 1, 0, 2):
        arrivals.note(f"{number} 1 x")
    assert arrivals.said_hello
    assert (len(arrivals), arrivals.figures().repeated) == (3, 2)


def test_what_is_no_checkout_is_said(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(ConfigurationError, match="There is no rosbridge_suite in"):
        main(["api", "--quick", "--rosbridge", str(tmp_path)])
    with pytest.raises(SystemExit):
        main(["pipeline", "--rosbridge", str(tmp_path)])
    assert "unrecognized arguments: --rosbridge" in capsys.readouterr().err


@pytest.mark.limit(300)
@pytest.mark.parametrize(
    ("name", "first"),
    [
        ("api", "ROSIC: to ROS, 64 B, 200/s, 1 client"),
        ("start", "ordinary: robots, first to last"),
    ],
)
def test_a_bench_keeps_what_it_had_seen_when_it_is_interrupted(name: str, first: str) -> None:
    assert cases_kept(name)[0] == first
