"""The plays of `rosic demo NAME`: each ends by itself, and its summary is what really happened."""

from __future__ import annotations

import re
import signal
import subprocess
import time
from concurrent.futures import ThreadPoolExecutor
from typing import TYPE_CHECKING

import pytest
from PIL import Image

from rosic.core.message import Chat, Outbound
from rosic.rendering.style import SEVERAL
from rosic.system import SystemClock, SystemEntropy
from rosic_sim.robots.simulation_loop import simulation_of
from rosic_sim.scenarios.registry import NAMES, play_named
from rosic_sim.scenarios.runner import FastClock, ScenarioOptions, play
from rosic_sim.scenarios.scenario import ScenarioMismatch
from rosic_sim.scenarios.terminal_view import TerminalView
from tests.cli.running import ROSIC, Ran, environment, rosic
from tests.cli.terminal import rosic_at
from tests.pace import pace

if TYPE_CHECKING:
    from pathlib import Path

    from rosic_sim.scenarios.scenario import ScenarioRunner

WITHIN_S = 300.0
SUMMARY = "What happened, by the record and by the robots\n"
PLACE = re.compile(r"^  (?P<shown>.+?): .* x (?P<x>-?[\d.]+) m · y (?P<y>-?[\d.]+) m", re.MULTILINE)


@pytest.fixture(scope="module")
def ran(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Ran]:
    """Run every play at once, four times as fast, as a person does."""
    files = {"TMPDIR": str(tmp_path_factory.mktemp("pictures"))}

    def run(name: str) -> Ran:
        return rosic("demo", name, "--plain", "--fast", within_s=WITHIN_S, env=files)

    with ThreadPoolExecutor(len(NAMES)) as pool:
        return dict(zip(NAMES, pool.map(run, NAMES), strict=True))


@pytest.mark.limit(400)
@pytest.mark.parametrize("name", NAMES)
def test_a_play_ends_by_itself_and_sums_up_what_was_told(ran: dict[str, Ran], name: str) -> None:
    status, out, err = ran[name]
    assert (status, err) == (0, ""), out
    assert "\x1b" not in out
    told, _, summary = out.partition(SUMMARY)
    assert "did not go as written" not in out
    assert int(number(r"(\d+) orders? accepted: ", summary)) == told.count(": accepted")
    for ending, words in (("done", r": done \d\d:"), ("cancelled", ": stopped before it ended ")):
        found = re.search(rf"(\d+) {ending}", summary.splitlines()[1])
        assert int(found[1] if found else 0) == len(re.findall(words, told)), ending
    assert "doing" not in summary, "nothing moves any more"
    assert summary.count(": at rest · ") + summary.count(": stopped by ") == robots(name)


@pytest.mark.parametrize(
    ("name", "went"), [("one-to-one", 1), ("class", 0), ("fleet", 3), ("shift", 3), ("swarm", 5)]
)
def test_a_play_ends_with_a_picture_of_what_moved(
    ran: dict[str, Ran], name: str, went: int
) -> None:
    file = re.search(r"A picture of what moved\. It lies in (\S+): only you", ran[name].out)
    assert file
    with Image.open(file[1]) as picture:
        raw = picture.convert("RGB").tobytes()
    pixels = set(zip(raw[::3], raw[1::3], raw[2::3], strict=True))
    shown = [colour for colour in SEVERAL if colour in pixels]
    if went:
        assert shown == list(SEVERAL[:went]), "one colour for each robot that went somewhere"
    else:
        assert not set(SEVERAL) <= pixels
        assert len(pixels) > 1_000, "the arm itself, which goes nowhere"


def robots(name: str) -> int:
    return len(play_named(name).profiles())


def number(pattern: str, text: str) -> str:
    found = re.search(pattern, text)
    assert found, text
    return found[1]


def test_what_the_class_sums_up_is_what_was_told(ran: dict[str, Ran]) -> None:
    lesson = ran["class"].out
    until = number(r"KUKA iiwa is at rest, and Student 2's until ([\d:]+)\.", lesson)
    assert f"KUKA iiwa is yours now, until {until}." in lesson
    assert "KUKA iiwa: at rest · taken by Student 2\n" in lesson, "their time is not over"
    assert "stopped before it ended" in lesson
    assert "Nobody said stop." in lesson, "what is taken over is ended, and nothing is stopped"


