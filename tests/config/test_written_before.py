"""Profiles that were written for earlier versions are read as they were read then.

``written_before`` holds the profiles that shipped with commit a428673, one with nearly every key,
and what that commit made of each: ``read.json``, without what was empty.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import msgspec
import pytest

from rosic.config.profiles import read_profile, shipped_profiles
from tests.config.profile_text import SHIPPED_KINDS

if TYPE_CHECKING:
    from rosic.core.robot.profile import Profile

FOLDER = Path(__file__).parent / "written_before"
READ: dict[str, Any] = json.loads((FOLDER / "read.json").read_text(encoding="utf-8"))
OF_A_PLAY = "play_"  # these are played by simulated robots, whatever link they name


def read(path: Path, link: str) -> Profile:
    found = read_profile(path, link=link)
    assert [str(error) for error in found.errors] == []
    assert found.profile is not None
    return found.profile


def lost(then: object, now: object, place: str = "") -> list[str]:
    """Say what was read then and is not read now, or otherwise."""
    if isinstance(then, dict):
        known = now if isinstance(now, dict) else {}
        return [
            one
            for key, value in then.items()
            for one in lost(value, known.get(key), f"{place}.{key}")
        ]
    if isinstance(then, list):
        items = (
            now if isinstance(now, list | tuple) and len(now) == len(then) else [None] * len(then)
        )
        return [
            one
            for index, pair in enumerate(zip(then, items, strict=True))
            for one in lost(*pair, f"{place}[{index}]")
        ]
    return [] if then == now else [f"{place}: {then!r} is {now!r}"]


@pytest.mark.parametrize("name", sorted(READ))
@pytest.mark.parametrize("link", ["as written", "simulated", "memory"])
def test_a_profile_is_read_as_it_was(name: str, link: str) -> None:
    given = link if link != "as written" else "simulated" if name.startswith(OF_A_PLAY) else ""
    now = msgspec.to_builtins(read(FOLDER / f"{name}.yaml", given))
    then = READ[name] | {"link": READ[name]["link"] | ({"kind": given} if given else {})}
    assert lost(then, now) == []


def test_every_profile_of_then_is_there() -> None:
    assert set(READ) == {path.stem for path in FOLDER.glob("*.yaml")}
    assert len(READ) == 11


@pytest.mark.parametrize("name", sorted(shipped_profiles()))
@pytest.mark.parametrize("link", ["", *SHIPPED_KINDS])
def test_a_profile_that_ships_is_read_by_every_kind(name: str, link: str) -> None:
    assert read(shipped_profiles()[name], link).id == name


def test_what_is_lost_is_noticed() -> None:
    then = {"a": [1, {"b": "x"}], "c": True}
    assert lost(then, {"a": [1, {"b": "x"}], "c": True, "new": 2}) == []
    assert lost(then, {"a": [1, {}], "c": False}) == [".a[1].b: 'x' is None", ".c: True is False"]
    assert lost(then, {"a": [1], "c": True}) == [".a[0]: 1 is None", ".a[1].b: 'x' is None"]
