"""`rosic` itself: quick, and never a trace for something a person can mistype."""

from __future__ import annotations

import os
import resource
import signal
import subprocess
import sys

import pytest

import rosic as package
from rosic.cli.main import COMMANDS, main
from tests.cli.running import ROSIC, cold_rosic, environment, rosic
from tests.pace import pace

# Half of what is allowed: the rest is for a slower machine.
CPU_S = 0.25


def test_help_names_every_command() -> None:
    for words in ([], ["--help"], ["-h"], ["help"]):
        ran = rosic(*words)

        assert ran.status == 0
        assert ran.err == ""
        assert all(f"  {name} " in ran.out for name in COMMANDS)


def test_help_costs_next_to_nothing() -> None:
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    ran = cold_rosic("--help")
    after = resource.getrusage(resource.RUSAGE_CHILDREN)

    assert ran.status == 0
    spent_s = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    assert spent_s < CPU_S


def test_help_imports_nothing_heavy() -> None:
    done = subprocess.run(  # noqa: S603 - our own command
        [sys.executable, "-X", "importtime", *ROSIC[1:], "--help"],
        capture_output=True,
        text=True,
        check=True,
        timeout=120 * pace(),
        env=environment(),
    )
    imported = {line.rpartition("|")[2].strip() for line in done.stderr.splitlines()}

    assert "rosic.cli.main" in imported
    heavy = {"asyncio", "argparse", "msgspec", "prompt_toolkit", "sqlalchemy", "pint", "rosic.app"}
    assert heavy.isdisjoint(imported)


@pytest.mark.parametrize("name", sorted(COMMANDS))
def test_every_command_has_help_and_turns_nonsense_away(
    name: str, capsys: pytest.CaptureFixture[str]
) -> None:
    for word, status in (("--help", 0), ("--nonsense", 2)):
        with pytest.raises(SystemExit) as ended:
            main([*name.split(), word])
        assert ended.value.code == status

    said = capsys.readouterr()
    assert said.out.startswith(f"usage: rosic {name} ")
    assert f"rosic {name}: error: " in said.err


def test_a_mistyped_command_is_answered_with_the_one_meant() -> None:
    assert rosic("rnu") == (2, "", "rosic: There is no command 'rnu'. Did you mean run?\n")
    assert rosic("xyzzy") == (2, "", "rosic: There is no command 'xyzzy'. See: rosic --help\n")


def test_robot_alone_says_what_can_follow() -> None:
    ran = rosic("robot")

    assert ran.status == 2
    assert "robot check" in ran.err
    assert "doctor" not in ran.err


def test_its_version() -> None:
    assert rosic("--version").out == f"rosic {package.__version__}\n"


UNREAD = 128 + signal.SIGPIPE


@pytest.mark.limit(150)
@pytest.mark.parametrize(
    ("arguments", "script", "lines"),
    [
        (("demo", "--plain"), "", 1),
        (("demo", "--plain"), "omni move 1 m\nkuka1 grasp\nstatus\n", 9),
        (("demo", "fleet", "--plain", "--fast"), "", 3),
        (("--help",), "", 1),
    ],
)
def test_who_reads_the_first_lines_alone_hears_of_nothing_else(
    arguments: tuple[str, ...], script: str, lines: int
) -> None:
    with subprocess.Popen(  # noqa: S603 - our own command
        [*ROSIC, *arguments],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env=environment(),
    ) as process:
        assert process.stdin is not None
        assert process.stdout is not None
        assert process.stderr is not None
        process.stdin.write(script)
        process.stdin.flush()
        for _ in range(lines):
            assert process.stdout.readline()
        process.stdout.close()
        process.stdin.close()  # now alone: what it says at its end is still to come
        said = process.stderr.read()
        status = process.wait(120)

    assert said == ""
    assert status in ({UNREAD} if arguments[0] == "demo" else {UNREAD, 0})


def test_a_reader_who_goes_away_causes_no_trace() -> None:
    reading, writing = os.pipe()
    os.close(reading)
    with os.fdopen(writing, "w") as gone:
        done = subprocess.run(  # noqa: S603 - our own command
            [*ROSIC, "--help"],
            stdout=gone,
            stderr=subprocess.PIPE,
            text=True,
            check=False,
            timeout=120 * pace(),
            env=environment(),
        )

    assert done.stderr == ""
    assert done.returncode == UNREAD
