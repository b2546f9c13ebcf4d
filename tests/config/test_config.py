from __future__ import annotations

import logging
from pathlib import Path

import msgspec
import pytest

from rosic.app.builder import settings_of
from rosic.app.config import load_config, read_config
from rosic.config.gateway_file import LogLevel
from rosic.config.profiles import known_units
from rosic.container.files import FileQuota
from rosic.core.identity import Address
from rosic.core.policy.limits import unit_converter
from rosic.core.policy.permissions import Permissions, fleet_of
from rosic.core.policy.roles import Grant
from rosic.core.rate_limit import RateLimit
from rosic.core.secret import Secret
from tests.config.profile_text import GOOD as PROFILE
from tests.config.profile_text import write
from tests.config.test_config_errors import GOOD, TOKEN

ROOT = Path(__file__).parents[2]


@pytest.fixture
def path(tmp_path: Path) -> Path:
    (tmp_path / "robots").mkdir()
    write(tmp_path / "robots", PROFILE)
    return write(tmp_path, GOOD, "rosic.toml")


def test_room_for_files_is_said_in_the_file(path: Path) -> None:
    environ = {"BOT_TOKEN": TOKEN}
    assert load_config(path, environ=environ).room == FileQuota(50, 100_000_000, 2_000_000_000)
    table = "\n[files]\nperson_files = 3\nperson_mb = 2000\nplace_mb = 5000.5\n"
    path.write_text(path.read_text() + table)
    config = load_config(path, environ=environ)
    assert config.room == FileQuota(3, 2_000_000_000, 5_000_500_000)
    assert settings_of(config).room == config.room


def test_a_file_becomes_what_a_gateway_is_seeded_with(path: Path) -> None:
    config = load_config(path, environ={"BOT_TOKEN": f"{TOKEN}\n"})
    assert (config.name, config.lease_idle_s, config.log_level) == ("lab", 60.0, LogLevel.INFO)
    assert config.data == path.parent / "data"
    assert config.limits == RateLimit(20, 2)
    telegram, terminal = config.messengers
    assert (telegram.kind, telegram.name, telegram.where) == ("telegram", "telegram", f"{path}:7")
    assert telegram.settings == {"token": Secret(TOKEN)}
    assert (terminal.kind, terminal.name, terminal.settings) == ("terminal", "terminal", {})
    assert [(robot.id, robot.link.kind) for robot in config.robots] == [
        ("rover", "ros2"),
        ("omni", "simulated"),
    ]
    assert config.robots[1].skills["move"].id == "move"
    admin, student = config.people
    assert (admin.name, admin.roles) == ("Admin", ("admin",))
    assert admin.addresses == (Address("telegram", "1001"),)
    assert student.addresses == (Address("telegram", "1002"), Address("terminal", "local"))
    assert student.roles == ("viewer", "student")
    assert config.rulebook.roles["student"].scopes == ("rover:move", "omni:read", "*:resume")


def test_what_is_left_out_has_a_sensible_value(tmp_path: Path) -> None:
    text = '[[messenger]]\nkind = "terminal"\n[[robot]]\nprofile = "yumi"\n'
    config = load_config(write(tmp_path, text, "rosic.toml"), environ={})
    assert (config.name, config.lease_idle_s) == ("rosic", 60.0)
    assert config.data == tmp_path / "rosic-data"
    assert config.limits == RateLimit()
    assert config.people == ()


def test_a_relative_path_is_taken_from_where_the_file_is(
    path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(path.parent.parent)
    relative = path.relative_to(path.parent.parent)
    config = load_config(relative, environ={"BOT_TOKEN": TOKEN})
    assert config.data == path.parent / "data"
    assert config.path == relative


SETTINGS = """\
[[messenger]]
kind = "telegram"
name = "lab bot"
token = { file = "token.txt" }
api_base = "http://127.0.0.1:8081"
poll_s = 30
password = "%(token)s"
env = "production"
[messenger.proxy]
user = "me"
secret = { env = "PROXY" }
[[messenger.accounts]]
api_key = { env = "PROXY" }
[[robot]]
profile = "yumi"
"""


def test_a_secret_is_hidden_wherever_it_stands(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    other = "hunter2-hunter2"
    (tmp_path / "token.txt").write_text(f"  {TOKEN}\n")
    (tmp_path / "token.txt").chmod(0o600)
    path = write(tmp_path, SETTINGS.replace("%(token)s", TOKEN), "rosic.toml")

    config = load_config(path, environ={"PROXY": other})

    [messenger] = config.messengers
    assert messenger.name == "lab bot"
    assert messenger.settings == {
        "token": Secret(TOKEN),
        "api_base": "http://127.0.0.1:8081",
        "poll_s": 30,
        "password": Secret(TOKEN),
        "env": "production",
        "proxy": {"user": "me", "secret": Secret(other)},
        "accounts": [{"api_key": Secret(other)}],
    }
    logging.getLogger("rosic.test").error("%s %r", config, messenger)
    for shown in (repr(config), str(messenger.settings), caplog.text):
        assert "***" in shown
        assert TOKEN not in shown
        assert other not in shown
    with pytest.raises(TypeError):
        msgspec.json.encode(messenger)


def test_a_role_of_the_file_gives_what_it_says(path: Path) -> None:
    config = load_config(path, environ={"BOT_TOKEN": TOKEN})
    students = {"p": (Grant(role="student"),)}
    convert = unit_converter(known_units())
    rights = Permissions.draw_up(1, config.rulebook, fleet_of(config.robots), students, convert)
    assert rights.holds("p", "rover", "move", 0)
    assert not rights.holds("p", "rover", "drive", 0)
    assert rights.holds("p", "omni", "read", 0)
    assert not rights.holds("p", "omni", "move", 0)


def test_the_process_environment_is_where_a_variable_is_looked_for(
    path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("BOT_TOKEN", TOKEN)
    assert load_config(path).messengers[0].settings["token"] == Secret(TOKEN)


def test_the_example_is_good() -> None:
    path = ROOT / "examples" / "rosic.toml"
    read = read_config(path, environ={"ROSIC_TELEGRAM_TOKEN": TOKEN})
    assert [str(error) for error in read.errors] == []
    assert read.advice == []
    assert read.config is not None
    assert [robot.id for robot in read.config.robots] == [
        "omni",
        "kuka1",
        "yumi",
        "cf1",
        "cf2",
        "cf3",
    ]
    assert {robot.link.kind for robot in read.config.robots} == {"simulated"}
