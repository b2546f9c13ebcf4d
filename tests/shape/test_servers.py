"""`make servers`, with an apt of this test's own."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.pace import pace
from tests.servers import NEEDS, needed

ROOT = Path(__file__).parents[2]

SUDO = """#!/bin/sh
[ "$1" = -n ] && shift
exec "$@"
"""
APT = """#!/bin/sh
[ "$DEBIAN_FRONTEND" = noninteractive ] || exit 9
echo "$*" >>{bin}/called
if read -r line; then exit 8; fi
{then}
"""
INSTALLS = """
case "$*" in *install*)
    for name in {commands}; do printf '#!/bin/sh\n' >{bin}/$name; chmod +x {bin}/$name; done ;;
esac
"""


def servers(folder: Path, then: str | None) -> subprocess.CompletedProcess[str]:
    """Run it where there is nothing on the path but this apt, if any."""
    if then is not None:
        commands = " ".join(need.command for need in NEEDS)
        then = then.replace("{commands}", commands).replace("{bin}", str(folder))
        for name, text in (
            ("apt-get", APT.format(bin=folder, then=then)),
            ("sudo", SUDO),
            ("env", '#!/bin/sh\nexec /usr/bin/env "$@"\n'),
            ("chmod", '#!/bin/sh\nexec /bin/chmod "$@"\n'),
        ):
            (folder / name).write_text(text)
            (folder / name).chmod(0o755)
    return subprocess.run(
        [sys.executable, "-m", "tests.servers"],
        cwd=ROOT,
        env=os.environ | {"PATH": str(folder)},
        capture_output=True,
        text=True,
        timeout=150 * pace(),
        check=False,
    )


def test_what_is_missing_is_installed_and_what_is_there_left_alone(tmp_path: Path) -> None:
    first = servers(tmp_path, INSTALLS)
    assert (first.returncode, first.stderr) == (0, "")
    update, install = (tmp_path / "called").read_text().splitlines()
    assert update.endswith(" update")
    assert install.endswith(" install " + " ".join(need.package for need in NEEDS))

    second = servers(tmp_path, INSTALLS)
    assert (second.returncode, second.stdout, second.stderr) == (0, "", "")
    assert len((tmp_path / "called").read_text().splitlines()) == 2


@pytest.mark.parametrize(
    ("then", "why"),
    [
        (None, "there is no apt-get here."),
        ("echo E: no such package; exit 100", "failed; E: no such package."),
        ("", "apt-get installed something else."),
    ],
)
def test_what_cannot_be_installed_is_said_in_one_sentence(
    tmp_path: Path, then: str | None, why: str
) -> None:
    done = servers(tmp_path, then)
    assert done.returncode == 1
    wanting = ", ".join(f"{need.command} (for {need.what_for})" for need in NEEDS)
    assert done.stderr.startswith(f"Not installed: {wanting}: ")
    assert done.stderr.endswith(why + "\n")
    assert done.stderr.count("\n") == 1


def test_a_test_without_what_it_needs_is_skipped_with_the_way_to_it() -> None:
    with pytest.raises(pytest.skip.Exception, match="nothing-is-called-so is not installed: run"):
        needed("nothing-is-called-so")
