"""The demonstration, as a script and by hand."""

from __future__ import annotations

import fcntl
import os
import pty
import re
import select
import signal
import struct
import subprocess
import sys
import termios
import time
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from tests.cli.running import ROSIC, environment, rosic, write_config
from tests.pace import pace

if TYPE_CHECKING:
    from collections.abc import Iterator

SCRIPT = """omni move forward 0.5 m
kuka1 grasp
yumi handover
crazyflies takeoff 1 m
status
stop
omni move 1 m
resume omni
omni move 1 m
"""


@pytest.mark.limit(300)
def test_every_life_of_the_demonstration_is_printed() -> None:
    ran = rosic("demo", "--plain", stdin=SCRIPT, within_s=240)

    assert ran.status == 0
    assert ran.err == ""
    assert "\x1b" not in ran.out
    parts = re.split(r"^> .*\n", ran.out, flags=re.MULTILINE)
    move, grasp, handover, takeoff, status, stop, refused, resumed, last = parts[1:]
    for life, who in ((move, "omni"), (grasp, "KUKA iiwa"), (handover, "YuMi")):
        steps = [line.removeprefix(f"{who}: ") for line in life.splitlines()]
        assert steps[0].endswith(": accepted")
        assert steps[1:3] == ["sent", "received by the robot"]
        assert any("%" in step for step in steps[3:-2])
        assert steps[-2].startswith("done ")
        assert "] Again  " in steps[-1]
    assert "moved 0.50 m forward" in move
    assert "object held" in grasp
    assert takeoff.count("received by the robot") == 3
    assert takeoff.count(": done ") == 3
    assert "omni: at rest · taken by you · battery 100 % · x 0.50 m · y 0.00 m" in status
    assert status.count("z 1.00 m") == 3
    assert stop.startswith("STOP: ")
    assert "has not confirmed" not in stop
    assert "omni is stopped, by you" in refused
    assert "accepted" not in refused
    assert resumed == "omni is ready again.\n"
    assert "moved 1.00 m forward" in last
    assert "x 1.50 m · y 0.00 m" in last.partition("At the end:")[2]


@pytest.mark.limit(300)
def test_tasks_that_lines_gave_are_done_before_it_leaves_and_stopped_ones_are_not_waited_for() -> (
    None
):
    lines = "/task omni move 20 cm then move 10 cm\n/tasks\n/task cf1 takeoff 1 m\nstop cf1\n"
    ran = rosic("demo", "--plain", stdin=lines, within_s=150)
    assert (ran.status, ran.err) == (0, "")
    assert "Task 1 (move 20 cm; move 10 cm): done by omni." in ran.out
    at_the_end = ran.out.partition("At the end:")[2]
    assert "omni: at rest" in at_the_end
    assert "x 0.30 m" in at_the_end
    assert "Crazyflie 1: stopped by you" in at_the_end
    assert "Still under way" not in ran.out


def test_without_any_line_it_ends_by_itself() -> None:
    ran = rosic("demo", "--plain", within_s=240)

    assert ran.status == 0
    assert "Six simulated robots" in ran.out
    assert ran.err == ""


def test_a_piped_demonstration_imports_nothing_it_does_not_use() -> None:
    done = subprocess.run(  # noqa: S603 - our own command
        [sys.executable, "-X", "importtime", *ROSIC[1:], "demo", "--plain"],
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        check=True,
        timeout=120 * pace(),
        env=environment(),
    )
    imported = {line.rpartition("|")[2].strip() for line in done.stderr.splitlines()}

    assert {"rosic.app.demo", "rosic_sim.robots.simulation_loop"} <= imported
    heavy = {"alembic", "numpy", "pint", "prompt_toolkit", "rclpy", "sqlalchemy", "telegram"}
    assert heavy.isdisjoint(imported)


@pytest.mark.limit(300)
def test_bad_lines_are_answered_and_hold_nothing_up() -> None:
    lines = [
        "omin move 1 m",
        "omni mvoe 1 m",
        "omni move 40 m",
        "omni move nan m",
        "kuka1 grasp force=-1 N",
        "omni move 1e400 m",
        "omni move 1 parsec",
        "omni move colour=red",
        "\u202etxet",
        "\x1b[2J",
        "x" * 100_000,
        "omni move 10^400 m",
    ]
    ran = rosic("demo", "--plain", stdin="\n".join(lines), within_s=240)

    assert ran.status == 0
    assert ran.err == ""
    assert "accepted" not in ran.out
    assert "x 0.00 m · y 0.00 m" in ran.out.partition("At the end:")[2]
    assert "\x1b" not in ran.out
    answers = re.split(r"^> .*\n", ran.out, flags=re.MULTILINE)[1:]
    assert len(answers) == len(lines)
    assert all(answer.strip() for answer in answers)


