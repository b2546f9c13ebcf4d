"""docs/howto/add-a-feature.md, followed word by word: one folder suffices."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
from pathlib import Path

from tests.pace import pace

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs" / "howto" / "add-a-feature.md"
STEP = re.compile(
    r"^`((?:src|tests)/[\w/]+\.py)`[^\n]*:\n\n```python\n(.*?)^```", re.MULTILINE | re.DOTALL
)
WORDS = re.compile(r"`(tests/[\w/]+\.txt)`[^\n]*:\n\n```text\n(.*?)^```", re.MULTILINE | re.DOTALL)
FEATURE = "src/rosic/features/odometer"
# What is written anew of them, and what tests of the shape read.
PAGES = (
    "docs/language.md",
    "docs/architecture.md",
    "docs/images/imports.svg",
    "docs/glossary.md",
    "docs/decisions/0013-the-fields-own-names.md",
)
# What a new module, class or command can break.
SHAPE = (
    "tests/app/test_commands.py",
    "tests/shape/test_measures.py",
    "tests/shape/test_names.py",
    "tests/shape/test_architecture.py::test_the_tables_are_of_today",
)


def follow(folder: Path) -> list[str]:
    """Do what the page says in a copy of the tree; return which files it made."""
    for part in ("src", "tests"):
        shutil.copytree(ROOT / part, folder / part, ignore=shutil.ignore_patterns("__pycache__"))
    for page in PAGES:
        (folder / page).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(ROOT / page, folder / page)
    shutil.copy(ROOT / "pyproject.toml", folder)
    made: list[str] = []
    for file, code in STEP.findall(PAGE.read_text(encoding="utf-8")):
        path = folder / file
        assert not path.exists(), "a feature changes nothing that is there"
        path.parent.mkdir(exist_ok=True)
        path.write_text(code, encoding="utf-8")
        made.append(file)
    [(listed, words)] = WORDS.findall(PAGE.read_text(encoding="utf-8"))
    with (folder / listed).open("a", encoding="utf-8") as file:
        file.write(words)
    return made


def test_a_feature_is_added_in_one_folder(tmp_path: Path) -> None:
    made = follow(tmp_path)
    assert made == [
        f"{FEATURE}/__init__.py",
        f"{FEATURE}/odometer.py",
        f"{FEATURE}/commands.py",
        f"{FEATURE}/messages.py",
        "tests/features/odometer/test_odometer.py",
    ]
    environment = {"PYTHONPATH": f"{tmp_path / 'src'}:{tmp_path}", "PATH": "/usr/bin:/bin"}
    ruff = str(Path(sys.executable).with_name("ruff"))
    for command in (
        [sys.executable, "-m", "tests.commands"],
        [sys.executable, "-m", "tests.architecture"],
        [
            sys.executable,
            "-m",
            "pytest",
            "-q",
            "-pno:cacheprovider",
            "-pno:schemathesis",
            made[-1],
            *SHAPE,
        ],
        [ruff, "check", FEATURE, made[-1]],
        [ruff, "format", "--check", FEATURE, made[-1]],
    ):
        done = subprocess.run(  # noqa: S603 - our own page and tests, in a copy
            command,
            cwd=tmp_path,
            env=environment,
            capture_output=True,
            text=True,
            timeout=120 * pace(),
            check=False,
        )
        assert done.returncode == 0, done.stdout[-4000:] + done.stderr[-2000:]
