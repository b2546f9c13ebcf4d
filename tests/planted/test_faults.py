"""Every guard was seen to matter: taken out, a test fails."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from tests.planted.faults import FAULTS, Fault
from tests.planted.faults_of_alerts import OF_ALERTS
from tests.planted.faults_of_among import OF_AMONG
from tests.planted.faults_of_cards import OF_CARDS
from tests.planted.faults_of_dispatch import OF_DISPATCH
from tests.planted.faults_of_fleet import OF_FLEET, OF_TASKS
from tests.planted.faults_of_orders import OF_ORDERS
from tests.planted.faults_of_telling import OF_TELLING
from tests.planted.messenger_faults import MESSENGER_FAULTS

ROOT = Path(__file__).parents[2]
PYTEST_TESTS_FAILED = 1
WITHIN_S = 240
# A plugin of the run that is to fail: which source it was that failed.
SAYS_WHERE = "says_where"
WHERE = """
def pytest_terminal_summary(terminalreporter):
    import rosic
    terminalreporter.write_line(f"source: {rosic.__file__}")
"""

ALL = (
    *FAULTS, *OF_ORDERS, *OF_DISPATCH, *OF_CARDS, *OF_TELLING, *OF_ALERTS, *OF_AMONG, *OF_FLEET,
    *OF_TASKS, *MESSENGER_FAULTS,
)  # fmt: skip


pytestmark = pytest.mark.limit(WITHIN_S + 10)


@pytest.mark.parametrize("fault", ALL, ids=[fault.name for fault in ALL])
def test_the_fault_is_caught(fault: Fault, tmp_path: Path) -> None:
    source = tmp_path / "src"
    # Compiled files come along, with the times that make them valid: only what changes is compiled.
    shutil.copytree(ROOT / "src" / "rosic", source / "rosic")
    file = source / "rosic" / fault.file
    text = file.read_text(encoding="utf-8")
    assert text.count(fault.guard) == 1, f"{fault.file} has changed: the fault must be planted anew"
    file.write_text(text.replace(fault.guard, fault.without), encoding="utf-8")
    (tmp_path / f"{SAYS_WHERE}.py").write_text(WHERE)
    run = subprocess.run(  # noqa: S603 - our own interpreter on our own tests
        [
            sys.executable, "-m", "pytest", "-q", "-x", "-p", "no:cacheprovider", "-p", SAYS_WHERE,
            "--hypothesis-profile=unread", *fault.caught_by,
        ],
        cwd=ROOT,
        env={**os.environ, "PYTHONPATH": os.pathsep.join(map(str, (source, tmp_path)))},
        capture_output=True,
        text=True,
        timeout=WITHIN_S,
        check=False,
    )  # fmt: skip
    assert run.returncode == PYTEST_TESTS_FAILED, (
        f"nothing noticed: {fault.name}\n{run.stdout[-2000:]}{run.stderr[-500:]}"
    )
    assert f"source: {source}" in run.stdout, "the planted source was not what ran"
