"""`rosic doctor`: figures that were measured, and an honest word where none was."""

from __future__ import annotations

import re
import signal
import subprocess
from typing import TYPE_CHECKING

import pytest
from msgspec.structs import replace

from rosic.app.admin.control_socket import AdminAnswer
from rosic.app.admin.dispatch import NOT_KEPT
from rosic.app.builder import latch_of
from rosic.app.config import load_config
from rosic.app.robot_startup import stops_of
from rosic.app.setup.diagnostics import examine, verdict_of
from rosic.app.setup.diagnostics_checks import (
    SLOW_MS,
    DiagnosticFinding,
    FindingVerdict,
    examine_clock,
    examine_disk,
)
from rosic.app.setup.stop_test import StopTest, slow_arguments, streaming_skill, try_robot
from rosic.config.profiles import load_profile, shipped_profiles
from rosic.core.order_gate import OrderGate
from rosic.core.records import Stopped
from rosic.errors import RobotOffline
from rosic.stores.database import DatabaseStore
from rosic.system import SystemClock, SystemEntropy
from rosic_sim.robots.robot import SimulatedRobot
from tests.cli.running import ROSIC, environment, gateway, rosic, write_config, write_neighbours

if TYPE_CHECKING:
    from pathlib import Path

    from rosic.contracts.robot import Tell
    from rosic.core.order import Order, RestReport, Stop


def test_the_disk_is_measured_and_left_as_it_was(tmp_path: Path) -> None:
    disk, record, space = examine_disk(tmp_path)

    figures = re.fullmatch(
        r"fsync (\S+) ms p50, (\S+) ms p99 over \d+ writes of 4 KiB"
        r"(\. Every command waits for this\.)?",
        disk.text,
    )
    assert figures is not None
    assert 0 < float(figures[1]) <= float(figures[2])
    if figures[3]:  # a busy machine may be that slow, and is told so
        assert (disk.verdict, float(figures[2]) >= SLOW_MS) == (FindingVerdict.LOOK, True)
    else:
        assert (disk.verdict, float(figures[2]) <= SLOW_MS) == (FindingVerdict.GOOD, True)
    assert record == DiagnosticFinding(
        "record", FindingVerdict.GOOD, "journal mode wal, synchronous 2 (2 is FULL), as read back"
    )
    assert "GB free" in space.text
    assert list(tmp_path.iterdir()) == []


def test_a_folder_that_is_not_there_yet_is_measured_beside(tmp_path: Path) -> None:
    disk, *_ = examine_disk(tmp_path / "rosic-data")

    assert f"measured in {tmp_path}" in disk.text


async def test_robots_that_share_a_namespace_are_pointed_out(tmp_path: Path) -> None:
    config = load_config(write_neighbours(tmp_path))
    clock, entropy = SystemClock(), SystemEntropy()
    found = [finding async for finding in examine(config, clock=clock, entropy=entropy)]
    [said] = [finding for finding in found if finding.about == "robots"]
    assert said.verdict is FindingVerdict.LOOK
    assert said.text.startswith("ant and bee have one namespace, /hill: ")


class BackwardsClock(SystemClock):
    """Its monotonic clock is not."""

    def __init__(self) -> None:
        self._readings = 0

    def monotonic_ns(self) -> int:
        self._readings += 1
        return super().monotonic_ns() - (10**9 if self._readings % 5000 == 0 else 0)


async def test_a_clock_that_goes_back_is_noticed() -> None:
    assert (await examine_clock(SystemClock())).verdict is FindingVerdict.GOOD

    bad = await examine_clock(BackwardsClock())

    assert bad.verdict is FindingVerdict.LOOK
    assert "went back 20 times" in bad.text


def test_a_trial_is_slow_whatever_the_profile_allows() -> None:
    omni = load_profile(shipped_profiles()["omni"])
    skill = streaming_skill(omni)
    assert skill is not None

    assert slow_arguments(omni, skill) == {
        "linear": 0.1,
        "lateral": 0.0,
        "angular": 0.0,
        "duration": 2.0,
    }
    assert streaming_skill(load_profile(shipped_profiles()["kuka1"])) is None


