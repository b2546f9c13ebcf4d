"""What the pages show is what the code takes."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from rosic.app.config import read_config
from rosic.config.profiles import check_profile, load_profile, shipped_profiles
from tests.config.profile_text import write

DOCS = Path(__file__).parents[2] / "docs"


def blocks(page: str, language: str) -> list[str]:
    text = (DOCS / page).read_text(encoding="utf-8")
    found = re.findall(rf"^```{language}\n(.*?)^```", text, re.MULTILINE | re.DOTALL)
    assert found, f"{page} shows no {language}"
    return found


CONFIGURATIONS = ("configuration.md", "robots/among.md", "howto/add-an-interpreter.md")


@pytest.mark.parametrize("text", [text for page in CONFIGURATIONS for text in blocks(page, "toml")])
def test_a_configuration_that_is_shown_is_good(text: str, tmp_path: Path) -> None:
    token = write(tmp_path, "secret\n", "token.txt")
    token.chmod(0o600)
    path = write(tmp_path, text, "rosic.toml")
    errors = read_config(path, environ={"ROSIC_TELEGRAM_TOKEN": "secret"}).errors
    assert [str(error) for error in errors] == []


@pytest.mark.parametrize(
    "text",
    [
        *blocks("robots/profiles.md", "yaml"),
        *blocks("robots/alerts.md", "yaml"),
        *blocks("robots/among.md", "yaml"),
        *blocks("robots/benchmarks.md", "yaml"),
    ],
)
def test_a_profile_that_is_shown_is_good(text: str, tmp_path: Path) -> None:
    assert [str(error) for error in check_profile(write(tmp_path, text))] == []


def test_the_table_of_shipped_profiles_is_complete() -> None:
    text = (DOCS / "robots" / "profiles.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| (`.*?) \|.*\| (.*?) \|$", text, re.MULTILINE)
    shown = {name: skills for names, skills in rows for name in re.findall(r"`(\w+)`", names)}
    for name, path in shipped_profiles().items():
        assert shown[name] == ", ".join(load_profile(path).skills)
