"""A simulated robot is driven by what its profile's binding says, as a real one is."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from rosic.config.profiles import load_profile, shipped_profiles
from rosic_sim.robots.machines.omni import Omni
from rosic_sim.robots.robot import SimulatedRobot
from rosic_sim.robots.simulation_loop import simulation_of
from tests.gateway.place import Place

if TYPE_CHECKING:
    from pathlib import Path

MOST = "unit: m/s, min: -0.8, max: 0.8, default: 0 }"
LINEAR = 'linear: { title: Forward, titles: { de: "Vorwärts" }, ' + MOST
LATERAL = '      lateral: { title: To the left, titles: { de: "Nach links" }, ' + f"{MOST}\n"
STAMPED = "{ twist.linear.x: $linear, twist.linear.y: $lateral, twist.angular.z: $angular }"
TYPE = "      type: geometry_msgs/msg/Twist"
TWIST = "{ linear.x: $linear, linear.y: $lateral, angular.z: $angular }"


class Simulated(Place):
    kind = SimulatedRobot


async def _driven(folder: Path, line: str, **changes: tuple[str, str]) -> tuple[str, float, float]:
    """Say a line to an omni whose profile reads otherwise; return what was told, and metres."""
    text = shipped_profiles()["omni"].read_text()
    for old, new in changes.values():
        assert old in text
        text = text.replace(old, new)
    file = folder / "omni.yaml"
    file.write_text(text)
    omni = load_profile(file, link="simulated")
    async with Simulated(fleet=(omni,)).open() as here:
        machine = simulation_of(here.clock).world.machines["omni"]
        assert isinstance(machine, Omni)
        before = (machine.base.x_m, machine.base.y_m)
        await here.say(line)
        for _ in range(40):
            await here.clock.advance(0.1)
        told = "\n".join(here.chat.shown(told.message).text for told in here.chat.told)
        return told, machine.base.x_m - before[0], machine.base.y_m - before[1]


async def test_a_parameter_of_another_name_drives_it_as_the_profile_says(tmp_path: Path) -> None:
    told, x_m, y_m = await _driven(
        tmp_path,
        "omni drive speed=0.3 duration=2",
        name=("linear: { title: Forward,", "speed: { title: Forward,"),
        sent=("linear.x: $linear", "linear.x: $speed"),
    )
    assert "drove for 2 s" in told
    assert x_m == pytest.approx(0.6, abs=0.1)
    assert y_m == pytest.approx(0.0, abs=0.01)


async def test_a_field_takes_whatever_parameter_the_profile_gives_it(tmp_path: Path) -> None:
    told, x_m, y_m = await _driven(
        tmp_path,
        "omni drive linear=0.3 duration=2",
        sent=(TWIST, "{ linear.y: $linear, linear.x: $lateral, angular.z: $angular }"),
    )
    assert "drove for 2 s" in told
    assert x_m == pytest.approx(0.0, abs=0.01)
    assert y_m == pytest.approx(0.6, abs=0.1)


async def test_a_choice_and_a_number_of_the_profile_itself_drive_it(tmp_path: Path) -> None:
    pace = "pace: { choices: { slow: [], fast: [] }, default: slow, "
    means = "means: { slow: { v: 0.1 }, fast: { v: 0.3 } } }"
    told, x_m, y_m = await _driven(
        tmp_path,
        "omni drive fast duration=2",
        taken=(LINEAR, pace + means),
        sent=("linear.x: $linear", "linear.x: $pace.v"),
        stamped=(".x: $pace.v, linear.y: $lateral", ".x: $pace.v, linear.y: 0.1"),
        unused=(LATERAL, ""),
    )
    assert "drove for 2 s" in told
    assert x_m == pytest.approx(0.6, abs=0.1)
    assert y_m == pytest.approx(0.2, abs=0.05)


async def test_a_stamped_twist_drives_it_as_well(tmp_path: Path) -> None:
    told, x_m, _ = await _driven(
        tmp_path,
        "omni drive linear=0.3 duration=2",
        kind=(f"{TYPE}\n", f"{TYPE}Stamped\n"),
        sent=(TWIST, STAMPED),
    )
    assert "drove for 2 s" in told
    assert x_m == pytest.approx(0.6, abs=0.1)


async def test_what_sends_it_no_velocity_is_refused_and_not_said_to_be_done(tmp_path: Path) -> None:
    told, x_m, y_m = await _driven(
        tmp_path,
        "omni drive linear=0.3 duration=2",
        sent=(TWIST, "{ linear.z: $linear, angular.x: $lateral, angular.y: $angular }"),
    )
    assert "is driven by linear.x, linear.y, angular.z, and this skill sends none" in told
    assert "Nothing was done." in told
    assert "drove" not in told
    assert (x_m, y_m) == (0.0, 0.0)


async def test_of_a_velocity_of_nothing_no_motion_is_said(tmp_path: Path) -> None:
    told, x_m, y_m = await _driven(tmp_path, "omni drive linear=0 duration=2")
    assert "drove" not in told
    assert "this robot does not acknowledge" in told
    assert (x_m, y_m) == (0.0, 0.0)


async def test_what_a_choice_means_is_where_it_goes(tmp_path: Path) -> None:
    dock = "place: { choices: { dock: [] }, means: { dock: { x: 0.5, y: 0.0 } } }"
    told, x_m, y_m = await _driven(
        tmp_path,
        "omni goto dock",
        x=("x: { title: x, unit: m, min: -10, max: 10 }", dock),
        y=("      y: { title: y, unit: m, min: -10, max: 10 }\n", ""),
        goal=("x_m: $x, y_m: $y", "x_m: $place.x, y_m: $place.y"),
    )
    assert "done" in told
    assert x_m == pytest.approx(0.5, abs=0.02)
    assert y_m == pytest.approx(0.0, abs=0.02)
