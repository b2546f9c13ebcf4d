"""Faults to try, as ROS parameters: ``ros2 param set /kuka1/machine object false``."""

from __future__ import annotations

from functools import partial
from importlib import import_module
from math import inf
from typing import TYPE_CHECKING

from rosic_sim.robots.machines.field_robots import Fire, FireWatcher, Rover
from rosic_sim.robots.machines.omni import Omni
from rosic_sim.robots.machines.world import CUBE

if TYPE_CHECKING:
    from collections.abc import Callable

    from rosic.robots.ros2.client.rclpy_import import RosObject
    from rosic_sim.robots.machines.world import SimulatedWorld
    from rosic_sim.robots.machines.yumi import Side
    from rosic_sim.ros2.endpoints import SimulatedRobotNode

LINK, BATTERY, OBJECT, WATCHDOG = "link", "battery", "object", "watchdog_s"
DRIFT, FIRE, MUD = "drift", "fire", "mud"
BURNS = Fire(1.6, 0.5, 45.0)
ARMS: dict[str, Side] = {"left_arm": "left", "right_arm": "right"}


class RobotFaults:
    """What can be broken, and mended, in one robot.

    - ``link``: false cuts it; the robot holds or lands by itself, and nothing of it is heard.
    - ``battery``: its charge from 0.0 to 1.0 (robots with one).
    - ``object``: false takes the cube away, true puts one at its station (kuka).
    - ``left_arm``, ``right_arm``: false lets one fail (yumi).
    - ``watchdog_s``: after so long without a velocity it comes to rest by itself; 0.0 switches
      that off (omni).
    - ``drift``: how many degrees its heat sensor is off; ``fire``: whether something burns (watch).
    - ``mud``: true lets the ground give way (rovers).
    """

    def __init__(self, owner: SimulatedRobotNode, world: SimulatedWorld) -> None:
        self._owner = owner
        self._world = world
        self._special: dict[str, Callable[[object], str]] = {
            WATCHDOG: self._watchdog,
            **{name: partial(self._outside, name) for name in (DRIFT, FIRE, MUD)},
        }
        self._result = import_module("rcl_interfaces.msg").SetParametersResult
        names: dict[str, bool | float] = {LINK: True}
        if owner.machine.battery is not None:
            names[BATTERY] = 1.0
        if owner.model == "kuka":
            names[OBJECT] = True
        if owner.model == "yumi":
            names |= dict.fromkeys(ARMS, True)
        if isinstance(owner.machine, Omni):
            names[WATCHDOG] = owner.machine.watchdog_s
        if isinstance(owner.machine, FireWatcher):
            names |= {DRIFT: 0.0, FIRE: False}
        if isinstance(owner.machine, Rover):
            names[MUD] = False
        for name, value in names.items():
            owner.node.declare_parameter(name, value)
        owner.node.add_on_set_parameters_callback(self._set)

    def _set(self, parameters: list[RosObject]) -> RosObject:
        for parameter in parameters:
            reason = self._apply(parameter.name, parameter.value)
            if reason:
                return self._result(successful=False, reason=reason)
        return self._result(successful=True)

    def _apply(self, name: str, value: object) -> str:
        """Do it; return why not, or nothing."""
        now_s = self._owner.now_s()
        if name == BATTERY:
            if not isinstance(value, float) or not 0.0 <= value <= 1.0:
                return "a battery is a number from 0.0 to 1.0"
            self._world.set_battery(self._owner.id, value)
        elif name in self._special:
            return self._special[name](value)
        elif not isinstance(value, bool):
            return "true or false"
        elif name == LINK:
            (self._owner.mend_link if value else self._owner.cut_link)(now_s)
        elif name == OBJECT:
            self._object(there=value)
        elif name in ARMS:
            self._arm(ARMS[name], works=value, now_s=now_s)
        return ""

    def _watchdog(self, value: object) -> str:
        machine = self._owner.machine
        if not isinstance(value, float) or not 0.0 <= value < inf or not isinstance(machine, Omni):
            return "a watchdog is a number of seconds; 0.0 is none"
        machine.set_watchdog(value)
        return ""

    def _outside(self, name: str, value: object) -> str:
        machine = self._owner.machine
        if isinstance(machine, FireWatcher) and name == DRIFT and isinstance(value, float):
            machine.drift_by(value)
        elif isinstance(machine, FireWatcher) and name == FIRE and isinstance(value, bool):
            if value:
                machine.kindle(BURNS)
            else:
                machine.put_out()
        elif isinstance(machine, Rover) and name == MUD and isinstance(value, bool):
            if value:
                machine.enter_mud()
            else:
                machine.leave_mud()
        else:
            return "drift is a number of degrees; fire and mud are true or false"
        return ""

    def _object(self, *, there: bool) -> None:
        if there:
            self._world.put_back()
        else:
            self._world.remove_thing(CUBE)

    def _arm(self, side: Side, *, works: bool, now_s: float) -> None:
        if works:
            self._world.repair_arm(side)
        else:
            self._world.fail_arm(side, now_s)
