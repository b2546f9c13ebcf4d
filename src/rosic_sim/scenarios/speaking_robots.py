"""Simulated robots whose own nodes speak with each other, as a play has them speak."""

from __future__ import annotations

from typing import TYPE_CHECKING

import msgspec

from rosic_sim.robots.robot import SimulatedRobot

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping
    from typing import Any

    from rosic.contracts.clock import Clock
    from rosic.core.order_gate import OrderGate
    from rosic.core.robot.profile import Profile


class SpeakingRobot(SimulatedRobot):
    """A simulated robot, and what its own nodes say and hear. See ``contracts.robot.PeerRobot``.

    Attributes:
        heard: Everything it was told, decoded.
        reacts: Its nodes: called with each thing it is told.
    """

    def __init__(self, profile: Profile, gate: OrderGate, clock: Clock) -> None:
        super().__init__(profile, gate, clock)
        self.heard: list[dict[str, Any]] = []
        self.reacts: Callable[[Mapping[str, Any]], None] | None = None

    def says(self, kind: str, **said: Any) -> None:  # noqa: ANN401 - any JSON
        """Have its nodes say something."""
        self.speak(msgspec.json.encode({"kind": kind, **said}), 0)

    def hear(self, words: bytes) -> bool:
        """Bring something to its nodes; the machine itself takes on strategies."""
        told = msgspec.json.decode(words)
        self.heard.append(told)
        if self.reacts is not None:
            self.reacts(told)
        return super().hear(words)
