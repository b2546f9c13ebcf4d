"""What the README shows is right: its profile and its configuration pass the checks."""

from __future__ import annotations

import re
from pathlib import Path

from rosic.app.config import check_config
from rosic.app.documents.profiles import check_profile, load_profile

README = Path(__file__).parents[2] / "README.md"
TEN_LINES = 10


def block(language: str) -> str:
    found = re.findall(rf"```{language}\n(.*?)```", README.read_text(encoding="utf-8"), re.DOTALL)
    assert len(found) == 1, f"one {language} block"
    return str(found[0])


def test_the_robot_of_ten_lines_is_right(tmp_path: Path) -> None:
    profile = tmp_path / "rover.yaml"
    profile.write_text(block("yaml"), encoding="utf-8")
    assert [str(error) for error in check_profile(profile)] == []
    assert set(load_profile(profile).skills) == {"drive"}
    assert len(block("yaml").splitlines()) <= TEN_LINES


def test_the_configuration_is_right(tmp_path: Path) -> None:
    (tmp_path / "rover.yaml").write_text(block("yaml"), encoding="utf-8")
    config = tmp_path / "rosic.toml"
    config.write_text(block("toml"), encoding="utf-8")
    environ = {"ROSIC_TELEGRAM_TOKEN": "123456:abcdefghijklmnopqrstuvwxyz"}
    assert [str(error) for error in check_config(config, environ=environ)] == []
