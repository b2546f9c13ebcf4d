"""Without aiohttp the stand-in for Telegram says in one sentence how to get it."""

from __future__ import annotations

import os
import subprocess
import sys
from typing import TYPE_CHECKING

import pytest

from tests.pace import pace

if TYPE_CHECKING:
    from pathlib import Path

BLOCK = """
import sys

class Missing:
    def find_spec(self, name, path=None, target=None):
        if name == "aiohttp":
            raise ModuleNotFoundError("No module named 'aiohttp'", name=name)

sys.meta_path.insert(0, Missing())
"""
SENTENCE = (
    "The stand-in for Telegram needs aiohttp: pip install 'rosic[testing]' "
    "(in a checkout: .venv/bin/pip install -e '.[testing]')."
)


@pytest.mark.parametrize(
    ("asked", "trace"),
    [(("-m", "rosic.testing.telegram"), False), (("-c", "import rosic.testing.telegram"), True)],
)
def test_what_is_missing_is_said_in_one_sentence(
    asked: tuple[str, str], trace: bool, tmp_path: Path
) -> None:
    (tmp_path / "sitecustomize.py").write_text(BLOCK)
    done = subprocess.run(  # noqa: S603 - our own program
        [sys.executable, *asked],
        check=False,
        capture_output=True,
        text=True,
        timeout=60 * pace(),
        env={**os.environ, "PYTHONPATH": str(tmp_path)},
    )
    assert done.returncode == 1
    assert done.stderr.strip().splitlines()[-1].endswith(SENTENCE)
    assert ("Traceback" in done.stderr) is trace
    if not trace:
        assert done.stderr == f"{SENTENCE}\n"
