"""uvicorn is bounded to the minor that the connections were written for and tested with."""

from __future__ import annotations

import tomllib
from importlib.metadata import version
from pathlib import Path

PROJECT = Path(__file__).parents[2] / "pyproject.toml"


def test_no_other_minor_of_uvicorn_is_installed_with_the_api() -> None:
    extras = tomllib.loads(PROJECT.read_text())["project"]["optional-dependencies"]
    [asked] = [each for each in extras["api"] if each.startswith("uvicorn")]
    major, minor = map(int, version("uvicorn").split(".")[:2])
    assert asked == f"uvicorn>={major}.{minor},<{major}.{minor + 1}"