# ---- by hand ----


class Hand:
    """A person at a terminal: what they type, and everything that was drawn."""

    def __init__(self, *arguments: str, language: str = "C.UTF-8") -> None:
        self.drawn = ""
        self._master, slave = pty.openpty()
        # A real terminal has a size, and tells where its cursor is when asked; this one does not.
        fcntl.ioctl(slave, termios.TIOCSWINSZ, struct.pack("HHHH", 40, 100, 0, 0))
        self.process = subprocess.Popen(  # noqa: S603 - our own command
            [*ROSIC, *(arguments or ("demo",))],
            stdin=slave,
            stdout=slave,
            stderr=slave,
            start_new_session=True,
            preexec_fn=_make_it_ours,  # noqa: PLW1509 - one system call
            env=environment({"TERM": "xterm", "PROMPT_TOOLKIT_NO_CPR": "1", "LANG": language}),
        )
        os.close(slave)

    def type(self, text: str) -> None:
        os.write(self._master, text.encode())

    def see(self, text: str, within_s: float = 60) -> str:
        """Read until a text was drawn since the last look; return it all, without colours."""
        end_s = time.monotonic() + within_s * pace()
        while text not in plain(self.drawn):
            assert time.monotonic() < end_s, f"no {text!r} in {plain(self.drawn)!r}"
            if select.select([self._master], [], [], 0.1)[0]:
                try:
                    self.drawn += os.read(self._master, 65536).decode(errors="replace")
                except OSError:
                    break  # the other side has closed
        drawn, self.drawn = plain(self.drawn), ""
        assert text in drawn
        return drawn

    def close(self) -> None:
        self.process.kill()
        self.process.wait()
        os.close(self._master)


def _make_it_ours() -> None:
    """Make standard input the terminal of the session, so that Ctrl-C is a signal in between."""
    fcntl.ioctl(0, termios.TIOCSCTTY, 0)


def plain(drawn: str) -> str:
    return re.sub(r"\x1b\[[0-9;?]*[A-Za-z]", "", drawn)


@pytest.fixture
def hand() -> Iterator[Hand]:
    hand = Hand()
    yield hand
    hand.close()


def test_by_hand_it_completes_asks_and_leaves(hand: Hand) -> None:
    hand.see("\n>")
    hand.type("omni mo")
    hand.see("Move in a straight line")
    hand.type("ve 10 cm left\r")
    hand.see("received by the robot")
    hand.see("moved 0.10 m left")
    hand.type("omni move 40 m\r")
    hand.see("] omni move 5 m")
    hand.type("use omni\r")
    hand.see("] STOP")
    hand.type("\x04")
    hand.see("Left. Nothing was kept.")
    assert hand.process.wait(60) == 0


def test_whoever_was_sent_a_picture_reads_on_leaving_where_it_lies(hand: Hand) -> None:
    hand.see("\n>")
    hand.type("picture omni\r")
    hand.see("It lies in ")
    hand.type("\x04")
    left = " ".join(hand.see("then rosic run").split())
    assert "nothing else was kept" in left
    folder = re.search(r"What you were sent lies in (/\S+);", left)
    assert folder, left
    assert [file.name for file in Path(folder[1]).iterdir()] == ["omni.jpg"]


def test_at_a_german_terminal_it_speaks_german_until_somebody_chooses() -> None:
    hand = Hand(language="de_DE.UTF-8")
    try:
        assert "English: /language en" in hand.see("\n>")
        hand.type("omni turn 5 Grad\r")
        hand.see("5 Grad nach links gedreht")
        hand.type("bogus\r")
        hand.see("Sag hilfe, dann")
        hand.type("\x03")
        drawn = " ".join(hand.see("alle").split())
        assert "wieder bewegen: freigeben alle" in drawn
        assert "STOP geschickt an KUKA iiwa, omni, " in drawn
        assert "omni steht still" in drawn
        assert "Noch einmal Strg-C beendet ROSIC." in drawn
        hand.type("zustand omni\r")
        hand.see("angehalten von dir")
        hand.type("/language en\r")
        hand.see("Saved.")
        hand.type("resume omni\r")
        hand.see("is ready again.")
        hand.type("omni turn 5 deg\r")
        hand.see("turned 5 deg left")
    finally:
        hand.close()


