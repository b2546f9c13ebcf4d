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
from tests.planted.faults_of_cards import OF_CARDS
from tests.planted.faults_of_telling import OF_TELLING
from tests.planted.messenger_faults import MESSENGER_FAULTS

ROOT = Path(__file__).parents[2]
PYTEST_TESTS_FAILED = 1


ALL = (*FAULTS, *OF_CARDS, *OF_TELLING, *OF_ALERTS, *MESSENGER_FAULTS)


@pytest.mark.parametrize("fault", ALL, ids=[fault.name for fault in ALL])
def test_the_fault_is_caught(fault: Fault, tmp_path: Path) -> None:
    source = tmp_path / "src"
    shutil.copytree(
        ROOT / "src" / "rosic", source / "rosic", ignore=shutil.ignore_patterns("__pycache__")
    )
    file = source / "rosic" / fault.file
    text = file.read_text(encoding="utf-8")
    assert text.count(fault.guard) == 1, f"{fault.file} has changed: the fault must be planted anew"
    file.write_text(text.replace(fault.guard, fault.without), encoding="utf-8")
    run = subprocess.run(  # noqa: S603 - our own interpreter on our own tests
        [sys.executable, "-m", "pytest", "-q", "-x", "-p", "no:cacheprovider", *fault.caught_by],
        cwd=ROOT,
        env={**os.environ, "PYTHONPATH": str(source), "PYTHONDONTWRITEBYTECODE": "1"},
        capture_output=True,
        text=True,
        timeout=55,
        check=False,
    )
    assert run.returncode == PYTEST_TESTS_FAILED, (
        f"nothing noticed: {fault.name}\n{run.stdout[-2000:]}{run.stderr[-500:]}"
    )
    assert str(source) in _where(source), "the planted source was not what ran"


def _where(source: Path) -> str:
    return subprocess.run(
        [sys.executable, "-c", "import rosic; print(rosic.__file__)"],
        env={**os.environ, "PYTHONPATH": str(source), "PYTHONDONTWRITEBYTECODE": "1"},
        capture_output=True,
        text=True,
        timeout=20,
        check=True,
    ).stdout
