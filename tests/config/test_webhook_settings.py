"""`[[webhook]]`: who elsewhere is told what happens, and what is wrong about it."""

from __future__ import annotations

import base64
from typing import TYPE_CHECKING

import pytest

from rosic.api.webhooks.settings import WebhookTopic
from rosic.app.builder import secrets_of
from rosic.app.config import load_config, read_config
from tests.config.profile_text import write

if TYPE_CHECKING:
    from pathlib import Path

TEXT = f"whsec_{base64.b64encode(bytes(range(32))).decode()}"
ENVIRON = {"HOOK": TEXT, "WRONG": "hunter2"}
BASE = """[[messenger]]
kind = "terminal"
[[robot]]
profile = "omni"
link = "simulated"
[[webhook]]
"""
GOOD = BASE + 'url = "https://hooks.example.org/rosic"\nsecret = { env = "HOOK" }\n'


def test_it_is_told_of_everything_signed_with_a_secret_from_elsewhere(tmp_path: Path) -> None:
    config = load_config(write(tmp_path, GOOD, "rosic.toml"), environ=ENVIRON)
    [hook] = config.webhooks
    assert (hook.url, hook.private) == ("https://hooks.example.org/rosic", False)
    assert hook.topics == set(WebhookTopic)
    assert hook.secret.reveal() == TEXT
    assert TEXT not in repr(config)
    assert hook.secret in secrets_of(config), "it is masked in the log"


def test_what_it_is_told_of_and_where_it_may_be_can_be_said(tmp_path: Path) -> None:
    text = GOOD + 'events = ["stops", "alerts"]\nprivate = true\n'
    [hook] = load_config(write(tmp_path, text, "rosic.toml"), environ=ENVIRON).webhooks
    assert hook.topics == {WebhookTopic.STOPS, WebhookTopic.ALERTS}
    assert hook.private


@pytest.mark.parametrize(
    ("old", "new", "sentence"),
    [
        ("https://hooks", "ftp://hooks", "is no address to which something can be posted."),
        ('env = "HOOK"', 'env = "GONE"', "The environment variable GONE is not set."),
        ('env = "HOOK"', 'env = "WRONG"', "A secret of a webhook is whsec_ and 24 to 64 bytes"),
        ("secret", "secrets", "'secrets' is not known here. Did you mean secret?"),
        (
            '"HOOK" }',
            '"HOOK" }\nevents = ["order"]',
            "must be one of orders, stops, robots, alerts",
        ),
    ],
)
def test_what_is_wrong_is_one_sentence_with_its_line(
    tmp_path: Path, old: str, new: str, sentence: str
) -> None:
    path = write(tmp_path, GOOD.replace(old, new), "rosic.toml")
    said = [str(error) for error in read_config(path, environ=ENVIRON).errors]
    assert any(sentence in each for each in said), said
    assert all(each.startswith(f"{path}:") or "rosic.toml:" in each for each in said)
    assert "hunter2" not in " ".join(said)
