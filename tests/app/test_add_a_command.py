"""docs/howto/add-a-command.md, followed word by word: three files of one folder suffice."""

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
STEP = re.compile(
    r"^([^\n`]*`[^\n]*|and [^\n]*):(?:[^\n]*)\n\n```python\n(.*?)^```", re.MULTILINE | re.DOTALL
)
COMMANDS = "src/rosic/features/media/commands.py"
INNER = 4 * " "


def follow(folder: Path) -> set[str]:
    """Do what the page says in a copy of the tree; return which files it touched."""
    for part in ("src", "tests"):
        shutil.copytree(ROOT / part, folder / part, ignore=shutil.ignore_patterns("__pycache__"))
    (folder / "docs").mkdir()
    shutil.copy(ROOT / "docs" / "language.md", folder / "docs")
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
        elif "imports" in where:
            after = before.replace("\nfrom rosic.features", f"\n{code}from rosic.features", 1)
        elif before:
            after = f"{before}\n\n{code}"
        else:
            after = code
        assert after != before, where
        path.write_text(after, encoding="utf-8")
    return touched


def test_a_command_is_added_in_one_folder(tmp_path: Path) -> None:
    touched = follow(tmp_path)
    assert sorted(touched) == [
        "src/rosic/features/media/battery.py",
        COMMANDS,
        "src/rosic/features/media/messages.py",
        "tests/features/media/test_battery.py",
    ]
    shutil.copy(ROOT / "pyproject.toml", tmp_path)
    environment = {"PYTHONPATH": f"{tmp_path / 'src'}:{tmp_path}", "PATH": "/usr/bin:/bin"}
    tests = ("tests/features/media/test_battery.py", "tests/app/test_commands.py")
    for arguments in (
        ("-m", "tests.commands"),
        ("-m", "pytest", "-q", "-p", "no:cacheprovider", *tests),
    ):
        done = subprocess.run(  # noqa: S603 - our own page and tests, in a copy
            [sys.executable, *arguments],
            cwd=tmp_path,
            env=environment,
            capture_output=True,
            text=True,
            timeout=120 * pace(),
            check=False,
        )
        assert done.returncode == 0, done.stdout[-4000:] + done.stderr[-2000:]
