"""``[language]``: what an endpoint may be, what is said about it, and where its key stands."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from rosic.app.builder import secrets_of
from rosic.app.config import ReadConfig, read_config
from rosic.interpreters.endpoint import Endpoint, parse_endpoint
from tests.config.profile_text import write

if TYPE_CHECKING:
    from pathlib import Path

FILE = """\
[[messenger]]
kind = "terminal"

[[robot]]
profile = "omni"
link = "simulated"

[language]
"""


def read(folder: Path, language: str, **environ: str) -> ReadConfig:
    return read_config(write(folder, FILE + language, "rosic.toml"), environ=environ)


def errors(folder: Path, language: str) -> str:
    return "\n".join(map(str, read(folder, language).errors))


@pytest.mark.parametrize(
    ("address", "endpoint"),
    [
        ("http://127.0.0.1:11434", Endpoint(False, "127.0.0.1", 11434, "/v1/chat/completions")),
        ("http://localhost/v1", Endpoint(False, "localhost", 80, "/v1/chat/completions")),
        ("https://a.example/api/", Endpoint(True, "a.example", 443, "/api/v1/chat/completions")),
        ("http://[::1]:8000/v1/", Endpoint(False, "::1", 8000, "/v1/chat/completions")),
    ],
)
def test_an_address_is_taken_apart(address: str, endpoint: Endpoint) -> None:
    assert parse_endpoint(address) == endpoint


@pytest.mark.parametrize(
    "address",
    [
        "127.0.0.1:11434",
        "ftp://a.example",
        "http://",
        "http://user:pw@a.example",
        "http://a.example?key=1",
        "http://a.example#x",
        "http://a.example:99999",
        "http://a.example:0",
        "http://a b.example",
        "http://a.example/\\r\\nX: 1",
        "http://a.example/%0d%0a",
        "http://ä.example",
        "file:///etc/passwd",
    ],
)
def test_what_is_no_endpoint_is_refused_in_one_sentence(address: str, tmp_path: Path) -> None:
    said = errors(tmp_path, f'endpoint = "{address}"\nmodel = "m"\n')
    assert said.startswith("rosic.toml:9:") or "rosic.toml:9:" in said
    assert len(said.splitlines()) == 1
    assert "pw" not in said


@pytest.mark.parametrize(
    ("language", "sentence"),
    [
        ('model = "m"\n', "No endpoint is named"),
        ('endpoint = "http://localhost"\n', "'model' names none of its models"),
        ('endpoint = "http://localhost"\nmodel = "a b"\n', "'model' names none of its models"),
        ('endpoint = "http://localhost"\nmodel = "m"\ntimeout_s = 60\n', "between 0.1 and 30"),
        ('endpoint = "http://localhost"\nmodel = "m"\nkey = 3\n', "'key' must be"),
        ('endpoint = "http://localhost"\nmodel = "m"\nkey = { env = "K" }\n', "K is not set"),
    ],
)
def test_what_is_wrong_is_said(language: str, sentence: str, tmp_path: Path) -> None:
    assert sentence in errors(tmp_path, language)


def test_nobody_is_asked_unless_somebody_is_named(tmp_path: Path) -> None:
    config = read(tmp_path, "").config
    assert config is not None
    assert config.interpreter is None


@pytest.mark.parametrize("address", ["http://127.0.0.1:1", "http://[::1]", "http://localhost:2"])
def test_of_this_machine_nothing_is_said(address: str, tmp_path: Path) -> None:
    found = read(tmp_path, f'endpoint = "{address}"\nmodel = "m"\n')
    assert found.config is not None
    assert found.advice == []


def test_that_text_leaves_the_house_is_said(tmp_path: Path) -> None:
    found = read(tmp_path, 'endpoint = "https://a.example"\nmodel = "m"\n')
    (advice,) = map(str, found.advice)
    assert "rosic.toml:9" in advice
    assert "leaves this machine: it is sent to a.example" in advice
    assert "cost" in advice


def test_that_it_goes_in_the_clear_is_said(tmp_path: Path) -> None:
    language = 'endpoint = "http://10.0.0.7:8000"\nmodel = "m"\nkey = { env = "K" }\n'
    found = read(tmp_path, language, K="sk-1")
    assert found.errors == []
    assert "What they write and the key go to 10.0.0.7:8000 in the clear" in str(found.advice[1])


@pytest.mark.parametrize("key", ['{ env = "K" }', '"sk-very-secret"'])
def test_the_key_is_a_secret_that_no_log_shows(key: str, tmp_path: Path) -> None:
    language = f'endpoint = "http://localhost"\nmodel = "m"\nkey = {key}\n'
    config = read(tmp_path, language, K="sk-very-secret").config
    assert config is not None
    assert "sk-very-secret" not in repr(config)
    assert [secret.reveal() for secret in secrets_of(config)] == ["sk-very-secret"]
