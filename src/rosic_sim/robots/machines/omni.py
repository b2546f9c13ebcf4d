"""An omni-directional mobile manipulator of the KUKA youBot class."""

from __future__ import annotations

from math import atan2, cos, degrees, hypot, inf, isfinite, pi, radians, sin
from types import MappingProxyType
from typing import TYPE_CHECKING

from rosic.core.i18n import said
from rosic.core.language.formatting import show_choice
from rosic.core.time_units import HOUR_S
from rosic.core.units import measured
from rosic_sim.robots.machines.activity import ActivityRefused, ActivityState
from rosic_sim.robots.machines.joints import JointGroup, MachineJointLimit, braking_speed
from rosic_sim.robots.machines.machine import Battery
from rosic_sim.robots.machines.mecanum import (
    ACCELERATION_M_S2,
    REST,
    SPEED_LIMIT_M_S,
    YAW_ACCELERATION_RAD_S2,
    YAW_LIMIT_RAD_S,
    MecanumBase,
    Velocity,
)
from rosic_sim.robots.machines.stepped_machine import Plan, Recipe, SteppedMachine

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rosic_sim.robots.machines.arguments import MachineArguments

# Ranges: KUKA youBot User Manual, "Arm", as in the maker's robot description. Speed: 90 deg/s,
# same manual. Accelerations: assumed.
_ARM_SPEED = radians(90)
_RANGES = ((-169, 169), (-65, 90), (-151, 145), (-102.5, 102.5), (-167.5, 167.5))
ARM_LIMITS = tuple(
    MachineJointLimit(radians(low), radians(high), _ARM_SPEED, 2.0, 6.0) for low, high in _RANGES
)
# Taught poses: assumed. Zero is the arm straight up.
ARM_POSES: Mapping[str, tuple[float, ...]] = MappingProxyType(
    {
        "home": tuple(map(radians, (0, -60, 140, -80, 0))),
        "carry": tuple(map(radians, (0, -30, 100, 20, 0))),
        "reach": tuple(map(radians, (0, 60, 30, 60, 0))),
        "up": (0.0, 0.0, 0.0, 0.0, 0.0),
    }
)
ARM_SHARE = 0.5

# 24 V, 5 Ah, about 90 minutes (KUKA youBot User Manual); the split over the loads is assumed.
IDLE_LASTS_S = 4.0 * HOUR_S
MOVING_LASTS_S = 5400.0
LOWEST_BATTERY = 0.05

WATCHDOG_S = 0.5
FARTHEST_M = 50.0
LONGEST_MOVE_M = 5.0
NEAR_M = 1e-4
NEAR_RAD = 1e-4

_DIRECTIONS = MappingProxyType({"forward": 0.0, "left": pi / 2, "back": pi, "right": -pi / 2})


