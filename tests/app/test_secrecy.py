"""Secrets stay in memory: no core dump, no debugger; and nobody else writes what is believed."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from rosic.app.setup.check import check_all
from rosic.cli.main import main
from rosic.config.secrets import open_to_others
from rosic.errors import ConfigurationError
from rosic.system import SystemClock
from tests.cli.running import CONFIG, rosic, write_config

MEMORY = CONFIG.replace('"simulated"', '"memory"')
LINUX = pytest.mark.skipif(sys.platform != "linux", reason="only Linux keeps core dumps out")
DIES = """
import ctypes, os, resource
resource.setrlimit(resource.RLIMIT_CORE, (resource.getrlimit(resource.RLIMIT_CORE)[1],) * 2)
from rosic.app.logging import keep_memory_private
print(keep_memory_private(), resource.getrlimit(resource.RLIMIT_CORE), flush=True)
print(ctypes.CDLL(None).prctl(3, 0, 0, 0, 0), flush=True)
os.abort()
"""
LOOKS = """
import sys
import rosic.app.runtime, rosic.cli.gateway as command
def run(coroutine):
    coroutine.close()
    import ctypes, resource
    print(ctypes.CDLL(None).prctl(3, 0, 0, 0, 0), resource.getrlimit(resource.RLIMIT_CORE)[0])
command.runtime.run = run
sys.exit(command.run(["-c", sys.argv[1]]))
"""


def python(program: str, *arguments: str, cwd: Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run(  # noqa: S603 - our own program
        [sys.executable, "-c", program, *arguments],
        capture_output=True,
        text=True,
        check=False,
        cwd=cwd,
    )


@LINUX
def test_what_dies_leaves_no_core_dump(tmp_path: Path) -> None:
    ran = python(DIES, cwd=tmp_path)
    assert ran.returncode == -signal.SIGABRT
    assert ran.stdout == "True (0, 0)\n0\n"
    assert list(tmp_path.iterdir()) == []


@LINUX
def test_a_gateway_is_not_dumpable_before_anything_is_opened(tmp_path: Path) -> None:
    assert python(LOOKS, str(write_config(tmp_path, MEMORY)), cwd=tmp_path).stdout == "0 0\n"


@LINUX
def test_the_doctor_says_so(tmp_path: Path) -> None:
    said = rosic("doctor", "-c", write_config(tmp_path, MEMORY)).out
    assert "memory     a gateway leaves no core dump, and no debugger in" in said
    assert "files      nobody else may write what it is started with" in said


@pytest.mark.parametrize("what", ["rosic.toml", "."])
def test_what_everybody_may_write_starts_nothing(tmp_path: Path, what: str) -> None:
    config = write_config(tmp_path, MEMORY)
    path = tmp_path / what
    path.chmod(path.stat().st_mode | 0o002)
    ran = rosic("run", "-c", config)
    assert ran.status == 2
    assert f"{path.resolve()} may be written by everybody on this machine." in ran.err
    assert f"Run: chmod o-w {path.resolve()}" in ran.err
    assert not (tmp_path / "rosic-data").exists()
    assert rosic("check", "-c", config).status == 2
    assert "files      look at this: The f" in rosic("doctor", "-c", config).out


def test_a_profile_that_everybody_may_write_is_found(tmp_path: Path) -> None:
    profile = tmp_path / "profiles" / "mine.yaml"
    profile.parent.mkdir()
    shipped = Path(main.__code__.co_filename).parents[1] / "robots/profiles/omni.yaml"
    profile.write_text(shipped.read_text().replace("id: omni", "id: mine"))
    config = write_config(tmp_path, MEMORY.replace('"omni"', '"profiles/mine.yaml"'))
    assert not [e for e in check_all(config, SystemClock()).errors if "everybody" in str(e)]
    profile.chmod(0o666)
    [said] = [e for e in check_all(config, SystemClock()).errors if "everybody" in str(e)]
    assert "mine.yaml" in str(said)


def test_a_group_or_another_owner_is_said_and_not_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    config = write_config(tmp_path, MEMORY)
    config.chmod(0o664)
    os.chown(config, -1, os.getegid())
    monkeypatch.setattr(os, "geteuid", lambda: config.stat().st_uid + 1)
    found = [one for one in open_to_others([config]) if str(config) in str(one.error)]
    if config.stat().st_uid:
        [one] = found
        assert "belongs to another user" in str(one.error)
        assert not one.everybody
    assert all(isinstance(one.error, ConfigurationError) for one in found)


def test_a_folder_as_tmp_is_no_danger(tmp_path: Path) -> None:
    config = write_config(tmp_path, MEMORY)
    tmp_path.chmod(0o1777)
    assert not [one for one in open_to_others([config]) if one.everybody]