def test_a_piped_demonstration_is_english_whatever_the_terminal_is_set_to() -> None:
    ran = rosic("demo", "--plain", stdin="/settings language\n", env={"LANG": "de_DE.UTF-8"})

    assert "Deutsch: /language de" in ran.out
    assert "Language: English. I speak English and Deutsch." in ran.out


@pytest.mark.limit(300)
def test_in_a_pipe_whoever_chose_german_reads_german_to_the_end() -> None:
    lines = "/language de\nomni fahre 20 cm\n/me\nstopp cf1\n"
    ran = rosic("demo", "--plain", stdin=lines, within_s=240)

    at_the_end = ran.out.partition("Am Ende:")[2]
    assert "omni: steht still · vergeben an Gast · Akku" in at_the_end
    assert "Crazyflie 1: angehalten von Gast" in at_the_end
    assert "Du bist Gast." in ran.out


def test_tab_completes_with_the_blank_that_follows(hand: Hand) -> None:
    hand.see("\n>")
    hand.type("omni mov")
    hand.see("Move in a straight line")
    hand.type("\t10 cm lef")
    hand.see("direction")
    hand.type("\t\r")
    drawn = hand.see("moved 0.10 m left")
    assert re.search(r"driving (5|6)\d %", drawn), "a drive says how far it is"


def test_the_first_ctrl_c_brings_every_robot_to_rest_and_a_second_one_leaves(hand: Hand) -> None:
    hand.see("\n>")
    hand.type("omni move 5 m\r")
    hand.see("received by the robot")
    hand.type("omni tu")
    hand.see("Turn on the spot")
    hand.type("\x03")
    drawn = hand.see("Ctrl-C again ends ROSIC.")
    assert "STOP sent to " in drawn
    assert "omni at rest" in " ".join(drawn.split())
    hand.type("status omni\r")
    hand.see("stopped")
    hand.type("\x03")
    hand.see("Ctrl-C again ends ROSIC.")
    hand.type("\x03")
    hand.see("Left.")
    assert hand.process.wait(60) == 0


def test_drones_that_fly_are_said_to_have_landed_before_it_is_left(hand: Hand) -> None:
    hand.see("\n>")
    hand.type("crazyflies takeoff 1 m\r")
    hand.see("Crazyflie 3: done")
    hand.type("\x04")
    drawn = " ".join(hand.see("Left. Nothing was kept.").split())
    assert "STOP sent to Crazyflie 1, Crazyflie 2, Crazyflie 3." in drawn
    assert drawn.count("on the ground (") == 3
    assert hand.process.wait(60 * pace()) == 0


def test_a_signal_ends_it(hand: Hand) -> None:
    hand.see("\n>")
    hand.process.send_signal(signal.SIGTERM)

    assert hand.process.wait(60) == 0


@contextmanager
def _run(folder: Path) -> Iterator[Hand]:
    hand = Hand("run", "-c", str(write_config(folder)))
    try:
        assert "Ctrl-C stops every robot." in hand.see("\n>", within_s=120)
        yield hand
    finally:
        hand.close()


def test_at_the_prompt_of_a_gateway_ctrl_c_stops_and_what_is_typed_then_is_heard(
    tmp_path: Path,
) -> None:
    with _run(tmp_path) as hand:
        hand.type("omni move 5 m speed 0.05 m/s\r")
        hand.see("driving")
        hand.type("\x03")
        assert "omni at rest" in " ".join(hand.see("Ctrl-C again ends ROSIC.").split())
        hand.type("resume omni\r")
        hand.see("omni is ready again.")
        hand.type("omni move 5 m speed 0.05 m/s\r")
        hand.see("driving")
        hand.type("stop\r")
        hand.see("STOP: omni at rest")
        hand.type("\x03")
        hand.see("Ctrl-C again ends ROSIC.")
        hand.type("\x03")
        assert hand.process.wait(60 * pace()) == 0


def test_ctrl_d_ends_a_gateway_whose_only_messenger_is_the_terminal(tmp_path: Path) -> None:
    with _run(tmp_path) as hand:
        hand.type("\x04")
        assert hand.process.wait(60 * pace()) == 0
