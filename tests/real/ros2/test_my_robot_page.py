"""The guide for a robot of one's own, followed command by command."""

from __future__ import annotations

import os
import re
import shlex
import subprocess
import time
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import pytest

from rosic.config.profiles import check_profile
from rosic.robots.ros2.interfaces.cache import KNOWN, ensure_built
from tests.cli.running import ROSIC, gateway
from tests.pace import pace
from tests.real.ros2.simulated import simulated

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rosic.testing.ros2.graph import RosGraph
    from tests.cli.running import Gateway

PAGES = Path(__file__).parents[3] / "docs" / "robots"
BLOCK = re.compile(r"^```(\w+)(?: (.*?))?\n(.*?)^```$", re.MULTILINE | re.DOTALL)


class Block(NamedTuple):
    """One block of the page: its language, what stands beside that, its lines."""

    language: str
    about: str
    lines: list[str]


def blocks(page: str) -> list[Block]:
    text = (PAGES / page).read_text(encoding="utf-8")
    return [Block(one, two or "", three.splitlines()) for one, two, three in BLOCK.findall(text)]


@pytest.fixture
def folder(graph: RosGraph, tmp_path: Path, interfaces: Path) -> Iterator[Path]:  # noqa: ARG001 - built before
    for package in KNOWN.values():
        ensure_built(package)
    [command] = [line for b in blocks("my-robot.md") if b.about == "sim" for line in b.lines]
    here = tmp_path / "here"
    here.mkdir()
    with simulated(graph, tmp_path, *command.removeprefix("rosic sim ").split()):
        yield here


@pytest.mark.limit(300)
def test_the_guide_works_command_by_command(folder: Path) -> None:
    done = []
    for block in blocks("my-robot.md"):
        if block.language == "sh" and not block.about:
            for line in block.lines:
                ran = run(line, folder)
                assert ran.returncode == 0, (line, ran.stdout, ran.stderr)
                assert "not measured: stop" not in ran.stdout
        elif block.language == "diff":
            edit(folder / block.about, block.lines)
        elif block.language == "chat":
            speak(folder, block.lines)
        done.append(block.about or block.language)
    assert done.count("sh") == 3
    assert "chat" in done


def run(line: str, folder: Path) -> subprocess.CompletedProcess[str]:
    name, *arguments = shlex.split(line)
    assert name == "rosic"
    return subprocess.run(  # noqa: S603 - the page's own commands
        [*ROSIC, *arguments],
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
        timeout=120 * pace(),
        env=dict(os.environ),
        stdin=subprocess.DEVNULL,
    )


def edit(file: Path, lines: list[str]) -> None:
    """Change a file as the page says, where it says; each place is there once."""
    before = "".join(f"{line[1:]}\n" for line in lines if line[0] != "+")
    after = "".join(f"{line[1:]}\n" for line in lines if line[0] != "-")
    text = file.read_text(encoding="utf-8")
    assert text.count(before) == 1, (file.name, before, text)
    file.write_text(text.replace(before, after), encoding="utf-8")


def speak(folder: Path, lines: list[str]) -> None:
    """Say each line that is not indented, and wait for what is, in what comes after it."""
    with gateway(folder / "rosic.toml", dict(os.environ)) as running:
        seen = 0
        for line in lines:
            if not line.startswith(" "):
                seen = len(running.out())
                running.say(line)
            else:
                wait_for(running, line.strip(), seen)


def wait_for(running: Gateway, text: str, seen: int) -> None:
    end_s = time.monotonic() + 60 * pace()
    while text not in running.out()[seen:]:
        assert time.monotonic() < end_s, f"no {text!r} in: {running.out()[seen:]}{running.err()}"
        assert running.process.poll() is None
        time.sleep(0.05)


@pytest.mark.parametrize("page", ["nav2.md", "arm.md"])
def test_the_profiles_that_are_shown_are_good(page: str, tmp_path: Path) -> None:
    shown = [block for block in blocks(page) if block.language == "yaml"]
    assert len(shown) == 1
    file = tmp_path / "robot.yaml"
    file.write_text("\n".join(shown[0].lines), encoding="utf-8")
    assert [str(error) for error in check_profile(file)] == []
