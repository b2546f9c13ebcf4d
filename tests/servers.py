"""Installs what tests start or use and no wheel brings: `make servers`.

Programs come from the distribution, packages of JavaScript from npm, and the homeserver of Matrix
from PyPI, in an environment of its own: what it requires contradicts what ROSIC does.

What is there already is left alone, so that a second call costs nothing. Tests ask `needed`.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Final, NamedTuple

import pytest

from rosic.testing.ros2.graph import environment_for_another_python

if TYPE_CHECKING:
    from collections.abc import Mapping

WITHIN_S: Final = 300.0
"""For one call of apt, npm or pip: a mirror may be slow, and nobody is asked anything."""


class Need(NamedTuple):
    """A program that tests need.

    Attributes:
        command: As it is found on the path.
        package: Of Debian and what descends from it.
        what_for: What is skipped without it.
    """

    command: str
    package: str
    what_for: str


NEEDS: Final = (
    Need("chromium", "chromium", "the page in a browser"),
    Need("gcc", "gcc", "ROS 2 interfaces, and tests under another date"),
    Need("g++", "g++", "ROS 2 interfaces"),
    Need("node", "nodejs", "clients of rosbridge and of Matrix in JavaScript"),
    Need("npm", "npm", "clients of rosbridge and of Matrix in JavaScript"),
    Need("openssl", "openssl", "a server of XMPP with a certificate"),
    Need("prosody", "prosody", "XMPP"),
    Need("zsh", "zsh", "completion in zsh"),
)
REQUIREMENTS: Final = Path(__file__).parents[1] / "requirements"
LISTED: Final = REQUIREMENTS / "node"
"""Which packages of npm tests use, pinned by hash."""
PACKAGES: Final = Path(sys.prefix) / "node"
"""Where they are: with the environment, and gone with it."""
SYNAPSE: Final = Path(sys.prefix) / "synapse"
"""The environment of the homeserver; gone with that of the tests, too."""

_QUIETLY: Final = ("-qq", "-o", "Acquire::Retries=3", "-o", "DPkg::Lock::Timeout=120")
_APT: Final = (
    ("apt-get", *_QUIETLY, "update"),
    ("apt-get", *_QUIETLY, "-y", "--no-install-recommends", "install"),
)


def needed(command: str) -> str:
    """Return where a program is; skip the test that asks, where it is not installed."""
    found = shutil.which(command)
    if found is None:
        pytest.skip(f"{command} is not installed: run make servers")
    return found


def node_modules() -> Path:
    """Return where packages of npm are; skip the test that asks, where they are not installed."""
    needed("node")
    if not _packages_are_here():
        pytest.skip("packages of npm are not installed: run make servers")
    return PACKAGES / "node_modules"


def _packages_are_here() -> bool:
    lock, there = LISTED / "package-lock.json", PACKAGES / "package-lock.json"
    whole = PACKAGES / "node_modules" / ".package-lock.json"
    return whole.exists() and there.read_bytes() == lock.read_bytes()


def install_packages() -> str:
    """Install packages of npm, running nothing of theirs; return why not, or nothing."""
    npm = shutil.which("npm")
    if npm is None or _packages_are_here():
        return ""
    PACKAGES.mkdir(exist_ok=True)
    for name in ("package.json", "package-lock.json"):
        shutil.copyfile(LISTED / name, PACKAGES / name)
    quietly = ("--ignore-scripts", "--no-audit", "--no-fund", "--prefix", str(PACKAGES))
    return _run((npm, "ci", *quietly))


def synapse_python() -> Path:
    """Return the Python that has Synapse; skip the test that asks, where it is not installed."""
    if not _synapse_is_here():
        pytest.skip("Synapse is not installed: run make servers")
    return SYNAPSE / "bin" / "python"


def _synapse_is_here() -> bool:
    mark, pins = SYNAPSE / "installed.txt", REQUIREMENTS / "synapse.txt"
    python = SYNAPSE / "bin" / "python"
    return python.exists() and mark.exists() and mark.read_bytes() == pins.read_bytes()


def install_synapse() -> str:
    """Make the environment of Synapse, running nothing of theirs; return why not, or nothing."""
    if _synapse_is_here():
        return ""
    pins = REQUIREMENTS / "synapse.txt"
    checked = ("--require-hashes", "--only-binary", ":all:", "--requirement", str(pins))
    # By pip, which knows the mirrors that this machine installs from.
    pip = (str(SYNAPSE / "bin" / "python"), "-m", "pip", "install", "--quiet", *checked)
    elsewhere = environment_for_another_python()
    why = _run((sys.executable, "-m", "venv", "--clear", str(SYNAPSE)), elsewhere)
    why = why or _run(pip, elsewhere)
    if not why:
        shutil.copyfile(pins, SYNAPSE / "installed.txt")  # last: half of it does not count
    return why


def missing() -> list[Need]:
    """Return what is not installed."""
    return [need for need in NEEDS if shutil.which(need.command) is None]


def install(packages: list[str]) -> str:
    """Install Debian packages; return why that was not possible, or nothing."""
    if shutil.which("apt-get") is None:
        return "there is no apt-get here"
    as_root: tuple[str, ...] = ()
    if os.geteuid() != 0:
        if shutil.which("sudo") is None:
            return "only root may install, and there is no sudo here"
        as_root = ("sudo", "-n")
    update, add = _APT
    # Old lists may do: only what is installed in the end counts.
    _run((*as_root, "env", "DEBIAN_FRONTEND=noninteractive", *update))
    return _run((*as_root, "env", "DEBIAN_FRONTEND=noninteractive", *add, *packages))


def _run(command: tuple[str, ...], environment: Mapping[str, str] | None = None) -> str:
    try:
        done = subprocess.run(  # noqa: S603 - apt, npm or pip, with names that stand above
            command,
            env=environment,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            errors="replace",
            timeout=WITHIN_S,
            check=False,
        )
    except subprocess.TimeoutExpired:
        return f"{' '.join(command)} took longer than {WITHIN_S:g} s"
    last = done.stdout.strip().splitlines()[-1:]
    return "" if done.returncode == 0 else "; ".join([f"{' '.join(command)} failed", *last])


def main() -> int:
    """Install what is missing; return 1 and say it in one sentence where that cannot be."""
    wanted = missing()
    if not wanted:
        return _status_of_packages()
    packages = [need.package for need in wanted]
    sys.stdout.write(f"Installing {', '.join(packages)}\n")
    sys.stdout.flush()
    why = install(packages)
    lacking = missing()
    if not lacking:
        return _status_of_packages()
    names = ", ".join(f"{need.command} (for {need.what_for})" for need in lacking)
    sys.stderr.write(f"Not installed: {names}: {why or 'apt-get installed something else'}.\n")
    return 1


def _status_of_packages() -> int:
    """Install what needs no distribution; return 1 and say what could not be."""
    whys = {
        "Packages of npm (for clients of rosbridge and of Matrix)": install_packages(),
        "Synapse (for Matrix)": install_synapse(),
    }
    lacking = {what: why for what, why in whys.items() if why}
    for what, why in lacking.items():
        sys.stderr.write(f"{what}: {why}.\n")
    return int(bool(lacking))


if __name__ == "__main__":
    sys.exit(main())
