"""docs/howto/add-a-command.md, followed word by word: one folder suffices."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
from pathlib import Path
from textwrap import indent

from tests.pace import pace

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs" / "howto" / "add-a-command.md"
STEP = re.compile(r"^([^\n`]*`[^\n]*):[^\n]*\n\n```python\n(.*?)^```", re.MULTILINE | re.DOTALL)
GERMAN = re.compile(r"`(src/[\w/]+\.po)`[^\n]*:\n\n```po\n(.*?)^```", re.MULTILINE | re.DOTALL)
EMPTY = 'msgstr ""\n'
# What is written anew of them, and what tests of the shape read.
PAGES = (
    "docs/language.md",
    "docs/glossary.md",
    "docs/decisions/0013-the-fields-own-names.md",
)
COMMANDS = "src/rosic/features/media/commands.py"
INNER = 4 * " "


def copy_tree(folder: Path) -> None:
    for part in ("src", "tests"):
        shutil.copytree(ROOT / part, folder / part, ignore=shutil.ignore_patterns("__pycache__"))
    for page in PAGES:
        (folder / page).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(ROOT / page, folder / page)


def follow(folder: Path) -> set[str]:
    """Do what the page says in a copy of the tree; return which files it touched."""
    copy_tree(folder)
    touched: set[str] = set()
    for where, code in STEP.findall(PAGE.read_text(encoding="utf-8")):
        file = COMMANDS
        if named := re.search(r"`((?:src|tests)/[\w/]+\.py)`", where):
            file = named[1]
        path, touched = folder / file, touched | {file}
        before = path.read_text(encoding="utf-8") if path.exists() else ""
        if "`COMMANDS`" in where:
            head, begin, body = before.partition("\nCOMMANDS: Final = (")
            after = (
                head + begin + body.replace("\n)\n", f"\n{indent(code.rstrip(), INNER)},\n)\n", 1)
            )
        elif "`register_commands`" in where:
            head, body, rest = before.partition("    commands.register(")
            after = f"{head}{indent(code, INNER)}{body}{rest}"
        elif above := re.search(r"above `([^`]+)`", where):
            after = before.replace(f"\n{above[1]}\n", f"\n{code}\n\n{above[1]}\n", 1)
        elif before:
            after = f"{before}\n\n{code}"
        else:
            after = code
        assert after != before, where
        path.write_text(after, encoding="utf-8")
    return touched


def translate(folder: Path) -> int:
    """Write the German of the page where it says; return of how many sentences."""
    [(file, entries)] = GERMAN.findall(PAGE.read_text(encoding="utf-8"))
    path = folder / file
    texts = path.read_text(encoding="utf-8")
    pairs = re.findall(r"(msgid .+\n)(msgstr .+\n)", entries)
    for sentence, german in pairs:
        assert texts.count(f"{sentence}{EMPTY}\n") == 1, sentence
        texts = texts.replace(f"{sentence}{EMPTY}\n", f"{sentence}{german}\n")
    path.write_text(texts, encoding="utf-8")
    return len(pairs)


def run(folder: Path, *arguments: str) -> str:
    """Run a module in the copy; return what it printed."""
    done = subprocess.run(  # noqa: S603 - our own page and tests, in a copy
        [sys.executable, "-m", *arguments],
        cwd=folder,
        env={"PYTHONPATH": f"{folder / 'src'}:{folder}", "PATH": "/usr/bin:/bin"},
        capture_output=True,
        text=True,
        timeout=120 * pace(),
        check=False,
    )
    assert done.returncode == 0, done.stdout[-4000:] + done.stderr[-2000:]
    return done.stdout


def test_a_command_is_added_in_one_folder(tmp_path: Path) -> None:
    touched = follow(tmp_path)
    assert sorted(touched) == [
        COMMANDS,
        "src/rosic/features/media/messages.py",
        "tests/features/media/test_battery.py",
    ]
    shutil.copy(ROOT / "pyproject.toml", tmp_path)
    wanting = run(tmp_path, "tests.texts")
    run(tmp_path, "tests.commands")
    assert f"texts, {translate(tmp_path)} without a translation" in wanting
    assert "texts, 0 without a translation" in run(tmp_path, "tests.texts")
    shape = (f"shape/test_{name}.py" for name in ("measures", "names", "texts"))
    tests = ("features/media/test_battery.py", "app/test_commands.py", *shape)
    run(
        tmp_path,
        "pytest",
        "-q",
        "-pno:cacheprovider",
        "-pno:schemathesis",
        *(f"tests/{test}" for test in tests),
    )
    run(tmp_path, "ruff", "check", *touched)
    run(tmp_path, "ruff", "format", "--check", *touched)
