"""The tool that changes safety code: what is tested dies, what is not is found."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING

import pytest

from tests.mutants.campaign import SOURCE as ROSIC
from tests.mutants.campaign import Known, Wanted, listed, share, table, tried, unlisted
from tests.mutants.modules import MODULES, Module
from tests.mutants.mutation import mutants

if TYPE_CHECKING:
    from pathlib import Path

SOURCE = '''
"""Doors."""

def may_open(age: int) -> bool:
    """Say who may open one."""
    if age < 18:
        return False
    return True


def alarms(level: int) -> bool:
    return level > 3


def closed(doors: int) -> int:
    done = 0
    while done < doors:
        done += 1
    return done


def nobody_asks() -> bool:
    return 1 == 2
'''
TESTS = """
import threading
from doors import alarms, closed, may_open

def test_age():
    assert may_open(18) is True
    assert may_open(17) is False

def test_alarms_in_a_thread():
    found = []
    thread = threading.Thread(target=lambda: found.append((alarms(5), alarms(2))))
    thread.start()
    thread.join()
    assert found == [(True, False)]

def test_closed():
    assert closed(3) == 3
    assert closed(0) == 0
"""
DOORS = Module("doors", "doors.py", ("tests",))


@pytest.fixture
def project(tmp_path: Path) -> Path:
    """A source with one boundary that no test looks at, and one function that none calls."""
    (tmp_path / "src").mkdir()
    (tmp_path / "tests").mkdir()
    (tmp_path / "pytest.ini").write_text("[pytest]\npythonpath = src\n")
    (tmp_path / "src" / "doors.py").write_text(SOURCE)
    (tmp_path / "tests" / "test_doors.py").write_text(TESTS)
    return tmp_path


def wanted(project: Path, **how: object) -> Wanted:
    usual: dict[str, object] = {
        "seed": 1,
        "at_most": 0,
        "each_s": 10.0,
        "until_s": time.time() + 150,
        "folder": project / "results",
        "slack_s": 3.0,
    }
    return Wanted(**{**usual, **how})  # type: ignore[arg-type]


def test_what_is_tested_dies_and_what_is_not_is_found(project: Path) -> None:
    found = tried(DOORS, wanted(project), project / "src", project)
    assert not found.failing
    assert len(found.results) == len(mutants(SOURCE))
    assert [result.id for result in found.survivors()] == [
        "alarms: compared otherwise: level > 3 -> level >= 3",
        "alarms: one more: 3 -> 4",
        "nobody_asks: compared otherwise: 1 == 2 -> 1 != 2",
        "nobody_asks: one more: 1 -> 2",
        "nobody_asks: one more: 2 -> 3",
        "nobody_asks: returns nothing: return 1 == 2 -> return None",
    ]
    endless = found.results["closed: opposite: done += 1 -> done -= 1"]
    assert endless.end == "timed out"
    assert endless.by == "tests/test_doors.py::test_closed"
    assert found.results["may_open: compared otherwise: age < 18 -> age <= 18"].end == "killed"
    assert table([found]).splitlines()[1].split() == (
        ["doors.py", "23", "16", "1", "6", "0", "73.9", "%"]
    )
    assert share([found]) == pytest.approx(100 * found.killed / found.real)

    reason = Known(file="doors.py", mutant=found.survivors()[0].id, why="it is never 3")
    others = unlisted([found], [reason])
    assert len(others) == 5
    assert others[0] == "src/rosic/doors.py:12  alarms: one more: 3 -> 4  [survived]"


def test_a_run_goes_on_where_it_was_cut_off_and_begins_anew_with_other_tests(project: Path) -> None:
    over = wanted(project, until_s=time.time() - 1)
    assert not tried(DOORS, over, project / "src", project).results
    few = wanted(project, at_most=3)
    first = tried(DOORS, few, project / "src", project)
    again = tried(DOORS, few, project / "src", project)
    assert len(first.results) == 3
    assert again.results == first.results, "to the hundredth of a second: they were not run again"
    (project / "tests" / "test_doors.py").write_text("from doors import alarms\n" + TESTS)
    anew = tried(DOORS, over, project / "src", project)
    assert not anew.results
    kept = tried(DOORS, wanted(project, at_most=3, keep_kills=True), project / "src", project)
    assert kept.killed == first.killed


def test_what_a_busy_machine_did_not_notice_is_tried_again_when_asked_for(project: Path) -> None:
    first = tried(DOORS, wanted(project), project / "src", project)
    [results] = (project / "results").glob("*.jsonl")
    results.write_text(results.read_text().replace('"end":"killed"', '"end":"survived"'))
    stays = tried(DOORS, wanted(project), project / "src", project)
    assert len(stays.survivors()) == len(first.survivors()) + first.count("killed")
    again = tried(DOORS, wanted(project, again=True), project / "src", project)
    assert again.killed == first.killed
    assert [one.id for one in again.survivors()] == [one.id for one in first.survivors()]


DEFAULTS = """
import os

