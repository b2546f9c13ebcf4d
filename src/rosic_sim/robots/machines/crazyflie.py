"""A Crazyflie 2.1 that keeps clear of its peers by itself."""

from __future__ import annotations

from math import hypot, isfinite, pi
from typing import TYPE_CHECKING

from rosic.core.i18n import said
from rosic.core.time_units import HOUR_S
from rosic.core.units import measured, number_in_units
from rosic_sim.robots.machines.activity import ActivityFailed, ActivityRefused, ActivityState
from rosic_sim.robots.machines.flight import NEAR_M, Flight, flight_time_s
from rosic_sim.robots.machines.following import NEAREST_M, FollowTarget, why_not
from rosic_sim.robots.machines.machine import Battery
from rosic_sim.robots.machines.stepped_machine import Plan, Recipe, SteppedMachine
from rosic_sim.robots.machines.swarm import (
    APART_M,
    KEEP_M,
    Place,
    SeparationBound,
    Swarm,
    SwarmReport,
    bound,
    slots,
)

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rosic_sim.robots.machines.arguments import MachineArguments


# ---- keeping clear of others ----

PEER_LOST_S = 1.0


class SwarmPeers:
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


# ---- the drone ----

# Bitcraze "Datasheet Crazyflie 2.1": flight time with the stock battery 7 minutes.
FLIGHT_LASTS_S = 420.0
# Assumed: electronics on, motors off.
IDLE_LASTS_S = 4.0 * HOUR_S
LOWEST_TAKEOFF = 0.20
LOWEST_FLIGHT = 0.10
# Assumed: the room.
LOWEST_M, HIGHEST_M = 0.2, 2.5
ROOM_M = 3.0
NARROWEST_M, WIDEST_M = 0.6, 2.0
# Crazyflie firmware, commander: without set-points it levels out, then falls back to the commander
# of lower priority: here the on-board one, which lands. (Without that one the motors are cut.)
LEVEL_AFTER_S = 1.0
LAND_AFTER_S = 2.0
REPORT_S = 0.05
# Assumed: a flight fails when it is this much later than it would be undisturbed.
PATIENCE_S = 25.0


