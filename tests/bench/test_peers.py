"""`rosic bench peers`: bots take turns, and one that does not install, start or last says so."""

from __future__ import annotations

import ast
import sys
from typing import TYPE_CHECKING

import pytest

from rosic.bench.command import BENCHES
from rosic.bench.peer_environment import SCRIPT, Peer, interpreter
from rosic.bench.peers import (
    CASES,
    DURABLE,
    MEASURED,
    OPSDROID_CASE,
    RATES,
    ROSIC,
    PeerCase,
    PeerLoad,
    findings,
    measured,
    ratio_of,
)
from rosic.bench.recorder import BenchRecorder
from rosic.bench.report import BenchRatio
from rosic.errors import ConfigurationError

if TYPE_CHECKING:
    from pathlib import Path

    from rosic.bench.report import BenchReport

ANSWERS = """
import json, sys
name, skills, loop = sys.argv[1:]
print(json.dumps("1.2"), flush=True)
for turn, line in enumerate(sys.stdin):
    if turn == {last}:
        sys.exit("it had enough")
    messages, in_flight = map(int, line.split())
    each_ns = 4_000_000 if in_flight == 1 else 2_000_000
    seen = {{"times_ns": [each_ns] * messages, "seconds": each_ns * messages / 1e9}}
    print(json.dumps(seen | {{"processor_s": messages / 1_000}}), flush=True)
"""
REFUSES = "import sys; sys.exit('no such bot')"


def stand_in(folder: Path, name: str, script: str, *requirements: str) -> PeerCase:
    file = folder / f"{name}.py"
    file.write_text(script)
    return PeerCase(name, Peer(name, requirements, file))


def seen_of(folder: Path, *cases: PeerCase, install: bool = True) -> BenchReport:
    load = PeerLoad(cases, turns=2, updates=0, folder=folder / "e", install=install, messages=70)
    return measured(BenchRecorder("peers"), load)


def came(report: BenchReport) -> dict[object, tuple[object, object]]:
    (table,) = report.tables
    return {row[0]: (row[1], row[-1]) for row in table.rows}


@pytest.mark.limit(120)
def test_bots_take_turns_and_those_that_fail_say_so_in_their_row(tmp_path: Path) -> None:
    report = seen_of(
        tmp_path,
        ROSIC,
        stand_in(tmp_path, OPSDROID_CASE.name, ANSWERS.format(last=99)),
        stand_in(tmp_path, "no package", ANSWERS.format(last=99), "./no such folder"),
        stand_in(tmp_path, "refuses", REFUSES),
        stand_in(tmp_path, "ends", ANSWERS.format(last=4)),
    )

    rows = came(report)
    assert rows[ROSIC.name][1] == MEASURED
    assert rows["opsdroid"] == ("1.2", MEASURED)
    _, why = rows["no package"]
    assert str(why).startswith("no package could not be installed: ")
    assert "does not exist" in str(why), "as pip says it"
    assert rows["refuses"] == ("", "refuses did not start: no such bot")
    assert rows["ends"] == ("1.2", "ends ended early: it had enough")
    cases = {case.name: case for case in report.cases}
    assert list(cases) == [
        f"{name}, {in_flight} in flight"
        for name in (ROSIC.name, "opsdroid", "ends")
        for in_flight in (1, 64)
    ]
    assert cases["opsdroid, 1 in flight"].rate_per_s == 250.0
    assert cases["opsdroid, 64 in flight"].rate_per_s == 500.0
    assert cases["opsdroid, 1 in flight"].processor_us == 1_000.0
    ratio, processor = report.ratios
    assert ratio.name == f"{RATES}opsdroid"
    faster = max(cases[f"{ROSIC.name}, {n} in flight"].rate_per_s for n in (1, 64))
    assert ratio.value == pytest.approx(faster / 500.0, rel=0.3)  # turn for turn, not of all
    assert processor.value > 1
    assert report.failures == ()


