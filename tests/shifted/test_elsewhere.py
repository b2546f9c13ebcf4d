"""The tests on other days, in other zones, from another folder, as another user.

Each run begins two minutes before something happens to the clock.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
import time
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple
from zoneinfo import ZoneInfo

import pytest

from tests.conftest import REQUIRE_ALL
from tests.pace import pace
from tests.servers import needed
from tests.shifted.clock import compiled, shifted

if TYPE_CHECKING:
    from collections.abc import Iterator

ROOT = Path(__file__).parents[2]
NOBODY = 65534
WITHIN_S = 3_000
PARTS = (
    "tests/app",
    "tests/conformance",
    "tests/organiser",
    "tests/authoriser",
    "tests/features/booking",
    "tests/features/access",
    "tests/container",
    "tests/stores",
    "tests/testing",
    "tests/real/stores",
    "tests/real/telegram",
    "tests/cli/test_control.py",
    "tests/cli/test_run.py",
    "tests/cli/test_running_access.py",
    "tests/journeys/test_first_time.py",
    "tests/journeys/test_pictures.py",
    "tests/journeys/test_card.py",
    "tests/journeys/test_stepping.py",
)


class Day(NamedTuple):
    """When and where a run begins; without a date, tomorrow at this hour."""

    zone: str
    begins: str = ""

    @property
    def begins_s(self) -> float:
        """Seconds after 1970."""
        if not self.begins:
            return time.time() + 86_400
        return datetime.fromisoformat(self.begins).replace(tzinfo=ZoneInfo(self.zone)).timestamp()


DAYS = {
    "tomorrow, at +13": Day("Pacific/Tongatapu"),
    "the end of a month": Day("UTC", "2027-01-31T23:58"),
    "the end of a year": Day("Europe/Berlin", "2026-12-31T23:58"),
    "29 February": Day("America/New_York", "2028-02-29T23:58"),
    "an hour is left out": Day("Europe/Berlin", "2027-03-28T01:58"),
    "an hour comes twice": Day("Europe/Berlin", "2027-10-31T02:58"),
}


@pytest.fixture(scope="module")
def checkout() -> Iterator[Path]:
    """A copy of what is here, in a folder that most shell scripts would trip over."""
    above = Path(tempfile.mkdtemp(dir="/tmp"))
    above.chmod(0o755)
    copy = above / "Müllers Labor" / "rosic"
    others = shutil.ignore_patterns(".git", ".venv", ".*_cache", ".hypothesis", "__pycache__")
    shutil.copytree(ROOT, copy, ignore=others, symlinks=True)
    if os.geteuid() == 0:
        for path in (above, *above.rglob("*")):
            os.chown(path, NOBODY, NOBODY, follow_symlinks=False)
    yield copy
    shutil.rmtree(above)


def as_another() -> list[str]:
    """Return what root puts before a command so that another user runs it.

    That user may look into every folder, for the interpreter may be below one that is closed.
    """
    if os.geteuid() != 0:
        return []
    looks = [f"--{kind}-caps=+dac_read_search" for kind in ("inh", "ambient")]
    user = [f"--reuid={NOBODY}", f"--regid={NOBODY}", "--clear-groups"]
    return [needed("setpriv"), *user, *looks]


@pytest.mark.campaign
@pytest.mark.limit(WITHIN_S + 60)
@pytest.mark.parametrize("day", DAYS.values(), ids=list(DAYS))
def test_it_is_all_the_same(day: Day, checkout: Path, tmp_path: Path) -> None:
    there = shifted(compiled(checkout.parents[1]), day.begins_s)
    home = checkout.parent / "home"
    home.mkdir(exist_ok=True)
    if os.geteuid() == 0:
        os.chown(home, NOBODY, NOBODY)
    own = {name: value for name, value in os.environ.items() if not name.startswith("PYTEST_")}
    there |= {"HOME": str(home), "PYTHONPATH": str(checkout / "src"), "TZ": day.zone}
    there[REQUIRE_ALL] = ""  # another user may mount nothing
    log = tmp_path / "log"
    with log.open("w") as file:
        status = subprocess.run(  # noqa: S603 - our own tests
            [
                *as_another(),
                sys.executable,
                "-m",
                "tests.alone",
                "-n",
                "4",
                "--dist",
                "loadfile",
                "--no-loadscope-reorder",
                "-q",
                *PARTS,
            ],
            cwd=checkout,
            env=own | there,
            stdin=subprocess.DEVNULL,
            stdout=file,
            stderr=subprocess.STDOUT,
            timeout=WITHIN_S * pace(),
            check=False,
        ).returncode
    said = log.read_text()
    assert "cannot be preloaded" not in said
    assert status == 0, said[-20_000:]
    assert "crowded out" not in said, said[-20_000:]
