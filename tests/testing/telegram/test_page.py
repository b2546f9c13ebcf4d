"""docs/fake-bot-api.md says what is true."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from aiohttp import ClientSession

from rosic.app.config import read_config
from rosic.testing.telegram import Control, FakeTelegram
from rosic.testing.telegram.control_door import VERBS
from rosic.testing.telegram.door import METHODS
from rosic.testing.telegram.server import DEFAULT_TOKEN

PAGE = (Path(__file__).parents[3] / "docs" / "fake-bot-api.md").read_text(encoding="utf-8")
SOURCES = "".join(
    path.read_text(encoding="utf-8")
    for path in sorted((Path(__file__).parents[3] / "src/rosic/testing/telegram").rglob("*.py"))
)
DOCUMENTATION = "https://core.telegram.org/bots/api"
BLOCKS = re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL)


@pytest.mark.parametrize("block", BLOCKS)
async def test_the_examples_run(block: str) -> None:
    names: dict[str, object] = {}
    exec(compile(block, "docs/fake-bot-api.md", "exec"), names)  # noqa: S102 - our own page
    example = names["example"]
    assert callable(example)
    await example()


def test_the_address_and_the_token_for_rosic_are_right(tmp_path: Path) -> None:
    [block] = re.findall(r"```toml\n(.*?)```", PAGE, re.DOTALL)
    config = tmp_path / "rosic.toml"
    config.write_text(f'{block}[[robot]]\nprofile = "omni"\nlink = "memory"\n', encoding="utf-8")
    environ = {"ROSIC_TELEGRAM_TOKEN": DEFAULT_TOKEN}
    assert [str(error) for error in read_config(config, environ=environ).errors] == []
    assert f"ROSIC_TELEGRAM_TOKEN={DEFAULT_TOKEN} rosic run" in block
    [ready] = re.findall(r"^ready (\S+)$", PAGE, re.MULTILINE)
    assert f'api_base = "{ready}/bot"' in block
    assert f"Without it that is `{DEFAULT_TOKEN}`" in PAGE


async def test_what_is_given_to_press_and_put_update_over_http_is_as_it_says() -> None:
    async with FakeTelegram() as server, Control(server.url) as control:
        ada = server.create_user("Ada")
        await control.call("put_update", kind="poll", payload={"id": "1"})
        assert await control.call("pending") == 1
        keyboard = {"inline_keyboard": [[{"text": "Yes", "callback_data": "y"}]]}
        async with (
            ClientSession() as bot,
            bot.post(
                f"{server.api_base}{server.token}/sendMessage",
                json={"chat_id": ada, "text": "Well?", "reply_markup": keyboard},
            ) as answer,
        ):
            message = (await answer.json())["result"]["message_id"]
        pressed = await control.tap(ada, ada, message, "Yes")
        assert (await control.call("press", query_id=pressed))["data"] == "y"
    assert "parameter `query_id`" in PAGE
    assert '{"kind": "message", "payload": {...}}' in PAGE


def test_there_are_examples() -> None:
    assert len(BLOCKS) == 3


def test_every_verb_is_explained() -> None:
    assert [verb for verb in VERBS if f"`{verb}" not in PAGE] == []


def test_every_method_has_a_row_that_says_what_it_refuses_and_what_is_left_out() -> None:
    _, _, record = PAGE.partition("## Every method")
    rows = [line.split("|") for line in record.splitlines() if line.startswith("| [`")]
    named = [found for row in rows for found in re.findall(r"\[`(\w+)`\]\((\S+)\)", row[1])]
    assert sorted(name for name, _ in named) == sorted(METHODS)
    wrong = [name for name, page in named if page != f"{DOCUMENTATION}#{name.lower()}"]
    assert wrong == [], "a method is documented elsewhere"
    assert {len(row) for row in rows} == {6}


@pytest.mark.parametrize(
    "words",
    sorted(
        {
            words
            for row in PAGE.partition("## Every method")[2].splitlines()
            if row.startswith("| [`")
            for words in re.findall(r"`([^`]+)`", row.split("|")[3])
            if "..." not in words and words not in {"retry_after", "Logged out"}
        }
    ),
)
def test_the_words_of_a_refusal_are_those_of_the_server(words: str) -> None:
    assert words in SOURCES or words.removesuffix(" not found") in SOURCES
