"""The published schemas: up to date, valid, and of one mind with the check."""

from __future__ import annotations

import json
import tomllib
from typing import TYPE_CHECKING, Any, Protocol

import jsonschema
import pytest

from rosic.config.json_schema import config_schema, main, published, robot_schema
from rosic.config.plugins import robot_kinds
from rosic.config.profiles import shipped_profiles
from rosic.config.yaml_source import read_yaml
from tests.config.profile_text import DIALOGUE, GOOD, ROOT, SHIPPED_KINDS, write
from tests.config.test_config_errors import GOOD as CONFIG

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    from rosic.config.source_map import Data


@pytest.mark.parametrize("name", sorted(published(SHIPPED_KINDS)))
def test_what_is_published_is_up_to_date(name: str) -> None:
    stored = (ROOT / "docs" / "schema" / name).read_text(encoding="utf-8")
    assert stored == published(SHIPPED_KINDS)[name], (
        "run: python -m rosic.config.json_schema docs/schema"
    )


def test_it_is_written_into_a_folder(tmp_path: Path) -> None:
    main(tmp_path / "schema")
    written = {
        path.name: path.read_text(encoding="utf-8") for path in (tmp_path / "schema").iterdir()
    }
    assert written == published(robot_kinds())


class Wrong(Protocol):
    message: str


class Validator(Protocol):
    def iter_errors(self, data: Data) -> Iterator[Wrong]: ...


def validator(schema: dict[str, Any]) -> Validator:
    published_form = json.loads(json.dumps(schema))
    jsonschema.Draft202012Validator.check_schema(published_form)
    made: Validator = jsonschema.Draft202012Validator(published_form)
    return made


@pytest.fixture(scope="module")
def robot() -> Validator:
    return validator(robot_schema(SHIPPED_KINDS))


@pytest.fixture(scope="module")
def config() -> Validator:
    return validator(config_schema())


def test_every_shipped_profile_fits(robot: Validator) -> None:
    for path in shipped_profiles().values():
        assert [error.message for error in robot.iter_errors(read_yaml(path).data)] == []


@pytest.mark.parametrize("text", [GOOD, DIALOGUE])
def test_a_good_profile_fits(text: str, robot: Validator, tmp_path: Path) -> None:
    assert list(robot.iter_errors(read_yaml(write(tmp_path, text)).data)) == []


def test_a_good_configuration_fits(config: Validator) -> None:
    for text in (CONFIG, (ROOT / "examples" / "rosic.toml").read_text()):
        assert [error.message for error in config.iter_errors(tomllib.loads(text))] == []


def put(data: Data, place: str, value: object) -> None:
    *above, last = place.split("/")
    for key in above:
        data = data[int(key) if key.isdigit() else key]
    data[last] = value


@pytest.mark.parametrize(
    ("place", "value"),
    [
        ("linkloss", "hold"),
        ("id", "Rover"),
        ("link_loss", "hodl"),
        ("queue_length", 0),
        ("queue_length", "many"),
        ("watchdog_s", None),
        ("stop/type", "std_srvs/Trigger"),
        ("at_rest/field", "twist twist"),
        ("skills/Light On", {}),
        ("skills/move/id", "move"),
        ("skills/move/class", "dance"),
        ("skills/move/words", ["a=b"]),
        ("skills/move/action/type", "rosic_interfaces/msg/Move"),
        ("skills/move/action/goal/a..b", 1),
        ("skills/move/action/goal/a", [1]),
        ("skills/drive/topic/stream_hz", 101),
    ],
)
def test_what_the_check_refuses_by_its_form_the_schema_refuses(
    place: str, value: object, robot: Validator, tmp_path: Path
) -> None:
    data = read_yaml(write(tmp_path, GOOD)).data
    put(data, place, value)
    assert list(robot.iter_errors(data))


@pytest.mark.parametrize(
    ("place", "value"),
    [
        ("limit", {}),
        ("gateway/log_level", "verbose"),
        ("limits/burst", 0),
        ("robot/1/link", "by hand"),
        ("principal/0/address", "1001"),
        ("role/student/scopes", "omni:move"),
        ("messenger/0/kind", ""),
    ],
)
def test_what_the_check_refuses_in_a_configuration_the_schema_refuses(
    place: str, value: object, config: Validator
) -> None:
    data = tomllib.loads(CONFIG)
    put(data, place, value)
    assert list(config.iter_errors(data))


def test_people_who_write_a_profile_are_told_what_a_key_means() -> None:
    schema = robot_schema(SHIPPED_KINDS)
    assert schema["properties"]["watchdog_s"]["description"].startswith("The robot's own time-out")
    skill = schema["$defs"]["Skill"]["properties"]
    assert skill["words"]["description"] == "Other names people use for it."
    assert skill["class"]["description"]
    for part in (schema, *schema["$defs"].values()):
        for name, described in part.get("properties", {}).items():
            assert "``" not in described.get("description", ""), name
            assert "\n" not in described.get("description", ""), name
