"""Which plays there are, by the name that is typed."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from rosic.app.plays.play import Play

# Name to module, so that whoever wants one play, or none, imports no other.
NAMES: Final = {
    "one-to-one": ("one_to_one", "ONE_TO_ONE"),
    "class": ("lesson", "LESSON"),
    "fleet": ("fleet", "FLEET"),
    "shift": ("shift", "SHIFT"),
    "swarm": ("swarm", "SWARM"),
}


def play_named(name: str) -> Play:
    """Return a play of `NAMES`."""
    module, play = NAMES[name]
    found: Play = getattr(import_module(f"rosic.app.plays.{module}"), play)
    return found