async def test_a_robot_is_tried_on_the_record(tmp_path: Path) -> None:
    config, clock = load_config(write_config(tmp_path)), SystemClock()

    stop, watchdog, after = [f async for f in try_robot(config, "omni", clock, SystemEntropy())]

    assert stop.verdict is FindingVerdict.GOOD
    measured = re.fullmatch(r"stop: at rest after (\d\.\d\d) s \(from a slow drive\)", stop.text)
    assert measured is not None
    assert 0.05 <= float(measured[1]) < 1
    assert watchdog.text.startswith("watchdog: ")
    store = DatabaseStore(config.data, clock=clock)
    memory = await store.open()
    await store.close()
    assert memory.numbers["omni"][0] >= 1
    assert memory.generations["omni"] == 1
    assert memory.unfinished == ()
    assert after.text == "resumed: it was stopped only to be measured"
    latch = latch_of(config)
    assert latch.read()["omni"] == (1, False), "the next start would find it stopped"
    await latch.close()


@pytest.mark.parametrize("where", ["latch", "record"])
async def test_a_trial_undoes_no_stop_but_its_own(tmp_path: Path, where: str) -> None:
    config, clock = load_config(write_config(tmp_path)), SystemClock()
    latch = latch_of(config)
    store = DatabaseStore(config.data, clock=clock, kept=latch.kept)
    await store.open()
    if where == "latch":
        await latch.write("omni", 3, latched=True)
    else:  # the latch could not be written when it was applied
        await store.write(Stopped(robot="omni", generation=3, principal="p-1", at_ns=1))
    await store.close()
    await latch.close()

    [found] = [f async for f in try_robot(config, "omni", clock, SystemEntropy())]

    assert found.text == "omni is stopped, so it was not moved; resume it first"
    latch = latch_of(config)
    assert latch.read().get("omni", (0, True))[1], "it would go on at the next start"
    await latch.close()


async def test_a_trial_that_did_not_go_well_leaves_the_robot_stopped(tmp_path: Path) -> None:
    config, clock = load_config(write_config(tmp_path)), SystemClock()
    omni = load_profile(shipped_profiles()["omni"], link="simulated")
    latch = latch_of(config)
    store = DatabaseStore(config.data, clock=clock, kept=latch.kept)
    await store.open()
    robot = NeverSeenAtRest(omni, OrderGate.new("omni"), clock)
    await robot.open(print)
    try:
        trial = StopTest(omni, robot, store, latch, clock, SystemEntropy())
        *_, stop, watchdog, after = [found async for found in trial.run()]
    finally:
        await robot.close()
    assert stop.verdict is FindingVerdict.LOOK
    assert watchdog.text == "watchdog: its stop was not confirmed, so it was not moved again"
    assert after == DiagnosticFinding(
        "omni",
        FindingVerdict.LOOK,
        "it stays stopped, also after a start, until somebody says: resume omni",
    )
    assert stops_of(latch.read(), {"omni": 1})["omni"] == (1, True)
    await store.close()
    await latch.close()


async def test_a_trial_that_breaks_off_says_whether_the_robot_stays_stopped(
    tmp_path: Path,
) -> None:
    config, clock = load_config(write_config(tmp_path)), SystemClock()
    omni = load_profile(shipped_profiles()["omni"], link="simulated")
    latch = latch_of(config)
    store = DatabaseStore(config.data, clock=clock, kept=latch.kept)
    await store.open()
    robot = GoesAway(omni, OrderGate.new("omni"), clock)
    await robot.open(print)
    try:
        trial = StopTest(omni, robot, store, latch, clock, SystemEntropy())
        *_, gone, after = [found async for found in trial.run()]
    finally:
        await robot.close()
    assert gone == DiagnosticFinding("omni", FindingVerdict.LOOK, "omni is not there.")
    assert after.text == "it stays stopped, also after a start, until somebody says: resume omni"
    await store.close()
    await latch.close()


