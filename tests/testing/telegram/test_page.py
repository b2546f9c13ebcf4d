"""docs/fake-bot-api.md says what is true."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from rosic.testing.telegram.control_door import VERBS
from rosic.testing.telegram.dispatch import METHODS

PAGE = (Path(__file__).parents[3] / "docs" / "fake-bot-api.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL)


@pytest.mark.parametrize("block", BLOCKS)
async def test_the_examples_run(block: str) -> None:
    names: dict[str, object] = {}
    exec(compile(block, "docs/fake-bot-api.md", "exec"), names)  # noqa: S102 - our own page
    example = names["example"]
    assert callable(example)
    await example()


def test_there_are_examples() -> None:
    assert len(BLOCKS) == 3


def test_every_verb_is_explained() -> None:
    assert [verb for verb in VERBS if f"`{verb}" not in PAGE] == []


def test_every_method_is_named() -> None:
    short = {
        "editMessageCaption": "-Caption",
        "editMessageReplyMarkup": "-ReplyMarkup",
        "getMyCommands": "setMyCommands, get, delete",
        "deleteMyCommands": "setMyCommands, get, delete",
        "setMyDescription": "-Description",
        "setMyShortDescription": "-ShortDescription",
    }
    unnamed = [name for name in METHODS if short.get(name, name) not in PAGE]
    assert unnamed == ["getMe", "getMyName", "getMyDescription", "getMyShortDescription"]
