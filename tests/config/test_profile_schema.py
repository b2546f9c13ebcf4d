"""What a profile says of its link is the business of that link's adapter, found by entry point."""

from __future__ import annotations

import os
from importlib import invalidate_caches
from typing import TYPE_CHECKING

import pytest

from rosic.config import plugins
from rosic.config.json_schema import main, published
from rosic.config.plugins import profile_schema, robot_factory, robot_kinds
from rosic.config.profile_validation import profile_rules
from rosic.config.profiles import known_units, read_profile
from rosic.contracts.adapter import EVERY_ROBOT, ProfileSchema
from rosic.contracts.file_rules import NumberBounds, Rules, ValidationFinding
from rosic.core.robot.profile import Profile
from rosic.core.robot.skill import Skill
from rosic.robots.ros2.profile import Ros2Profile
from tests.cli.running import cold_rosic, environment, rosic
from tests.config.profile_text import ROOT, SHIPPED_KINDS, spoil, write

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

PLAIN = """
from rosic.robots.memory import MemoryRobot
from rosic.contracts.adapter import EVERY_ROBOT

class PlainRobot(MemoryRobot):
    schema = EVERY_ROBOT
    stops_itself = False
"""
WANTING = "import a_library_that_nobody_has\n"
POINTS = "[rosic.robots]\nplain = plain_link:PlainRobot\nwanting = wanting_link:WantingRobot\n"
BARE = "id: cart\nlink: { kind: plain }\nskills: { push: { title: Push } }\n"


@pytest.fixture
def installed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """Install two kinds of link: one without keys of its own, and one whose library is missing."""
    info = tmp_path / "plain_link-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: plain-link\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text(POINTS)
    (tmp_path / "plain_link.py").write_text(PLAIN)
    (tmp_path / "wanting_link.py").write_text(WANTING)
    monkeypatch.syspath_prepend(str(tmp_path))
    invalidate_caches()
    plugins._installed.cache_clear()
    yield tmp_path
    plugins._installed.cache_clear()


def sentences(path: Path) -> list[str]:
    return [str(error).partition(path.name)[2] for error in read_profile(path).errors]


def test_the_kinds_of_rosic_are_found_like_those_of_strangers(installed: Path) -> None:
    assert installed.is_dir()
    assert {*SHIPPED_KINDS, "plain", "wanting"} <= {*robot_kinds()}
    schema = profile_schema("ros2")
    assert schema is not None
    assert schema.profile is Ros2Profile


def test_what_is_published_of_rosic_says_nothing_of_strangers(installed: Path) -> None:
    stored = (ROOT / "docs" / "schema" / "robot.schema.json").read_text(encoding="utf-8")
    assert published(SHIPPED_KINDS)["robot.schema.json"] == stored
    main(installed / "schema")
    assert '"plain"' in (installed / "schema" / "robot.schema.json").read_text(encoding="utf-8")


def test_a_kind_without_keys_of_its_own_takes_those_of_every_robot(installed: Path) -> None:
    assert profile_schema("plain") is EVERY_ROBOT
    path = installed / "cart.yaml"
    path.write_text(BARE)
    assert sentences(path) == []
    path.write_text(f"{BARE}stop: {{ service: /halt }}\ncamera: {{ topic: /c }}\n")
    said = sentences(path)
    assert [one.partition(". ")[0] for one in said] == [
        ":4: 'stop' is not known here",
        ":5: 'camera' is not known here",
    ]
    assert "joints" not in said[0]


def test_what_moves_needs_a_stop_whatever_its_kind(installed: Path) -> None:
    path = installed / "cart.yaml"
    path.write_text(BARE)
    env = {"PYTHONPATH": os.pathsep.join((environment()["PYTHONPATH"], str(installed)))}
    said = cold_rosic("robot", "check", path, env=env).err
    assert "cart.yaml:2: cart moves, and nothing here would stop it or measure" in said
    path.write_text(f"{BARE}unstoppable: true\n")
    assert "is good: cart, 1 skill." in cold_rosic("robot", "check", path, env=env).out


def test_a_kind_that_is_not_there_leaves_the_rest_to_be_checked(tmp_path: Path) -> None:
    path = write(tmp_path, spoil("kind: ros2", "kind: ros3"))
    assert sentences(path) == []
    ran = rosic("robot", "check", path)
    assert "rover.yaml:5: There is no robot link of the kind 'ros3'. Did you mean ros2?" in ran.err
    text = spoil("queue_length: 16", "queue_length: many", spoil("kind: ros2", "kind: ros3"))
    [said] = sentences(write(tmp_path, text))
    assert "'queue_length' must be a whole number" in said


def test_a_kind_whose_library_is_missing_is_checked_for_what_every_robot_has(
    installed: Path,
) -> None:
    assert profile_schema("wanting") is None
    path = installed / "cart.yaml"
    path.write_text(BARE.replace("plain", "wanting, wheel: 4") + "stop: [anything]\n")
    assert sentences(path) == []
    path.write_text(BARE.replace("plain", "wanting").replace("title", "titel"))
    assert sentences(path) == []  # it may be a key of that link's
    path.write_text(BARE.replace("plain", "wanting").replace("cart", "Cart"))
    assert len(sentences(path)) == 1


@pytest.mark.parametrize("link", ["[]", "ros2", "{ kind: 7 }", "{ kind: [ros2] }", "{ }", "null"])
def test_a_link_that_says_no_kind_is_named(tmp_path: Path, link: str) -> None:
    path = tmp_path / "cart.yaml"
    path.write_text(f"id: cart\nlink: {link}\n")
    [said] = sentences(path)
    assert said.startswith((":2: 'kind' ", ":2: 'link' ")), said


def test_an_adapter_adds_to_what_is_asked_and_takes_nothing_away() -> None:
    def complain(_: Skill) -> Iterator[ValidationFinding]:
        yield ValidationFinding((), "Not on my robot.")

    own = Rules(
        bounds={(Profile, "queue_length"): NumberBounds(0, 10**9)},
        forms={},
        hidden=frozenset(),
        checks={Skill: (complain,)},
    )
    rules, alone = (profile_rules(known_units(), one) for one in (own, EVERY_ROBOT.rules))
    names = {asked: [rule.__name__ for rule in alone.checks[asked]] for asked in alone.checks}
    names[Skill].append("complain")
    assert {
        asked: [rule.__name__ for rule in rules.checks[asked]] for asked in rules.checks
    } == names
    assert rules.bounds == alone.bounds
    assert rules.hidden == alone.hidden


def test_every_kind_of_rosic_says_what_its_profiles_say() -> None:
    for kind in ("memory", "ros2", "simulated"):
        factory = robot_factory(kind)
        assert isinstance(getattr(factory, "schema", None), ProfileSchema), kind
