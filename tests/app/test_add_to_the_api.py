"""docs/howto/add-to-the-api.md, followed word by word in a copy of the source, and run."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from tests.pace import pace

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs" / "howto" / "add-to-the-api.md"
STEP = re.compile(
    r"^`((?:src|tests)/[\w/]+\.\w+)`[^\n]*\n\n```(\w+)\n(.*?)^```", re.MULTILINE | re.DOTALL
)
PAGES = ("docs/glossary.md", "docs/decisions/0013-the-fields-own-names.md")
TEST = "tests/api/test_clock.py"


def changed(before: str, difference: str) -> str:
    """Return a text with the parts of a difference that stand between ``@@``; each fits once."""
    for part in difference.split("@@\n"):
        lines = part.splitlines(keepends=True)
        old = "".join(line[1:] for line in lines if not line.startswith("+"))
        new = "".join(line[1:] for line in lines if not line.startswith("-"))
        assert before.count(old) == 1, old
        before = before.replace(old, new)
    return before


def follow(folder: Path) -> list[str]:
    """Do what the page says in a copy of the tree; return which files it touched."""
    for part in ("src", "tests"):
        shutil.copytree(ROOT / part, folder / part, ignore=shutil.ignore_patterns("__pycache__"))
    for page in PAGES:
        (folder / page).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(ROOT / page, folder / page)
    shutil.copy(ROOT / "pyproject.toml", folder)
    touched = []
    for file, language, text in STEP.findall(PAGE.read_text(encoding="utf-8")):
        path = folder / file
        assert path.exists() == (language == "diff"), file
        before = path.read_text(encoding="utf-8") if path.exists() else ""
        path.write_text(changed(before, text) if before else text, encoding="utf-8")
        touched.append(file)
    return touched


@pytest.mark.limit(300)
def test_what_the_page_adds_is_there_by_all_five_ways(tmp_path: Path) -> None:
    touched = follow(tmp_path)
    assert len(touched) == len(re.findall(r"^```\w", PAGE.read_text(), re.MULTILINE))
    python = [file for file in touched if file.endswith(".py")]
    ruff = str(Path(sys.executable).with_name("ruff"))
    tests = (TEST, "tests/api/test_client_operations.py", "tests/shape/test_names.py")
    quiet = ("-q", "-pno:cacheprovider", "-pno:schemathesis")
    for command in (
        [ruff, "check", *python],
        [ruff, "format", "--check", *python],
        [sys.executable, "-m", "pytest", *quiet, *tests, "tests/console/test_pages.py"],
    ):
        done = subprocess.run(  # noqa: S603 - our own page and tests, in a copy
            command,
            cwd=tmp_path,
            env={"PYTHONPATH": f"{tmp_path / 'src'}:{tmp_path}", "PATH": "/usr/bin:/bin"},
            capture_output=True,
            text=True,
            timeout=240 * pace(),
            check=False,
        )
        assert done.returncode == 0, done.stdout[-4000:] + done.stderr[-2000:]