class GoesAway(SimulatedRobot):
    """It is not there any more when its watchdog is to be measured."""

    async def fall_silent(self, _order: Order, _tell: Tell) -> RestReport:
        raise RobotOffline("omni is not there.")


class NeverSeenAtRest(SimulatedRobot):
    """Its stop is carried out and not confirmed."""

    async def stop(self, stop: Stop) -> RestReport:
        return replace(await super().stop(stop), confirmed=False)


async def test_a_robot_that_streams_nothing_is_stopped_at_rest(tmp_path: Path) -> None:
    config = load_config(write_config(tmp_path))

    stop, watchdog, _ = [
        f async for f in try_robot(config, "kuka1", SystemClock(), SystemEntropy())
    ]

    assert "(it was not moving)" in stop.text
    assert watchdog.verdict is FindingVerdict.NOT_MEASURED


def test_the_command_prints_a_line_for_each(tmp_path: Path) -> None:
    ran = rosic("doctor", cwd=tmp_path)

    assert ran.err == ""
    assert [line.split()[0] for line in ran.out.splitlines()] == [
        "disk",
        "record",
        "space",
        "memory",
        "clock",
        "ROS",
    ]


def test_with_a_running_gateway_the_robot_is_only_stopped(tmp_path: Path) -> None:
    config = write_config(tmp_path)
    with gateway(config):
        ran = rosic("doctor", "-c", config, "--try", "omni")

        assert "STOP: omni at rest" in ran.out
        assert "resume omni" in ran.out
        assert "not measured: watchdog" in ran.out
        assert "stopped by" in rosic("status", "omni", "-c", config).out


@pytest.mark.parametrize(
    ("told", "well"),
    [
        ("STOP sent to omni.", True),
        ("STOP: omni at rest (0.05 s).", True),
        ("STOP: omni has not confirmed the stop. Use its own stop button.", False),
        ("STOP: omni at rest (1.05 s). omni's own stop did not answer.", False),
        ("STOP: omni at rest (0.05 s). omni's own stop answered that it failed: no.", False),
        (str(NOT_KEPT), False),
    ],
)
def test_what_the_gateway_says_of_a_stop_is_judged(told: str, well: bool) -> None:
    assert (verdict_of(AdminAnswer(told)) is FindingVerdict.GOOD) == well


def test_ctrl_c_in_a_trial_says_that_the_robot_may_stay_stopped(tmp_path: Path) -> None:
    config = write_config(tmp_path)
    asked = [*ROSIC, "doctor", "-c", str(config), "--try", "omni"]
    with subprocess.Popen(  # noqa: S603 - our own command
        asked, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, env=environment()
    ) as process:
        assert process.stdout is not None
        for line in process.stdout:
            if line.startswith("ROS 2"):
                break
        process.send_signal(signal.SIGINT)
        said = process.stdout.read()
        assert process.wait(60) == 130
    assert "Broken off." in said
    assert said.endswith("say: resume omni\n")


def test_a_robot_that_is_not_in_the_file_is_a_sentence(tmp_path: Path) -> None:
    config = write_config(tmp_path)

    ran = rosic("doctor", "-c", config, "--try", "zed")

    assert ran.status == 1
    assert "there is no such robot; there are: omni, kuka1" in ran.out
    assert rosic("doctor", "--try", "omni").status == 2


@pytest.mark.parametrize(
    ("verdict", "line"),
    [
        (FindingVerdict.GOOD, "disk       fsync 1 ms"),
        (FindingVerdict.LOOK, "disk       look at this: fsync 1 ms"),
    ],
)
def test_a_finding_reads_well(verdict: FindingVerdict, line: str) -> None:
    assert str(DiagnosticFinding("disk", verdict, "fsync 1 ms")) == line