@pytest.mark.limit(90)
def test_orders_on_disk_stand_beside_one_sync_for_each_group_of_them(tmp_path: Path) -> None:
    report = seen_of(tmp_path, DURABLE)

    (ratio,) = report.ratios
    assert ratio.name == "on disk beside fdatasync"
    assert ratio.value > 0


def test_what_is_not_installed_is_left_out_if_nothing_may_be_installed(tmp_path: Path) -> None:
    peers = [case for case in CASES if case.peer is not None]

    report = seen_of(tmp_path, *peers, install=False)

    assert not (tmp_path / "e").exists()
    assert came(report)["opsdroid"] == ("", "opsdroid is not installed.")
    assert (report.cases, report.ratios, report.failures) == ((), (), ())
    assert "--no-install" in BENCHES["peers"].report_options


@pytest.mark.limit(90)
def test_an_environment_is_made_once_and_anew_for_other_versions(tmp_path: Path) -> None:
    peer = Peer("bare", ())
    python = interpreter(peer, tmp_path, install=True)
    kept = python.parent.parent / "kept"
    kept.touch()

    assert interpreter(peer, tmp_path, install=True) == python
    assert kept.exists()

    (python.parent.parent / "installed.txt").write_text("other==1\n")
    with pytest.raises(ConfigurationError, match="bare is not installed"):
        interpreter(peer, tmp_path, install=False)
    assert interpreter(peer, tmp_path, install=True) == python
    assert not kept.exists()


def test_a_folder_that_cannot_be_made_is_told(tmp_path: Path) -> None:
    (tmp_path / "file").touch()

    with pytest.raises(ConfigurationError, match="could not be installed: Not a directory"):
        interpreter(Peer("bare", ()), tmp_path / "file" / "e", install=True)


def test_the_script_imports_nothing_that_a_peer_may_not_have() -> None:
    tree = ast.parse(SCRIPT.read_text())
    names = {
        name
        for node in tree.body
        if isinstance(node, ast.Import | ast.ImportFrom)
        for name in (
            [alias.name for alias in node.names]
            if isinstance(node, ast.Import)
            else [node.module or ""]
        )
    }

    assert {name.partition(".")[0] for name in names} <= set(sys.stdlib_module_names)
    assert "rosic" not in {
        (node.module or "").partition(".")[0]
        for node in ast.walk(tree)
        if isinstance(node, ast.ImportFrom)
    }


def test_a_ratio_is_of_turns_and_its_spread_of_stretches_of_them() -> None:
    (ratio,) = ratio_of("a", [2.0, 4.0, 4.0, 4.0, 6.0, 9.0], [2.0] * 5, "of")

    assert ratio == BenchRatio(name="a", value=2.0, spread=0.5, of="of")
    assert list(ratio_of("a", [], [1.0], "of")) == []


def test_where_rosic_loses_it_says_so() -> None:
    told = list(
        findings(
            [
                BenchRatio(name=f"{RATES}opsdroid", value=0.8, of=""),
                BenchRatio(name="5000 skills beside 1", value=1.05, of=""),
            ]
        )
    )

    assert told == [
        "messages/s, beside opsdroid: 0.80; promised: at least 2; not kept.",
        "ROSIC loses to opsdroid: 0.80 times its messages a second.",
        "5000 skills beside 1: 1.05; promised: at most 1.1; kept.",
    ]


@pytest.mark.campaign
@pytest.mark.limit(1_800)
def test_every_peer_installs_and_answers(tmp_path: Path) -> None:
    load = PeerLoad(CASES, turns=1, updates=50, folder=tmp_path / "e", messages=100)

    report = measured(BenchRecorder("peers"), load)

    rows = came(report)
    assert {told for _, told in rows.values()} == {MEASURED}
    assert all(version for version, _ in rows.values())
    assert len(report.ratios) == 15
