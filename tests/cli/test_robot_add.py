"""`rosic robot add`, from a process of its own, to a gateway that runs and is killed."""

from __future__ import annotations

import signal
from concurrent.futures import ThreadPoolExecutor
from typing import TYPE_CHECKING

from tests.cli.running import CONFIG, Ran, gateway, rosic, write_config
from tests.gateway.rover import CAN, ROVER

if TYPE_CHECKING:
    from pathlib import Path

    from tests.cli.running import Ran

QUICK = CONFIG + "\n[limits]\nburst = 1000\nper_s = 1000\n"  # killed, it forgets what was left
FREE = ROVER.replace("groups: [swarm]\n", "")


def add(config: Path, profile: str | Path, *more: str) -> Ran:
    """Ask for a robot."""
    return rosic("robot", "add", "-c", config, str(profile), *more)


def test_a_robot_comes_to_a_gateway_that_works_and_is_there_after_it_was_killed(
    tmp_path: Path,
) -> None:
    config, profile = write_config(tmp_path, QUICK), tmp_path / "rover.yaml"
    profile.write_text(FREE)
    with gateway(config) as running:
        running.say("omni move 5 m speed 0.05 m/s")
        running.wait_for("driving")

        assert add(config, profile) == (0, f"Rover 3 is here now, as rover.\n{CAN}\n", "")
        assert "move" in rosic("status", "omni", "-c", config).out
        assert rosic("status", "rover", "-c", config).out.startswith("Rover 3: ")
        running.say("rover wiggle 2")
        running.wait_for("Rover 3: wiggle")
        assert "ok" in rosic("explain", "Bob", "rover wiggle", "-c", config).out

        stopped = rosic("stop", "-c", config)
        assert "Rover 3" in stopped.out
        again = add(config, profile)
        assert (again.status, again.out) == (1, "")
        assert again.err == (
            "A robot is called rover here already. Give this one another id. Nothing was changed.\n"
        )
        running.process.send_signal(signal.SIGKILL)
        running.process.wait(60)

    with gateway(config) as running:
        assert "3 robots" in running.err()
        assert "stopped" in rosic("status", "rover", "-c", config).out
        running.say("resume rover")
        running.wait_for("Rover 3 is ready again.")
        running.say("rover wiggle 2")
        running.wait_for("done")
    assert "ok" in rosic("explain", "Bob", "rover wiggle", "-c", config).out  # without a gateway


def test_what_is_wrong_is_said_as_a_check_does_and_changes_nothing(tmp_path: Path) -> None:
    config, profile = write_config(tmp_path), tmp_path / "rover.yaml"
    profile.write_text(FREE.replace("max: 9", "max: 0").replace("class: observe", "class: sing"))
    checked = rosic("robot", "check", profile)
    with gateway(config):
        assert add(config, profile) == (2, "", checked.err)
        assert len(checked.err.splitlines()) == 2
        profile.write_text(FREE.replace("kind: memory", "kind: carrier_pigeon"))
        refused = add(config, profile)
        assert refused.status == 1
        assert refused.err.startswith(
            "Rover 3 cannot be reached: There is no robot link of the kind 'carrier_pigeon'."
        )
        missing = add(config, "roover")
        assert (missing.status, missing.out) == (2, "")
        assert "No profile is called 'roover'." in missing.err
        assert add(config, "cf1", "--link", "simulated").status == 0
        status = rosic("status", "-c", config).out
        assert len(status.splitlines()) == 3
    profile.write_text(FREE)
    alone = add(config, profile)
    assert (alone.status, alone.out) == (1, "")
    assert "No gateway is running on" in alone.err
    assert "[[robot]]" in alone.err


def test_of_many_that_are_added_at_once_every_one_is_there_once(tmp_path: Path) -> None:
    config = write_config(tmp_path)
    profiles = []
    for n in (1, 2):
        profile = tmp_path / f"rover{n}.yaml"
        text = FREE.replace("rover", f"rover{n}").replace("Rover 3", f"Rover {n}")
        profile.write_text(text.replace("buggy", f"buggy{n}"))
        profiles += [profile, profile]
    with gateway(config):

        def add(profile: Path) -> Ran:
            return rosic("robot", "add", "-c", config, profile)

        with ThreadPoolExecutor(len(profiles)) as pool:
            answers = list(pool.map(add, profiles))
        assert sorted(ran.status for ran in answers) == [0, 0, 1, 1]
        assert sum("called" in ran.err and "already" in ran.err for ran in answers) == 2
        status = rosic("status", "-c", config).out
        assert status.count("Rover 1: ") == status.count("Rover 2: ") == 1
