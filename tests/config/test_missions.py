"""Files of missions: what is wrong is said with its line."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from rosic.app.config import read_config
from rosic.config.missions import Missions
from rosic.config.profiles import known_units
from tests.features.fleet.test_tasks import WAREHOUSE

if TYPE_CHECKING:
    from pathlib import Path

GOOD = """\
name: restock
title: Restock an aisle
do:
  - on: warehouse
    steps: [move 1 m, wave]
    priority: 3
    within: 5 min
    battery: 30
  - together:
      - {on: w1, steps: [wave]}
      - {on: any, steps: [wave], once: true}
"""


def wrong(tmp_path: Path, *texts: str) -> list[str]:
    missions = Missions(WAREHOUSE, known_units())
    for number, text in enumerate(texts):
        file = tmp_path / f"m{number}.yaml"
        file.write_text(text, encoding="utf-8")
        missions.read(file)
    missions.found()
    return [str(error).replace(f"{tmp_path}/", "") for error in missions.errors]


def test_a_good_one_is_read(tmp_path: Path) -> None:
    missions = Missions(WAREHOUSE, known_units())
    (tmp_path / "m.yaml").write_text(GOOD, encoding="utf-8")
    missions.read(tmp_path / "m.yaml")
    [mission] = missions.found()
    assert not missions.errors
    assert mission.shown == "Restock an aisle"
    assert mission.do[0].steps == ("move 1 m", "wave")


@pytest.mark.parametrize(
    ("old", "new", "sentence"),
    [
        ("on: warehouse", "on: warehose", "m0.yaml:4: No robot and no group is called 'warehose'"),
        ("move 1 m", "move 40 m", "m0.yaml:5: Nobody of warehouse can do this: "),
        ("[move 1 m, wave]", "[dance]", "m0.yaml:5: Nobody of warehouse can do this: "),
        ("priority: 3", "priority: 30", "m0.yaml:6: "),
        ("5 min", "soon", "m0.yaml:7: 'soon' is no length of time"),
        ("battery: 30", "batery: 30", "m0.yaml:8: "),
        ("steps: [wave]}", "mission: restock}", "m0.yaml:10: This mission goes round in a circle"),
        ("on: w1, steps: [wave]", "on: w1", "m0.yaml:10: A part has exactly one of"),
        ("name: restock", "name: Re stock", "m0.yaml:1: "),
    ],
)
def test_what_is_wrong_is_said_with_its_line(
    old: str, new: str, sentence: str, tmp_path: Path
) -> None:
    [found, *_] = wrong(tmp_path, GOOD.replace(old, new, 1))
    assert found.startswith(sentence)


def test_two_may_not_have_one_name_and_a_circle_of_two_is_found(tmp_path: Path) -> None:
    assert "Two missions are called restock." in "\n".join(wrong(tmp_path, GOOD, GOOD))
    one = "name: one\ndo:\n  - mission: two\n"
    two = "name: two\ndo:\n  - {on: w1, steps: [wave]}\n  - mission: one\n"
    found = wrong(tmp_path, one, two)
    assert found[0].startswith("m0.yaml:3: This mission goes round in a circle: one -> two -> one")
    assert found[1].startswith("m1.yaml:4: ")


CONFIG = """\
[[messenger]]
kind = "terminal"

[[robot]]
profile = "omni"
link = "simulated"

[[principal]]
name = "Ada"
address = "terminal:ada"
role = "admin"

[[mission]]
file = "tour.yaml"
"""


def test_the_configuration_names_them_and_says_what_is_wrong_where_it_is(tmp_path: Path) -> None:
    file = tmp_path / "rosic.toml"
    file.write_text(CONFIG, encoding="utf-8")
    [error] = read_config(file).errors
    assert "rosic.toml:14: There is no mission at tour.yaml." in str(error)
    tour = tmp_path / "tour.yaml"
    tour.write_text("name: tour\ndo:\n  - {on: omni, steps: [move 50 cm left]}\n", encoding="utf-8")
    read = read_config(file)
    assert not read.errors
    assert read.config is not None
    assert [mission.name for mission in read.config.missions] == ["tour"]
    tour.write_text("name: tour\ndo:\n  - {on: omni, steps: [move 50 km left]}\n", encoding="utf-8")
    [error] = read_config(file).errors
    assert "tour.yaml:3: Nobody of omni can do this" in str(error)


OPEN = """\
name: fetch
parameters:
  distance: {unit: m, min: 0.1, max: 5, default: 1}
  far: {unit: cm, min: 10, max: 200}
deadline: 20 min
late: cancel
do:
  - on: w1
    steps: [move $distance, move $far back]
    deadline: 5 min
    late: cancel
  - {mission: back, with: {way: $distance}}
"""
BACK = """\
name: back
parameters:
  way: {unit: m, min: 0.1, max: 5}
do:
  - {on: w2, steps: [move $way]}
"""


def test_one_with_parameters_and_deadlines_is_read(tmp_path: Path) -> None:
    assert wrong(tmp_path, OPEN, BACK) == []


@pytest.mark.parametrize(
    ("old", "new", "sentence"),
    [
        (
            "max: 5, default",
            "max: 40, default",
            "m0.yaml:9: Nobody of w1 can do this with distance=40 m: ",
        ),
        (
            "default: 1}",
            "default: 9}",
            "m0.yaml:3: The default 9 is not between 0.1 and 5. Change the default",
        ),
        ("unit: cm", "unit: parsec", "m0.yaml:4: 'parsec' is no unit that is known here."),
        ("unit: cm", "unit: N", "m0.yaml:9: Nobody of w1 can do this with far="),
        ("min: 10,", "min: 900,", "m0.yaml:4: min and max have to be finite, and min not above"),
        ("min: 10, max: 200", "min: 10", "m0.yaml:4: "),
        ("  far:", "  Far:", "m0.yaml:4: 'Far' is no name for a parameter. Use small letters"),
        ("  far:", "  every:", "m0.yaml:4: 'every' begins a time here. Call it otherwise."),
        (
            "$distance,",
            "$distanse,",
            "m0.yaml:9: There is no parameter 'distanse'. Did you mean distance?",
        ),
        ("$far back", "1 m back", "m0.yaml:4: No step uses 'far'. Write $far in a step"),
        ("20 min", "soon", "m0.yaml:5: 'soon' is no length of time. Write for example 20 min."),
        ("deadline: 20 min\n", "", "m0.yaml:5: Without a deadline nothing is late. Write for"),
        ("    deadline: 5 min\n", "", "m0.yaml:10: Without a deadline nothing is late."),
        ("    late: cancel", "    late: shout", "m0.yaml:11: "),
        ("way: $distance", "why: $distance", "m0.yaml:12: There is no why to be said. There is:"),
        ("with: {way: $distance}", "with: {way: 9 m}", "m0.yaml:12: way goes from 0.1 m to 5 m."),
        (", with: {way: $distance}", "", "m0.yaml:12: Say way, for example way=0.1 m."),
        ("mission: back, with", "on: w1, steps: [wave], with", "m0.yaml:12: Only another mission"),
        (
            "mission: back, with: {way: $distance}",
            "mission: back, deadline: 5 min",
            "m0.yaml:12: Only a part with steps has a deadline of its own.",
        ),
    ],
)
def test_what_is_wrong_with_parameters_and_deadlines_is_said_with_its_line(
    old: str, new: str, sentence: str, tmp_path: Path
) -> None:
    assert old in OPEN
    [found, *_] = wrong(tmp_path, OPEN.replace(old, new, 1), BACK)
    assert found.startswith(sentence)