class Crazyflie(SteppedMachine):
    """Skills: ``takeoff``, ``land``, ``goto``, ``formation``, ``follow``; streamed positions.

    Promises, kept by the drone alone from what is in `swarm`: its centre stays at least
    `APART_M` from every peer's, horizontally, flying or not; and when a peer that flies has not
    been heard for `PEER_LOST_S`, it lands where it is. A flight ends within 2 cm of its goal, or
    fails in a hover when a peer stays in the way. Stopping means: brake and land here.

    Drones of one process are stepped together (`World.step`), at most `PEER_LOST_S` apart.

    Attributes:
        flight: Where it is.
        swarm: What it knows of its peers.
        silent: True when its reports do not get out (a fault).
    """

    def __init__(self, robot: str, swarm: Swarm, place: Place) -> None:
        self._cell = Battery()
        super().__init__(robot, self._cell)
        self.flight = Flight(*place)
        self.swarm = swarm
        self._peers = SwarmPeers(robot, swarm)
        self.silent = False
        self.airborne = False
        self._landing = False
        self._setpoint_s: float | None = None
        self._reported_s = 0.0
        self._from = (*place, 0.0)
        self._started_s: float | None = None
        self._intent: Place = place
        self._leader = ""
        self._plans: dict[str, Plan] = {
            "takeoff": self._plan_takeoff,
            "land": self._plan_land,
            "goto": self._plan_goto,
            "formation": self._plan_formation,
            "follow": self._plan_follow,
        }
        self._report(0.0)

    # ----------------------------------------------------------------------------------- set-points

    def set_position(self, x_m: float, y_m: float, z_m: float, now_s: float) -> None:
        """Fly to a position, streamed: without a new one for 1 s it levels out, for 2 s it lands.

        Raises:
            ActivityRefused: Not finite, out of the room, not flying, landing, or a skill is
                running. Nothing has changed.
        """
        self.step(now_s)
        if not all(map(isfinite, (x_m, y_m, z_m))):
            raise ActivityRefused(self.id, said("a position is not a finite number"))
        if max(abs(x_m), abs(y_m)) > ROOM_M or not LOWEST_M <= z_m <= HIGHEST_M:
            raise ActivityRefused(self.id, said("that is out of the room"))
        if self.activity is not None and self.activity.running:
            raise ActivityRefused(self.id, said("busy with {skill}", skill=self.activity.skill))
        self._must_fly()
        self._setpoint_s = now_s
        self.flight.fly_to((x_m, y_m), z_m)

    # --------------------------------------------------------------------------------------- plans

    def _plan(self, skill: str) -> Plan | None:
        return self._plans.get(skill)

    def _must_fly(self) -> None:
        if not self.airborne:
            raise ActivityRefused(self.id, said("on the ground, take off first"))
        if self._landing:
            raise ActivityRefused(self.id, "landing")

    def _plan_takeoff(self, asked: MachineArguments) -> Recipe:
        height = asked.number("height_m", LOWEST_M, HIGHEST_M, 1.0)
        if self.airborne:
            raise ActivityRefused(self.id, said("already flying"))
        if self._cell.fraction < LOWEST_TAKEOFF:
            raise ActivityRefused(
                self.id, said("battery {percent} %: too low", percent=self._cell.percent)
            )
        distance, peer = self._peers.nearest(self._here())
        if distance < APART_M:
            raise ActivityRefused(self.id, said("{peer} is too near to take off", peer=peer))
        lost = self._peers.unheard(self._time_s)
        if lost is not None:
            raise ActivityRefused(self.id, said("{lost} flies and is not heard", lost=lost))
        self._intent = self._here()
        return self._recipe_takeoff(height)

    def _plan_land(self, _asked: MachineArguments) -> Recipe:
        self._intent = self.flight.rest_place()
        return self._recipe_land()

    def _plan_goto(self, asked: MachineArguments) -> Recipe:
        x = asked.number("x_m", -ROOM_M, ROOM_M)
        y = asked.number("y_m", -ROOM_M, ROOM_M)
        z = asked.number("z_m", LOWEST_M, HIGHEST_M, max(LOWEST_M, self.flight.height.position))
        self._must_fly()
        peer = self._peers.at((x, y))
        if peer is not None:
            raise ActivityRefused(self.id, said("{peer} is there or on its way there", peer=peer))
        self._intent = (x, y)
        return self._recipe_fly(x, y, z)

    def _plan_formation(self, asked: MachineArguments) -> Recipe:
        shape = asked.choice("shape", ("line", "triangle", "column"), "line")
        spacing = asked.number("spacing_m", NARROWEST_M, WIDEST_M, 0.8)
        self._must_fly()
        members = self.swarm.members
        if shape == "triangle" and len(members) != 3:  # noqa: PLR2004
            raise ActivityRefused(self.id, said("a triangle needs three drones"))
        places = slots(shape, spacing, len(members), self.swarm.centre)
        x, y = places[members.index(self.id)]
        self._intent = (x, y)
        return self._recipe_fly(x, y, self.flight.height.target)

    def _plan_follow(self, asked: MachineArguments) -> Recipe:
        others = tuple(name for name in self.swarm.members if name != self.id)
        leader = asked.choice("leader", others)
        gap_m = asked.number("distance_m", NEAREST_M, WIDEST_M, 1.2)
        bearing_rad = asked.number("bearing_rad", -pi / 2, pi / 2, 0.0)
        self._must_fly()
        why = why_not(self.swarm, self.id, leader)
        if why:
            raise ActivityRefused(self.id, why)
        return self._recipe_follow(
            FollowTarget(self.swarm, leader, gap_m, bearing_rad, self._here())
        )

    # -------------------------------------------------------------------------------------- recipes

    def _recipe_takeoff(self, height_m: float) -> Recipe:
        flight = self.flight
        self._stage(said("taking off"))
        self._started_s = self._time_s
        self.airborne = True
        flight.fly_to((flight.x_m, flight.y_m), height_m)
        while not flight.height.arrived:
            self._advance(flight.height.position / height_m)
            yield
        height_m = flight.height.position
        return said("hovering at {height}", height=measured(f"{height_m:.1f} m", height_m, "m"))

    def _recipe_land(self) -> Recipe:
        if not self.airborne:
            return said("on the ground")
        self._stage(said("landing"))
        self._started_s = self._time_s
        height = max(self.flight.height.position, NEAR_M)
        self._land()
        while self.airborne:
            self._advance(1.0 - self.flight.height.position / height)
            yield
        return said("landed")

    def _recipe_fly(self, x_m: float, y_m: float, z_m: float) -> Recipe:
        flight = self.flight
        self._stage(said("flying"))
        self._started_s = self._time_s
        flight.fly_to((x_m, y_m), z_m)
        whole = max(flight.left_m() + abs(z_m - flight.height.position), NEAR_M)
        about_s = flight_time_s(flight.left_m(), z_m - flight.height.position)
        until_s = self._time_s + about_s + PATIENCE_S
        while not (flight.left_m() < NEAR_M and flight.steady and flight.height.arrived):
            if self._time_s > until_s:
                flight.hover()
                raise ActivityFailed(
                    said(
                        "{nearest} is in the way, hovering",
                        nearest=self._peers.nearest(self._here())[1],
                    )
                )
            left = flight.left_m() + abs(z_m - flight.height.position)
            self._advance(1.0 - left / whole)
            yield
        return said(
            "at {x}, {y}, {z}",
            x=number_in_units(round(flight.x_m, 2) + 0.0, "m"),  # no -0.00
            y=number_in_units(round(flight.y_m, 2) + 0.0, "m"),
            z=measured(f"{flight.height.position:.2f} m", flight.height.position, "m"),
        )

    def _recipe_follow(self, chase: FollowTarget) -> Recipe:
        """Keep behind another until its order is over, then come to rest there."""
        self._stage(said("following {leader}", leader=chase.leader))
        self._started_s = self._time_s
        self._leader = chase.leader
        try:
            for place in chase.fly(self.id, self.flight, lambda: self._time_s):
                self._intent = place
                yield
        finally:  # also when it is stopped
            self._leader = ""
        return chase.done(self._here(), self._time_s)

    # ------------------------------------------------------------------------------------ mechanics

    def _land(self) -> None:
        """From now on: brake, hold the place, descend, switch the motors off."""
        self._setpoint_s = None
        self.flight.hold_place()
        if self.airborne:
            self._landing = True
            self.flight.height.aim(0.0)

    def _brake(self) -> None:
        self._land()

    def _after_failure(self) -> None:
        """A flight that finds no way hovers; the recipe has seen to it."""

    def _settled(self) -> bool:
        return not self.airborne or self.holding

    def link_lost(self, now_s: float) -> None:
        """Land where it is; see `Machine.link_lost`."""
        if self.airborne:
            self.note = said("link lost, landing")
        self._give_up(now_s, said("link lost, landing"))

    def cut_link(self, now_s: float) -> None:
        """Fall silent to its peers as well, and land where it is."""
        self.silent = True
        super().cut_link(now_s)

    def mend_link(self, now_s: float) -> None:
        """Be heard by its peers again, at once."""
        super().mend_link(now_s)
        self.silent = False
        self.swarm.hear(self.sighting(now_s))

    def _watch(self) -> None:
        if not self.airborne or self._landing:
            return
        reason = self._reason_to_land()
        if reason:
            self.note = said("{reason}, landing", reason=reason)
            self._land()
            self._end(ActivityState.FAILED, self.note)
        elif self._setpoint_s is not None and self._time_s - self._setpoint_s >= LEVEL_AFTER_S:
            self.flight.hover()

    def _reason_to_land(self) -> str:
        if self._cell.fraction < LOWEST_FLIGHT:
            return said("battery {percent} %", percent=self._cell.percent)
        if self._setpoint_s is not None and self._time_s - self._setpoint_s >= LAND_AFTER_S:
            return said("no set-point for {land_after_s:g} s", land_after_s=LAND_AFTER_S)
        lost = self._peers.unheard(self._time_s)
        return (
            said("{lost} not heard for {peer_lost_s:g} s", lost=lost, peer_lost_s=PEER_LOST_S)
            if lost is not None
            else ""
        )

    def _here(self) -> Place:
        return (self.flight.x_m, self.flight.y_m)

    def _drive(self, dt_s: float) -> None:
        if not self.airborne:
            self._cell.drain(dt_s, IDLE_LASTS_S)
            return
        self.flight.step(dt_s, self._peers.bounds(self._here(), self._time_s))
        self._cell.drain(dt_s, FLIGHT_LASTS_S)
        end_s = self._time_s + dt_s
        if self._landing and self.flight.height.arrived:
            self._touch_down()
            self._report(end_s)
        elif end_s - self._reported_s >= REPORT_S:
            self._report(end_s)

    def _touch_down(self) -> None:
        self.airborne = False
        self._landing = False
        self.flight.touch_down()

    def _report(self, now_s: float) -> None:
        self._reported_s = now_s
        if not self.silent:
            self.swarm.hear(self.sighting(now_s))

    def sighting(self, now_s: float) -> SwarmReport:
        """Return what the drone says of itself now."""
        flight = self.flight
        x, y = self._intended()
        return SwarmReport(
            self.id,
            now_s,
            flight.x_m,
            flight.y_m,
            flight.height.position,
            flight.speed_m_s,
            x,
            y,
            self.airborne,
            flight.vx_m_s,
            flight.vy_m_s,
            self._setpoint_s is not None or (self.activity is not None and self.activity.running),
            self._landing,
            self._leader,
        )

    def _intended(self) -> Place:
        """Return where this drone is going or stays."""
        if self.activity is not None and self.activity.running and not self._landing:
            return self._intent
        return self.flight.goal if self.flight.goal is not None else self.flight.rest_place()

    def _idle(self, dt_s: float) -> None:
        self._cell.drain(dt_s, IDLE_LASTS_S)

    def _in_motion(self) -> bool:
        return self.airborne

    def at_rest(self) -> bool:
        """True when on the ground with the motors off."""
        return not self.airborne

    @property
    def holding(self) -> bool:
        """True when hovering steadily and not landing."""
        return self.airborne and not self._landing and self.flight.steady

    def _mark(self) -> None:
        self._from = (self.flight.x_m, self.flight.y_m, self.flight.height.position)
        self._started_s = None
        if self._setpoint_s is not None:  # the on-board commander takes over, in a hover
            self._setpoint_s = None
            self.flight.hold_place()
        self._report(self._time_s)

    def _measured(self) -> dict[str, float]:
        x, y, z = self._from
        flight = self.flight
        facts = {
            "distance_m": hypot(flight.x_m - x, flight.y_m - y, flight.height.position - z),
            "x_m": flight.x_m,
            "y_m": flight.y_m,
            "z_m": flight.height.position,
        }
        if self._started_s is not None:
            facts["started_s"] = self._started_s
        return facts

    def _mode(self) -> str:
        if not self.airborne:
            return said("on the ground")
        if self._landing:
            return said("landing")
        return said("hovering") if self.flight.steady else said("flying")

    def telemetry(self) -> Mapping[str, float | str]:
        """Position and velocity in the room's frame, battery, and what it does."""
        flight = self.flight
        return {
            "x_m": flight.x_m,
            "y_m": flight.y_m,
            "z_m": flight.height.position,
            "velocity_x_m_s": flight.vx_m_s,
            "velocity_y_m_s": flight.vy_m_s,
            "velocity_z_m_s": flight.height.velocity,
            "battery": self._cell.fraction,
            "mode": self._mode(),
            "note": self.note,
        }