def settled(path, wait=os.fsync, *, times=1, quick=False, other=None):
    for _ in range(times):
        wait(path)
    return other if quick else path
"""
TESTS_OF_DEFAULTS = """
from doors import settled

def test_settled(monkeypatch):
    assert settled("door", lambda path: None) == "door"
    seen = []
    assert settled("door", seen.append, times=2) == "door"
    assert seen == ["door"] * 2
    if {whole}:
        import os, tempfile
        with tempfile.TemporaryFile() as file:
            assert settled(file.fileno(), quick=True) is None
        seen.clear()
        settled("door", seen.append)
        assert seen == ["door"]
        try:
            settled(-1)
        except (OSError, ValueError):
            return
        raise AssertionError("nobody waited for the disk")
"""


@pytest.mark.parametrize("whole", [False, True])
def test_what_a_parameter_defaults_to_is_changed_too(project: Path, *, whole: bool) -> None:
    """Though it was made before any test began: whoever calls the function reaches it."""
    (project / "src" / "doors.py").write_text(DEFAULTS)
    (project / "tests" / "test_doors.py").write_text(TESTS_OF_DEFAULTS.format(whole=whole))
    found = tried(DOORS, wanted(project), project / "src", project)
    assert not found.failing
    of_defaults = {r.id: r.end for r in found.results.values() if ": default of " in r.id}
    assert of_defaults == {
        "settled: default of wait: os.fsync -> lambda *_, **__: None": "killed"
        if whole
        else "survived",
        "settled: default of times: 1 -> 2": "killed" if whole else "survived",
        "settled: default of quick: False -> True": "killed",
        "settled: default of other: None -> ...": "killed" if whole else "survived",
    }


AWAITED = """
from types import coroutine

@coroutine
def passed_on(given):
    yield
    return given + 1
"""
TESTS_OF_AWAITED = """
import asyncio
from doors import passed_on

def test_passed_on():
    async def passing():
        return await passed_on(1)
    assert asyncio.run(passing()) == 2
"""


def test_a_generator_that_is_awaited_can_still_be(project: Path) -> None:
    """`types.coroutine` marks the code of a function: what takes its place is marked as well."""
    (project / "src" / "doors.py").write_text(AWAITED)
    (project / "tests" / "test_doors.py").write_text(TESTS_OF_AWAITED)
    found = tried(DOORS, wanted(project), project / "src", project)
    assert not found.failing
    assert [each.end for each in found.results.values()] == ["killed"] * len(found.results)
    (project / "tests" / "test_doors.py").write_text(TESTS_OF_AWAITED.replace("== 2", "> 1"))
    found = tried(DOORS, wanted(project), project / "src", project)
    assert "passed_on: one more: 1 -> 2" in {each.id for each in found.survivors()}


TIRED = """
import time
from pathlib import Path
from doors import echoed

def test_that_passes_once():
    echoed("a knock")
    before = Path(__file__).with_name("before")
    if before.exists():
        {after}
    before.touch()
"""


@pytest.mark.parametrize("after", ["raise AssertionError", "time.sleep(60)"])
def test_what_fails_without_a_change_too_has_noticed_nothing(project: Path, after: str) -> None:
    """As a test does that a busy machine is too slow for."""
    (project / "src" / "doors.py").write_text("def echoed(word):\n    return word\n")
    (project / "tests" / "test_doors.py").write_text(TIRED.format(after=after))
    found = tried(DOORS, wanted(project, slack_s=1.0), project / "src", project)
    assert not found.failing, "it passed while the machine was idle"
    assert [each.end for each in found.results.values()] == ["survived"]


def test_every_reason_is_about_a_change_that_can_be_made() -> None:
    """Once its line has changed, a survivor is another: its reason is looked at anew."""
    files = {module.file for module in MODULES}
    for each in listed():
        assert each.file in files, each
        assert each.why.strip(), each
        assert each.mutant in mutants((ROSIC / each.file).read_text(encoding="utf-8")), each


@pytest.mark.campaign
@pytest.mark.limit(7_200)
def test_some_of_each_module(tmp_path: Path) -> None:
    some = wanted(tmp_path, at_most=15, each_s=30.0, slack_s=20.0, until_s=time.time() + 7_000)
    found = [tried(module, some) for module in MODULES]
    assert not unlisted(found, listed())
    assert all(len(one.results) == len(one.chosen) for one in found)
    assert share(found) >= 90.0, "with so few of each, chance counts"