def test_what_each_play_is_about_really_happened(ran: dict[str, Ran]) -> None:
    forest, lesson, fleet, shift, swarm = (ran[name].out for name in NAMES)
    assert "recalibrated; the sensor was -24.0 °C off" in forest
    assert "ALARM · Forest watch: It is hotter here than a forest should be." in forest
    assert re.search(r"\(watch\.jpg, \d+ kB\)", forest)
    late = re.search(
        r"Go to a place: took ([\d.]+) s, expected 3\.0 s · \1 s instead of 4\.2 s", forest
    )
    assert late
    assert float(late[1]) > 4.2

    assert (
        "21 requests refused: 19 because the robot was somebody else's at that time, "
        "1 because a value was out of its bounds, "
        "1 because taking it over from somebody had to be said."
    ) in lesson
    who = "Student 1 (1 order), Student 2 (1 order), Teacher (1 order)"
    assert f"KUKA iiwa worked for {who}." in lesson
    assert "You can have it then." in lesson

    assert "moved 1 time.\n" in fleet
    assert fleet.count("moved 1 time") == 1
    assert fleet.count("The task goes to another robot. 1 of 2 steps are done and stay so.") == 1
    assert "Restock the shelves is begun as restock-5 · 3 tasks" in fleet
    assert re.search(r"1: restock begins by itself, next .*08:00", fleet)
    assert re.search(r"of 3 robots are free\.\n(.*\n){3,4} +as of .*\n +\[ Look again \]", fleet)
    last = fleet.index(": goto, x 0.00 m, y 0.00 m · task 7: accepted")
    assert max(fleet.index(f"Task {n} (goto x=0.6") for n in (5, 6)) < last, "when both are there"
    assert fleet.partition(SUMMARY)[2].count("done, 1 of 1 step done") == 4

    # Of three steps; how many were begun before the hand-over depends on the machine's pace.
    assert re.search(
        r"Carrier 1 worked for North manager \([12] orders?\), Night manager \([12] orders?\)",
        shift,
    )

    helped = re.search(r"(Rover \d) helps (Rover \d) \(stuck in the mud\)\.", swarm)
    assert helped
    assert f"Task 1 goes from {helped[2]} to {helped[1]}." in swarm
    assert f"Task 2 (goto x=3.5 y=-0.5): {helped[2]} goes on with it." in swarm
    assert re.search(r'Crazyflie 1 shares seen: .*"a coat"\}\n +\[ Silence Crazyflie 1 \]', swarm)
    assert f"{helped[2]} has taken on: Careful (speed 0.2 m/s)." in swarm
    assert "Stopped: Crazyflie 1, Crazyflie 2, Crazyflie 3, Rover 1, Rover 2." in swarm
    assert swarm.partition(SUMMARY)[2].count("z 0.00 m") == 3


@pytest.mark.limit(300)
async def test_the_summary_is_where_the_machines_are(capsys: pytest.CaptureFixture[str]) -> None:
    clock = FastClock(SystemClock(), 8.0)
    assert await play(play_named("shift"), ScenarioOptions(plain=True), clock, SystemEntropy()) == 0
    machines = simulation_of(clock).world.machines
    summary = capsys.readouterr().out.partition(SUMMARY)[2]
    seen = {found["shown"]: (found["x"], found["y"]) for found in PLACE.finditer(summary)}
    assert len(seen) == 3
    for shown, (x, y) in seen.items():
        told = machines[shown.casefold().replace(" ", "")].telemetry()
        assert abs(float(x) - float(told["x_m"])) < 0.01
        assert abs(float(y) - float(told["y_m"])) < 0.01


