"""`[language]` in rosic.toml, and a gateway is made that asks the endpoint it names."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from rosic.app.builder import latch_of, parts_of
from rosic.app.config import load_config
from rosic.app.setup.check import check_all
from rosic.system import SystemClock, SystemEntropy
from tests.interpreters.hostile import GOOD
from tests.interpreters.scripted import ScriptedEndpoint, saying

if TYPE_CHECKING:
    from pathlib import Path

    from rosic.contracts.interpreter import Interpreter

CONFIG = """
[[messenger]]
kind = "terminal"
[[robot]]
profile = "omni"
link = "memory"
"""


def interpreter_of(folder: Path, language: str) -> Interpreter | None:
    path = folder / "rosic.toml"
    path.write_text(CONFIG + language)
    config = load_config(path, environ={"K": "sk-1"})
    return parts_of(config, latch_of(config), SystemClock(), SystemEntropy()).interpreter


async def test_the_endpoint_that_is_named_is_asked(tmp_path: Path) -> None:
    with ScriptedEndpoint(saying(GOOD)) as endpoint:
        language = f"""
[language]
endpoint = "{endpoint.address}/v1"
model = "small-7"
key = {{ env = "K" }}
"""
        interpreter = interpreter_of(tmp_path, language)
        assert interpreter is not None
        assert interpreter.where == ""
        assert (await interpreter.ask("rules", "text")).text == GOOD
        assert endpoint.calls[0].body["model"] == "small-7"
        assert "Authorization: Bearer sk-1\r\n" in endpoint.calls[0].head + "\r\n"


def test_without_one_nobody_is(tmp_path: Path) -> None:
    assert interpreter_of(tmp_path, "") is None


@pytest.mark.parametrize("where", ["http://llm.example.com", "https://10.0.0.7:8000"])
def test_check_says_that_text_leaves_the_house(tmp_path: Path, where: str) -> None:
    path = tmp_path / "rosic.toml"
    path.write_text(f'{CONFIG}[language]\nendpoint = "{where}"\nmodel = "m"\n')
    found = check_all(path, SystemClock())
    assert found.errors == []
    assert any("leaves this machine" in str(advice) for advice in found.advice)
