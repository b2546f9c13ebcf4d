"""The core reckons with dates and asks no clock: the linter that says so is seen to say so."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
CORE, OUTSIDE = "src/rosic/core/asking.py", "src/rosic/app/asking.py"


def banned(line: str, file: str) -> bool:
    """Whether ruff, as it is configured here, forbids a line in this file."""
    given = f"from datetime import UTC, date, datetime\n\n{line}\n"
    command = [sys.executable, "-m", "ruff", "check", "--no-cache", "--select", "TID251"]
    shown = subprocess.run(  # noqa: S603 - the linter of this environment
        [*command, "--output-format", "concise", "--stdin-filename", file, "-"],
        cwd=ROOT,
        input=given,
        capture_output=True,
        text=True,
        check=False,
    )
    return f"{file}:3:" in shown.stdout


@pytest.mark.parametrize(
    "line",
    ["datetime.now(UTC)", "datetime.today()", "datetime.utcnow()", "date.today()"],
)
def test_only_the_core_may_not_ask_what_time_it_is(line: str) -> None:
    assert banned(line, CORE)
    assert not banned(line, OUTSIDE)


def test_the_core_may_reckon_with_dates() -> None:
    assert not banned("date(2027, 1, 1).toordinal()", CORE)
