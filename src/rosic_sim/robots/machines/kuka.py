"""A KUKA LBR iiwa 7 R800 with a parallel gripper, at a table."""

from __future__ import annotations

from math import degrees, radians
from typing import TYPE_CHECKING

from rosic.core.i18n import said
from rosic.core.language.formatting import show_choice
from rosic.core.units import measured
from rosic_sim.robots.machines.activity import ActivityFailed, ActivityRefused
from rosic_sim.robots.machines.joints import JointGroup, MachineJointLimit
from rosic_sim.robots.machines.kinematics import iiwa_points, iiwa_tool_down
from rosic_sim.robots.machines.objects import Gripper, Position, SimulatedObjects
from rosic_sim.robots.machines.stepped_machine import Plan, Recipe, SteppedMachine

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from rosic_sim.robots.machines.arguments import MachineArguments

# Range and speed of A1 to A7: KUKA "LBR iiwa 7 R800, LBR iiwa 14 R820 Specification", axis data.
# Accelerations: assumed (the maker publishes none).
_AXES = ((170, 98), (120, 98), (170, 100), (120, 130), (170, 140), (120, 180), (175, 180))
IIWA_LIMITS = tuple(
    MachineJointLimit(-radians(reach), radians(reach), radians(speed), 3.0, 10.0)
    for reach, speed in _AXES
)
# Assumed: 30 % of the axis speeds beside people, 10 % close to the thing.
SHARE = 0.3
SLOW_SHARE = 0.1
# Assumed gripper, of the Schunk WSG 50 class: 110 mm opening; closing at 100 mm/s.
OPENING_M = 0.110
CLOSING_M_S = 0.100
FORCE_LOW_N, FORCE_HIGH_N, FORCE_N = 5.0, 40.0, 15.0
# Assumed: taught positions and the room they need.
STATION_M: Position = (0.5, 0.0, 0.05)
ABOVE_M = 0.10
MISS_M = 0.02
LOWEST_TIP_M = 0.02
LOWEST_LINK_M = 0.10
SETTLE_S = 0.2
HOME = (0.0, radians(20), 0.0, radians(-90), 0.0, radians(70), 0.0)
STRAIGHT_UP = (0.0,) * 7
_SAMPLES = 16