@pytest.mark.limit(300)
async def test_a_play_that_goes_wrong_says_so_and_fails(
    capsys: pytest.CaptureFixture[str],
) -> None:
    async def script(stage: ScenarioRunner) -> None:
        await stage.says("Ranger", "watch goto x=0.1 y=0", hears="done ")
        raise ScenarioMismatch("Nobody came.")

    odd = play_named("one-to-one")._replace(script=script)
    clock = FastClock(SystemClock(), 8.0)
    assert await play(odd, ScenarioOptions(plain=True), clock, SystemEntropy()) == 1
    out = capsys.readouterr().out
    assert "This did not go as written. Nobody came." in out
    assert "1 order accepted: 1 done." in out


def test_what_is_longer_than_the_terminal_is_broken_between_words(
    capsys: pytest.CaptureFixture[str],
) -> None:
    long = "Task 2 (goto x=1.2 y=0; goto x=0.2 y=0): Carrier 3 has failed at it. It is stopped."
    narrow = TerminalView(["Ada"], lambda: 1.0, colour=True, columns=60)
    narrow.told("Ada", Outbound(chat=Chat(platform="phones", id="a"), text=f"{long}\n\nOmni: done"))
    narrow.plain(f"  {long}")
    narrow.aside(long)
    lines = re.sub(r"\x1b\[[\d;]*m", "", capsys.readouterr().out).splitlines()
    assert max(map(len, lines)) < 60
    assert " ".join(" ".join(lines).split()).count(long) == 3, "no word is cut, and none is lost"
    wide = TerminalView(["Ada"], lambda: 1.0, colour=False)
    wide.told("Ada", Outbound(chat=Chat(platform="phones", id="a"), text=long))
    assert f"            {long}\n" in capsys.readouterr().out


@pytest.mark.limit(300)
def test_a_newcomer_acts_as_somebody_with_their_rights() -> None:
    lines = "carrier1 goto x=0.2 y=0\ncarrier3 goto x=0.2 y=-0.6\n"
    done = rosic(
        "demo", "shift", "--interactive", "--as", "south manager", "--plain", "--fast", stdin=lines
    )
    assert (done.status, done.err) == (0, "")
    assert "You are: South manager." in done.out
    assert 'I do not know "carrier1".' in done.out
    assert "1 order accepted: 1 done." in done.out
    assert "Carrier 3 worked for South manager (1 order)." in done.out


@pytest.mark.limit(300)
def test_a_student_who_stops_the_arm_can_let_it_go_on() -> None:
    lines = "stop\nkuka1 home\nresume kuka1\nkuka1 home\n"
    asked = ("demo", "class", "--interactive", "--as", "student 2", "--plain", "--fast")
    done = rosic(*asked, stdin=lines)
    assert (done.status, done.err) == (0, "")
    assert "KUKA iiwa is ready again." in done.out
    assert "1 order accepted: 1 done." in done.out


@pytest.mark.limit(300)
def test_tasks_and_missions_of_piped_lines_are_done_before_it_sums_up() -> None:
    lines = "/task carriers goto x=0.4 y=0.4 then goto x=0 y=0.4\n/mission start restock\n/fleet\n"
    done = rosic("demo", "fleet", "--interactive", "--plain", "--fast", stdin=lines)
    assert (done.status, done.err) == (0, "")
    told, _, summary = done.out.partition(SUMMARY)
    assert "] Look again" in told
    assert summary.count("Task ") == summary.count(": done, ") == 4
    assert "5 orders accepted: 5 done." in summary


@pytest.mark.limit(300)
def test_drones_that_hover_are_ready_for_a_common_start_and_for_tasks() -> None:
    lines = (
        "crazyflies takeoff 1 m\n/together crazyflies formation line\n/fleet crazyflies\n"
        "/task cf1 goto x=1 y=0.6 z=1\n"
    )
    done = rosic("demo", "swarm", "--interactive", "--plain", "--fast", stdin=lines)
    assert (done.status, done.err) == (0, "")
    assert "not all are ready" not in done.out
    shown = done.out.partition("> /fleet")[2].partition("> /task")[0]
    assert "moving without a task" not in shown, "they hover"
    told, _, summary = done.out.partition(SUMMARY)
    assert told.count(": formation, 0.60 m line: accepted") == 3
    assert "Task 1: done, 1 of 1 step done." in summary


