"""Two profiles that reach one robot are refused: a second id would pass by stops of the first."""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING

import pytest
from msgspec.structs import replace

from rosic.app.added_robots import check_distinct, fact_of, with_added
from rosic.cli.main import main
from rosic.config.plugins import same_robot
from rosic.config.profiles import known_units, read_profile_text, shipped_profiles
from rosic.contracts.adapter import EVERY_ROBOT
from rosic.errors import NotUnderstood
from rosic.gateway.robot_registry import ProfileDraft
from tests.cli.running import CONFIG, write_config
from tests.gateway.place import profile

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    from rosic.core.robot.profile import Profile

BOAT = """\
id: fjord
link: { kind: ros2, namespace: /fjord }
stop: { service: /fjord/anchor }
watchdog_s: 0.5
at_rest:
  topic: /fjord/odom
  type: nav_msgs/msg/Odometry
  field: twist.twist.linear.x
  below: 0.01
skills:
  drive:
    parameters: { duration: { unit: s, min: 0.1, max: 5 } }
    topic:
      name: /fjord/cmd_vel
      type: geometry_msgs/msg/Twist
      message: { linear.x: 0.1 }
      stream_hz: 10
  sail:
    action: { name: /fjord/sail, type: acme_msgs/action/Sail }
  lamp:
    class: observe
    service: { name: /harbour/lamp, type: std_srvs/srv/Trigger }
"""
OTHER = BOAT.replace("fjord", "boat7")
NAMES = {
    "/fjord/anchor": "the service",
    "/fjord/odom": "twist.twist.linear.x of the topic",
    "/fjord/cmd_vel": "the topic",
    "/fjord/sail": "the action",
}


def boat(text: str) -> Profile:
    read = read_profile_text(text, "boat.yaml")
    assert read.profile is not None, read.errors
    return read.profile


@pytest.mark.parametrize("name", NAMES)
def test_one_name_that_two_profiles_give_is_named_with_both(name: str) -> None:
    twin = OTHER.replace(name.replace("fjord", "boat7"), name)
    assert twin != OTHER

    [found] = same_robot((boat(BOAT), boat(twin)))

    shared = f"{NAMES[name]} {name}"
    assert found.sentence.startswith(f"fjord and boat7 reach one robot: both name {shared}. ")


def test_what_belongs_to_a_room_may_be_named_by_every_robot_in_it() -> None:
    fleet = [boat(BOAT), boat(OTHER)]
    assert "/harbour/lamp" in BOAT
    assert "/harbour/lamp" in OTHER
    assert list(same_robot(fleet)) == []
    shipped = [boat(path.read_text()) for path in shipped_profiles().values()]
    assert list(same_robot(shipped)) == []


def test_a_check_and_a_start_refuse_the_pair_and_say_where(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    text = CONFIG
    for name in ("fjord", "boat7"):
        (tmp_path / f"{name}.yaml").write_text(BOAT.replace("id: fjord", f"id: {name}"))
        text += f'\n[[robot]]\nprofile = "./{name}.yaml"\n'
    path = write_config(tmp_path, text)

    for command in ("check", "run"):
        assert main([command, "-c", str(path)]) == 2, command
        said = capsys.readouterr().err
        assert "fjord and boat7 reach one robot: both name" in said
        assert str(path) in said


def test_a_robot_is_not_added_beside_itself(caplog: pytest.LogCaptureFixture) -> None:
    twin = BOAT.replace("id: fjord", "id: boat7").replace("namespace: /fjord", "namespace: /boat7")
    with pytest.raises(NotUnderstood, match="boat7 is the robot that is here as fjord: both name"):
        check_distinct(boat(twin), [boat(BOAT)])
    check_distinct(boat(OTHER), [boat(BOAT)])

    added = fact_of("boat7", ProfileDraft(text=twin, name="boat7.yaml"))
    with caplog.at_level(logging.WARNING):
        fleet = with_added((boat(BOAT),), [added], known_units())
    assert [one.id for one in fleet] == ["fjord"]
    assert "boat7, added earlier, is left out: fjord and boat7 reach one robot" in caplog.text


def _of_its_port(made: Profile) -> Iterator[str]:
    yield f"the port {made.title}"


def test_the_law_asks_every_kind_of_link() -> None:
    """Also a link of somebody else's, whose robots hang on ports."""
    hanging = EVERY_ROBOT._replace(reaches=_of_its_port)
    wired = [replace(profile(name), title="tty1") for name in ("omni", "kuka1")]
    assert list(same_robot(wired)) == []

    [found] = same_robot(wired, lambda _kind: hanging)

    assert found.sentence.startswith("omni and kuka1 reach one robot: both name the port tty1.")
