"""The robots of the plays: profiles that ship, and three more beside this module."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from msgspec.structs import replace

from rosic.config.profiles import known_units, load_profile, shipped_profiles

if TYPE_CHECKING:
    from rosic.core.robot.profile import Profile

SIMULATED = "simulated"
FOLDER = Path(__file__).with_name("robots")


def shipped(*names: str) -> tuple[Profile, ...]:
    """Return profiles that ship, reached in this process."""
    known = shipped_profiles()
    return tuple(load_profile(known[name], known_units(), link=SIMULATED) for name in names)


def prop(kind: str) -> Profile:
    """Return one of the plays' own profiles, reached in this process."""
    return load_profile(FOLDER / f"{kind}.yaml", known_units(), link=SIMULATED)


def several(kind: str, groups: tuple[tuple[str, ...], ...]) -> tuple[Profile, ...]:
    """Return robots of one kind, numbered from 1, each in its groups."""
    first = prop(kind)
    return tuple(
        replace(first, id=f"{kind}{n}", title=f"{first.title} {n}", groups=(f"{kind}s", *own))
        for n, own in enumerate(groups, 1)
    )