class Omni(SteppedMachine):
    """Skills: ``move``, ``turn``, ``goto``, ``arm``; and a velocity topic with a watchdog.

    A move or a goto ends within 1 cm, a turn within 0.01 rad of what was asked, typically within
    0.1 mm; when stopped at full speed the base rests after 0.4 s and 0.16 m.

    Attributes:
        base: The drive and its odometry.
        arm: Five joints.
        watchdog_s: Without a new set-point for this long the base comes to rest by itself.
        speed_cap_m_s: It drives no faster than this, whatever is asked.
    """

    def __init__(
        self,
        robot: str = "omni",
        pose: tuple[float, float, float] = (0.0, 0.0, 0.0),
        watchdog_s: float = WATCHDOG_S,
    ) -> None:
        self._cell = Battery()
        super().__init__(robot, self._cell)
        self.base = MecanumBase(*pose)
        self.arm = JointGroup(ARM_LIMITS, ARM_POSES["home"])
        self.watchdog_s = watchdog_s
        self.speed_cap_m_s = SPEED_LIMIT_M_S
        self._wanted = REST
        self._braking = False
        self._setpoint_s: float | None = None
        self._from = pose
        self._plans: dict[str, Plan] = {
            "move": self._plan_move,
            "turn": self._plan_turn,
            "goto": self._plan_goto,
            "arm": self._plan_arm,
        }

    def set_watchdog(self, watchdog_s: float) -> None:
        """Come to rest by itself after so long without a set-point; 0 switches that off."""
        self.watchdog_s = watchdog_s or inf

    def cap_speed(self, speed_m_s: float) -> None:
        """Drive no faster than this from now on, and never faster than its wheels allow."""
        self.speed_cap_m_s = min(speed_m_s, SPEED_LIMIT_M_S)

    # ------------------------------------------------------------------------------- velocity topic

    def set_velocity(self, x_m_s: float, y_m_s: float, yaw_rad_s: float, now_s: float) -> None:
        """Hold a velocity in the base's frame until the next set-point or the watchdog.

        What is faster than the wheels allow is scaled down, direction kept, as the drive does.
        Zero always is a stop: it also cancels a running skill.

        Raises:
            ActivityRefused: Not finite, a skill is running, coming to rest after a stop, or the
                battery is too low. Nothing has changed.
        """
        self.step(now_s)
        velocity = Velocity(x_m_s, y_m_s, yaw_rad_s)
        if not all(map(isfinite, velocity)):
            raise ActivityRefused(self.id, said("a velocity is not a finite number"))
        if velocity == REST:
            self.halt(now_s)
            return
        if self._recipe is not None and self.activity is not None:
            raise ActivityRefused(self.id, said("busy with {skill}", skill=self.activity.skill))
        self._powered()
        if self._braking or not self.arm.still:
            raise ActivityRefused(self.id, said("still coming to rest"))
        self._setpoint_s = now_s
        self._wanted = self._capped(velocity)

    def _capped(self, velocity: Velocity) -> Velocity:
        """Return a velocity that is no faster than the cap, direction kept."""
        share = hypot(velocity.x_m_s, velocity.y_m_s) / self.speed_cap_m_s
        if self.speed_cap_m_s >= SPEED_LIMIT_M_S or share <= 1.0:
            return velocity
        return Velocity(velocity.x_m_s / share, velocity.y_m_s / share, velocity.yaw_rad_s)

    # --------------------------------------------------------------------------------------- skills

    def _plan(self, skill: str) -> Plan | None:
        return self._plans.get(skill)

    def _able(self) -> None:
        self._powered()
        if self._setpoint_s is not None:
            raise ActivityRefused(self.id, said("driven by velocities at present"))
        if not self._quiet():
            raise ActivityRefused(self.id, said("still coming to rest"))

    def _powered(self) -> None:
        if self._cell.fraction < LOWEST_BATTERY:
            raise ActivityRefused(
                self.id, said("battery {percent} %: too low", percent=self._cell.percent)
            )

    def _quiet(self) -> bool:
        return self.base.still and self.arm.still

    def _plan_move(self, asked: MachineArguments) -> Recipe:
        direction = asked.choice("direction", tuple(_DIRECTIONS), "forward")
        distance = asked.number("distance_m", 0.001, LONGEST_MOVE_M)
        speed = asked.number("speed_m_s", 0.01, SPEED_LIMIT_M_S, 0.3)
        angle = self.base.yaw_rad + _DIRECTIONS[direction]
        x = self.base.x_m + distance * cos(angle)
        y = self.base.y_m + distance * sin(angle)
        self._reachable(x, y)
        return self._recipe_move(x, y, speed, direction)

    def _plan_turn(self, asked: MachineArguments) -> Recipe:
        direction = asked.choice("direction", ("left", "right"), "left")
        angle = asked.number("angle_rad", 0.001, 2 * pi)
        speed = asked.number("speed_rad_s", 0.01, YAW_LIMIT_RAD_S, 0.5)
        yaw = self.base.yaw_rad + (angle if direction == "left" else -angle)
        return self._recipe_turn(yaw, speed)

    def _plan_goto(self, asked: MachineArguments) -> Recipe:
        x = asked.number("x_m", -FARTHEST_M, FARTHEST_M)
        y = asked.number("y_m", -FARTHEST_M, FARTHEST_M)
        speed = asked.number("speed_m_s", 0.01, SPEED_LIMIT_M_S, 0.3)
        yaw = None
        if asked.has("yaw_rad"):
            # The short way round from here.
            turn = asked.number("yaw_rad", -2 * pi, 2 * pi) - self.base.yaw_rad
            yaw = self.base.yaw_rad + atan2(sin(turn), cos(turn))
        return self._recipe_goto(x, y, yaw, speed)

    def _plan_arm(self, asked: MachineArguments) -> Recipe:
        pose = asked.choice("pose", tuple(ARM_POSES), "home")
        return self._recipe_arm(pose)

    def _reachable(self, x_m: float, y_m: float) -> None:
        if max(abs(x_m), abs(y_m)) > FARTHEST_M:
            raise ActivityRefused(
                self.id,
                said(
                    "that is more than {farthest} from the start",
                    farthest=measured(f"{FARTHEST_M:g} m", FARTHEST_M, "m"),
                ),
            )

    def _recipe_move(self, x_m: float, y_m: float, speed: float, direction: str) -> Recipe:
        yield from self._drive_to(x_m, y_m, speed, 1.0)
        way = self._measured()["distance_m"]
        shown = measured(f"{way:.2f} m", way, "m")
        return said("moved {way} {direction}", way=shown, direction=show_choice(direction))

    def _recipe_turn(self, yaw_rad: float, speed: float) -> Recipe:
        yield from self._turn_to(yaw_rad, speed, 0.0)
        turned = degrees(self._measured()["angle_rad"])
        if turned > 0:
            return said("turned {turned:.3g} deg left", turned=turned)
        return said("turned {turned:.3g} deg right", turned=-turned)

    def _recipe_goto(self, x_m: float, y_m: float, yaw: float | None, speed: float) -> Recipe:
        share = 1.0 if yaw is None else 0.7
        yield from self._drive_to(x_m, y_m, speed, share)
        if yaw is not None:
            yield from self._turn_to(yaw, 0.5, share)
        x_m, y_m = (round(at_m, 2) + 0.0 for at_m in (self.base.x_m, self.base.y_m))  # no -0.00
        x, y = (measured(f"{value:.2f} m", value, "m") for value in (x_m, y_m))
        return said("at {x}, {y}", x=x, y=y)

    def _recipe_arm(self, pose: str) -> Recipe:
        self._stage(said("moving the arm"))
        self.arm.go(ARM_POSES[pose], ARM_SHARE)
        while not self.arm.still:
            self._advance(self.arm.progress)
            yield
        return said("arm in pose {pose}", pose=show_choice(pose))

    def _mark(self) -> None:
        self._from = (self.base.x_m, self.base.y_m, self.base.yaw_rad)

    def _drive_to(self, x_m: float, y_m: float, speed: float, share: float) -> Recipe:
        self._stage(said("driving"))
        base = self.base
        whole = max(hypot(x_m - base.x_m, y_m - base.y_m), NEAR_M)
        while True:
            x, y = x_m - base.x_m, y_m - base.y_m
            left = hypot(x, y)
            if left < NEAR_M and base.at_rest():
                self._wanted = REST
                return ""
            heading = atan2(y, x) - base.yaw_rad
            along, across = cos(heading), sin(heading)
            towards = base.velocity.x_m_s * along + base.velocity.y_m_s * across
            # The wheels' limit, too, is kept here: braking must not have to wait for scaling.
            limit = min(speed, self.speed_cap_m_s, SPEED_LIMIT_M_S / (abs(along) + abs(across)))
            wanted = min(limit, braking_speed(left, towards, ACCELERATION_M_S2, self._dt_s))
            self._wanted = Velocity(wanted * along, wanted * across, 0.0)
            self._advance(share * (1.0 - left / whole))
            yield

    def _turn_to(self, yaw_rad: float, speed: float, share: float) -> Recipe:
        self._stage(said("turning"))
        base = self.base
        whole = max(abs(yaw_rad - base.yaw_rad), NEAR_RAD)
        while True:
            left = yaw_rad - base.yaw_rad
            if abs(left) < NEAR_RAD and base.at_rest():
                self._wanted = REST
                return ""
            sign = 1.0 if left > 0 else -1.0
            wanted = min(
                speed,
                braking_speed(
                    abs(left), base.velocity.yaw_rad_s * sign, YAW_ACCELERATION_RAD_S2, self._dt_s
                ),
            )
            self._wanted = Velocity(0.0, 0.0, wanted * sign)
            self._advance(share + (1.0 - share) * (1.0 - abs(left) / whole))
            yield

    # ------------------------------------------------------------------------------------ mechanics

    def _brake(self) -> None:
        self._wanted = REST
        self._setpoint_s = None
        self._braking = not self._quiet()
        self.arm.brake()

    def _watch(self) -> None:
        if self._setpoint_s is not None and self._time_s - self._setpoint_s >= self.watchdog_s:
            self.note = said(
                "no set-point for {watchdog_s:g} s, stopped", watchdog_s=self.watchdog_s
            )
            self._brake()
        if self._cell.fraction <= 0.0 and not self._braking:
            self._end(ActivityState.FAILED, said("battery empty"))
            self._brake()

    def _drive(self, dt_s: float) -> None:
        self.base.step(self._wanted, dt_s, braking=self._braking)
        self.arm.step(dt_s)
        if self._braking and self._quiet():
            self._braking = False
        self._cell.drain(dt_s, IDLE_LASTS_S if self.at_rest() else MOVING_LASTS_S)

    def _idle(self, dt_s: float) -> None:
        self._cell.drain(dt_s, IDLE_LASTS_S)

    def _in_motion(self) -> bool:
        return self._setpoint_s is not None or not self._quiet()

    def at_rest(self) -> bool:
        """True when the base is slower than 1 mm/s and 1 mrad/s and the arm's joints likewise."""
        return self.base.at_rest() and self.arm.at_rest

    def _measured(self) -> dict[str, float]:
        x, y, yaw = self._from
        return {
            "distance_m": hypot(self.base.x_m - x, self.base.y_m - y),
            "angle_rad": self.base.yaw_rad - yaw,
            "x_m": self.base.x_m,
            "y_m": self.base.y_m,
            "yaw_rad": self.base.yaw_rad,
        }

    def telemetry(self) -> Mapping[str, float | str]:
        """Pose in the odometry frame, velocity in the base's frame, arm, battery."""
        base = self.base
        values: dict[str, float | str] = {
            "x_m": base.x_m,
            "y_m": base.y_m,
            "yaw_rad": atan2(sin(base.yaw_rad), cos(base.yaw_rad)),
            "velocity_x_m_s": base.velocity.x_m_s,
            "velocity_y_m_s": base.velocity.y_m_s,
            "velocity_yaw_rad_s": base.velocity.yaw_rad_s,
            "battery": self._cell.fraction,
            "mode": "at rest" if self.at_rest() else "moving",
        }
        for index, angle in enumerate(self.arm.positions, 1):
            values[f"joint_{index}_rad"] = angle
        return values
