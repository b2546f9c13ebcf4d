"""A test that was crowded out gets a second chance alone; nothing else does."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.pace import pace

ROOT = Path(__file__).parents[2]
FAILS_ONCE = """
from pathlib import Path

def test_it():
    seen = Path(__file__).with_suffix(".seen")
    before = seen.exists()
    seen.touch()
    assert before
"""
FAILS = "def test_it():\n    assert False\n"
PASSES = "def test_it():\n    pass\n"
AGAIN = "run once more alone"
# Nothing in these projects uses them, and what they bring takes long to load.
FEW = "-p no:faker -p no:schemathesis"


def run(folder: Path, **files: str) -> tuple[int, str]:
    """Run tests of a project of its own, named ``journeys__x`` for ``tests/journeys/test_x.py``."""
    (folder / "pytest.ini").write_text("[pytest]\n")
    for name, text in files.items():
        path = folder / "tests" / f"{name.replace('__', '/test_')}.py"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    ended = subprocess.run(  # noqa: S603 - our own interpreter
        [sys.executable, ROOT / "tests" / "alone.py", "-p", "no:cacheprovider", "tests"],
        cwd=folder,
        env=os.environ | {"PYTEST_ADDOPTS": FEW},
        capture_output=True,
        text=True,
        timeout=60 * pace(),
        check=False,
    )
    return ended.returncode, ended.stdout


def test_what_passes_alone_passes_and_is_named(tmp_path: Path) -> None:
    status, said = run(tmp_path, journeys__crowd=FAILS_ONCE, core__fine=PASSES)
    assert status == 0
    assert "These pass alone: crowded out, to be mended:\n  tests/journeys/test_crowd.py" in said


def test_what_fails_alone_fails(tmp_path: Path) -> None:
    status, said = run(tmp_path, journeys__crowd=FAILS_ONCE, real__wrong=FAILS)
    assert status == 1
    assert "These fail alone, too:" in said


@pytest.mark.parametrize(
    "files",
    [
        {"core__once": FAILS_ONCE},
        {"journeys__crowd": FAILS_ONCE, "core__wrong": FAILS},
        {f"journeys__crowd{n}": FAILS_ONCE for n in range(6)},
        {"journeys__broken": "import nothing_of_the_kind\n"},
    ],
)
def test_nothing_else_has_a_second_chance(tmp_path: Path, files: dict[str, str]) -> None:
    status, said = run(tmp_path, **files)
    assert status != 0
    assert AGAIN not in said


def test_nothing_is_run_twice_when_all_is_well(tmp_path: Path) -> None:
    status, said = run(tmp_path, journeys__fine=PASSES)
    assert status == 0
    assert AGAIN not in said
