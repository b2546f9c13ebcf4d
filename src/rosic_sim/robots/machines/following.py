"""Where a drone that follows another wants to be: it knows only what that one last said."""

from __future__ import annotations

from math import atan2, cos, hypot, sin
from typing import TYPE_CHECKING

from rosic.core.i18n import said
from rosic.core.units import measured
from rosic_sim.robots.machines.activity import ActivityFailed
from rosic_sim.robots.machines.flight import NEAR_M

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from rosic_sim.robots.machines.flight import Flight
    from rosic_sim.robots.machines.swarm import Place, Swarm, SwarmReport

NEAREST_M = 1.1
"""Nearer, and what keeps drones apart would not let it fly as fast as whom it follows."""
MOVES_M_S = 0.1
"""Slower than this it goes nowhere, and behind it stays where that was."""
EXTRAPOLATED_S = 0.3
TURNS_RAD_S = 0.8
"""Behind moves round the leader no faster than this, so that its follower can."""
WAITS_S = 30.0
SETTLES_S = 5.0


class FollowTarget:
    """One drone behind another.

    Args:
        swarm: What is known of the leader.
        leader: Whom it follows.
        gap_m: How far behind it stays, centre to centre, horizontally.
        bearing_rad: Off straight behind, as seen from the leader; positive is to its left.
        here: Where the follower is: until the leader has moved, straight behind it is there.
    """

    def __init__(
        self, swarm: Swarm, leader: str, gap_m: float, bearing_rad: float, here: Place
    ) -> None:
        self.leader = leader
        self.gap_m = gap_m
        self._swarm = swarm
        self._bearing_rad = bearing_rad
        first = swarm.last(leader)
        x, y = (0.0, 0.0) if first is None else (first.x_m - here[0], first.y_m - here[1])
        self._heading_rad = atan2(y, x) + bearing_rad if (x, y) != (0.0, 0.0) else 0.0
        self._busy = False
        self._turned_s = 0.0 if first is None else first.time_s

    def why_over(self, robot: str, waited_s: float) -> str:
        """Return why there is nothing to follow any more; empty while there is.

        Args:
            robot: Who follows.
            waited_s: For how long it has.
        """
        seen = self._swarm.last(self.leader)
        if seen is None or seen.landing or not seen.flying:
            return said("{leader} does not fly any more, hovering", leader=self.leader)
        if goes_round(self._swarm, robot, self.leader):
            return said("{leader} follows this drone itself, hovering", leader=self.leader)
        if not self._busy and not seen.busy and waited_s > WAITS_S:
            return said("{leader} goes nowhere, hovering", leader=self.leader)
        return ""

    def ended(self, begun_s: float) -> bool:
        """Whether the leader did something after the follower began, and does nothing any more.

        By its last word, one that has just ended an order is busy until it speaks again. What it
        said before the follower began is not of what it is followed in.
        """
        seen = self._swarm.last(self.leader)
        if seen is None:
            return False
        if seen.busy and seen.time_s > begun_s:
            self._busy = True
        return self._busy and not seen.busy

    def fly(self, robot: str, flight: Flight, now_s: Callable[[], float]) -> Iterator[Place]:
        """Lead a flight behind the leader, then to rest there; yield where it is to be.

        Raises:
            ActivityFailed: There is nothing to follow any more. It hovers.
        """
        begun_s = now_s()
        try:
            while True:
                why = self.why_over(robot, now_s() - begun_s)
                if why:  # asked first: a leader that was stopped has ended what it did as well
                    raise ActivityFailed(why)
                if self.ended(begun_s):
                    break
                place = self.place(now_s())
                flight.chase(place, self._velocity())
                yield place
            until_s = now_s() + SETTLES_S
            while now_s() < until_s and not (flight.left_m() < NEAR_M and flight.steady):
                place = self.place(now_s())
                flight.chase(place)
                yield place
        finally:  # also when it is stopped
            flight.hold_place()

    def done(self, here: Place, now_s: float) -> str:
        """Return how it ended, as a sentence."""
        gap_m = self.gap_now_m(here, now_s)
        return said(
            "followed {leader}, {gap} behind it at the end",
            leader=self.leader,
            gap=measured(f"{gap_m:.2f} m", gap_m, "m"),
        )

    def place(self, now_s: float) -> Place:
        """Return where the follower belongs at this moment."""
        seen = self._swarm.last(self.leader)
        if seen is None:
            return (0.0, 0.0)
        if seen.speed_m_s > MOVES_M_S:
            self._turn(atan2(seen.vy_m_s, seen.vx_m_s), now_s)
        self._turned_s = now_s
        x, y = _now(seen, now_s)
        behind = self._heading_rad - self._bearing_rad
        return (x - self.gap_m * cos(behind), y - self.gap_m * sin(behind))

    def _turn(self, heading_rad: float, now_s: float) -> None:
        most = TURNS_RAD_S * max(0.0, now_s - self._turned_s)
        off = heading_rad - self._heading_rad
        off = atan2(sin(off), cos(off))  # the short way round
        self._heading_rad += min(max(off, -most), most)

    def _velocity(self) -> Place:
        """Return how fast that place goes with the leader."""
        seen = self._swarm.last(self.leader)
        return (0.0, 0.0) if seen is None else (seen.vx_m_s, seen.vy_m_s)

    def gap_now_m(self, here: Place, now_s: float) -> float:
        """Return how far the leader is."""
        seen = self._swarm.last(self.leader)
        if seen is None:
            return 0.0
        x, y = _now(seen, now_s)
        return hypot(x - here[0], y - here[1])


def goes_round(swarm: Swarm, robot: str, leader: str) -> bool:
    """Whether a leader, or whom it follows, follows the robot itself."""
    for _ in swarm.members:
        seen = swarm.last(leader)
        if seen is None or not seen.leader:
            return False
        if seen.leader == robot:
            return True
        leader = seen.leader
    return True  # they go round among themselves


def why_not(swarm: Swarm, robot: str, leader: str) -> str:
    """Return why a drone cannot begin to follow another; empty if it can."""
    seen = swarm.last(leader)
    if seen is None or not seen.flying or seen.landing:
        return said("{leader} does not fly", leader=leader)
    if goes_round(swarm, robot, leader):
        return said("{leader} follows this drone itself", leader=leader)
    return ""


def _now(seen: SwarmReport, now_s: float) -> Place:
    """Return where a drone is by now, if it has gone on as it said."""
    past_s = min(max(now_s - seen.time_s, 0.0), EXTRAPOLATED_S)
    return (seen.x_m + seen.vx_m_s * past_s, seen.y_m + seen.vy_m_s * past_s)
