"""The pages about the command line and the terminal say what is there."""

from __future__ import annotations

import re
import subprocess
from pathlib import Path

from rosic.cli.main import COMMANDS
from tests.cli.running import ROSIC, environment
from tests.pace import pace

DOCS = Path(__file__).parents[2] / "docs"


def test_every_command_is_in_the_table_and_has_a_section() -> None:
    page = (DOCS / "command-line.md").read_text(encoding="utf-8")
    headings = " ".join(re.findall(r"^## (.*)$", page, re.MULTILINE))

    assert re.findall(r"^\| `rosic (.*?)` \|", page, re.MULTILINE) == list(COMMANDS)
    assert all(f"`rosic {name}`" in headings for name in COMMANDS)


def test_what_can_be_pasted_into_a_shell_works() -> None:
    page = (DOCS / "command-line.md").read_text(encoding="utf-8")
    [script] = re.findall(r"^```sh\n(.*?)^```", page, re.MULTILINE | re.DOTALL)
    script = script.replace("rosic demo", " ".join([*ROSIC, "demo"]))

    done = subprocess.run(  # noqa: S603 - our own page
        ["/bin/sh", "-c", script],
        capture_output=True,
        text=True,
        timeout=150 * pace(),
        check=False,
        env=environment(),
    )

    assert done.returncode == 0
    assert done.stdout.count(": done ") == 3
    assert "omni is stopped, by you" in done.stdout
