"""tests/conftest.py seen at work, in another run of pytest under the same configuration."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

from tests.conftest import SECONDS
from tests.pace import PACE, pace

ROOT = Path(__file__).parents[2]

SUBJECT = """
import asyncio, time
import pytest

def test_fine(): pass

@pytest.mark.skip(reason="needs a real server")
def test_left_out(): pass

@pytest.mark.xfail(reason="known", strict=True)
def test_known(): assert False

@pytest.mark.limit(0.2)
def test_sleeps(): time.sleep(20)

@pytest.mark.limit(0.2)
async def test_waits(): await asyncio.sleep(20)

@pytest.fixture
def server(request):
    yield
    print("server put away")

@pytest.mark.limit(0.2)
def test_serves(server): time.sleep(20)

@pytest.mark.campaign
def test_for_hours(): pass
"""

ABSENT = """
import pytest
pytest.importorskip("a_library_that_nobody_has", reason="needs a rare library")
def test_never_seen(): pass
"""


# Nothing in the subject uses these, and what they bring takes long to load.
FEW = ("-pno:xdist", "-pno:faker", "-pno:schemathesis")


def run_pytest(
    folder: Path, *arguments: str, require_all: bool = False, paced: float = 1.0
) -> dict[str, str]:
    """Outcome of each test by its name; the whole output stands under the empty name."""
    shutil.copy(ROOT / "pyproject.toml", folder)
    shutil.copy(ROOT / "tests/conftest.py", folder)
    (folder / "tests").mkdir()
    for name in ("leaks.py", "pace.py"):
        shutil.copy(ROOT / "tests" / name, folder / "tests")
    (folder / "test_subject.py").write_text(SUBJECT)
    (folder / "test_absent.py").write_text(ABSENT)
    own = {name: value for name, value in os.environ.items() if not name.startswith("PYTEST_")}
    done = subprocess.run(  # noqa: S603
        [sys.executable, "-m", "pytest", "-rA", *FEW, *arguments, "."],
        cwd=folder,
        env=own | {"ROSIC_REQUIRE_ALL": "1" if require_all else "", PACE: f"{paced}"},
        capture_output=True,
        text=True,
        timeout=150 * pace(),
        check=False,
    )
    outcomes = re.findall(
        r"^(PASSED|FAILED|XFAIL|ERROR) \S*?(\w+)(?:\.py)?(?: - |$)", done.stdout, re.MULTILINE
    )
    return {name: outcome for outcome, name in outcomes} | {"": done.stdout}


def test_an_ordinary_run(tmp_path: Path) -> None:
    outcomes = run_pytest(tmp_path)
    output = outcomes.pop("")

    assert outcomes == {
        "test_fine": "PASSED",
        "test_known": "XFAIL",
        "test_sleeps": "FAILED",
        "test_waits": "FAILED",
        "test_serves": "FAILED",
    }
    assert output.count("Failed: took longer than 0.2 s") >= 3
    assert "server put away" in output
    assert "2 skipped, 1 deselected" in output


def test_where_everything_must_run_a_skip_fails_with_its_sentence(tmp_path: Path) -> None:
    outcomes = run_pytest(tmp_path, "--continue-on-collection-errors", require_all=True)

    assert outcomes["test_left_out"] == "ERROR"  # a mark skips while setting up
    assert outcomes["test_absent"] == "ERROR"
    assert outcomes["test_known"] == "XFAIL"
    assert "this was skipped: Skipped: needs a real server" in outcomes[""]
    assert "this was skipped: Skipped: needs a rare library" in outcomes[""]


def test_on_a_slow_machine_a_test_may_take_longer(tmp_path: Path) -> None:
    output = run_pytest(tmp_path, "-k", "sleeps", paced=3.0)[""]

    assert "Failed: took longer than 0.6 s" in output


def test_a_campaign_runs_when_it_is_asked_for(tmp_path: Path) -> None:
    assert run_pytest(tmp_path, "-m", "campaign")["test_for_hours"] == "PASSED"


def test_the_longest_files_come_first_and_are_there(tmp_path: Path) -> None:
    assert [file for file in SECONDS if not (ROOT / file).is_file()] == []

    (tmp_path / "tests").mkdir()
    shutil.copy(ROOT / "pyproject.toml", tmp_path)
    shutil.copy(ROOT / "tests/conftest.py", tmp_path / "tests")
    for name in ("leaks.py", "pace.py"):
        shutil.copy(ROOT / "tests" / name, tmp_path / "tests")
    longest = max(SECONDS, key=SECONDS.__getitem__)
    for file in ("tests/a/test_first.py", longest):
        (tmp_path / file).parent.mkdir()
        (tmp_path / file).write_text("def test_fine(): pass\n")
    own = {name: value for name, value in os.environ.items() if not name.startswith("PYTEST_")}
    shared_out = ["-n", "1", "--dist", "loadfile", "--no-loadscope-reorder"]
    for how, first in ((shared_out, longest), (["-p", "no:xdist"], "tests/a/test_first.py")):
        done = subprocess.run(  # noqa: S603
            [sys.executable, "-m", "pytest", "-v", *how, "tests"],
            cwd=tmp_path,
            env=own,
            capture_output=True,
            text=True,
            timeout=150 * pace(),
            check=True,
        )
        assert re.findall(r"\btests/\S+\.py", done.stdout)[0] == first, done.stdout
