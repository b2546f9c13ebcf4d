"""What the README shows is right: its profile and its configuration pass the checks."""

from __future__ import annotations

import asyncio
import re
from pathlib import Path

from rosic.app.config import read_config
from rosic.config.profiles import check_profile, load_profile
from rosic.testing.telegram import FakeTelegram
from tests.cli.running import gateway, rosic

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
    assert [str(error) for error in read_config(config, environ=environ).errors] == []


async def test_whoever_has_not_written_to_the_bot_is_named_and_that_is_no_error(
    tmp_path: Path,
) -> None:
    (tmp_path / "rover.yaml").write_text(block("yaml"), encoding="utf-8")
    async with FakeTelegram() as server:
        here = f'kind = "telegram"\napi_base = "{server.api_base}"'
        text = block("toml").replace('kind = "telegram"', here)
        (tmp_path / "rosic.toml").write_text(
            text.replace("[[robot]]", '[[robot]]\nlink = "memory"'), encoding="utf-8"
        )
        token = {"ROSIC_TELEGRAM_TOKEN": server.token}
        with gateway(tmp_path / "rosic.toml", token) as running:
            todo = "Ada has not written to @rosic_test_bot yet: nothing is told there until then"
            await asyncio.to_thread(running.wait_for, todo, log=True)
            assert " error " not in running.err()


def sample() -> str:
    text = README.read_text(encoding="utf-8")
    [found] = re.findall(r"```\n(> .*?)```", text, re.DOTALL)
    return str(found)


def alike(lines: str) -> list[str]:
    """Return lines in which every figure of this run is one figure, and progress one line."""
    found: list[str] = []
    for line in lines.splitlines():
        one = re.sub(r"\d\d:\d\d:\d\d|\(\d\.\d\d s\)|\d+ %", "#", line.rstrip())
        if found[-1:] != [one]:
            found.append(one)
    return found


def test_the_sample_is_what_the_demo_shows() -> None:
    asked = [line.removeprefix("> ") for line in sample().splitlines() if line.startswith("> ")]
    said = rosic("demo", stdin="".join(f"{line}\n" for line in asked)).out
    shown = alike(said[said.index("\n> ") + 1 : said.index("At the end:")])
    for line, real in zip(alike(sample()), shown, strict=False):
        assert real.startswith(line.removesuffix("...")), shown
        assert line.endswith("...") or real == line, shown
    # What follows the last line that was asked for is too much for a first look.
    left_out = shown[len(alike(sample())) :]
    assert all(line.startswith("  [") for line in left_out), left_out
