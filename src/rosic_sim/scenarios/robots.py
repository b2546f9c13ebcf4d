"""The robots of the plays: profiles that ship, and three more beside this module."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import msgspec
from msgspec.structs import replace

from rosic.config.profiles import known_units, load_profile, shipped_profiles
from rosic_sim.robots.robot import SimulatedRobot

if TYPE_CHECKING:
    from typing import Any

    from rosic.contracts.clock import Clock
    from rosic.core.order_gate import OrderGate
    from rosic.core.robot.profile import Profile


# ---- speaking robots ----

# Simulated robots whose own nodes speak with each other, as a play has them speak.


class SpeakingRobot(SimulatedRobot):
    """A simulated robot, and what its own nodes say and hear. See ``contracts.robot.PeerRobot``.

    Attributes:
        heard: Everything it was told, decoded.
    """

    def __init__(self, profile: Profile, gate: OrderGate, clock: Clock) -> None:
        super().__init__(profile, gate, clock)
        self.heard: list[dict[str, Any]] = []
        self._helps = False

    def help_others(self) -> None:
        """Have its nodes accept whatever call for help they hear from now on."""
        self._helps = True

    def says(self, kind: str, **said: Any) -> None:  # noqa: ANN401 - any JSON
        """Have its nodes say something."""
        self.speak(msgspec.json.encode({"kind": kind, **said}), 0)

    def hear(self, words: bytes) -> bool:
        """Bring something to its nodes; the machine itself takes on strategies."""
        told = msgspec.json.decode(words)
        self.heard.append(told)
        if self._helps and told["kind"] == "help":
            self.says("accept", id=told["id"])
        return super().hear(words)


# ---- robots ----

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