class Kuka(SteppedMachine):
    """Skills: ``home``, ``move_joint``, ``grasp``, ``release``. Runs on mains.

    Joint motions end exactly on their targets. Stopped in ordinary motion (30 % speed) the arm
    rests within 0.1 s. A motion that would bring the elbow, the wrist or the finger tips to the
    table is refused before it begins; other collisions are not modelled.

    Attributes:
        arm: Seven joints.
        gripper: Named after the robot.
    """

    def __init__(
        self,
        robot: str = "kuka1",
        things: SimulatedObjects | None = None,
        station_m: Position = STATION_M,
    ) -> None:
        super().__init__(robot)
        self._things = things if things is not None else SimulatedObjects()
        self.arm = JointGroup(IIWA_LIMITS, HOME)
        self.gripper = Gripper(robot, OPENING_M, CLOSING_M_S, self._things)
        self._station = station_m
        x, y, z = station_m
        self._at = self._taught(x, y, z)
        self._above = self._taught(x, y, z + ABOVE_M)
        self._extra: dict[str, float] = {}
        self._plans: dict[str, Plan] = {
            "home": self._plan_home,
            "move_joint": self._plan_move_joint,
            "grasp": self._plan_grasp,
            "release": self._plan_release,
        }

    def _taught(self, x_m: float, y_m: float, z_m: float) -> tuple[float, ...]:
        angles = iiwa_tool_down(x_m, y_m, z_m)
        if angles is None or self.arm.outside(angles) is not None:
            raise ValueError("the station is out of the arm's reach")
        return angles

    # --------------------------------------------------------------------------------------- plans

    def _plan(self, skill: str) -> Plan | None:
        return self._plans.get(skill)

    def _able(self) -> None:
        if not (self.arm.still and self.gripper.still):
            raise ActivityRefused(self.id, said("still coming to rest"))

    def _plan_home(self, _asked: MachineArguments) -> Recipe:
        return self._recipe_home(self._way(HOME))

    def _plan_move_joint(self, asked: MachineArguments) -> Recipe:
        joint = asked.number("joint", 1, len(IIWA_LIMITS))
        angle = asked.number("angle_rad", -10.0, 10.0)
        if joint != int(joint):
            raise ActivityRefused(self.id, said("joint must be a whole number"))
        index = int(joint) - 1
        limit = IIWA_LIMITS[index]
        if not limit.lower_rad <= angle <= limit.upper_rad:
            raise ActivityRefused(
                self.id,
                said(
                    "joint {index} reaches from {lower_rad:.2f} to {upper_rad:.2f} rad, not "
                    "{angle:.2f}",
                    index=index + 1,
                    lower_rad=limit.lower_rad,
                    upper_rad=limit.upper_rad,
                    angle=angle,
                ),
            )
        targets = (*self.arm.positions[:index], angle, *self.arm.positions[index + 1 :])
        if not self._clear(self.arm.positions, targets):
            raise ActivityRefused(self.id, said("the arm would touch the table"))
        return self._recipe_move_joint(index, targets)

    def _plan_grasp(self, asked: MachineArguments) -> Recipe:
        force = asked.number("force_n", FORCE_LOW_N, FORCE_HIGH_N, FORCE_N)
        held = self.gripper.held
        if held is not None:
            raise ActivityRefused(
                self.id, said("already holds the {name}", name=show_choice(held.name))
            )
        return self._recipe_grasp(force, self._way(self._above))

    def _plan_release(self, _asked: MachineArguments) -> Recipe:
        return self._recipe_release(self._way(self._above))

    def _way(self, targets: Sequence[float]) -> list[Sequence[float]]:
        """Return the poses to pass: straight there if the table allows, else by straight up."""
        here = self.arm.positions
        if self._clear(here, targets):
            return [targets]
        if self._clear(here, STRAIGHT_UP) and self._clear(STRAIGHT_UP, targets):
            return [STRAIGHT_UP, targets]
        raise ActivityRefused(
            self.id, said("the arm would touch the table; move a joint away from it first")
        )

    @staticmethod
    def _clear(start: Sequence[float], end: Sequence[float]) -> bool:
        for sample in range(1, _SAMPLES + 1):
            part = sample / _SAMPLES
            angles = [a + part * (b - a) for a, b in zip(start, end, strict=True)]
            elbow, wrist, tips = iiwa_points(tuple(angles))
            if min(elbow[2], wrist[2]) < LOWEST_LINK_M or tips[2] < LOWEST_TIP_M:
                return False
        return True

    # -------------------------------------------------------------------------------------- recipes

    def _recipe_home(self, way: list[Sequence[float]]) -> Recipe:
        self._stage(said("going home"))
        yield from self._follow(way, 0.0, 1.0)
        return said("at home")

    def _recipe_move_joint(self, index: int, targets: Sequence[float]) -> Recipe:
        self._stage(said("moving joint {index}", index=index + 1))
        yield from self._move(targets, SHARE, 0.0, 1.0)
        return said(
            "joint {index} at {angle:.1f} deg",
            index=index + 1,
            angle=degrees(self.arm.positions[index]),
        )

    def _recipe_grasp(self, force_n: float, way: list[Sequence[float]]) -> Recipe:
        self._stage(said("approaching"))
        self.gripper.open()
        yield from self._follow(way, 0.0, 0.35)
        yield from self._move(self._at, SLOW_SHARE, 0.35, 0.5)
        height = self._tips()[2]
        self._stage(said("closing"))
        thing = self._things.near(self.id, self._tips(), MISS_M)
        self.gripper.close(force_n, thing)
        yield from self._fingers(0.6)
        self._stage(said("verifying"))
        yield from self._wait(SETTLE_S)
        self._extra = {"width_m": self.gripper.width_m, "force_n": self.gripper.force_n}
        self._advance(0.7)
        if self.gripper.held is None:
            yield from self._return()
            raise ActivityFailed(said("nothing between the fingers, opened and returned"))
        self._stage(said("lifting"))
        yield from self._lift()
        self._extra["lift_m"] = self._tips()[2] - height
        lift_cm = self._extra["lift_m"] * 100
        return said("object held, lifted {lift}", lift=measured(f"{lift_cm:.0f} cm", lift_cm, "cm"))

    def _lift(self) -> Recipe:
        held = self.gripper.held
        if held is not None and self.gripper.force_n < held.force_needed_n:
            force = self.gripper.force_n
            self.gripper.lose()
            self._stage(said("the object slipped"))
            yield from self._return()
            raise ActivityFailed(
                said("the object slipped at {force:g} N, opened and returned", force=force)
            )
        yield from self._move(self._above, SLOW_SHARE, 0.7, 1.0)
        if self.gripper.held is None:
            yield from self._return()
            raise ActivityFailed(said("the object was lost while lifting, opened and returned"))
        return ""

    def _return(self) -> Recipe:
        """Open, rise and go home; the fraction stays."""
        self.gripper.open()
        yield from self._fingers(0.0)
        self._stage(said("returning"))
        yield from self._follow([self._above, HOME], 0.0, 0.0)
        return ""

    def _recipe_release(self, way: list[Sequence[float]]) -> Recipe:
        held = self.gripper.held
        if held is None:
            self._stage(said("opening"))
            self.gripper.open()
            yield from self._fingers(1.0)
            return said("gripper open, it held nothing")
        self._stage(said("putting down"))
        yield from self._follow(way, 0.0, 0.4)
        yield from self._move(self._at, SLOW_SHARE, 0.4, 0.6)
        self._stage(said("opening"))
        self.gripper.open()
        yield from self._fingers(0.7)
        self._stage(said("rising"))
        yield from self._move(self._above, SLOW_SHARE, 0.7, 1.0)
        return said("{name} put down", name=show_choice(held.name))

    def _follow(self, way: list[Sequence[float]], start: float, end: float) -> Recipe:
        part = (end - start) / len(way)
        for index, targets in enumerate(way):
            yield from self._move(targets, SHARE, start + index * part, start + (index + 1) * part)
        return ""

    def _move(self, targets: Sequence[float], share: float, start: float, end: float) -> Recipe:
        self.arm.go(targets, share)
        while not self.arm.still:
            self._advance(start + (end - start) * self.arm.progress)
            yield
        self._advance(end)
        return ""

    def _fingers(self, end: float) -> Recipe:
        while not self.gripper.still:
            yield
        self._advance(end)
        return ""

    def _wait(self, duration_s: float) -> Recipe:
        until_s = self._time_s + duration_s
        while self._time_s < until_s:
            yield
        return ""

    # ------------------------------------------------------------------------------------ mechanics

    def _tips(self) -> Position:
        return iiwa_points(self.arm.positions)[2]

    def _drive(self, dt_s: float) -> None:
        self.gripper.step(dt_s)
        if self.arm.still:
            return
        self.arm.step(dt_s)
        if self.arm.still:
            held = self.gripper.held
            if held is not None:
                held.come_to(self._tips())

    def _brake(self) -> None:
        self.arm.brake()
        self.gripper.stop()

    def _in_motion(self) -> bool:
        return not (self.arm.still and self.gripper.still)

    def at_rest(self) -> bool:
        """True when all joints are slower than 1 mrad/s and the fingers slower than 0.5 mm/s."""
        return self.arm.at_rest and abs(self.gripper.speed_m_s) < 0.0005  # noqa: PLR2004

    def _mark(self) -> None:
        self._extra = {}

    def _measured(self) -> dict[str, float]:
        return dict(self._extra)

    def telemetry(self) -> Mapping[str, float | str]:
        """Joints, finger tips in the base frame, gripper; on mains, so no battery."""
        x, y, z = self._tips()
        held = self.gripper.held
        values: dict[str, float | str] = {
            "x_m": x,
            "y_m": y,
            "z_m": z,
            "gripper_m": self.gripper.width_m,
            "gripper_n": self.gripper.force_n,
            "holding": held.name if held is not None else "",
            "power": "mains",
            "mode": "at rest" if self.at_rest() else "moving",
        }
        for index, angle in enumerate(self.arm.positions, 1):
            values[f"joint_{index}_rad"] = angle
        for index, speed in enumerate(self.arm.velocities, 1):
            values[f"joint_{index}_rad_s"] = speed
        return values
