"""Which plays there are, by the name that is typed."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from rosic_sim.scenarios.scenario import Scenario

# Name to module, so that whoever wants one play, or none, imports no other.
NAMES: Final = {
    "one-to-one": ("one_to_one", "ONE_TO_ONE"),
    "class": ("lesson", "LESSON"),
    "fleet": ("fleet", "FLEET"),
    "shift": ("shift", "SHIFT"),
    "swarm": ("swarm", "SWARM"),
}


def play_named(name: str) -> Scenario:
    """Return a play of `NAMES`."""
    module, play = NAMES[name]
    found: Scenario = getattr(import_module(f"rosic_sim.scenarios.{module}"), play)
    return found
