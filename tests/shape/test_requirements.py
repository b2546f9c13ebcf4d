"""The pinned requirements say the same as the project, and as each other."""

from __future__ import annotations

import re
import tomllib
from importlib.metadata import packages_distributions
from pathlib import Path

import pytest

from tests.shape import rules

ROOT = Path(__file__).parents[2]
SETS = ("core", "dev")


def pinned(name: str) -> str:
    return (ROOT / "requirements" / f"{name}.txt").read_text()


def declared(*extras: str) -> set[str]:
    """Names that pyproject.toml asks for, as the pinned files spell them."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    wanted = [*project["dependencies"]]
    for extra in extras:
        wanted += project["optional-dependencies"][extra]
    names = {re.split(r"[^A-Za-z0-9_.-]", line)[0] for line in wanted}
    return {re.sub(r"[-_.]+", "-", name).lower() for name in names} - {"rosic"}


@pytest.mark.parametrize("name", [*SETS, "synapse"])
def test_every_pin_has_its_hash(name: str) -> None:
    assert rules.without_hash(pinned(name)) == []


@pytest.mark.parametrize("name", SETS)
def test_a_smaller_set_grows_into_the_larger_in_place(name: str) -> None:
    assert rules.pins(pinned(name)).items() <= rules.pins(pinned("dev")).items()


def test_everything_declared_is_pinned() -> None:
    assert declared("telegram", "pictures") <= set(rules.pins(pinned("core")))
    assert declared("telegram", "ros2", "testing", "dev") <= set(rules.pins(pinned("dev")))


def test_everything_that_is_always_installed_is_used() -> None:
    sources = [path.read_text() for path in (ROOT / "src").rglob("*.py")]
    used = rules.imported_packages(sources)
    providers = packages_distributions()
    in_use = {
        name.lower().replace("_", "-") for package in used for name in providers.get(package, [])
    }

    assert declared() - in_use == set()