@pytest.mark.limit(300)
async def test_drones_go_on_hovering_where_a_busy_machine_has_no_processor_for_a_moment(
    capsys: pytest.CaptureFixture[str],
) -> None:
    """However fast a play is, the process stands still no faster than it does."""

    async def script(stage: ScenarioRunner) -> None:
        drones = [stage.world.machines[name] for name in ("cf1", "cf2", "cf3")]
        await stage.says("Search leader", "crazyflies takeoff 1 m", hears="accepted")
        await stage.quiet()
        for _ in range(3):
            stand_still(0.4)
            await stage.clock.sleep(1.0)
        assert [drone.note for drone in drones] == ["", "", ""]
        assert all(drone.holding for drone in drones)

    hovering = play_named("swarm")._replace(script=script)
    assert (
        await play(hovering, ScenarioOptions(plain=True, fast=True), SystemClock(), SystemEntropy())
        == 0
    )
    assert "link lost" not in capsys.readouterr().out


def stand_still(seconds: float) -> None:
    """Take the machine's time, in which nothing else in this process is done."""
    time.sleep(seconds)


@pytest.mark.limit(300)
def test_ctrl_c_does_not_wait_for_the_tasks_of_piped_lines() -> None:
    asked = [*ROSIC, "demo", "fleet", "--interactive", "--plain"]
    with subprocess.Popen(  # noqa: S603 - our own command
        asked, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, env=environment()
    ) as process:
        assert process.stdin is not None
        assert process.stdout is not None
        process.stdin.write("/task carrier1 goto x=5 y=0\n")
        process.stdin.close()
        for line in process.stdout:
            if "driving" in line:
                break
        process.send_signal(signal.SIGINT)
        assert process.wait(60) == 130
        assert "Every robot is at rest." in process.stdout.read()


def test_who_and_what_is_unknown_is_said() -> None:
    watching = rosic("demo", "class", "--as", "student 2")
    assert (watching.status, watching.out) == (2, "")
    assert "you only watch" in watching.err
    assert 'rosic demo class --interactive --as "student 2"' in watching.err
    wrong = rosic("demo", "fleet", "--as", "the cat")
    assert (wrong.status, wrong.out) == (2, "")
    assert "Nobody in this play is called 'the cat'. There are: Manager." in wrong.err
    assert rosic("demo", "opera").status == 2
    assert "say which play" in rosic("demo", "--fast").err


def test_a_ctrl_c_in_a_play_brings_its_robots_to_rest_and_a_second_one_ends_it(
    tmp_path: Path,
) -> None:
    with rosic_at(["demo", "class", "--interactive"], tmp_path) as seat:
        seat.wait_for("Ctrl-D leaves.")
        seat.type("kuka1 grasp force=10")
        seat.wait_for("approaching 0 %")
        while "STOP sent to" not in seat.shown:  # a key that comes while something is drawn is lost
            assert seat.process.poll() is None, seat.shown
            seat.type("", end="\x03")
            heard_by_s = time.monotonic() + 2 * pace()
            while "STOP sent to" not in seat.shown and time.monotonic() < heard_by_s:
                seat.look(0.1)
        seat.wait_for("iiwa at rest")
        seat.wait_for("Ctrl-C again ends ROSIC.")
        while seat.process.poll() is None:  # likewise
            seat.type("", end="\x03")
            seat.look(0.5)
        assert seat.ended() == 0


def test_whoever_leaves_while_something_moves_reads_its_end_before_the_summary(
    tmp_path: Path,
) -> None:
    with rosic_at(["demo", "class", "--interactive", "--plain"], tmp_path) as seat:
        seat.wait_for("type 1 to tap it")
        seat.wait_for("Ctrl-D leaves.")
        seat.type("kuka1 grasp force=10")
        seat.wait_for("approaching 0 %")
        seat.type("", end="\x04")
        assert seat.ended() == 0
        told, _, summary = seat.shown.partition("What happened, by the record and by the robots")
    assert "KUKA iiwa: stopped before it ended" in told
    assert "KUKA iiwa at rest" in told
    assert "1 order accepted: 1 cancelled." in summary
    assert "doing" not in summary
    assert "[1]" not in told.partition("STOP sent to")[2] + summary, "nobody can tap it any more"
