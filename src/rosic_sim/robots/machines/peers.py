"""What one drone makes of what it knows of the others."""

from __future__ import annotations

from math import hypot
from typing import TYPE_CHECKING

from rosic_sim.robots.machines.separation import KEEP_M, SeparationBound, bound

if TYPE_CHECKING:
    from rosic_sim.robots.machines.swarm import Place, Swarm

PEER_LOST_S = 1.0


class Peers:
    """The others of a swarm, seen by one drone."""

    def __init__(self, robot: str, swarm: Swarm) -> None:
        self._robot = robot
        self._swarm = swarm

    def bounds(self, here: Place, now_s: float) -> list[SeparationBound]:
        """Return the limits they set to the velocity; an old sighting counts as nearer."""
        return [
            bound(
                here,
                (peer.x_m, peer.y_m),
                peer.speed_m_s * min(max(now_s - peer.time_s, 0.0), PEER_LOST_S),
            )
            for peer in self._swarm.peers(self._robot)
        ]

    def unheard(self, now_s: float) -> str | None:
        """Return a peer that flies, by its last word, and has been silent for too long."""
        for peer in self._swarm.peers(self._robot):
            if peer.flying and now_s - peer.time_s > PEER_LOST_S:
                return peer.robot
        return None

    def at(self, place: Place) -> str | None:
        """Return a peer that is, or will be, too near to a place for two."""
        for peer in self._swarm.peers(self._robot):
            if hypot(peer.goal_x_m - place[0], peer.goal_y_m - place[1]) < KEEP_M:
                return peer.robot
        return None

    def nearest(self, here: Place) -> tuple[float, str]:
        """Return distance and name of the nearest peer; infinitely far when there is none."""
        found = [
            (hypot(peer.x_m - here[0], peer.y_m - here[1]), peer.robot)
            for peer in self._swarm.peers(self._robot)
        ]
        return min(found, default=(float("inf"), "nobody"))
